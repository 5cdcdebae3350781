"""The stores of a plane by the suffix of its file: one, or one for each map of a set."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError
from weftex.io.formats import show, suffix_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from weftex.planes.layout import Layout
    from weftex.planes.store import Store

#: Suffixes of files that are always written block by block.
ALWAYS = (".zarr", ".dzi")
#: All suffixes of files that can be.
SUFFIXES = (*ALWAYS, ".tif", ".tiff")


def open_stores(
    target: str,
    layouts: Mapping[str, Layout],
    stems: Mapping[str, str] | None = None,
    about: Mapping[str, Any] | None = None,
) -> dict[str, Store]:
    """Return a store for each layout, by the names of maps.

    One picture goes to `target`; of several each has a group in a Zarr, or a file beside it, which
    `stems` may name. `about` says what made the pixels.
    """
    stem, suffix = os.path.splitext(target)[0], suffix_of(target)
    kind = _kind(suffix)
    if len(layouts) == 1:
        return {name: kind(target, layout, about) for name, layout in layouts.items()}
    found = {}
    for name, layout in layouts.items():
        file = stems[name] if stems else f"{os.path.basename(stem)}_{name}"
        path = os.path.join(os.path.dirname(target), file + os.path.splitext(target)[1])
        path = os.path.join(target, name) if suffix == ".zarr" else path
        found[name] = kind(path, layout, about)
    return found


def _kind(suffix: str) -> type[Store]:
    """The format, of which no other is loaded."""
    if suffix == ".zarr":
        from weftex.planes.ome_zarr import ZarrStore

        return ZarrStore
    if suffix == ".dzi":
        from weftex.planes.deep_zoom import DeepZoomStore

        return DeepZoomStore
    from weftex.planes.tiff import TiffStore

    return TiffStore


def check_target(target: str) -> None:
    """Refuse a path that cannot become a plane, before any work.

    Raises
    ------
    FileError
        If its suffix is another, or its folder is missing or read-only.
    """
    suffix, folder = suffix_of(target), os.path.dirname(os.path.abspath(target))
    if suffix not in SUFFIXES:
        raise FileError(
            f"{show(target)}: planes are written to {', '.join(SUFFIXES)}, not '{suffix}'"
        )
    if not os.path.isdir(folder):
        raise FileError(f"{show(target)}: the folder {show(folder)} does not exist")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(f"{show(target)}: the folder {show(folder)} is read-only")
