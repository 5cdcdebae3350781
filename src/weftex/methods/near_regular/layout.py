"""How a canvas is divided into blocks (section 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, Around, CanvasLattice
from weftex.analysis.rows import ColoredRows
from weftex.canvas import Canvas
from weftex.endless.boxes import Corner, PlaneRequest, check_period
from weftex.methods.near_regular.sample import BlockSample
from weftex.random import draw
from weftex.raster.arrays import Bytes, Ints, Mask

#: Blocks around the visible ones that their sources depend on: 1 beside a gap, and 2 for each color
#: but the last, which is drawn with regard to the ones before.
_RING = 7
_UNIT = 1 << 16  # of a pixel, that distances of blocks are in
#: Stands for any rows.
ANY = -(2**31)


class Cuts:
    """Where an axis is cut into blocks: every `size` pixels, or at joints of rows.

    An axis that wraps after `period` pixels has `count` blocks, a multiple of `by`: of 2 to have a
    gap at every second block, of 4 to have the four colors of blocks wrap, too. `share` blocks
    share a row, 1 where a block has whole rows; no block is smaller than `least`.
    """

    def __init__(self, size: int, colored: ColoredRows | None, period: int, by: int) -> None:
        self.count, self.share, self._rows, self._period = 0, 1, 0, period
        self.start = 0 if colored is None else colored.joint  # where in the plane edges count from
        self._first, self._unit = self.start * _UNIT, _UNIT
        self._step = size * _UNIT
        if period:
            self._wrap(size, colored, period, by)
        elif colored is not None:
            rows, self.share = colored.division(size)
            self._step = round(colored.height * rows * _UNIT / self.share)
            self.start = 0  # as edges have it
        self.least = self._step // self._unit
        if self._rows:
            self.least = self._rows // self.count * (period // self._rows)

    def _wrap(self, size: int, colored: ColoredRows | None, period: int, by: int) -> None:
        self.count = by * max(1, -(-period // (by * size)))
        if colored is not None:
            rows = max(1, round(period / colored.height))
            each, self.share = colored.division(size, period / rows)
            self.count = by * -(-rows // (by * each))
            if self.share == 1 and (self.count > rows or by * rows % 4):
                self.share = 2
            if self.share == 1:
                self._rows = rows
            else:
                while rows * self.share % by:  # or gaps would be beside gaps
                    self.share += 1
                self.count = rows * self.share
        self._first, self._step, self._unit = 0, period, self.count

    def edge(self, number: int) -> int:
        """Where a block begins; counted from `start` where the axis wraps."""
        if self._rows:
            return number * self._rows // self.count * self._period // self._rows
        return (number * self._step + self._first) // self._unit

    def name(self, number: int) -> int:
        """The number that a block is drawn by, the same after each turn."""
        return number % self.count if self.count else number

    def block_at(self, pixel: int) -> int:
        """The number of the block that has this pixel: the last one that begins there or before."""
        guess = pixel * self._unit // self._step
        while self.edge(guess) > pixel:
            guess -= 1
        while self.edge(guess + 1) <= pixel:
            guess += 1
        return guess


class Axis:
    """The blocks along one axis of a canvas.

    A window is `side` pixels wide at most and reaches `margin` beyond its block. `visible` blocks
    are on the canvas or overlap it; others matter to what these become.
    """

    edges: Ints  # (n + 1,): where blocks begin and the last one ends, on the canvas
    corners: Ints  # (n,): where their windows begin in the plane of the lattice
    sizes: Ints  # (n,)
    numbers: Ints  # (n,), counted from the plane's origin
    period: int  # the canvas's length if it wraps, else 0
    # (n,): where the first and the last begin of the blocks that share a row with each block.
    first_of_row: Ints
    last_of_row: Ints
    # (5, n), [k, i] for k from -2 to 2: the block k after block i, -1 if there is none, and the
    # pixels from where it begins to where block i begins.
    beside: Ints
    apart: Ints

    def __init__(
        self,
        length: int,
        origin: int,
        wraps: bool,
        plane_period: int,
        method: Any,
        colored: ColoredRows | None,
    ) -> None:
        self.length, self.margin, self.side = length, method.margin, method.window_side
        period = plane_period or (length if wraps else 0)
        cuts = Cuts(method.block_size, colored, period, 2 if wraps else 4)
        self.share, self.least, self.period = cuts.share, cuts.least, length if wraps else 0
        if wraps:
            numbers, ring, first = range(cuts.count), 0, 0
            start = origin if colored is None else cuts.start
        else:
            begin = cuts.block_at(origin - self.margin)
            end = cuts.block_at(origin + length - 1 + self.margin) + 1
            numbers, ring, first = range(begin - _RING, end + _RING), _RING, origin
            start = cuts.start
        names = [cuts.name(n) for n in numbers]
        rows = [n // self.share * self.share for n in numbers]

        def edges(which: list[int]) -> Ints:
            return np.array([cuts.edge(n) for n in which], np.int64)

        self.edges = edges([*numbers, numbers.stop]) - first
        self.corners = edges(names) + start - self.margin
        self.sizes, self.numbers = np.diff(self.edges), np.array(names, np.int64)
        self.visible = slice(ring, len(numbers) - ring)
        self.first_of_row = edges(rows) - first
        self.last_of_row = edges([n + self.share - 1 for n in rows]) - first
        blocks, steps = np.arange(len(numbers)), np.array([[0], [1], [2], [-2], [-1]])
        turns, found = np.divmod(blocks + steps, len(numbers))
        self.beside = np.where((turns == 0) | wraps, found, -1)
        self.apart = self.edges[blocks] - self.edges[found] - turns * self.period

    def pasted(self, reach: int) -> tuple[int, Ints]:
        """The number of lines of a window that are pasted, and the first one of each visible block.

        All lines, unless the canvas is smaller than a window: no window may overlap itself.
        """
        lines = min(self.side, self.length)
        first = np.full(self.visible.stop - self.visible.start, self.margin - reach)
        if not self.period:
            first = np.maximum(first, self.margin - self.edges[:-1][self.visible])
        return lines, np.minimum(first, self.side - lines)


@dataclass(frozen=True, eq=False)
class Layout:
    """The blocks of one canvas."""

    canvas: Canvas
    origin: Corner  # of the canvas in the plane of the sample's lattice
    seed: int
    lattice: CanvasLattice  # stretched to wrap around the canvas
    rows: Axis
    columns: Axis
    reach: int  # how far blocks overlap past their edges: the margin, or less for small blocks
    half_border: int  # how far the borders that match reach past edges: at most that
    bits: NDArray[np.uint64]  # (rows, columns), random ones
    phase: Ints  # (rows, columns, 2): of windows in the first tile (eq. 3.29), 1/65536
    row: Ints | None  # (rows, columns): rows of the sample to contain, see `_rows`

    @cached_property
    def gap(self) -> Mask:
        """Every second block, in a chess-like fashion, is a gap; the others are drawn."""
        odd: Mask = (self.rows.numbers[:, None] + self.columns.numbers) % 2 == 1
        return odd

    @property
    def visible(self) -> tuple[slice, slice]:
        """The blocks that are on the canvas or overlap it."""
        return self.rows.visible, self.columns.visible

    @property
    def visible_gaps(self) -> Ints:
        """Rows and columns (n, 2) of the gaps among them."""
        start = self.rows.visible.start, self.columns.visible.start
        return np.argwhere(self.gap[self.visible]) + start

    def preview(self, sample: BlockSample, sources: NDArray[np.int32]) -> Bytes:
        """The blocks that have a source, with straight edges."""
        canvas = np.zeros((*self.canvas.shape, sample.exemplar.channels), np.uint8)
        for i, j in np.argwhere(sources[self.visible] >= 0).tolist():
            i, j = i + self.rows.visible.start, j + self.columns.visible.start
            y, x = divmod(int(sources[i, j]), sample.pixels.shape[1])
            top, left = int(self.rows.edges[i]), int(self.columns.edges[j])
            v, u = max(0, -top), max(0, -left)
            part = canvas[top + v : self.rows.edges[i + 1], left + u : self.columns.edges[j + 1]]
            y, x = y + self.rows.margin + v, x + self.rows.margin + u
            part[:] = sample.pixels[y : y + part.shape[0], x : x + part.shape[1], : canvas.shape[2]]
        return canvas


def divide(
    method: Any, sample: BlockSample, canvas: Canvas, corner: Corner, asked: PlaneRequest
) -> Layout:
    """Divide a canvas, or a window of a plane that may have a period, into square blocks.

    Raises `InvalidInputError` if the lattice would have to be stretched by more than looks right,
    and than the tolerance makes up for, to wrap.
    """
    size, period, seed = method.block_size, asked.period, asked.seed
    check_period(period, max(2 * size, 4))
    around = canvas if period is None else Around(*period)
    limit = max(VISIBLE_STRAIN, method.tolerance / size)
    lattice = CanvasLattice(method.lattice, around, limit)
    colored = sample.colored_rows
    rows, columns = (
        Axis(*along, method, colored if colored and colored.axis == axis else None)
        for axis, along in enumerate(
            zip(canvas.shape, corner, canvas.wrap, period or (0, 0), strict=True)
        )
    )
    phase = lattice.phase(rows.corners[:, None], columns.corners[None, :])
    row = None
    if colored is not None:
        row = _rows(sample, colored.axis, lattice, (rows, columns), phase, seed)
    most = max(0, min(rows.least, columns.least) - 1) // 2
    return Layout(
        canvas=canvas,
        origin=corner,
        seed=seed,
        lattice=lattice,
        rows=rows,
        columns=columns,
        reach=min(method.margin, most),
        half_border=min(method.border_width // 2, most),
        bits=draw(seed, "block", rows.numbers[:, None], columns.numbers[None, :]),
        phase=np.ascontiguousarray(phase),
        row=row,
    )


def _rows(
    sample: BlockSample,
    axis: int,
    lattice: CanvasLattice,
    axes: tuple[Axis, Axis],
    phase: Ints,
    seed: int,
) -> Ints:
    """Which multiple of the first vector leads to the row of each block; see `Layout.row`."""
    along, windows, multiples = axes[axis], sample.windows, np.unique(sample.multiples)
    shape = (-1, 1) if axis == 0 else (1, -1)
    on = along.edges[:-1] - along.first_of_row
    begin = [a.corners for a in axes]
    begin[axis] = begin[axis] - on
    from_first = lattice.phase(begin[0][:, None], begin[1][None, :])[..., axis]
    height = lattice.sample[0, axis] * _UNIT
    step = np.rint(height * multiples).astype(np.int64)
    # A pixel more, because places are rounded, each for itself.
    stretched = float(lattice.sample[0, axis] / lattice.canvas[0, axis])
    apart = along.last_of_row - along.first_of_row
    reach = np.ceil(apart * stretched).astype(np.int64) + (apart > 0)
    row = _choose_rows(
        np.any(windows.usable > 0, axis=1 - axis),
        int(windows.period[2 + axis]),
        multiples,
        (from_first[..., None] + step + _UNIT // 2) >> 16,
        reach.reshape(shape),
        (along.numbers // along.share).reshape(shape),
        seed,
    )
    # The same row of the sample, counted from the tile that this block begins in.
    beyond = (from_first + on.reshape(shape) * _UNIT - phase[..., axis]) / height
    return np.where(row == ANY, row, row + np.rint(beyond).astype(np.int64))


def _choose_rows(
    whole: Mask, period: int, multiples: Ints, places: Ints, reach: Ints, numbers: Ints, seed: int
) -> Ints:
    """The multiple of the first vector for each block, one after the other from row to row.

    `places` (rows, columns, k) are where `multiples` lead for the first of the blocks that share a
    row, the last is `reach` further; `ANY` where not all of these are `whole` windows.
    """
    there = np.ones(places.shape, bool)
    for ends in (places, places + reach[..., None]):
        if period:
            ends = ends % period
        inside = (ends >= 0) & (ends < len(whole))
        inside[inside] = whole[ends[inside]]
        there &= inside
    # One after the other, up or down, from a row that is drawn for every round of them.
    count = np.maximum(there.sum(axis=-1), 1)
    rounds, turn = np.divmod(np.broadcast_to(numbers, count.shape), count)
    bits = draw(seed, "rows", rounds)
    turn = np.where(bits >> np.uint64(63), turn, -turn)
    chosen = ((bits % count.astype(np.uint64)).astype(np.int64) + turn) % count
    first = (there.cumsum(axis=-1) == chosen[..., None] + 1).argmax(axis=-1)
    return np.where(there.any(axis=-1), multiples[first], ANY)
