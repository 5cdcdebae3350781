"""How many threads to use."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from weftex.errors import InvalidInputError


def thread_count(threads: int | None) -> int:
    """Return how many threads to use: at most `threads`, by default one a processor.

    Raises
    ------
    InvalidInputError
        If it is not an integer of 1 or more.
    """
    if threads is not None and (type(threads) is not int or threads < 1):
        raise InvalidInputError(f"threads is {threads!r}; it must be an integer of 1 or more")
    return threads or os.cpu_count() or 1


@contextmanager
def thread_map(threads: int) -> Iterator[Callable[..., Any]]:
    """Give a function like `map` that makes up to so many calls at a time.

    Examples
    --------
    >>> with thread_map(2) as map_:
    ...     list(map_(abs, [-1, 2]))
    [1, 2]
    """
    if threads == 1:
        yield map
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads) as pool:
        yield pool.map
