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
def mapping(threads: int | None) -> Iterator[Callable[..., Any]]:
    """A `map` that calls its function on so many threads; results come in order.

    Parameters
    ----------
    threads : int or None
        See `thread_count`.

    Examples
    --------
    >>> with mapping(2) as each:
    ...     list(each(abs, [-3, 2]))
    [3, 2]
    """
    count = thread_count(threads)
    if count == 1:
        yield map
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(count) as pool:
        yield pool.map
