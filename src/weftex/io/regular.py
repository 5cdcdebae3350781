"""Open files that may be anybody's: never a pipe or a device, which may have no end."""

from __future__ import annotations

import errno
import os
import stat
from typing import IO

_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: str | os.PathLike[str], most_bytes: int | None = None) -> IO[bytes]:
    """Return an open file; OSError if it is no regular file, or has more than `most_bytes`."""
    number = os.open(path, _FLAGS)
    try:
        found = os.fstat(number)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(path))
        if most_bytes is not None and found.st_size > most_bytes:
            raise OSError(errno.EFBIG, f"it has more than {most_bytes} bytes", os.fspath(path))
        return open(number, "rb")
    except BaseException:
        os.close(number)
        raise
