"""The repetition penalty of entire samples: salient features that repeat nearby, in any copy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.raster.turning import TURNS, Box, turned_pixels
from weftex.repeats import Offsets, Output, Repetition
from weftex.repeats import repeat_kernels as kernels
from weftex.search.windows import Windows

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


class SaliencePenalty:
    """Salient features that repeat nearby, and cells of the sample that are used more than others.

    `boxes` are those of the oriented copies that the sample is a picture of, see `prepare.turned`,
    or of the sample alone; `first` has the pixels of the first one.
    """

    def __init__(
        self,
        policy: Repetition,
        exemplar: Exemplar,
        output: Output,
        first: Windows,
        boxes: list[Box],
    ) -> None:
        self.policy, self.output, self.shape = policy, output, first.shape
        self.cell, cells = _salient_cells(first.pixels, first.usable)
        side = self.cell
        height, width = (-(-n // side) for n in self.shape)
        salience = np.zeros((height, width), np.int32)
        salience[: cells.shape[0], : cells.shape[1]] = cells
        self.salience = salience.ravel()
        rows, columns = (np.arange(n) // side for n in self.shape)
        own = (rows[:, None] * width + columns).astype(np.int32)
        #: Of each pixel of the exemplar, the cell of the sample, and the copy.
        self.cell_of = own if exemplar.turn is None else turned_pixels(own, exemplar.turn)
        self.copy_of = np.zeros(exemplar.shape, np.int32)
        self.cells = []
        for number, (top, left, high, wide) in enumerate(boxes):
            self.copy_of[top : top + high, left : left + wide] = number
            middles = [
                np.minimum(np.arange(0, n, side) + side // 2, n - 1) + start
                for n, start in ((high, top), (wide, left))
            ]
            self.cells.append(np.ascontiguousarray(self.cell_of[np.ix_(*middles)]))
        ways = [[(0, False)]] if exemplar.turn is None else TURNS[exemplar.turn]
        self.mirrored = np.array([mirrored for row in ways for _, mirrored in row], np.int32)
        near, close = (int((far * min(height, width)) ** 2) for far in (_NEAR, _CLOSE))
        self.near = np.array([near, close if self.mirrored.any() else -1], np.int32)
        # What lies around a hole stays, so repeats in line with it do not count more.
        line, self._far = (_IN_LINE, _LINE_FAR) if output.canvas.hole is None else (0.0, _FAR)
        self.weights = _weights(self.shape, side, line, self._far)

    def next_patch(self, pixel: tuple[int, int]) -> None:
        """See `Penalty.next_patch`."""
        source, cell_of, side = self.output.source, self.cell_of.ravel(), self.cell
        rows, columns = self._lines(pixel)
        shown = source[np.ix_(rows[0], columns[0])]
        v, u = np.nonzero(shown >= 0)
        label = shown[v, u]
        cell, copy = cell_of[label], self.copy_of.ravel()[label]
        order = np.argsort(cell, kind="stable")
        at = [rows[1][v] // side, columns[1][u] // side, copy, self.mirrored[copy]]
        self._where = np.ascontiguousarray(np.stack(at, 1).astype(np.int32)[order])
        some = source[::side, ::side]
        counts = np.bincount(cell_of[some[some >= 0]], minlength=len(self.salience))
        self._mean = max(float(counts.mean()), 1.0 / len(counts))
        first = np.searchsorted(cell[order], np.arange(len(self.salience) + 1))
        self._cells = np.zeros((3, len(first)), np.int32)
        self._cells[0], self._cells[1, :-1], self._cells[2, :-1] = first, counts, self.salience
        self._missing = self._missing_around(pixel, max(self.cells[0].shape))

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """See `Penalty.of`."""
        own, strength, allowed = self.cells[offsets.copy], self.policy.strength, offsets.allowed
        rows, columns = ((np.arange(n) << offsets.halvings) // self.cell for n in allowed.shape)
        asked, (v, u) = np.zeros(own.shape, np.uint8), np.nonzero(allowed)
        asked[rows[v], columns[u]] = 1
        sums = np.zeros((*own.shape, 6), np.int64)
        copy = np.array([offsets.copy, self.mirrored[offsets.copy]], np.int32)
        kernels.sum_copies(
            self._cells, self._where, self.weights, self.near, own, copy, self._missing, asked, sums
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

    def _lines(self, pixel: tuple[int, int]) -> list[NDArray[np.int32]]:
        """The rows and the columns nearby: every `cell`-th, and its distance in pixels."""
        lines, canvas = [], self.output.canvas
        for at, side, n, wraps in zip(pixel, self.shape, canvas.shape, canvas.wrap, strict=True):
            reach = -(-int((1 + self._far) * side) // self.cell) * self.cell
            away = np.arange(-reach, reach + 1, self.cell)
            line = at + away
            inside = np.full(len(line), True) if wraps else (line >= 0) & (line < n)
            lines.append(np.array([(line % n)[inside], away[inside]], np.int32))
        return lines

    def _missing_around(self, pixel: tuple[int, int], count: int) -> NDArray[np.uint8]:
        """1 where pixels are missing, of every `cell`-th up to `count` cells away."""
        away = np.arange(-count, count + 1) * self.cell
        rows, columns = (at + away for at in pixel)
        (height, width), (wrap_y, wrap_x) = self.output.canvas.shape, self.output.canvas.wrap
        missing: NDArray[np.bool_] = self.output.done[np.ix_(rows % height, columns % width)] == 0
        missing &= (wrap_y | ((rows >= 0) & (rows < height)))[:, None]
        missing &= wrap_x | ((columns >= 0) & (columns < width))
        return missing.view(np.uint8)


def _salient_cells(
    pixels: NDArray[np.uint8], usable: NDArray[np.uint8]
) -> tuple[int, NDArray[np.int32]]:
    """The side of cells in pixels, and how far the color of each is from the mean, squared."""
    side, shape = 1, usable.shape
    while min(shape) >= 2 * side * _CELLS:
        side *= 2
        pixels, usable = _halved(pixels, usable)
    away = np.square(pixels - pixels[usable != 0].sum(axis=0) / max((usable != 0).sum(), 1))
    away = away.sum(axis=2) * (usable != 0)
    mean = float(away.sum() / max((usable != 0).sum(), 1))
    away = np.minimum(away / mean, _MOST) if mean else (usable != 0).astype(np.float64)
    return side, np.rint(_LEVELS * away).astype(np.int32)


def _weights(shape: tuple[int, ...], cell: int, line: float, far: float) -> NDArray[np.int32]:
    """Weights of repeats by their distance in cells: the nearer the more, and more in `line`."""
    reach = [-(-int(far * n) // cell) for n in shape]
    down, along = (np.arange(-n, n + 1) * cell / s for n, s in zip(reach, shape, strict=True))
    away = np.sqrt(down[:, None] ** 2 + along**2)
    weight = np.maximum(1 - away / _FAR, 0)
    off = np.minimum(abs(down)[:, None], abs(along))  # the row or the column that is nearer
    weight += line * np.maximum(1 - _LINES * off, 0) * np.maximum(1 - away / _LINE_FAR, 0)
    weights: NDArray[np.int32] = np.rint(_UNIT * weight).astype(np.int32)
    return weights


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
