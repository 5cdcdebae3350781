"""The repetition penalty of entire samples: salient features that repeat nearby, in any copy."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.raster.arrays import Bytes, Floats, Indices, Ints, Mask
from weftex.raster.turning import TURNS, Box, turned_pixels
from weftex.repeats import Output, Repetition
from weftex.repeats import repeat_kernels as kernels

#: What repeats count for: strength apart, see `Repetition`.
_CELLS, _OF_COPIES = 16, 11  # of the shorter side, or up to twice as many; fewer if it is thin
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
# What a line of pixels as long as the sample costs by mean salience that is shown again at no
# distance, and if shown as often as the mean, as a share of a `unit`.
_PRICE, _PRICE_OF_USE = 3.3, 1.1
_HIGHEST = 2**20  # of a pixel, so that sums over blocks are no larger than an int


class SaliencePenalty:
    """Salient features that repeat nearby, and cells of the sample that are used more than others.

    `of` says by which factor a whole patch costs more, and `prices` what each part of it adds.

    `boxes` are those of the oriented copies that the sample is a picture of, see `prepare.turned`,
    or of the sample alone; `small` are its pixels and mask, a pixel for each cell.
    """

    def __init__(
        self,
        policy: Repetition,
        exemplar: Exemplar,
        output: Output,
        boxes: list[Box],
        small: tuple[Bytes, Bytes],
        unit: float,
    ) -> None:
        self.policy, self.output, self.shape = policy, output, boxes[0][2:]
        #: What a patch covers from its first pixel on, in pixels; None: as far as the sample goes.
        self.covers: tuple[int, int] | None = None
        self._unit = policy.strength * unit / min(self.shape)
        side = self.cell = cell_side(boxes)
        height, width = (-(-n // side) for n in self.shape)
        salience = np.zeros((height, width), np.int32)
        salience[: small[1].shape[0], : small[1].shape[1]] = _salience(*small)
        rows, columns = (np.arange(n) // side for n in self.shape)
        #: Of each pixel of the exemplar the cell, times the number of copies, and the copy.
        self.shows = ((rows[:, None] * width + columns) * len(boxes)).astype(np.int32)
        turn = exemplar.turn if len(boxes) > 1 else None
        if turn is not None:
            self.shows = turned_pixels(self.shows, turn)
        # Of all copies the cells, and where they are, see `repeat_kernels.sum_copies`.
        self.most = [-(-max(box[axis] for box in boxes) // side) for axis in (2, 3)]
        own = []
        for number, (top, left, high, wide) in enumerate(boxes):
            self.shows[top : top + high, left : left + wide] += number
            y, x = np.indices((-(-high // side), -(-wide // side))).reshape(2, -1)
            v, u = (np.minimum(side * k + side // 2, n - 1) for k, n in ((y, high), (x, wide)))
            from_last = self.most[0] - 1 - y, self.most[1] - 1 - x
            own.append([*np.divmod(self.shows[top + v, left + u], len(boxes)), *from_last])
        every = np.concatenate(own, axis=1)
        every = every[:, np.argsort(every[0], kind="stable")]
        self.own = np.ascontiguousarray(every[1:].T, np.int32)
        self.cells = np.zeros((4, salience.size + 1), np.int32)
        self.cells[1] = np.searchsorted(every[0], np.arange(salience.size + 1))
        self.cells[3, :-1] = salience.ravel()
        ways = [[(0, False)]] if turn is None else TURNS[turn]
        self.mirrored = np.array([mirrored for row in ways for _, mirrored in row], np.int32)
        near, close = (int((far * min(height, width)) ** 2) for far in (_NEAR, _CLOSE))
        self.near = np.array([near, close, int(near**0.5)], np.int32)
        # What lies around a hole stays, so repeats in line with it do not count more.
        line, self._far = (_IN_LINE, _LINE_FAR) if output.canvas.hole is None else (0.0, _FAR)
        self.weights = _weights(self.shape, side, line, self._far)
        self.spans = _spans(self.weights)
        self._cell_of = self.shows.ravel() // len(boxes)
        middle = [n // 2 for n in self.weights.shape]
        self._apart = self.weights[middle[0] :, middle[1] :].copy()
        self._apart[:2, :2] = 0  # pixels side by side may show one cell once
        sides = zip(output.canvas.shape, output.canvas.wrap, strict=True)
        beyond = [n if wraps else 1 << 29 for n, wraps in sides]
        self._sizes = np.array([*beyond, exemplar.shape[1], side.bit_length() - 1], np.int32)

    def look(self, pixel: tuple[int, int]) -> None:
        """Look at the cells that are shown around a pixel, for `prices` of patches there."""
        canvas = self.output.canvas
        lines = zip(pixel, self.shape, canvas.shape, canvas.wrap, strict=True)
        around = []
        for at, side, n, wraps in lines:
            reach = int((1 + self._far) * side)
            low, high = (0, n) if wraps else (max(at - reach, 0), at + reach)
            around.append(slice(low, high, self.cell))
        source = self.output.source[tuple(around)]
        places = np.argwhere(source >= 0)
        shown = self._cell_of[source[tuple(places.T)]]
        counts = np.bincount(shown, minlength=self.cells.shape[1])
        places = places[np.argsort(shown, kind="stable")] * self.cell
        self._where = (places + [line.start for line in around]).astype(np.int32)
        self._shown = np.stack([counts.cumsum() - counts, counts, self.cells[3]]).astype(np.int32)

    def prices(self, box: tuple[Indices, Indices, Indices, Indices]) -> Indices:
        """What each cell of a patch's box adds by repeats if it becomes new, for each pixel.

        Less what stays there otherwise, in costs of seams (`seam_cost`). Repeats within the box
        count half, as the patch may replace them. `box`: its rows and columns, then the sample's.
        """
        sums = np.zeros((2, *(-(-len(line) // self.cell) for line in box[:2])), np.int64)
        kernels.sum_changes(
            self.output.source, self._cell_of, *box, self._shown, self._where, self._apart,
            self._sizes, sums,
        )  # fmt: skip
        mean = max(len(self._where) / (self.cells.shape[1] - 1), 1.0)
        repeats, use = _PRICE / (2 * _UNIT * _LEVELS) * sums[0], _PRICE_OF_USE / mean * sums[1]
        prices: Floats = np.rint(self._unit * (repeats + use))
        return prices.clip(-_HIGHEST, _HIGHEST).astype(np.int32)

    def of(self, pixel: tuple[int, int], allowed: list[Mask], level: int) -> list[Floats]:
        """Factors for the costs of a patch at the offsets of each copy, 1 or more if allowed."""
        self.look(pixel)
        places = np.concatenate([np.argwhere(each) for each in allowed]) << level
        first, last = places.min(axis=0) // self.cell, places.max(axis=0) // self.cell
        sums = self.sums(pixel, len(allowed), first, last - first + 1)
        repeats, salience, used, beside, area, mirrored = np.moveaxis(sums, 1, 0)
        policy, strength = self.policy, self.policy.strength
        nearby = repeats / np.maximum(_UNIT * salience, 1)
        use = np.minimum(used / np.maximum(area * self._mean, 1), policy.most)
        factors = 1 + strength * (policy.nearby * nearby + policy.use * use)
        factors += strength * np.minimum(_BESIDE * beside / np.maximum(area, 1), _MOST_BESIDE)
        factors[mirrored > _SHARE * (self.cells.shape[1] - 1)] += strength * _NEVER
        found = []
        for own, each in zip(factors, allowed, strict=True):
            lines = [(np.arange(n) << level) // self.cell for n in each.shape]
            for line, low, high in zip(lines, first, last, strict=True):
                own = own.take(np.minimum(np.maximum(line, low), high) - low, axis=0).T
            found.append(own)
        return found

    def sums(
        self, pixel: tuple[int, int], copies: int, first: NDArray[np.intp], size: NDArray[np.intp]
    ) -> Ints:
        """See `repeat_kernels.sum_copies`, for the offsets of a box of cells."""
        source, shows, cells = self.output.source, self.shows.ravel(), self.cells.copy()
        rows, columns = self._lines(pixel)
        shown = source[np.ix_(rows[0], columns[0])].ravel()
        known = (shown >= 0).nonzero()[0]
        v, u = np.divmod(known, columns.shape[1])
        cell, copy = np.divmod(shows[shown[known]], copies)
        # The distances of cells from the last one of a copy at the first offset.
        axes = zip(first, self.most, size, strict=True)
        away = [np.arange(low - n + 1, low + count) for low, n, count in axes]
        missing = self._missing_at(pixel, [-line for line in away])
        at = [rows[1][v] + away[0][0], columns[1][u] + away[1][0], copy]
        small = np.uint16 if cells.size < 2**16 else np.uint32  # which is sorted faster
        order = np.argsort(cell.astype(small), kind="stable")
        where = np.ascontiguousarray(np.stack(at, 1)[order], np.int32)
        some = source[:: self.cell, :: self.cell]
        cells[0, 1:] = np.bincount(cell, minlength=cells.shape[1] - 1).cumsum()
        cells[2, :-1] = np.bincount(shows[some[some >= 0]] // copies, minlength=cells.shape[1] - 1)
        self._mean = max(float(cells[2, :-1].mean()), 1.0 / (cells.shape[1] - 1))
        sums = np.zeros((copies, 6, *size), np.int64)
        kernels.sum_copies(
            cells, where, self.own, self.weights, self.spans, self.near, self.mirrored, missing,
            _spans(missing), np.empty(missing.shape, np.int32), sums,
        )  # fmt: skip
        return sums

    def _lines(self, pixel: tuple[int, int]) -> list[Indices]:
        """The rows and the columns nearby: every `cell`-th, and its distance in cells."""
        lines, canvas = [], self.output.canvas
        for at, side, n, wraps in zip(pixel, self.shape, canvas.shape, canvas.wrap, strict=True):
            reach = -(-int((1 + self._far) * side) // self.cell)
            away = np.arange(-reach, reach + 1)
            line = at + self.cell * away
            inside = np.full(len(line), True) if wraps else (line >= 0) & (line < n)
            lines.append(np.array([(line % n)[inside], away[inside]], np.int32))
        return lines

    def _missing_at(self, pixel: tuple[int, int], away: list[NDArray[np.int_]]) -> Ints:
        """-1 where the pixels at these distances in cells are missing, else 0."""
        rows, columns = (at + self.cell * line for at, line in zip(pixel, away, strict=True))
        (height, width), (wrap_y, wrap_x) = self.output.canvas.shape, self.output.canvas.wrap
        missing: Mask = self.output.done[np.ix_(rows % height, columns % width)] == 0
        missing &= (wrap_y | ((rows >= 0) & (rows < height)))[:, None]
        missing &= wrap_x | ((columns >= 0) & (columns < width))
        if self.covers is not None:
            (height, width), (y, x) = self.covers, away
            missing &= ((y >= 0) & (y * self.cell < height))[:, None]
            missing &= (x >= 0) & (x * self.cell < width)
        return -missing.astype(np.int64)


def cell_side(boxes: list[Box]) -> int:
    """The side in pixels of the cells of a sample and its copies, a power of 2."""
    least = _CELLS if len(boxes) == 1 else _OF_COPIES
    high, wide = boxes[0][2:]
    side = max(min(high, wide) // least, math.isqrt(high * wide) // (2 * _CELLS))
    return 1 << max(side.bit_length() - 1, 0)


def _salience(pixels: Bytes, usable: Bytes) -> Indices:
    """How far the color of each pixel is from the mean, squared."""
    away = np.square(pixels - pixels[usable != 0].sum(axis=0) / max((usable != 0).sum(), 1))
    away = away.sum(axis=2) * (usable != 0)
    mean = float(away.sum() / max((usable != 0).sum(), 1))
    away = np.minimum(away / mean, _MOST) if mean else (usable != 0).astype(np.float64)
    found: Indices = np.rint(_LEVELS * away).astype(np.int32)
    return found


def _weights(shape: tuple[int, ...], cell: int, line: float, far: float) -> Indices:
    """Weights of repeats by their distance in cells: the nearer the more, and more in `line`."""
    reach = [-(-int(far * n) // cell) for n in shape]
    down, along = (np.arange(-n, n + 1) * cell / s for n, s in zip(reach, shape, strict=True))
    away = np.sqrt(down[:, None] ** 2 + along**2)
    weight = np.maximum(1 - away / _FAR, 0)
    off = np.minimum(abs(down)[:, None], abs(along))  # the row or the column that is nearer
    weight += line * np.maximum(1 - _LINES * off, 0) * np.maximum(1 - away / _LINE_FAR, 0)
    weights: Indices = np.rint(_UNIT * weight).astype(np.int32)
    return weights


def _spans(values: NDArray[np.integer]) -> Indices:
    """The first column of each row that is not 0, and the one after the last."""
    some = values != 0
    first, last = some.argmax(axis=1), some.shape[1] - some[:, ::-1].argmax(axis=1)
    return np.stack([first, np.where(some.any(axis=1), last, first)], 1).astype(np.int32)
