"""Remove the files of a store, and nothing that somebody else put beside them."""

from __future__ import annotations

import os
import re
from contextlib import suppress

#: Files below the folder of a Zarr group, or below the folder of Deep Zoom's tiles.
_FILES = re.compile(r"zarr\.json|\d+/zarr\.json|\d+/c/(\d+/)?\d+/\d+|\d+/\d+_\d+\.png")
_FOLDERS = re.compile(r"\.|\d+|\d+/c(/\d+){0,2}")
#: What a killed process leaves: of `weftex.io.temporary`, and of Zarr.
_STALE = re.compile(r"\.weftex-\d+(-[0-9a-f]{8}){2}(\.\w+)?|.*\.[0-9a-f]{32}\.partial")


def remove(root: str) -> None:
    """Remove a file, or a folder of a store as far as it has nothing else in it."""
    if os.path.islink(root) and not os.path.isdir(root):
        open(root, "wb").close()  # the link is somebody's
    elif not os.path.isdir(root):
        with suppress(FileNotFoundError):
            os.unlink(root)
    else:
        _walk(root, of_store=True)


def sweep(root: str) -> None:
    """Remove temporary files that nobody writes any more."""
    if os.path.isdir(root):
        _walk(root, of_store=False)


def is_stale(name: str) -> bool:
    """Whether a file's name is that of a temporary file."""
    return bool(_STALE.fullmatch(name))


def _walk(root: str, *, of_store: bool) -> None:
    for folder, _, names in os.walk(root, topdown=False):
        where = os.path.relpath(folder, root).replace(os.sep, "/")
        inside = _FOLDERS.fullmatch(where)
        for name in names:
            path = name if where == "." else f"{where}/{name}"
            if inside and (is_stale(name) or (of_store and _FILES.fullmatch(path))):
                with suppress(FileNotFoundError):
                    os.unlink(os.path.join(folder, name))
        if inside and of_store:
            with suppress(OSError):  # there is something else in it
                os.rmdir(folder)
