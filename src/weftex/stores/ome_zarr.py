"""Zarr of version 3 with a pyramid as OME-NGFF 0.5 describes it; a block is a shard.

Shards are files of their own, which one writer replaces whole, so writers need no word of each
other. Axes are channel, y, x, as the standard asks and GDAL expects.
"""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.stores.store import Store, synced

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.stores.layout import Place, Window

_COLORS = {"red": "FF0000", "green": "00FF00", "blue": "0000FF"}
_SPEED = 1  # of Zstandard: 3 takes half as long again for 1 % less of a photo


def zarr_library() -> Any:
    """Return zarr, or say how to get it."""
    try:
        import zarr
    except ImportError:
        raise InvalidInputError(
            "'.zarr' needs the extra zarr: pip install 'weftex[zarr]'"
        ) from None
    return zarr


class ZarrStore(Store):
    """A picture as a group of arrays, one a level."""

    def check(self) -> None:
        """Refuse to go on without the library."""
        zarr_library()
        self._arrays: dict[int, Any] = {}

    def create(self, about: Mapping[str, Any]) -> None:
        """Write the metadata of the group and of its arrays."""
        zarr = zarr_library()
        layout = self.layout
        bands = (layout.channels,) if layout.channels else ()
        names = ["c", "y", "x"] if bands else ["y", "x"]
        kinds = {"c": "channel", "y": "space", "x": "space"}
        group = zarr.create_group(self.path, zarr_format=3, overwrite=True)
        pyramid = []
        for level in range(self.levels):
            group.create_array(
                str(level),
                shape=(*bands, *layout.shape(level)),
                dtype=layout.dtype,
                chunks=(*bands, layout.tile, layout.tile),
                shards=(*bands, layout.block, layout.block),
                compressors=zarr.codecs.ZstdCodec(level=_SPEED),
                dimension_names=names,
            )
            scale = [float(2**level) if name != "c" else 1.0 for name in names]
            moved = [
                (k - 1) / 2 if name != "c" else 0.0 for k, name in zip(scale, names, strict=True)
            ]
            where = [
                {"type": "scale", "scale": scale},
                {"type": "translation", "translation": moved},
            ]
            pyramid.append({"path": str(level), "coordinateTransformations": where})
        name = os.path.splitext(os.path.basename(self.path))[0]
        axes = [{"name": name, "type": kinds[name]} for name in names]
        found: dict[str, Any] = {"version": "0.5", "multiscales": [
            {"name": name, "axes": axes, "datasets": pyramid, "type": "mean"}
        ]}  # fmt: skip
        if bands and layout.channels >= len(_COLORS) and layout.dtype != "float32":
            full = int(np.iinfo(layout.dtype).max)
            window = {"min": 0, "max": full, "start": 0, "end": full}
            found["omero"] = {"channels": [
                {"label": label, "color": color, "active": True, "window": window}
                for label, color in _COLORS.items()
            ]}  # fmt: skip
        group.attrs.update({"ome": found, "weftex": dict(about)})

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a shard."""
        level, row, column = place
        top, left, height, width = self.layout.window(place)
        self._array(level)[..., top : top + height, left : left + width] = (
            np.moveaxis(pixels, -1, 0) if self.layout.channels else pixels
        )
        zero = "0/" if self.layout.channels else ""
        synced(os.path.join(self.path, str(level), "c", f"{zero}{row}", str(column)))

    def read(self, level: int, window: Window) -> NDArray[Any]:
        """Read the chunks that a window touches."""
        top, left, height, width = window
        found: NDArray[Any] = self._array(level)[..., top : top + height, left : left + width]
        return np.moveaxis(found, 0, -1) if self.layout.channels else found

    def remove(self) -> None:
        """Remove the group."""
        shutil.rmtree(self.path)

    def exists(self) -> bool:
        """Whether there is a group with all that belongs to it."""
        return "weftex" in attributes(self.path)

    def _array(self, level: int) -> Any:
        if level not in self._arrays:
            zarr = zarr_library()
            # A shard of zeros must be written, too: what is not there was not made.
            with zarr.config.set({"array.write_empty_chunks": True}):
                self._arrays[level] = zarr.open_array(
                    os.path.join(self.path, str(level)), mode="r+"
                )
        return self._arrays[level]


def attributes(path: str) -> dict[str, Any]:
    """Return what a group says of itself; nothing if it is none."""
    import json

    try:
        with open(os.path.join(path, "zarr.json"), encoding="utf-8") as file:
            found = json.load(file)["attributes"]
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
