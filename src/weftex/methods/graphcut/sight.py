"""What stands out in the sample is not shown again in sight of itself; no idea of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut.copies import copies_of
from weftex.methods.graphcut.repeat_kernels import sum_over

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

    @property
    def count(self) -> list[int]:
        """How many cells there are along both axes."""
        return [-(-n // self.cell) for n in self.shape]

    def again(self, pixel: tuple[int, int], cells: NDArray[np.uint8]) -> NDArray[np.float64]:
        """For the places of some cells that come to lie on a pixel; of others nothing is said.

        The weight of its distance if all that is newly shown is shown once.
        """
        count = self.count
        rows, columns = (
            self._line(axis, at, n * self.cell, self.holes[axis])
            for axis, (at, n) in enumerate(zip(pixel, count, strict=True))
        )
        missing = self.growth.done[np.ix_(rows[1], columns[1])] == 0
        missing &= rows[2][:, None] & columns[2]
        shifts, shown = self._pieces(pixel)
        down, along = (
            (np.arange(n) * self.cell + shift[:, None]) / side
            for n, shift, side in zip(count, shifts, self.shape, strict=True)
        )
        weights = self._weights(down[:, :, None], along[:, None]) * (cells != 0)
        near = weights.any(axis=(1, 2))
        # Its middle, where a place may be, lies a sample's length from the corner of `missing`.
        where, offset = missing.view(np.uint8), np.array(count, np.int32)
        total, sums = np.zeros(count, np.int64), np.zeros((*count, 2), np.int64)
        for piece, weight in zip(shown[near], weights[near], strict=True):
            sum_over(piece, where, cells, offset, sums)
            total += weight * sums[..., 0]
        sum_over(self.salience, where, cells, offset, sums)
        result: NDArray[np.float64] = total / np.maximum(_WEIGHTS * sums[..., 0], 1)
        return result

    def _weights(self, down: NDArray[np.float64], along: NDArray[np.float64]) -> NDArray[np.int64]:
        """What a repetition counts at a distance, in sides of the sample: the nearer, the more."""
        far = np.sqrt(np.square(down) + np.square(along))
        weights: NDArray[np.float64] = np.maximum(1 - far / _FAR, 0)
        if self.lines:
            off = np.minimum(np.abs(down), np.abs(along))  # the row or the column that is nearer
            line = np.maximum(1 - _LINES * off, 0) * np.maximum(1 - far / _LINE_FAR, 0)
            weights += _IN_LINE * line
        return np.rint(_WEIGHTS * weights).astype(np.int64)

    def _line(
        self, axis: int, at: int, reach: int, ends: tuple[int, int]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """Every `cell`-th row or column up to a reach: how far away, which, whether it counts."""
        n, wraps = self.growth.canvas.shape[axis], self.growth.canvas.wrap[axis]
        away = np.arange(-reach, reach + 1, self.cell)
        line = at + away
        inside = np.full(len(line), True) if wraps else (line >= ends[0]) & (line < ends[1])
        return away, line % n, inside

    def _pieces(self, pixel: tuple[int, int]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """The pieces in sight: how they are shifted as seen from the pixel, and what they show."""
        far = _LINE_FAR if self.lines else _FAR
        rows, columns = (
            self._line(axis, at, -(-int((1 + far) * n) // self.cell) * self.cell, (0, m))
            for axis, (at, n, m) in enumerate(
                zip(pixel, self.shape, self.growth.canvas.shape, strict=True)
            )
        )
        source = self.growth.source[np.ix_(rows[1], columns[1])]
        v, u = np.nonzero((source >= 0) & rows[2][:, None] & columns[2])
        y, x = np.divmod(source[v, u], self.shape[1])
        # One number for each shift, and that of neighbors once, as most are of one piece.
        down, along = rows[0][v] - y, columns[0][u] - x
        width = 2 * int(abs(along).max(initial=0)) + 1
        number = down * width + along
        starts = np.flatnonzero(np.diff(number, prepend=number[:1] - 1))
        found, run = _different(number[starts])
        piece = np.repeat(run, np.diff(starts, append=len(number)))
        along = (found + width // 2) % width - width // 2
        shown = np.zeros((len(found), *self.salience.shape), np.int32)
        y, x = (
            np.minimum(p // self.cell, n - 1)
            for p, n in zip((y, x), self.salience.shape, strict=True)
        )
        shown[piece, y, x] = self.salience[y, x]
        return np.stack([(found - along) // width, along]), shown


def _different(numbers: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The different numbers, sorted, and for each which it is; np.unique loads masked arrays."""
    order = numbers.argsort()
    again = numbers[order]
    first = np.diff(again, prepend=again[:1] - 1) != 0
    which = np.empty(len(numbers), np.int64)
    which[order] = np.cumsum(first) - 1
    return again[first], which
