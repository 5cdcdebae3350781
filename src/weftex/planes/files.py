"""The stores of a plane by the suffix of its file: one, or one for each map of a set."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex.planes.layout import Layout
    from weftex.planes.store import Store

#: Suffixes of files that are always written block by block.
ALWAYS = (".zarr", ".dzi")
#: All suffixes of files that can be.
SUFFIXES = (*ALWAYS, ".tif", ".tiff")


def suffix_of(target: str) -> str:
    """The suffix in lower case, with its dot."""
    return os.path.splitext(target)[1].lower()


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
    if suffix_of(target) == ".dzi":
        from weftex.planes.deep_zoom import DeepZoomStore

        return DeepZoomStore
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
