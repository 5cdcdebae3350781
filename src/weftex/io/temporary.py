"""Temporary files and folders of this process; removal of the ones that a dead process left.

A process holds a lock on each of its temporary files until it removes them; the lock ends with the
process. So a file of this name and machine without a lock belongs to nobody.
"""

from __future__ import annotations

import os
import re
import zlib
from contextlib import suppress
from functools import cache, lru_cache

try:
    import fcntl
except ImportError:  # Windows: nothing is locked there, and nothing is swept
    fcntl = None  # type: ignore[assignment]

__all__ = ["is_temporary", "write_through"]

#: Temporary files and folders that this process has now, and the descriptors that lock them.
_mine: dict[str, int] = {}


def claim(folder: str, suffix: str = "", *, as_folder: bool = False) -> str:
    """Create an empty temporary file, or a folder, and return its path; `release` ends its lock."""
    _sweep(os.path.realpath(folder))
    while True:
        name = f".weftex-{os.getpid()}-{_machine()}-{os.urandom(4).hex()}{suffix}"
        path = os.path.join(folder, name)
        _mine[path] = -1
        if as_folder:
            os.mkdir(path, 0o700)
        else:
            # Not the tempfile module: its files can be read by their owner alone.
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        held = lock(path)
        if held is not None:
            _mine[path] = held
            return path
        del _mine[path]


def lock(path: str) -> int | None:
    """Return a descriptor that holds a file or folder, -1 where there are no locks.

    None if another process holds it, or removed it.
    """
    if fcntl is None:
        return -1
    try:
        number = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        gone = not os.path.exists(path)
    except OSError as error:  # some network folders know no locks
        gone = isinstance(error, BlockingIOError)
    if gone:
        os.close(number)
        return None
    return number


def is_mine(path: str) -> bool:
    """Return whether a path is a temporary file that this process has now."""
    return path in _mine


def is_temporary(name: str, machine: str = "[0-9a-f]{8}") -> bool:
    """Whether a file has the name of a temporary one, of any machine."""
    return re.fullmatch(rf"\.weftex-\d+-{machine}-[0-9a-f]{{8}}(\.\w+)?", name) is not None


def write_through(path: str, flags: int = os.O_RDWR) -> None:
    """Wait until a file is on the disk; a folder is opened to read, by its flags."""
    number = os.open(path, flags)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def release(path: str) -> None:
    """Remove a temporary file or folder if it is still there, and end its lock."""
    number = _mine.pop(path, -1)
    with suppress(OSError):
        _remove(path)
    if number >= 0:
        os.close(number)


def release_all() -> None:
    """`release` everything, where the process ends at once."""
    for path in list(_mine):
        release(path)


@lru_cache(maxsize=64)
def _sweep(folder: str) -> None:
    """Remove the temporary files of dead processes from a folder; once in each process."""
    if fcntl is None:
        return
    with suppress(OSError), os.scandir(folder) as found:
        for name in [one.name for one in found if is_temporary(one.name, _machine())]:
            with suppress(OSError):  # it is locked, gone, or a link
                _remove_unlocked(os.path.join(folder, name))


def _remove_unlocked(path: str) -> None:
    number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        if os.fstat(number).st_uid == os.geteuid():
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            _remove(path)
    finally:
        os.close(number)


def _remove(path: str) -> None:
    if os.path.isdir(path):
        import shutil  # 5 ms

        shutil.rmtree(path)
    else:
        os.unlink(path)


@cache
def _machine() -> str:
    """Eight letters for the machine's name: locks of another one may not be seen from here."""
    return f"{zlib.crc32(os.uname().nodename.encode() if hasattr(os, 'uname') else b''):08x}"
