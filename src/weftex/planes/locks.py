"""Who works on a plane: locks that end with their process, also over a shared file system."""

from __future__ import annotations

import os
import random
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

#: Numbers of locks that a file has.
COUNT = 2**20
_POLL = 0.02  # seconds

#: For each lock file: who of the threads has it. The system holds no lock against its own process,
#: and closing a file ends all locks that the process has on it.
_threads: dict[str, threading.Lock] = {}
#: Lock files that threads of this process share: how many, and what to close at the end.
_shared: dict[str, tuple[int, ExitStack]] = {}
_share_guard = threading.Lock()


@contextmanager
def locked(path: str, first: int = 0, count: int = COUNT, *, wait: bool = False) -> Iterator[bool]:
    """Hold some numbers of a lock file, all by default, while the block runs.

    False if somebody has one of them, unless it is to `wait`.
    """
    thread = _threads.setdefault(os.path.realpath(path), threading.Lock())
    if not thread.acquire(blocking=wait):
        yield False
        return
    try:
        number = _opened(path, first, count, wait)
        try:
            yield number is not None
        finally:
            if number is not None:
                _unlock(number, first, count)
                os.close(number)
    finally:
        thread.release()


@contextmanager
def shared(path: str) -> Iterator[None]:
    """Hold a lock file together with others while the block runs; waits for who holds all of it."""
    key = os.path.realpath(path)
    with _share_guard:
        users, stack = _shared.get(key) or (0, ExitStack())
        if not users:  # a number of its own, so that others share the file
            stack.enter_context(locked(path, random.randrange(COUNT), 1, wait=True))
        _shared[key] = users + 1, stack
    try:
        yield
    finally:
        with _share_guard:
            users, stack = _shared.pop(key)
            if users > 1:
                _shared[key] = users - 1, stack
            else:
                stack.close()


def _opened(path: str, first: int, count: int, wait: bool) -> int | None:
    """The file, locked, and still the one of that name; None if somebody has it."""
    while True:
        number = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            got = _lock(number, first, count, wait)
            if got and _is_there(path, number):
                return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)
        if not got:
            return None


def _is_there(path: str, number: int) -> bool:
    """Whether nobody removed an open file meanwhile."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(number))
    except FileNotFoundError:
        return False


if sys.platform == "win32":
    import msvcrt

    def _lock(number: int, first: int, count: int, wait: bool) -> bool:
        while True:
            os.lseek(number, first, os.SEEK_SET)
            try:
                msvcrt.locking(number, msvcrt.LK_NBLCK, count)
                return True
            except OSError:
                if not wait:
                    return False
                time.sleep(_POLL)

    def _unlock(number: int, first: int, count: int) -> None:
        os.lseek(number, first, os.SEEK_SET)
        msvcrt.locking(number, msvcrt.LK_UNLCK, count)
else:
    import fcntl

    def _lock(number: int, first: int, count: int, wait: bool) -> bool:
        try:
            how = fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB
            fcntl.lockf(number, how, count, first)
        except (BlockingIOError, PermissionError):  # systems differ
            return False
        return True

    def _unlock(number: int, first: int, count: int) -> None:
        fcntl.lockf(number, fcntl.LOCK_UN, count, first)
