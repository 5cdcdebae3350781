"""The repetition penalty of entire samples: salient features that repeat nearby, in any copy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.raster.arrays import fast_size
from weftex.raster.turning import TURNS, turned_pixels
from weftex.repeats import Usage
from weftex.repeats import repeat_kernels as kernels
from weftex.search.translation import correlations

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.raster.turning import Box
    from weftex.repeats import Offsets, Output, Repetition

#: What repeats count for: strength apart, see `Repetition`.
_CELLS = 16  # of the sample's shorter side, or up to twice as many, are looked at
_LEVELS = 16  # of salience, so that sums are of whole numbers
_MOST = 8  # times the mean salience; what stands out more counts as much
_FAR = 1.25  # sides of the sample from which on nothing is in sight
# Repeats in the same row or column count so much more, and farther away; a sixth of a side off
# it is in another one.
_IN_LINE, _LINE_FAR, _LINES = 2.0, 2.0, 6.0
_UNIT = 64  # weight of a repeat at no distance
# What an offset shows within a third of a side of another copy of it costs by its share, at most.
_BESIDE, _NEAR, _MOST_BESIDE = 10.0, 0.35, 4.0
# A feature beside its mirror image is seen at once, and costs nothing to cut between. So an offset
# with more than a share within a seventh of a side is taken only where there is no other.
_CLOSE, _SHARE, _NEVER = 0.15, 0.05, 1e6


class Sight:
    """The salience of a sample by cells, and what counts as a repeat near a pixel.

    The salience of a cell is how far its color is from the sample's mean, squared. What lies around
    a hole stays, so repeats in line with it do not count more.
    """

    def __init__(
        self, output: Output, pixels: NDArray[np.uint8], usable: NDArray[np.uint8]
    ) -> None:
        self.output, self.shape = output, usable.shape
        self.cell = 1
        while min(self.shape) >= 2 * self.cell * _CELLS:
            self.cell *= 2
            pixels, usable = _halved(pixels, usable)
        away = np.square(pixels - pixels[usable != 0].sum(axis=0) / max((usable != 0).sum(), 1))
        away = away.sum(axis=2) * (usable != 0)
        mean = float(away.sum() / max((usable != 0).sum(), 1))
        away = np.minimum(away / mean, _MOST) if mean else (usable != 0).astype(np.float64)
        self.salience = np.rint(_LEVELS * away).astype(np.int32)
        self.count = [-(-n // self.cell) for n in self.shape]
        line, self.far = (_IN_LINE, _LINE_FAR) if output.canvas.hole is None else (0.0, _FAR)
        self.distances = np.array(
            [self.cell, *self.shape, _FAR, line, _LINE_FAR, _LINES, _UNIT], np.float64
        )

    def cells_of(
        self, offsets: Offsets, count: list[int]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]:
        """The cell of each row and column of offsets, and 1 for the cells that have an offset."""
        allowed = offsets.allowed
        rows, columns = ((np.arange(n) << offsets.halvings) // self.cell for n in allowed.shape)
        cells, (v, u) = np.zeros(count, np.uint8), np.nonzero(allowed)
        cells[rows[v], columns[u]] = 1
        return rows, columns, cells

    def missing(self, pixel: tuple[int, int], down: int, along: int) -> NDArray[np.uint8]:
        """Whether a pixel is missing, for every `cell`-th pixel up to a number of cells away."""
        rows, columns = (
            np.arange(at - n * self.cell, at + n * self.cell + 1, self.cell)
            for at, n in zip(pixel, (down, along), strict=True)
        )
        return missing_at(self.output, rows, columns)

    def lines(self, pixel: tuple[int, int]) -> list[NDArray[np.int32]]:
        """The rows and the columns nearby: every `cell`-th, and its distance in pixels."""
        lines, canvas = [], self.output.canvas
        for at, side, n, wraps in zip(pixel, self.shape, canvas.shape, canvas.wrap, strict=True):
            reach = -(-int((1 + self.far) * side) // self.cell) * self.cell
            away = np.arange(-reach, reach + 1, self.cell)
            line = at + away
            inside = np.full(len(line), True) if wraps else (line >= 0) & (line < n)
            lines.append(np.array([(line % n)[inside], away[inside]], np.int32))
        return lines


class SaliencePenalty:
    """Salient features that repeat nearby, and pixels that are used more than others.

    The canvas shows pieces of the sample; a patch shifted by t and a piece shifted by t' show the
    same places at the distance t - t'. Copies that the method matches on are up to `reduction`
    times smaller.
    """

    def __init__(
        self,
        policy: Repetition,
        output: Output,
        pixels: NDArray[np.uint8],
        usable: NDArray[np.uint8],
        reduction: int,
    ) -> None:
        self.policy, self.output = policy, output
        height, width = usable.shape
        self.usage = Usage(output, (height, width), (height, width), 2 * reduction)
        self.sight, self.next_patch = Sight(output, pixels, usable), self.usage.next_patch
        self._reach = [-(-(n - 1) // reduction) * reduction for n in usable.shape]
        self._reduction = reduction

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """See `Penalty.of`."""
        use = self._use(offsets)
        rows, columns, cells = self.sight.cells_of(offsets, self.sight.count)
        nearby = self._in_sight(offsets.pixel, cells)[np.ix_(rows, columns)]
        return self.policy.factors(nearby=nearby, use=use)

    def _use(self, offsets: Offsets) -> NDArray[np.float64]:
        """How often the canvas shows what each offset would newly show, 1 as often as the mean."""
        counts, k, allowed = self.usage.counts(offsets.halvings), offsets.halvings, offsets.allowed
        lines = (
            np.arange(at - reach, at + reach + self._reduction)[:: 1 << k]
            for at, reach in zip(offsets.pixel, self._reach, strict=True)
        )
        missing, offset = missing_at(self.output, *lines), [reach >> k for reach in self._reach]
        shown, area = sums_under(missing, counts, offset, allowed.shape)
        mean = counts.mean()
        result: NDArray[np.float64] = shown / np.maximum(area * mean, mean or 1)
        return result

    def _in_sight(self, pixel: tuple[int, int], cells: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Repeats of what the offsets of some cells would newly show, by salience and distance."""
        sight, count = self.sight, self.sight.count
        missing = sight.missing(pixel, *count)
        total = np.zeros(count, np.int64)
        kernels.sum_pieces(*self._pieces(pixel), missing, cells, sight.distances, total)
        salience = sums_under(missing, sight.salience, count, tuple(count))[0]
        result: NDArray[np.float64] = total / np.maximum(_UNIT * salience, 1)
        return result

    def _pieces(
        self, pixel: tuple[int, int]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
        """The pieces nearby: their salience by cells, the boxes of these, and their shifts."""
        sight, source = self.sight, self.output.source
        rows, columns = sight.lines(pixel)
        size, width = (rows.shape[1], columns.shape[1]), sight.shape[1]
        shifts, pieces = np.empty((size[0] * size[1], 2), np.int32), np.empty(size, np.int32)
        count = kernels.find_pieces(source, rows, columns, width, shifts, pieces)
        shown = np.zeros((count, *sight.salience.shape), np.int32)
        boxes = np.empty((count, 4), np.int32)
        at = np.array([sight.cell, width], np.int32)
        kernels.show_pieces(source, rows, columns, pieces, at, sight.salience, shown, boxes)
        return shown, boxes, shifts[:count]


def sums_under(
    missing: NDArray[np.uint8], values: NDArray[Any], offset: list[int], shape: tuple[int, ...]
) -> NDArray[np.int64]:
    """(2, H, W): sums of the values under missing pixels at each offset, and these pixels."""
    size = tuple(fast_size(n + m) for n, m in zip(values.shape, missing.shape, strict=True))
    both = correlations(np.stack([values, np.ones_like(values)]), missing, size)
    return np.roll(both, offset, (1, 2))[:, : shape[0], : shape[1]]


def missing_at(
    output: Output, rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> NDArray[np.uint8]:
    """1 where pixels of these rows and columns are missing, 0 beyond the canvas."""
    (height, width), (wrap_y, wrap_x) = output.canvas.shape, output.canvas.wrap
    missing: NDArray[np.bool_] = output.done[np.ix_(rows % height, columns % width)] == 0
    missing &= (wrap_y | ((rows >= 0) & (rows < height)))[:, None]
    missing &= wrap_x | ((columns >= 0) & (columns < width))
    return missing.view(np.uint8)


def _halved(
    pixels: NDArray[np.uint8], usable: NDArray[np.uint8]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Rounded means of squares of four pixels, usable if all four are."""
    rows, columns = (n // 2 * 2 for n in usable.shape)
    upper, lower = pixels[:rows:2, :columns], pixels[1:rows:2, :columns]
    total = np.add(upper[:, ::2], upper[:, 1::2], dtype=np.uint16) + lower[:, ::2] + lower[:, 1::2]
    upper, lower = usable[:rows:2, :columns], usable[1:rows:2, :columns]
    half = upper[:, ::2] & upper[:, 1::2] & lower[:, ::2] & lower[:, 1::2]
    return (total + 2 >> 2).astype(np.uint8), half


class OrientedPenalty:
    """`SaliencePenalty` where the sample is a picture of oriented copies, see `prepare.turned`.

    `boxes` are those of the copies; the first is the sample, of these pixels.
    """

    def __init__(
        self,
        policy: Repetition,
        exemplar: Exemplar,
        output: Output,
        pixels: NDArray[np.uint8],
        usable: NDArray[np.uint8],
        boxes: list[Box],
    ) -> None:
        self.policy, self.output = policy, output
        self.sight = sight = Sight(output, pixels, usable)
        height, width = sight.count
        side = sight.cell
        rows, columns = (np.arange(n) // side for n in sight.shape)
        own = (rows[:, None] * width + columns).astype(np.int32)
        assert exemplar.turn is not None
        #: Of each pixel of the picture of copies, the cell of the sample, and the copy.
        self.cell_of = turned_pixels(own, exemplar.turn)
        self.copy_of = np.zeros(exemplar.shape, np.int32)
        self.cells = []
        for number, (top, left, high, wide) in enumerate(boxes):
            self.copy_of[top : top + high, left : left + wide] = number
            middles = [
                np.minimum(np.arange(0, n, side) + side // 2, n - 1) + start
                for n, start in ((high, top), (wide, left))
            ]
            self.cells.append(np.ascontiguousarray(self.cell_of[np.ix_(*middles)]))
        salience = np.zeros((height, width), np.int32)
        salience[: sight.salience.shape[0], : sight.salience.shape[1]] = sight.salience
        self.salience = salience.ravel()
        copies = [copy for row in TURNS[exemplar.turn] for copy in row]
        self.mirrored = np.array([mirrored for _, mirrored in copies], np.int32)
        near, close = (int((far * min(height, width)) ** 2) for far in (_NEAR, _CLOSE))
        self.near = np.array([near, close if self.mirrored.any() else -1], np.int32)
        reach = [-(-int(sight.far * n) // side) for n in sight.shape]
        self.weights = np.empty([2 * n + 1 for n in reach], np.int32)
        kernels.weigh_cells(sight.distances, self.weights)

    def next_patch(self, pixel: tuple[int, int]) -> None:
        """See `Penalty.next_patch`."""
        sight, source, cell_of = self.sight, self.output.source, self.cell_of.ravel()
        rows, columns = sight.lines(pixel)
        shown = source[np.ix_(rows[0], columns[0])]
        v, u = np.nonzero(shown >= 0)
        label = shown[v, u]
        cell, copy = cell_of[label], self.copy_of.ravel()[label]
        order = np.argsort(cell, kind="stable")
        at = [rows[1][v] // sight.cell, columns[1][u] // sight.cell, copy, self.mirrored[copy]]
        self._where = np.ascontiguousarray(np.stack(at, 1).astype(np.int32)[order])
        some = source[:: sight.cell, :: sight.cell]
        counts = np.bincount(cell_of[some[some >= 0]], minlength=len(self.salience))
        self._mean = max(float(counts.mean()), 1.0 / len(counts))
        first = np.searchsorted(cell[order], np.arange(len(self.salience) + 1))
        self._cells = np.zeros((3, len(first)), np.int32)
        self._cells[0], self._cells[1, :-1], self._cells[2, :-1] = first, counts, self.salience
        self._missing = sight.missing(pixel, *[max(self.cells[0].shape)] * 2)

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """See `Penalty.of`."""
        own, strength = self.cells[offsets.copy], self.policy.strength
        rows, columns, cells = self.sight.cells_of(offsets, list(own.shape))
        sums = np.zeros((*own.shape, 6), np.int64)
        copy = np.array([offsets.copy, self.mirrored[offsets.copy]], np.int32)
        kernels.sum_copies(
            self._cells, self._where, self.weights, self.near, own, copy, self._missing, cells, sums
        )
        repeats, salience, used, beside, area, mirrored = np.moveaxis(sums, 2, 0)
        factors = self.policy.factors(
            nearby=repeats / np.maximum(_UNIT * salience, 1),
            use=used / np.maximum(area * self._mean, 1),
        )
        factors += strength * np.minimum(_BESIDE * beside / np.maximum(area, 1), _MOST_BESIDE)
        factors[mirrored > _SHARE * own.size] += strength * _NEVER
        result: NDArray[np.float64] = factors[np.ix_(rows, columns)]
        return result
