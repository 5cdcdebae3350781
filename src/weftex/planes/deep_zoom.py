"""Deep Zoom: a folder of PNG tiles for every level, down to one pixel, and a file about them.

Web pages show it with OpenSeadragon, and libvips and QGIS read it.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.pictures import read_image, write_image
from weftex.planes.store import FilePart, Store, synced

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from weftex.planes.layout import Place, Window

_TEXT = """\
<?xml version="1.0" encoding="UTF-8"?>
<Image xmlns="http://schemas.microsoft.com/deepzoom/2008"
       Format="png" Overlap="0" TileSize="{tile}">
  <Size Width="{width}" Height="{height}"/>
</Image>
"""


class DeepZoomStore(Store):
    """A picture as tiles of a web page."""

    smallest: ClassVar[int] = 1

    def check(self) -> None:
        """Refuse pixels that PNG does not hold."""
        layout = self.layout
        colors = max(layout.channels, 1) - layout.alpha
        if layout.dtype == "float32" or colors not in (1, 3):
            raise InvalidInputError(
                f"{self.path}: '.dzi' is of PNG tiles, which do not hold {layout.dtype} "
                f"pixels of {colors} channels; use .zarr or .tif"
            )

    def frame(self) -> Iterator[FilePart]:
        """Give the file about the tiles."""
        layout = self.layout
        data = _TEXT.format(tile=layout.tile, width=layout.width, height=layout.height).encode()
        yield FilePart(self.path, 0, data, len(data))

    def files(self, place: Place) -> list[str]:
        """Give the tiles of a block."""
        return [path for path, *_ in self._tiles(place[0], self.layout.window(place))]

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write the tiles of a block."""
        window = self.layout.window(place)
        for path, rows, columns, *_ in self._tiles(place[0], window):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            part = pixels[rows, columns]
            write_image(path, part, alpha=self.layout.alpha, icc=self.layout.icc)
            synced(path)

    def get(self, level: int, window: Window) -> NDArray[Any]:
        """Read the tiles that a window touches."""
        out = np.empty((*window[2:], *self.layout.axes), self.layout.dtype)
        for path, rows, columns, y, x in self._tiles(level, window):
            part, place = read_image(path).pixels, out[rows, columns]
            part = part[y : y + len(place), x : x + place.shape[1]]
            place[:] = part.reshape(place.shape)
        return out

    def _tiles(self, level: int, window: Window) -> Iterator[tuple[str, slice, slice, int, int]]:
        """The tiles that a window touches: path, rows and columns in it, first ones in the tile."""
        top, left, height, width = window
        tile = self.layout.tile
        folder = os.path.join(self._folder, str(self.levels - 1 - level))  # from the smallest one
        for row in range(top // tile, -(-(top + height) // tile)):
            for column in range(left // tile, -(-(left + width) // tile)):
                y, x = row * tile - top, column * tile - left
                rows = slice(max(y, 0), min(y + tile, height))
                columns = slice(max(x, 0), min(x + tile, width))
                path = os.path.join(folder, f"{column}_{row}.png")
                yield path, rows, columns, max(-y, 0), max(-x, 0)

    @property
    def roots(self) -> tuple[str, ...]:
        """The file and the folder of tiles."""
        return (self.path, self._folder)

    @property
    def grid(self) -> list[int]:
        """As of others, but that a file holds a tile."""
        return [*super().grid[:3], self.layout.tile]

    @property
    def _folder(self) -> str:
        return os.path.splitext(self.path)[0] + "_files"
