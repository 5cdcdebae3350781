"""How a canvas is divided into blocks (section 4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, Around, CanvasLattice
from weftex.methods.near_regular import block_kernels as kernels
from weftex.methods.near_regular.rows import ANY, Courses, rows_shown
from weftex.planes.boxes import check_period
from weftex.random import draw

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.methods.near_regular.sample import BlockSample
    from weftex.methods.near_regular.settings import Settings

#: Blocks around those that show that their sources hang on: 1 beside a gap, and 2 for each color
#: but the last, which is drawn with regard to the ones before.
_RING = 7
_UNIT = 1 << 16  # of a pixel, that distances of blocks are in


class Turn:
    """Blocks that go around once: `count` of them, a multiple of `by`.

    Parameters
    ----------
    length, size : int
        Of what they go around, and of a block at most.
    courses : Courses, optional
        Rows whose joints blocks end at; it begins at a joint.
    by : int
        2, so that every second block is a gap; 4, so that colors of blocks go around, too.
    """

    def __init__(self, length: int, size: int, courses: Courses | None, by: int) -> None:
        self.length, self.share, self.rows = length, 1, 0
        self.count = by * max(1, -(-length // (by * size)))
        self.least = length // self.count
        if courses is None:
            return
        rows = max(1, round(length / courses.height))
        each, self.share = courses.division(size, length / rows)
        self.count = by * -(-rows // (by * each))
        if self.share == 1 and (self.count > rows or by * rows % 4):
            self.share = 2
        if self.share == 1:  # whole rows
            self.rows = rows
            self.least = rows // self.count * (length // rows)
            return
        while rows * self.share % by:  # or gaps would be beside gaps
            self.share += 1
        self.count = rows * self.share
        self.least = length // self.count

    def edge(self, number: int) -> int:
        """Where a block begins."""
        turns, k = divmod(number, self.count)
        if self.rows:
            return turns * self.length + k * self.rows // self.count * self.length // self.rows
        return turns * self.length + k * self.length // self.count


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

    around : int
        The plane, of which the canvas is a window, comes back to itself after so many pixels; 0 if
        it does not.

    Attributes
    ----------
    edges : int64 array (n + 1,)
        Where blocks begin and the last one ends, in canvas pixels.
    places : int64 array (n,)
        Where blocks begin in the plane of the lattice.
    side : int
        Of a block's window.
    sizes, numbers : int64 array (n,)
        Of the blocks; numbers count from the plane's origin.
    least : int
        A size that no block is smaller than.
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
        around: int = 0,
    ) -> None:
        self.length, self.margin, self.side = length, margin, size + 2 * margin
        joint = 0 if courses is None else courses.joint
        ring, self.period, first = _RING, 0, 0
        if wraps or around:
            turn = Turn(around or length, size, courses, 2 if wraps else 4)
            edge, self.share, self.least = turn.edge, turn.share, turn.least
        else:
            step, self.share = size * _UNIT, 1
            if courses is not None:
                each, self.share = courses.division(size)
                step = round(courses.height * each * _UNIT / self.share)
            self.least = step // _UNIT

            def edge(number: int) -> int:
                return (number * step + joint * _UNIT) // _UNIT

        if wraps:
            ring, self.period, begin, end = 0, length, 0, turn.count
        else:
            first = origin
            begin, end = (
                _block_at(edge, pixel, *((turn.count, around) if around else (_UNIT, step)))
                for pixel in (origin - margin, origin + length - 1 + margin)
            )
            end += 1
        every = range(begin - ring, end + ring)
        self.shown = slice(ring, end - begin + ring)
        self.edges = np.array([edge(n) - first for n in [*every, every.stop]], np.int64)
        self.sizes = np.diff(self.edges)
        names = [n % turn.count for n in every] if around else every
        self.numbers = np.array(names, np.int64)
        start = (joint if courses is not None else origin) if wraps else joint if around else 0
        self.places = np.array([edge(n) + start for n in names], np.int64)
        row = [n // self.share * self.share for n in every]
        self._ends = (
            np.array([edge(n) - first for n in row], np.int64),
            np.array([edge(n + self.share - 1) - first for n in row], np.int64),
        )

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


def _block_at(edge: Callable[[int], int], pixel: int, count: int, length: int) -> int:
    """The last block that begins at a pixel or before, of `count` in about `length`."""
    number = pixel * count // length
    while edge(number) > pixel:
        number -= 1
    while edge(number + 1) <= pixel:
        number += 1
    return number


def divide(
    settings: Settings,
    sample: BlockSample,
    canvas: Canvas,
    origin: tuple[int, int],
    seed: int,
    period: tuple[int, int] | None = None,
) -> Layout:
    """Divide a canvas into square blocks, or a window of a plane that may have a period.

    Raises
    ------
    InvalidInputError
        If the canvas goes around and the lattice would have to be stretched by more than looks
        right, and than the tolerance makes up for.
    """
    size, margin = settings.block_size, settings.margin
    check_period(period, max(2 * size, 4))
    around = canvas if period is None else Around(*period)
    lattice = CanvasLattice(
        settings.lattice, around, max(VISIBLE_STRAIN, settings.tolerance / size)
    )
    # What a canvas knows, it knows where it is.
    courses = sample.courses if canvas.known is None else (None, None)
    rows, columns = (
        Axis(length, at, size, margin, wraps, own, turn)
        for length, at, wraps, own, turn in zip(
            canvas.shape, origin, canvas.wrap, courses, period or (0, 0), strict=True
        )
    )
    corner = [axis.places - margin for axis in (rows, columns)]
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
        reach=min(margin, max(0, min(rows.least, columns.least) - 1) // 2),
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
