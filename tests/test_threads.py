"""How many threads are used."""

import os
import sys
import threading

import numpy as np
import pytest

from processes import run
from weftex.threads import quick_map, thread_count


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="Linux only")
def test_no_more_than_this_process_may_use():
    code = """
        import os
        from weftex.threads import quick_map, thread_count
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        print(thread_count(None), thread_count(3))
    """
    assert run(code).stdout.split() == ["1", "3"]


def test_numbers_of_numpy_are_numbers():
    assert thread_count(np.int64(2)) == 2 and type(thread_count(np.int64(2))) is int
    assert thread_count(None) >= 1 and sys.version_info


def test_quick_calls_are_shared_and_end_with_the_first_that_fails():
    seen, both = set(), threading.Barrier(2, timeout=60)

    def square(number):
        if number < 2:
            both.wait()  # only another thread lets this one go on
        seen.add(threading.get_ident())
        return number**2

    def fail(number):
        if number == 3:
            raise KeyError(number)
        return number

    with quick_map(2) as map_:
        assert map_(square, range(50)) == [k**2 for k in range(50)]
        assert len(seen) == 2 and threading.get_ident() in seen
        assert map_(square, []) == []
        with pytest.raises(KeyError):
            map_(fail, range(1000))
        assert map_(abs, [-1]) == [1]
