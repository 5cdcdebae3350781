"""Zarr of version 3 with a pyramid as OME-NGFF 0.5 describes it; a block is a shard.

Shards are files of their own, which one writer replaces whole, so writers need no word of each
other. Axes are channel, y, x, as the standard asks and GDAL expects.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import FileError, InvalidInputError
from weftex.io.formats import show
from weftex.planes.store import REPAIR, Piece, Store, synced

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from numpy.typing import NDArray

    from weftex.planes.layout import Place, Window

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

    def frame(self) -> Iterator[Piece]:
        """Give the metadata of the arrays and of their group."""
        for level in range(self.levels):
            yield self._metadata(level)
        about = {"ome": self._pyramid(), "weftex": self.about}
        yield self._file({"attributes": about, "zarr_format": 3, "node_type": "group"})

    def files(self, place: Place) -> Iterable[str]:
        """Give the shard."""
        level, row, column = place
        zero = "0/" if self.layout.channels else ""
        return (os.path.join(self.path, str(level), "c", f"{zero}{row}", str(column)),)

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write a shard."""
        level, *_ = place
        top, left, height, width = self.layout.window(place)
        (path,) = self.files(place)
        with suppress(FileNotFoundError):
            os.unlink(path)  # Zarr reads a shard at the border first, which may be damaged
        self._array(level)[..., top : top + height, left : left + width] = (
            np.moveaxis(pixels, -1, 0) if self.layout.channels else pixels
        )
        synced(path)

    def get(self, level: int, window: Window) -> NDArray[Any]:
        """Read the chunks that a window touches."""
        top, left, height, width = window
        found: NDArray[Any] = self._array(level)[..., top : top + height, left : left + width]
        return np.moveaxis(found, 0, -1) if self.layout.channels else found

    def _of(self, height: int, width: int) -> list[int]:
        """The shape of an array, a shard or a chunk."""
        return [*[self.layout.channels] * (self.layout.channels > 0), height, width]

    @property
    def _axes(self) -> list[str]:
        return ["c", "y", "x"] if self.layout.channels else ["y", "x"]

    @property
    def _array_facts(self) -> dict[str, Any]:
        """What the metadata of every level says."""
        layout = self.layout
        little = {"configuration": {"endian": "little"}} if layout.dtype != "uint8" else {}
        pixels = {"name": "zstd", "configuration": {"level": _SPEED, "checksum": False}}
        index = {"name": "bytes", "configuration": {"endian": "little"}}
        sharding = {
            "chunk_shape": self._of(layout.tile, layout.tile),
            "codecs": [{"name": "bytes", **little}, pixels],
            "index_codecs": [index, {"name": "crc32c"}],
            "index_location": "end",
        }
        shards = {"chunk_shape": self._of(layout.block, layout.block)}
        return {
            "data_type": layout.dtype,
            "chunk_grid": {"name": "regular", "configuration": shards},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": 0.0 if layout.dtype == "float32" else 0,
            "codecs": [{"name": "sharding_indexed", "configuration": sharding}],
            "attributes": {},
            "dimension_names": self._axes,
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }

    def _pyramid(self) -> dict[str, Any]:
        """The levels as OME-NGFF describes them."""
        layout, names = self.layout, self._axes
        kinds = {"c": "channel", "y": "space", "x": "space"}
        levels = []
        for level in range(self.levels):
            scale = [float(2**level) if name != "c" else 1.0 for name in names]
            moved = [
                (k - 1) / 2 if name != "c" else 0.0 for k, name in zip(scale, names, strict=True)
            ]
            where = [
                {"type": "scale", "scale": scale},
                {"type": "translation", "translation": moved},
            ]
            levels.append({"path": str(level), "coordinateTransformations": where})
        name = os.path.splitext(os.path.basename(self.path))[0]
        axes = [{"name": name, "type": kinds[name]} for name in names]
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

    def _metadata(self, level: int) -> Piece:
        shape = self._of(*self.layout.shape(level))
        return self._file({"shape": shape, **self._array_facts}, str(level))

    def _file(self, facts: dict[str, Any], folder: str = "") -> Piece:
        data = json.dumps(facts, indent=2).encode()
        return Piece(os.path.join(self.path, folder, "zarr.json"), 0, data, len(data))

    def _array(self, level: int) -> Any:
        if level not in self._arrays:
            zarr, facts = zarr_library(), self._metadata(level)
            if not facts.is_there():
                raise FileError(f"{show(facts.path)} is missing or damaged; {REPAIR}")
            # A shard of zeros must be written, too: what is not there was not made.
            with zarr.config.set({"array.write_empty_chunks": True}):
                self._arrays[level] = zarr.open_array(
                    os.path.join(self.path, str(level)), mode="r+", zarr_format=3
                )
        return self._arrays[level]
