"""The windows of a sample that pixels are compared by."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError, size_words
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Bytes
from weftex.raster.boxes import whole_windows
from weftex.search.picture_kernels import Query, SampleWindows

#: How far a window reaches up, down, left and right of its center, in pixels.
Reach = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class Windows:
    """A sample's bytes, and where whole windows lie in it."""

    #: (H', W', K): the bytes that distances are taken on; a sample that tiles is padded with its
    #: other side, so that windows may hang over its border.
    pixels: Bytes
    #: (H', W'): 1 where a window may be centered: whole, on usable pixels, and not in the padding.
    usable: Bytes
    period: NDArray[np.int32]  # top, left, height, width of a tiling sample in `pixels`; or zeros
    shape: tuple[int, int]  # of the sample itself

    @property
    def kernel(self) -> SampleWindows:
        """The windows as kernels take them."""
        return SampleWindows(self.pixels, self.usable, self.period)

    @cached_property
    def centers(self) -> NDArray[np.int32]:
        """Flat indices into `pixels` where a window may be centered, in scan order."""
        return np.flatnonzero(self.usable).astype(np.int32)

    def to_sample(self, index: NDArray[np.int32]) -> NDArray[np.int32]:
        """Turn flat indices into `pixels` into those of the sample itself; -1 stays."""
        if not self.period[2]:
            return index
        y, x = np.divmod(index, self.pixels.shape[1])
        top, left, height, width = self.period
        flat = ((y - top) % height) * width + (x - left) % width
        return np.where(index < 0, np.int32(-1), flat).astype(np.int32)

    def from_sample(self, index: NDArray[np.int32]) -> NDArray[np.int32]:
        """Turn flat indices into the sample into those of `pixels`; -1 stays."""
        if not self.period[2]:
            return index
        y, x = np.divmod(index, self.shape[1])
        flat = (y + self.period[0]) * self.pixels.shape[1] + x + self.period[1]
        return np.where(index < 0, np.int32(-1), flat).astype(np.int32)


def windows_of(exemplar: Exemplar, reach: Reach, pixels: Bytes | None = None) -> Windows:
    """Return the whole windows of a sample, with a reach (up, down, left, right) in pixels.

    Distances are taken on `pixels`, by default those of `exemplar.matching`.
    """
    pixels = exemplar.matching() if pixels is None else pixels
    up, down, left, right = reach
    mask = exemplar.usable
    period = np.zeros(4, np.int32)
    if exemplar.tileable:
        period[:] = (up, left, *exemplar.shape)
        pads = ((up, down), (left, right))
        pixels = np.pad(pixels, (*pads, (0, 0)), mode="wrap")
        mask = np.pad(mask, pads, mode="wrap")
    usable = whole_windows(mask, reach)
    if not usable.any():
        raise InvalidInputError(
            f"no whole window of {left + right + 1}x{up + down + 1} pixels lies on usable pixels "
            f"of {exemplar.name}, which is {size_words(exemplar.shape)}; make window_width smaller"
        )
    return Windows(np.ascontiguousarray(pixels), usable, period, exemplar.shape)


def new_query(reach: int, channels: int) -> Query:
    """Return an empty query for the known part of a square window, or of the 8 neighbors."""
    width = max(2 * reach + 1, 3)
    runs = np.empty((width * (width + 1), 3), np.int32)
    return Query(runs, np.empty(width * width * channels, np.uint8))


def square_windows(exemplar: Exemplar, width: int, pixels: Bytes | None = None) -> Windows:
    """Return the square windows of a sample, of an odd width; see `windows_of`."""
    return windows_of(exemplar, (width // 2,) * 4, pixels)
