"""How many threads to use."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

from weftex.errors import is_whole, wrong_value

__all__ = ["in_turn", "thread_count"]

#: The limit of BLAS, and None for each further context that needs it.
_limits: list[Any] = []
_lock = Lock()


def thread_count(threads: int | None) -> int:
    """The number of threads: `threads`, which must be 1 or more, or one per usable processor."""
    if threads is not None and not is_whole(threads, 1):
        raise wrong_value("threads", threads, "an integer of 1 or more")
    return _processors() if threads is None else int(threads)


def _processors() -> int:
    """The number of processors that this process may use; containers and queues may limit it."""
    if sys.version_info >= (3, 13):
        return os.process_cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):  # Linux
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def thread_map(threads: int) -> Iterator[Callable[..., Any]]:
    """Yield a function like `map` that runs at most `threads` calls at a time."""
    if threads == 1:
        yield map
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads) as pool:
        yield pool.map


@contextmanager
def quick_map(threads: int) -> Iterator[Callable[..., Any]]:
    """Yield a `thread_map` for calls under a millisecond, all done before it returns.

    The calling thread takes part, and each takes the next call itself, which saves hand-overs.
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
    """Yield `work` of each item in order, at most two ahead per thread; takes endless iterables."""
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


@cache
def _blas() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep BLAS to one thread; the last of several such contexts at a time restores its limit.

    Its threads busy-wait, so a product of a millisecond takes a tenth of a second beside other
    work. Rounding must not depend on their number either.
    """
    if os.environ.get("OPENBLAS_NUM_THREADS") == "1":
        yield
        return
    with _lock:
        _limits.append(None if _limits else _blas().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            last = _limits.pop()
            if last is not None:
                last.restore_original_limits()
