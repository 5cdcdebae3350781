"""How many threads to use."""

from __future__ import annotations

import numbers
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from weftex.errors import InvalidInputError, shown


def thread_count(threads: int | None) -> int:
    """Return how many threads to use: at most `threads`, by default one a usable processor.

    Raises
    ------
    InvalidInputError
        If it is not an integer of 1 or more.
    """
    whole = isinstance(threads, numbers.Integral) and not isinstance(threads, bool)
    if threads is not None and not (whole and threads >= 1):
        raise InvalidInputError(f"threads is {shown(threads)}; it must be an integer of 1 or more")
    threads = None if threads is None else int(threads)
    return threads or _processors()


def _processors() -> int:
    """Those that this process may run on, which a container or a queue may have made few."""
    if sys.version_info >= (3, 13):
        return os.process_cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):  # Linux
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


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


@contextmanager
def quick_map(threads: int) -> Iterator[Callable[..., Any]]:
    """`thread_map` for calls of less than a millisecond, which are all made before it returns.

    The thread that asks takes part, and each takes the next call as soon as it has made one: to
    hand over every single one would take a tenth as long as the call.

    Examples
    --------
    >>> with quick_map(2) as map_:
    ...     list(map_(pow, [2, 3, 4], [3, 2, 1]))
    [8, 9, 4]
    """
    if threads == 1:
        yield map
        return
    from collections import deque
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads - 1) as pool:

        def made(function: Callable[..., Any], *over: Iterable[Any]) -> list[Any]:
            left = deque(enumerate(zip(*over, strict=False)))
            results = [None] * len(left)

            def work() -> None:
                while True:
                    try:
                        number, given = left.popleft()
                    except IndexError:
                        return
                    try:
                        results[number] = function(*given)
                    except BaseException:
                        left.clear()
                        raise

            others = [pool.submit(work) for _ in range(min(threads, len(left)) - 1)]
            try:
                work()
            finally:
                for other in others:
                    other.result()
            return results

        yield made


def in_turn(work: Callable[[Any], Any], over: Iterable[Any], threads: int) -> Iterator[Any]:
    """Yield `work` of each thing in their order, a few of them made ahead in threads.

    Unlike `map` of a pool it takes things without end, and holds no more than two a thread.

    Examples
    --------
    >>> from itertools import count, islice
    >>> list(islice(in_turn(abs, count(-2), threads=2), 4))
    [2, 1, 0, 1]
    """
    if threads == 1:
        yield from map(work, over)
        return
    from collections import deque
    from concurrent.futures import Future, ThreadPoolExecutor

    with ThreadPoolExecutor(threads) as pool:
        ahead: deque[Future[Any]] = deque()
        try:
            for number in over:
                ahead.append(pool.submit(work, number))
                if len(ahead) > 2 * threads:
                    yield ahead.popleft().result()
            while ahead:
                yield ahead.popleft().result()
        finally:  # also where nobody asks for more
            for future in ahead:
                future.cancel()
