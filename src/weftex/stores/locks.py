"""Who works on a plane: locks that end with their process, also over a shared file system."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

_WHOLE = 2**20  # numbers of locks

#: Lock files of this process, which the system does not hold against itself.
_held: set[str] = set()


@contextmanager
def locked(path: str, first: int, count: int = 1, *, wait: bool = False) -> Iterator[bool]:
    """Hold some numbers of a lock file while the block runs; False if somebody has one of them.

    Parameters
    ----------
    path : str
        The file, which is made and stays.
    first, count : int
        Bytes of the file: who holds some of them shuts out those that want any of them.
    wait : bool
        Until it is free.
    """
    key = os.path.realpath(path)
    if key in _held:  # to close the file a second time would end the lock
        yield False
        return
    number = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        got = _lock(number, first, count, wait)
        if got:
            _held.add(key)
        try:
            yield got
        finally:
            if got:
                _held.discard(key)
                _unlock(number, first, count)
    finally:
        os.close(number)


def all_from(first: int) -> int:
    """How many numbers there are from one on."""
    return _WHOLE - first


if sys.platform == "win32":
    import msvcrt
    import time

    def _lock(number: int, first: int, count: int, wait: bool) -> bool:
        while True:
            os.lseek(number, first, os.SEEK_SET)
            try:
                msvcrt.locking(number, msvcrt.LK_NBLCK, count)
                return True
            except OSError:
                if not wait:
                    return False
                time.sleep(0.1)

    def _unlock(number: int, first: int, count: int) -> None:
        os.lseek(number, first, os.SEEK_SET)
        msvcrt.locking(number, msvcrt.LK_UNLCK, count)
else:
    import fcntl

    def _lock(number: int, first: int, count: int, wait: bool) -> bool:
        try:
            how = fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB
            fcntl.lockf(number, how, count, first)
        except BlockingIOError:
            return False
        return True

    def _unlock(number: int, first: int, count: int) -> None:
        fcntl.lockf(number, fcntl.LOCK_UN, count, first)
