"""Files of a plane: which may be written, what is removed, and what is on the disk."""

from __future__ import annotations

import os
import re
from contextlib import suppress

from weftex.errors import FileError
from weftex.io.formats import suffix_of

#: Suffixes of files that can be written block by block.
SUFFIXES = (".tif", ".tiff")

#: What a killed process leaves, of `weftex.io.temporary`.
_STALE = re.compile(r"\.weftex-\d+(-[0-9a-f]{8}){2}(\.\w+)?")


def check_target(target: str) -> None:
    """Raise `FileError` for a path that cannot become a plane, before any work."""
    folder = os.path.dirname(os.path.abspath(target))
    if suffix_of(target) not in SUFFIXES:
        raise FileError(
            f"{target}: planes are written to {', '.join(SUFFIXES)}, not '{suffix_of(target)}'"
        )
    if not os.path.isdir(folder):
        raise FileError(f"{target}: the folder {folder} does not exist")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(f"{target}: the folder {folder} is read-only")


def remove(path: str) -> None:
    """Remove a file if it is there; a link is kept."""
    if not os.path.islink(path):
        with suppress(FileNotFoundError):
            os.unlink(path)


def is_stale(name: str) -> bool:
    """Whether a file's name is that of a temporary file."""
    return bool(_STALE.fullmatch(name))


def synced(path: str) -> None:
    """Wait until a file or folder, and its name, are on the disk."""
    if os.path.isfile(path):
        _sync(path, os.O_RDWR)
    for folder in filter(os.path.isdir, (path, os.path.dirname(os.path.abspath(path)))):
        with suppress(OSError):  # Windows opens no folders, and some file systems sync none
            _sync(folder, os.O_RDONLY)


def _sync(path: str, flags: int) -> None:
    number = os.open(path, flags)
    try:
        os.fsync(number)
    finally:
        os.close(number)
