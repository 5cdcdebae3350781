"""The files of a plane: the stores that write them, and the removal of no other files."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError
from weftex.io.formats import suffix_of
from weftex.planes.layout import Layout

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from weftex.planes.store import Store

#: Suffixes of files that are always written block by block.
ALWAYS = (".zarr",)
#: All suffixes of files that can be.
SUFFIXES = (*ALWAYS, ".tif", ".tiff")


#: Files and folders below the folder of a Zarr group.
_N = r"(0|[1-9]\d{0,12})"
_FILES = re.compile(rf"{_N}/(?:zarr\.json|c/(?:0/)?{_N}/{_N})")
_FOLDERS = re.compile(r"\.|\d+|\d+/c(/\d+){0,2}")
#: What a killed process leaves: of `weftex.io.temporary`, and of Zarr.
_STALE = re.compile(r"\.weftex-\d+(-[0-9a-f]{8}){2}(\.\w+)?|.*\.[0-9a-f]{32}\.partial")


def open_stores(
    target: str, layouts: Mapping[str, Layout], stems: Mapping[str, str], about: Mapping[str, Any]
) -> dict[str, Store]:
    """Return a store for each layout, by the names of maps.

    One picture goes to `target`; of several each has a group in a Zarr, or a file beside it, which
    `stems` may name. `about` says what made the pixels.
    """
    suffix, kind = suffix_of(target), _kind(target)
    stem, given = os.path.splitext(target)
    found = {}
    for name, layout in layouts.items():
        file = stems.get(name) or f"{os.path.basename(stem)}_{name}"
        path = os.path.join(os.path.dirname(target), file + given)
        path = os.path.join(target, name) if suffix == ".zarr" else path
        found[name] = kind(target if len(layouts) == 1 else path, layout, about)
    return found


def _kind(target: str) -> type[Store]:
    """The format, of which no other is loaded."""
    if suffix_of(target) == ".zarr":
        from weftex.planes.ome_zarr import ZarrStore

        return ZarrStore
    from weftex.planes.tiff import TiffStore

    return TiffStore


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


def remove(root: str, grid: Sequence[int] | None = None) -> None:
    """Remove a file, or a folder of a store as far as it has nothing else in it.

    Files of blocks are removed if they lie in the `grid` of `Store.grid`. Links are kept.
    """
    if os.path.isdir(root) and not os.path.islink(root):
        _walk(root, grid, of_store=True)
    elif not os.path.islink(root):
        with suppress(FileNotFoundError):
            os.unlink(root)


def sweep(root: str) -> None:
    """Remove temporary files that nobody writes any more; a file has none."""
    _walk(root, None, of_store=False)


def is_stale(name: str) -> bool:
    """Whether a file's name is that of a temporary file."""
    return bool(_STALE.fullmatch(name))


def _is_of(grid: Sequence[int] | None, path: str) -> bool:
    """Whether a file below the folder of a store is one of its grid, or says what the folder is."""
    file = _FILES.fullmatch(path)
    if file is None or grid is None:
        return path == "zarr.json"
    levels, height, width, side = grid
    level, row, column = (int(one or 0) for one in file.groups())
    rows, columns = Layout(height, width, side).grid(level)
    return level < levels and row < rows and column < columns


def _walk(root: str, grid: Sequence[int] | None, *, of_store: bool) -> None:
    for folder, _, names in os.walk(root, topdown=False):
        where = os.path.relpath(folder, root).replace(os.sep, "/")
        if not _FOLDERS.fullmatch(where):
            continue
        for name in names:
            path = name if where == "." else f"{where}/{name}"
            if is_stale(name) or (of_store and _is_of(grid, path)):
                with suppress(FileNotFoundError):
                    os.unlink(os.path.join(folder, name))
        if of_store:
            with suppress(OSError):  # there is something else in it
                os.rmdir(folder)
