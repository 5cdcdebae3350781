"""Deep Zoom: a folder of PNG tiles for every level, down to one pixel, and a file about them.

Web pages show it with OpenSeadragon, and libvips and QGIS read it.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.formats import FORMATS, show
from weftex.io.pictures import read_image, write_image
from weftex.planes.store import Piece, Store, synced

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

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
        if not FORMATS[".png"].holds(layout.dtype, colors, layout.alpha):
            raise InvalidInputError(
                f"{show(self.path)}: '.dzi' is of PNG tiles, which do not hold {layout.dtype} "
                f"pixels of {colors} channels; use .zarr or .tif"
            )

    def frame(self) -> Iterator[Piece]:
        """Give the file about the tiles."""
        layout = self.layout
        sizes = {"tile": layout.tile, "width": layout.width, "height": layout.height}
        data = _TEXT.format(**sizes).encode()
        yield Piece(self.path, 0, data, len(data))

    def files(self, place: Place) -> Iterable[str]:
        """Give the tiles of a block."""
        return (self._tile(place[0], *corner) for corner in self._corners(place))

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write the tiles of a block."""
        layout, tile = self.layout, self.layout.tile
        top, left, *_ = layout.window(place)
        os.makedirs(self._folder(place[0]), exist_ok=True)
        for row, column in self._corners(place):
            y, x = row * tile - top, column * tile - left
            part = pixels[y : y + tile, x : x + tile]
            path = self._tile(place[0], row, column)
            write_image(path, part, alpha=layout.alpha, icc=layout.icc)
            synced(path)

    def get(self, level: int, window: Window) -> NDArray[Any]:
        """Read the tiles that a window touches."""
        top, left, height, width = window
        bands, tile = self.layout.channels, self.layout.tile
        out = np.empty((height, width, *[bands] * (bands > 0)), self.layout.dtype)
        for y in range(top // tile * tile, top + height, tile):
            for x in range(left // tile * tile, left + width, tile):
                part = read_image(self._tile(level, y // tile, x // tile)).pixels
                part = part[max(top - y, 0) :, max(left - x, 0) :]
                part = part[: top + height - max(y, top), : left + width - max(x, left)]
                at = max(y - top, 0), max(x - left, 0)
                out[at[0] : at[0] + part.shape[0], at[1] : at[1] + part.shape[1]] = part.reshape(
                    *part.shape[:2], *out.shape[2:]
                )
        return out

    @property
    def roots(self) -> tuple[str, ...]:
        """The file and the folder of tiles."""
        return (self.path, self._tiles)

    @property
    def grid(self) -> tuple[int, int, int, int]:
        """A file holds a tile."""
        return (*super().grid[:3], self.layout.tile)

    def _corners(self, place: Place) -> Iterator[tuple[int, int]]:
        """Row and column of each tile of a block."""
        tile = self.layout.tile
        top, left, height, width = self.layout.window(place)
        for row in range(top // tile, -(-(top + height) // tile)):
            for column in range(left // tile, -(-(left + width) // tile)):
                yield row, column

    @property
    def _tiles(self) -> str:
        return os.path.splitext(self.path)[0] + "_files"

    def _folder(self, level: int) -> str:
        """Levels count from the smallest one."""
        return os.path.join(self._tiles, str(self.levels - 1 - level))

    def _tile(self, level: int, row: int, column: int) -> str:
        return os.path.join(self._folder(level), f"{column}_{row}.png")
