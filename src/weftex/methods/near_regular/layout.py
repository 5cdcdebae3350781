"""How a canvas is divided into blocks (section 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice
from weftex.methods.near_regular import block_kernels as kernels
from weftex.methods.near_regular.rows import ANY, Courses, rows_shown
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

#: Blocks around those that show that their sources hang on: 1 beside a gap, and 2 for each color
#: but the last, which is drawn with regard to the ones before.
_RING = 7
_UNIT = 1 << 16  # of a pixel, that distances of blocks are in


class Axis:
    """Blocks along one axis of a plane or of a canvas that goes around.

    Parameters
    ----------
    length, origin : int
        Of the canvas, and where in the plane it begins.
    size, margin : int
        Of a block, at most, and how far its window reaches beyond it.
    wraps : bool
        The canvas goes around.
    courses : Courses, optional
        Rows whose joints blocks end at. A canvas that goes around begins at a joint.

    Attributes
    ----------
    edges : int64 array (n + 1,)
        Where blocks begin and the last one ends, in canvas pixels.
    side : int
        Of a block's window.
    sizes, numbers : int64 array (n,)
        Of the blocks; numbers count from the plane's origin.
    share : int
        Blocks that share a row; 1 where a block holds whole rows, or there are none.
    period : int
        The canvas's length if it goes around, else 0.
    shown : slice
        The blocks that can show.
    """

    def __init__(
        self,
        length: int,
        origin: int,
        size: int,
        margin: int,
        wraps: bool,
        courses: Courses | None,
    ) -> None:
        self.length, self.margin, self.side = length, margin, size + 2 * margin
        self.share = 1
        if wraps:
            count = 2 * max(1, -(-length // (2 * size)))
            numbers = np.arange(count + 1, dtype=np.int64)
            if courses is not None:
                rows = max(1, round(length / courses.height))
                each, self.share = courses.division(size, length / rows)
                count = 2 * -(-rows // (2 * each))
                if self.share == 1 and count > rows:
                    self.share = 2
                self.share += rows * self.share % 2  # or gaps would be beside gaps
                count = count if self.share == 1 else rows * self.share
                numbers = np.arange(count + 1, dtype=np.int64)
                if self.share == 1:  # whole rows
                    numbers, count = numbers * rows // count, rows
            first, self.period, self.shown = 0, length, slice(0, len(numbers) - 1)
            self.edges = numbers * length // count
        else:
            step, shift = size * _UNIT, 0
            if courses is not None:
                each, self.share = courses.division(size)
                step = round(courses.height * each * _UNIT / self.share)
                shift = courses.joint * _UNIT
            begin = ((origin - margin) * _UNIT - shift) // step
            end = ((origin + length - 1 + margin) * _UNIT - shift) // step + 1
            first, self.period = begin - _RING, 0
            self.shown = slice(_RING, end - begin + _RING)
            numbers = np.arange(begin - _RING, end + _RING + 1, dtype=np.int64)
            self.edges = (numbers * step + shift) // _UNIT - origin
        self.sizes = np.diff(self.edges)
        self.numbers = first + np.arange(len(self.sizes), dtype=np.int64)
        row = self.numbers // self.share * self.share
        if self.period:
            self._ends = self.edges[row], self.edges[row + self.share - 1]
        else:
            at = np.stack([row, row + self.share - 1]) * step + shift
            self._ends = at[0] // _UNIT - origin, at[1] // _UNIT - origin

    def ends_of_rows(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Where the first and the last begin of those blocks that share a row with each."""
        return self._ends

    def laid(self, reach: int) -> tuple[int, NDArray[np.int64]]:
        """Which lines of the shown blocks' windows are laid: how many, and from which one on.

        All of them, unless the canvas is smaller than a window. No window may lie over itself.
        """
        lines = min(self.side, self.length)
        first = np.full(self.shown.stop - self.shown.start, self.margin - reach)
        if not self.period:
            first = np.maximum(first, self.margin - self.edges[:-1][self.shown])
        return lines, np.minimum(first, self.side - lines)

    def lines(
        self, block: int, count: int | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Canvas lines of a block's window, all or so many, and which are on the canvas."""
        at = self.edges[block] - self.margin + np.arange(self.side if count is None else count)
        return at % self.length, ((at >= 0) & (at < self.length)) | bool(self.period)


@dataclass(frozen=True, eq=False)
class Layout:
    """The blocks of one canvas.

    Attributes
    ----------
    canvas : Canvas
        What to make.
    origin : (int, int)
        Where its corner is in the plane of the sample's lattice.
    seed : int
        For `weftex.random.draw`.
    lattice : CanvasLattice
        The vectors, stretched to go around the canvas.
    rows, columns : Axis
        The blocks along both axes.
    reach : int
        How far seams leave the edges of blocks; less than the margin where blocks are small.
    bits : uint64 array (rows, columns)
        Random bits of each block.
    phase : int64 array (rows, columns, 2)
        Where in the first tile the corner of its window lies (eq. 3.29), in 1/65536 pixel.
    row : int64 array (rows, columns) or None
        Which rows of the sample it is to show, see `rows_shown`; None if it may show any.
    """

    canvas: Canvas
    origin: tuple[int, int]
    seed: int
    lattice: CanvasLattice
    rows: Axis
    columns: Axis
    reach: int
    bits: NDArray[np.uint64]
    phase: NDArray[np.int64]
    row: NDArray[np.int64] | None

    @cached_property
    def gap(self) -> NDArray[np.bool_]:
        """Every second block, in a chess-like fashion, is a gap; the others are drawn."""
        even: NDArray[np.bool_] = (self.rows.numbers[:, None] + self.columns.numbers) % 2 == 1
        return even

    @cached_property
    def shown(self) -> NDArray[np.bool_]:
        """The blocks that can show."""
        result = np.zeros(self.bits.shape, bool)
        result[self.rows.shown, self.columns.shown] = True
        return result

    def grid(self, place: NDArray[np.int32]) -> kernels.Grid:
        """The blocks as kernels take them, with an array of places that they fill."""
        wrap = np.array([self.rows.period, self.columns.period], np.int32)
        return kernels.Grid(self.rows.edges, self.columns.edges, wrap, self.phase, self.bits, place)

    def preview(self, sample: BlockSample, place: NDArray[np.int32]) -> NDArray[np.uint8]:
        """The blocks that are there, with straight edges."""
        canvas = np.zeros((*self.canvas.shape, sample.exemplar.channels), np.uint8)
        width, margin = sample.pixels.shape[1], self.rows.margin
        for i, j in np.argwhere(self.shown & (place >= 0)).tolist():
            y, x = divmod(int(place[i, j]), width)
            top, left = int(self.rows.edges[i]), int(self.columns.edges[j])
            v, u = max(0, -top), max(0, -left)
            part = canvas[
                top + v : int(self.rows.edges[i + 1]), left + u : int(self.columns.edges[j + 1])
            ]
            y, x = y + margin + v, x + margin + u
            part[:] = sample.pixels[y : y + part.shape[0], x : x + part.shape[1], : canvas.shape[2]]
        if self.canvas.known is not None and self.canvas.hole is not None:
            there = ~self.canvas.hole
            known = sample.exemplar.as_known(self.canvas.known)
            canvas[there] = known[there][:, : canvas.shape[2]]
        return canvas


def divide(
    settings: Settings, sample: BlockSample, canvas: Canvas, origin: tuple[int, int], seed: int
) -> Layout:
    """Divide a canvas into square blocks.

    Raises
    ------
    InvalidInputError
        If the canvas goes around and the lattice would have to be stretched by more than looks
        right, and than the tolerance makes up for.
    """
    size, margin = settings.block_size, settings.margin
    lattice = CanvasLattice(
        settings.lattice, canvas, max(VISIBLE_STRAIN, settings.tolerance / size)
    )
    # What a canvas knows, it knows where it is.
    courses = sample.courses if canvas.known is None else (None, None)
    rows, columns = (
        Axis(length, at, size, margin, wraps, own)
        for length, at, wraps, own in zip(canvas.shape, origin, canvas.wrap, courses, strict=True)
    )
    least = min(int(rows.sizes.min()), int(columns.sizes.min()))
    begin = [
        own.joint if wraps and own is not None else at
        for at, wraps, own in zip(origin, canvas.wrap, courses, strict=True)
    ]
    corner = [
        axis.edges[:-1] + at - margin for axis, at in zip((rows, columns), begin, strict=True)
    ]
    phase = lattice.phase(corner[0][:, None], corner[1][None, :])
    row = None
    if sample.row_axis is not None and canvas.known is None:
        row = _rows(sample, lattice, (rows, columns), corner, phase, seed)
    return Layout(
        canvas=canvas,
        origin=origin,
        seed=seed,
        lattice=lattice,
        rows=rows,
        columns=columns,
        reach=min(margin, max(0, least - 1) // 2),
        bits=draw(seed, "block", rows.numbers[:, None], columns.numbers[None, :]),
        phase=np.ascontiguousarray(phase),
        row=row,
    )


def _rows(
    sample: BlockSample,
    lattice: CanvasLattice,
    axes: tuple[Axis, Axis],
    corner: list[NDArray[np.int64]],
    phase: NDArray[np.int64],
    seed: int,
) -> NDArray[np.int64]:
    """Which multiple of the first vector each block shows; blocks that share a row show one row."""
    axis = sample.row_axis
    assert axis is not None
    along, windows, multiples = axes[axis], sample.windows, np.unique(sample.multiples)
    first, last = along.ends_of_rows()
    shape = (-1, 1) if axis == 0 else (1, -1)
    on = (along.edges[:-1] - first).reshape(shape)
    begin = list(corner)
    begin[axis] = corner[axis] - on.ravel()
    from_first = lattice.phase(begin[0][:, None], begin[1][None, :])[..., axis]
    height = lattice.sample[0, axis] * _UNIT
    step = np.rint(height * multiples).astype(np.int64)
    # A pixel more, because places are rounded, each for itself.
    stretched = float(lattice.sample[0, axis] / lattice.canvas[0, axis])
    reach = np.ceil((last - first) * stretched).astype(np.int64) + (last > first)
    row = rows_shown(
        np.any(windows.usable > 0, axis=1 - axis),
        int(windows.period[2 + axis]),
        multiples,
        (from_first[..., None] + step + _UNIT // 2) >> 16,
        reach.reshape(shape),
        (along.numbers // along.share).reshape(shape),
        seed,
    )
    # The same row of the sample, counted from the tile that this block begins in.
    beyond = np.rint((from_first + on * _UNIT - phase[..., axis]) / height).astype(np.int64)
    return np.where(row == ANY, row, row + beyond)
