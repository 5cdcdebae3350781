"""Zarr of version 3 with a pyramid as OME-NGFF 0.5 describes it; a block is a shard.

Shards are files of their own, which one writer replaces whole, so writers need no word of each
other. Axes are channel, y, x, as the standard asks and GDAL expects.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import FileError, missing_packages
from weftex.planes.store import REPAIR, FilePart, Store, synced

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from weftex.planes.layout import Place, Window

_COLORS = {"red": "FF0000", "green": "00FF00", "blue": "0000FF"}
_SPEED = 1  # of Zstandard: 3 takes half as long again for 1 % less of a photo


class ZarrStore(Store):
    """A picture as a group of arrays, one a level."""

    def check(self) -> None:
        """Refuse to begin without the library."""
        try:
            import zarr  # noqa: F401
        except ImportError:
            raise missing_packages("'.zarr' needs Zarr", "zarr") from None

    def frame(self) -> Iterator[FilePart]:
        """Give the metadata of the arrays and of their group."""
        for level in range(self.levels):
            yield self._metadata(level)
        about = {"ome": self._pyramid(), "weftex": self.about}
        yield self._file({"attributes": about, "zarr_format": 3, "node_type": "group"})

    def files(self, place: Place) -> list[str]:
        """Give the shard."""
        level, row, column = place
        names = ["c", *["0"] * len(self.layout.axes), str(row), str(column)]
        return [os.path.join(self.path, str(level), *names)]

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a shard."""
        (path,) = self.files(place)
        with suppress(FileNotFoundError):
            os.unlink(path)  # Zarr reads a shard at the border first, which may be damaged
        top, left, height, width = self.layout.window(place)
        self._array(place[0])[..., top : top + height, left : left + width] = (
            np.moveaxis(pixels, -1, 0) if self.layout.channels else pixels
        )
        synced(path)

    def get(self, level: int, window: Window) -> NDArray[Any]:
        """Read the chunks that a window touches."""
        top, left, height, width = window
        found: NDArray[Any] = self._array(level)[..., top : top + height, left : left + width]
        return np.moveaxis(found, 0, -1) if self.layout.channels else found

    def _array(self, level: int) -> Any:
        if level not in self._arrays:
            import zarr

            facts = self._metadata(level)
            if not facts.is_there():
                raise FileError(f"{facts.path} is missing or damaged; {REPAIR}")
            path = os.path.join(self.path, str(level))
            # A shard of zeros must be written, too: what is not there was not made.
            with zarr.config.set({"array.write_empty_chunks": True}):
                self._arrays[level] = zarr.open_array(path, mode="r+", zarr_format=3)
        return self._arrays[level]

    @cached_property
    def _arrays(self) -> dict[int, Any]:
        """The arrays that are open, by level."""
        return {}

    def _metadata(self, level: int) -> FilePart:
        """The metadata of a level's array."""
        layout = self.layout
        little = {"configuration": {"endian": "little"}}
        pixels = {"name": "zstd", "configuration": {"level": _SPEED, "checksum": False}}
        sharding = {
            "chunk_shape": [*layout.axes, layout.tile, layout.tile],
            "codecs": [{"name": "bytes", **(little if layout.dtype != "uint8" else {})}, pixels],
            "index_codecs": [{"name": "bytes", **little}, {"name": "crc32c"}],
            "index_location": "end",
        }
        shards = {"chunk_shape": [*layout.axes, layout.block, layout.block]}
        facts = {
            "shape": [*layout.axes, *layout.shape(level)],
            "data_type": layout.dtype,
            "chunk_grid": {"name": "regular", "configuration": shards},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": 0.0 if layout.dtype == "float32" else 0,
            "codecs": [{"name": "sharding_indexed", "configuration": sharding}],
            "attributes": {},
            "dimension_names": [*"cyx"][-2 - len(layout.axes) :],
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }
        return self._file(facts, str(level))

    def _pyramid(self) -> dict[str, Any]:
        """The levels as OME-NGFF describes them."""
        layout = self.layout
        channel = len(layout.axes)
        levels = []
        for level in range(self.levels):
            scale = [1.0] * channel + [float(2**level)] * 2
            moved = [0.0] * channel + [(2**level - 1) / 2] * 2
            where = [
                {"type": "scale", "scale": scale},
                {"type": "translation", "translation": moved},
            ]
            levels.append({"path": str(level), "coordinateTransformations": where})
        name = os.path.splitext(os.path.basename(self.path))[0]
        axes = [{"name": "c", "type": "channel"}] * channel
        axes += [{"name": name, "type": "space"} for name in "yx"]
        found: dict[str, Any] = {"version": "0.5", "multiscales": [
            {"name": name, "axes": axes, "datasets": levels, "type": "mean"}
        ]}  # fmt: skip
        if layout.channels >= len(_COLORS) and layout.dtype != "float32":
            full = int(np.iinfo(layout.dtype).max)
            window = {"min": 0, "max": full, "start": 0, "end": full}
            found["omero"] = {"channels": [
                {"label": label, "color": color, "active": True, "window": window}
                for label, color in _COLORS.items()
            ]}  # fmt: skip
        return found

    def _file(self, facts: dict[str, Any], folder: str = "") -> FilePart:
        data = json.dumps(facts, indent=2).encode()
        return FilePart(os.path.join(self.path, folder, "zarr.json"), 0, data, len(data))
