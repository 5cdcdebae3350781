"""How many threads are used."""

from __future__ import annotations

import os
import sys

import numpy as np
import pytest

import weftex
from processes import run
from weftex.threads import thread_count


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="Linux only")
def test_no_more_than_this_process_may_use():
    code = """
        import os
        from weftex.threads import thread_count
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        print(thread_count(None), thread_count(3))
    """
    assert run(code).stdout.split() == ["1", "3"]


def test_numbers_of_numpy_are_numbers():
    assert thread_count(np.int64(2)) == 2 and type(thread_count(np.int64(2))) is int
    assert thread_count(None) >= 1 and sys.version_info
    for wrong in (0, -1, True, 1.0, "2", [1]):
        with pytest.raises(weftex.InvalidInputError, match="threads is"):
            thread_count(wrong)
