"""How many threads are used."""

import os
import sys
import threading

import numpy as np
import pytest
import threadpoolctl

from processes import run
from weftex.threads import one_blas_thread, quick_map, thread_count


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="Linux only")
def test_no_more_than_this_process_may_use():
    code = """
        import os
        from weftex.threads import one_blas_thread, quick_map, thread_count
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


def test_blas_gets_its_threads_back_after_calls_that_overlap(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    blas = threadpoolctl.ThreadpoolController().select(user_api="blas")
    with blas.limit(limits=2):
        first, second = one_blas_thread(), one_blas_thread()
        first.__enter__()
        second.__enter__()
        first.__exit__(None, None, None)
        assert all(one["num_threads"] == 1 for one in blas.info())
        second.__exit__(None, None, None)
        assert blas.info() and all(one["num_threads"] == 2 for one in blas.info())
