"""What stands out in the sample is not shown again in sight of itself; no idea of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut import repeat_kernels as kernels
from weftex.methods.graphcut.copies import copies_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.copies import Copy
    from weftex.methods.pixels.growth import Growth

_CELLS = 16  # of the sample's shorter side, or up to twice as many, are looked at
_LEVELS = 16  # of salience, so that sums are of whole numbers
_MOST = 8  # times the mean; what stands out more than that counts as much
_FAR = 1.25  # sides of the sample from which on nothing is in sight
# What comes again in the same row or column counts so much more, and farther away; a sixth of a
# side off it is in another one.
_IN_LINE, _LINE_FAR, _LINES = 2.0, 2.0, 6.0
_WEIGHTS = 64  # of distances, likewise


class Sight:
    """How much of what a patch would newly show is shown already, and near.

    A place counts by its salience: how far its color is from the sample's mean, squared. The canvas
    shows pieces of the sample; a patch shifted by t and a piece shifted by t' show the same places
    at the distance t - t'.

    Parameters
    ----------
    growth : Growth
        The canvas.
    sample : Copy
        The sample in full size.
    holes : list of (int, int)
        First row and one after the last where something is missing, and columns.
    """

    UNIT = _WEIGHTS  #: of what repetitions count

    def __init__(self, growth: Growth, sample: Copy, holes: list[tuple[int, int]]) -> None:
        self.growth, self.shape, self.holes = growth, sample.mask.shape, holes
        self.lines = growth.canvas.hole is None  # what is around a hole stays, and is to be met
        self.cell = 1
        while min(self.shape) >= 2 * self.cell * _CELLS:
            self.cell *= 2
        copy = copies_of(sample, self.cell)[-1]
        usable = copy.mask != 0
        away = np.square(copy.pixels - copy.pixels[usable].sum(axis=0) / max(usable.sum(), 1))
        away = away.sum(axis=2) * usable
        mean = float(away.sum() / max(usable.sum(), 1))
        away = np.minimum(away / mean, _MOST) if mean else usable.astype(np.float64)
        self.salience = np.rint(_LEVELS * away).astype(np.int32)
        line, self.far = (_IN_LINE, _LINE_FAR) if self.lines else (0.0, _FAR)
        self.distances = kernels.Distances(
            self.cell, self.shape, _FAR, line, _LINE_FAR, _LINES, _WEIGHTS
        )

    @property
    def count(self) -> list[int]:
        """How many cells there are along both axes."""
        return [-(-n // self.cell) for n in self.shape]

    def again(self, pixel: tuple[int, int], cells: NDArray[np.uint8]) -> NDArray[np.float64]:
        """For the places of some cells that come to lie on a pixel; of others nothing is said.

        The weight of its distance if all that is newly shown is shown once.
        """
        count = self.count
        missing = self.missing(pixel, *count)
        offset = np.array(count, np.int32)
        # Its middle, where a place may be, lies a sample's length from the corner of `missing`.
        total, sums = np.zeros(count, np.int64), np.zeros((*count, 2), np.int64)
        kernels.sum_pieces(*self._pieces(pixel), missing, cells, self.distances, total)
        kernels.sum_over(self.salience, missing, cells, offset, sums)
        result: NDArray[np.float64] = total / np.maximum(_WEIGHTS * sums[..., 0], 1)
        return result

    def missing(self, pixel: tuple[int, int], down: int, along: int) -> NDArray[np.uint8]:
        """Whether a pixel is missing up to so many cells away: every `cell`-th, both ways."""
        rows, columns = (
            self._line(axis, at, n * self.cell, self.holes[axis])
            for axis, (at, n) in enumerate(zip(pixel, (down, along), strict=True))
        )
        missing: NDArray[np.bool_] = self.growth.done[np.ix_(rows[1], columns[1])] == 0
        missing &= rows[2][:, None] & columns[2]
        return missing.view(np.uint8)

    def weights(self) -> NDArray[np.int32]:
        """What a repetition counts that lies so many cells away; the middle is no distance."""
        reach = [-(-int(self.far * n) // self.cell) for n in self.shape]
        weights = np.empty([2 * n + 1 for n in reach], np.int32)
        kernels.weigh_cells(self.distances, weights)
        return weights

    def _line(
        self, axis: int, at: int, reach: int, ends: tuple[int, int]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """Every `cell`-th row or column up to a reach: how far away, which, whether it counts."""
        n, wraps = self.growth.canvas.shape[axis], self.growth.canvas.wrap[axis]
        away = np.arange(-reach, reach + 1, self.cell)
        line = at + away
        inside = np.full(len(line), True) if wraps else (line >= ends[0]) & (line < ends[1])
        return away, line % n, inside

    def lines_of(self, pixel: tuple[int, int]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The rows and the columns in sight: every `cell`-th, and how many pixels away it is."""
        rows, columns = (
            self._in_sight(axis, at, int((1 + self.far) * n))
            for axis, (at, n) in enumerate(zip(pixel, self.shape, strict=True))
        )
        return rows, columns

    def _pieces(
        self, pixel: tuple[int, int]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
        """The pieces in sight: what they show, where, and how they are shifted from the pixel."""
        rows, columns = self.lines_of(pixel)
        source, size = self.growth.source, (rows.shape[1], columns.shape[1])
        shifts, pieces = np.empty((size[0] * size[1], 2), np.int32), np.empty(size, np.int32)
        count = kernels.find_pieces(source, rows, columns, self.shape[1], shifts, pieces)
        shown = np.zeros((count, *self.salience.shape), np.int32)
        boxes = np.empty((count, 4), np.int32)
        kernels.show_pieces(
            source, rows, columns, pieces, self.distances, self.salience, shown, boxes
        )
        return shown, boxes, shifts[:count]

    def _in_sight(self, axis: int, at: int, reach: int) -> NDArray[np.int32]:
        """The rows or columns up to a reach, and how far away they are."""
        reach = -(-reach // self.cell) * self.cell
        away, line, inside = self._line(axis, at, reach, (0, self.growth.canvas.shape[axis]))
        return np.array([line[inside], away[inside]], np.int32)
