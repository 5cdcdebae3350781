"""Who works on a plane: locks that end with their process, also over a shared file system."""

from __future__ import annotations

import os
import random
import sys
import threading
import time
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

_WHOLE = 2**20  # numbers of locks
_POLL = 0.02  # seconds

#: Lock files of this process, which the system does not hold against itself.
_held: set[str] = set()
#: Lock files that threads of this process share: how many, and what to close at the end.
_shared: dict[str, tuple[int, ExitStack]] = {}
_guard, _share_guard = threading.Lock(), threading.Lock()


@contextmanager
def locked(path: str, first: int = 0, count: int = _WHOLE, *, wait: bool = False) -> Iterator[bool]:
    """Hold some numbers of a lock file while the block runs; False if somebody has one of them.

    Parameters
    ----------
    path : str
        The file, which is made if it is missing.
    first, count : int
        Bytes of the file, all by default: who holds some of them shuts out those that want any of
        them.
    wait : bool
        Until they are free.
    """
    key = os.path.realpath(path)
    while not _claimed(key):  # to close the file a second time would end the lock
        if not wait:
            yield False
            return
        time.sleep(_POLL)
    try:
        number = _opened(path, first, count, wait)
        if number is None:
            yield False
            return
        try:
            yield True
        finally:
            _unlock(number, first, count)
            os.close(number)
    finally:
        _held.discard(key)


@contextmanager
def shared(path: str) -> Iterator[None]:
    """Hold a lock file together with others while the block runs; waits for who holds all of it."""
    key = os.path.realpath(path)
    with _share_guard:
        users, stack = _shared.get(key) or (0, ExitStack())
        if not users:  # a number of its own, so that others share the file
            stack.enter_context(locked(path, random.randrange(_WHOLE), 1, wait=True))
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


def _claimed(key: str) -> bool:
    """Whether no other thread of this process holds the file; it is this one's then."""
    with _guard:
        free = key not in _held
        _held.add(key)
        return free


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


def all_from(first: int) -> int:
    """Return the number of locks from one on."""
    return _WHOLE - first


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
