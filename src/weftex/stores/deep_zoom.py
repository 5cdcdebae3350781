"""Deep Zoom: a folder of PNG tiles for every level, down to one pixel, and a file about them.

Web pages show it with OpenSeadragon, and libvips and QGIS read it.
"""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.errors import InvalidInputError
from weftex.io.formats import FORMATS, show
from weftex.io.pictures import read_image, write_image, write_text
from weftex.stores.store import Store, synced

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weftex.stores.layout import Place, Window

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

    def create(self, about: Mapping[str, Any]) -> None:
        """Make the folders, then the file."""
        for level in range(self.levels):
            os.makedirs(self._folder(level), exist_ok=True)
        layout = self.layout
        sizes = {"tile": layout.tile, "width": layout.width, "height": layout.height}
        write_text(self.path, _TEXT.format(**sizes))

    def put(self, place: Place, pixels: NDArray[Any]) -> None:
        """Write the tiles of a block."""
        layout, tile = self.layout, self.layout.tile
        top, left, height, width = layout.window(place)
        for y in range(0, height, tile):
            for x in range(0, width, tile):
                path = self._tile(place[0], (top + y) // tile, (left + x) // tile)
                part = pixels[y : y + tile, x : x + tile]
                write_image(path, part, alpha=layout.alpha, icc=layout.icc)
                synced(path)

    def read(self, level: int, window: Window) -> NDArray[Any]:
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

    def remove(self) -> None:
        """Remove the file and its tiles."""
        shutil.rmtree(self._tiles, ignore_errors=True)
        os.unlink(self.path)

    @property
    def _tiles(self) -> str:
        return os.path.splitext(self.path)[0] + "_files"

    def _folder(self, level: int) -> str:
        """Levels count from the smallest one."""
        return os.path.join(self._tiles, str(self.levels - 1 - level))

    def _tile(self, level: int, row: int, column: int) -> str:
        return os.path.join(self._folder(level), f"{column}_{row}.png")
