"""How patches lie on a canvas, and in which order.

Those of a new picture go row by row (Liang et al., 2001, Fig. 3, Fig. 5, section 2.5), those of a
hole in spirals from its border inwards (section 2.3).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.methods.patches.analysis import Zones
from weftex.methods.patches.method import PatchMethod
from weftex.random import draw
from weftex.raster.arrays import Ints, Mask
from weftex.raster.masks import grown

_MOST_AROUND = 11  # earlier patches that a patch should not repeat
THREADS_FROM = 512  # patches; fewer are pasted faster by one thread
PIECE = 16  # patches that a thread takes at a time


@dataclass(frozen=True, eq=False)
class Frame:
    """How windows of the sample lie on a canvas; see `frame_of`."""

    canvas: Canvas
    method: PatchMethod  # resolved
    window: tuple[int, int]  # rows and columns that are compared; no more than the canvas has
    boundary_width: int  # width w_E of the boundary zone on this canvas
    margin: tuple[int, int]  # by which a single pixel's window hangs over a border without wrap

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the canvas with its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return height + 2 * top, width + 2 * left

    @property
    def inside(self) -> tuple[slice, slice]:
        """The canvas inside its margins."""
        (height, width), (top, left) = self.canvas.shape, self.margin
        return slice(top, top + height), slice(left, left + width)

    @property
    def known(self) -> NDArray[Any] | None:
        """The known pixels around a hole (section 2.3); None where everything is to be made."""
        hole = self.canvas.hole
        return self.canvas.known if hole is not None and not hole.all() else None


def frame_of(method: PatchMethod, canvas: Canvas) -> Frame:
    """Return the frame that fits the windows of a resolved method to a canvas.

    The boundary may be narrower than the method's, as the last patch of a wrapped row has a zone at
    either end.
    """
    assert method.boundary_width
    (height, width), (wraps_y, wraps_x) = canvas.shape, canvas.wrap
    side, boundary = method.window_side, method.boundary_width
    if method.pixelwise:
        margin = 0 if wraps_y else boundary, 0 if wraps_x else boundary
        return Frame(canvas, method, (side, side), boundary, margin)
    window = min(side, height), min(side, width)
    wrapped = [n // 4 for n, wraps in zip(window, canvas.wrap, strict=True) if wraps]
    return Frame(canvas, method, window, max(1, min([boundary, *wrapped])), (0, 0))


class Run(NamedTuple):
    """Patches `first` to `last` - 1 of an order; they have one zone."""

    zone: int
    first: int
    last: int


class Step(NamedTuple):
    """Runs to paste next: `pieces` are independent of each other, the runs of a piece are not.

    `done` is their share of the order's `total`.
    """

    pieces: list[list[Run]]
    done: int


@dataclass(frozen=True, eq=False)
class Order:
    """The patches of an output in their order."""

    corners: NDArray[np.int32]  # (n, 2): upper left corner of each window on the frame
    bits: NDArray[np.uint64]  # (n,): random, one number a patch
    around: NDArray[np.int32]  # (n, k): earlier patches that each should not repeat, -1 for none
    steps: Iterator[Step]  # goes through all patches
    total: int  # what the steps add up to, in units of `stage`
    stage: str  # patches or pixels, for progress
    parallel: bool = False  # some steps have several pieces


def runs_of(zones: list[int], first: int) -> list[Run]:
    """Return runs of patches with the same zone, the first patch numbered `first`."""
    changes = [k for k in range(1, len(zones)) if zones[k] != zones[k - 1]]
    ends = pairwise([0, *changes, len(zones)])
    return [Run(zones[start], first + start, first + stop) for start, stop in ends]


def scan_patches(frame: Frame, zones: Zones, seed: int, threads: int) -> Order:
    """Patches in rows, evenly spread, that overlap by the boundary zone (section 2.2, Fig. 3 a)."""
    canvas, window, width = frame.canvas, frame.window, frame.boundary_width
    starts = [
        patch_starts(length, side, min(width, side - 1), wraps)
        for length, side, wraps in zip(canvas.shape, window, canvas.wrap, strict=True)
    ]
    rows, columns = len(starts[0]), len(starts[1])
    kinds = [
        _kinds(at, side, length, wraps)
        for at, side, length, wraps in zip(starts, window, canvas.shape, canvas.wrap, strict=True)
    ]
    numbers = {
        (row, column): _grid_zone(frame, zones, row, column)
        for row in dict.fromkeys(kinds[0])
        for column in dict.fromkeys(kinds[1])
    }

    def runs(row: int, first: int, last: int) -> list[Run]:
        found = [numbers[kinds[0][row], kind] for kind in kinds[1][first:last]]
        return runs_of(found, row * columns + first)

    # Around a wrapped axis every patch of a row depends on the whole row above.
    parallel = threads > 1 and not canvas.wrap[1] and rows * columns >= THREADS_FROM
    fronts: Iterable[list[tuple[int, int, int]]] = ([(row, 0, columns)] for row in range(rows))
    if parallel:
        ends = np.add(starts[1], window[1])
        overlapped = np.searchsorted(starts[1], ends) - 1 - np.arange(columns)
        fronts = wavefronts(rows, columns, PIECE, max(1, int(overlapped.max())))
    grid = np.meshgrid(*starts, indexing="ij")
    around = np.zeros((rows * columns, 0), np.int32)
    if frame.method.repeat_distance > 0:
        around = patches_around(rows, columns)
    return Order(
        corners=np.stack(grid, axis=-1).reshape(-1, 2).astype(np.int32),
        bits=draw(seed, "patch", *np.indices((rows, columns))).ravel(),
        around=around,
        steps=(
            Step([runs(*piece) for piece in front], sum(last - first for _, first, last in front))
            for front in fronts
        ),
        total=rows * columns,
        stage="patches",
        parallel=parallel,
    )


def patch_starts(length: int, size: int, overlap: int, wrap: bool) -> list[int]:
    """Return first pixels of evenly spread patches that overlap by `overlap` pixels or more.

    Only the zone, `overlap` pixels wide, is compared; the rest of an overlap is pasted over.
    """
    step = size - overlap
    if wrap:
        count = max(-(-length // step), 2)
        return [j * length // count for j in range(count)]
    if length <= size:
        return [0]
    count = -(-(length - size) // step)
    return [j * (length - size) // count for j in range(count + 1)]


def _kinds(starts: list[int], side: int, length: int, wraps: bool) -> list[tuple[bool, int]]:
    """Along one axis, for each patch: is there one before, and how far does it go around."""
    return [
        (k > 0, max(0, at + side - length) if k and wraps else 0) for k, at in enumerate(starts)
    ]


def _grid_zone(frame: Frame, zones: Zones, row: tuple[bool, int], column: tuple[bool, int]) -> int:
    """The configuration of Fig. 3 (b) to (d) and Fig. 5 for a patch of the grid, see `_kinds`."""
    known = np.zeros(frame.window, bool)
    known[: frame.boundary_width] |= row[0]
    known[:, : frame.boundary_width] |= column[0]
    known[frame.window[0] - row[1] :] = True
    known[:, frame.window[1] - column[1] :] = True
    return zones.number(known, often=not (row[1] or column[1]))


#: Patches, as (rows up, columns right), that are always pasted before a patch and lie around it.
_EARLIER = [(0, -2), (0, -1)] + [(-1, k) for k in (-2, -1, 0, 1)] + [(-2, k) for k in range(-2, 3)]


def patches_around(rows: int, columns: int) -> NDArray[np.int32]:
    """Numbers of the earlier patches around each patch of the grid, -1 for none: (n, 11)."""
    i, j = np.indices((rows, columns)).reshape(2, -1, 1)
    di, dj = np.array(_EARLIER).T
    i, j = i + di, j + dj
    inside = (i >= 0) & (j >= 0) & (j < columns)
    return np.ascontiguousarray(np.where(inside, i * columns + j, -1), np.int32)


def wavefronts(
    rows: int, columns: int, length: int, reach: int = 1
) -> Iterator[list[tuple[int, int, int]]]:
    """Yield independent groups of pieces of rows, (row, first, last + 1).

    A patch depends on those to its left and, in the row above, up to `reach` columns to its right.
    So piece c of row i depends on piece c - 1 of its row and on pieces up to c of the row above.
    """
    pieces = -(-(columns + rows * reach) // length)
    for front in range(rows + pieces):
        group = []
        for row in range(max(0, front - pieces + 1), min(rows, front + 1)):
            first = (front - row) * length - row * reach
            first, last = max(first, 0), min(first + length, columns)
            if first < last:
                group.append((row, first, last))
        if group:
            yield group


def scan_pixels(frame: Frame, zones: Zones, seed: int) -> Order:
    """Patches of one pixel, whose zone is the neighborhood above and to the left (section 2.5)."""
    unknown = np.zeros(frame.shape, bool)
    unknown[frame.inside] = True
    y, x = np.indices(frame.canvas.shape).reshape(2, -1)
    corners = (np.stack([y, x], axis=1) + frame.margin - frame.boundary_width) % frame.shape
    return Order(
        corners=corners.astype(np.int32),
        bits=draw(seed, "patch", y, x),
        around=np.zeros((len(corners), 0), np.int32),
        steps=_one_by_one(frame, zones, corners, unknown),
        total=len(corners),
        stage="pixels",
    )


def spiral_patches(frame: Frame, zones: Zones, seed: int) -> Order:
    """Patches, or single pixels, that fill the canvas's hole."""
    unknown = np.zeros(frame.shape, bool)
    unknown[frame.inside] = frame.canvas.hole
    reach = frame.boundary_width
    if frame.method.pixelwise:
        found = [(y - reach, x - reach) for y, x in spiral(unknown)]
        corners = np.array(found, np.int32).reshape(-1, 2) % np.array(frame.shape, np.int32)
    else:
        corners = _useful(_corners(frame, unknown), frame, unknown)
    around = np.zeros((len(corners), 0), np.int32)
    if frame.method.repeat_distance > 0 and not frame.method.pixelwise:
        around = pasted_nearby(corners, 2 * np.array(frame.window))
    return Order(
        corners=corners,
        bits=draw(seed, "patch", np.arange(len(corners))),
        around=around,
        steps=_one_by_one(frame, zones, corners, unknown, ~unknown),
        total=int(unknown.sum()),
        stage="pixels",
    )


def _one_by_one(
    frame: Frame, zones: Zones, corners: NDArray[Any], unknown: Mask, frozen: Mask | None = None
) -> Iterator[Step]:
    """Yield a step for each patch, whose zone are the known pixels of its window; `frozen` stay."""
    unknown, reach = unknown.copy(), frame.boundary_width
    outside = np.ones(frame.shape, bool)
    outside[frame.inside] = False
    for k, (y, x) in enumerate(corners.tolist()):
        at = made = _window_at(frame, y, x)
        stays = None if frozen is None else frozen[at]
        zone = zones.number(~unknown[at] & ~outside[at], stays)
        if frame.method.pixelwise:
            made = at[0][reach, 0], at[1][0, reach]
        yield Step([[Run(zone, k, k + 1)]], int(unknown[made].sum()))
        unknown[made] = False


def pasted_nearby(corners: NDArray[np.int32], reach: Ints) -> NDArray[np.int32]:
    """Return the latest earlier patches nearer than `reach` to each; -1 for none."""
    around = np.full((len(corners), _MOST_AROUND), -1, np.int32)
    for k in range(1, len(corners)):
        near = (np.abs(corners[:k] - corners[k]) < reach).all(axis=1)
        latest = np.flatnonzero(near)[-_MOST_AROUND:]
        around[k, : len(latest)] = latest
    return around


def _window_at(frame: Frame, y: int, x: int) -> tuple[NDArray[np.intp], ...]:
    """Index of the window at a corner; it goes around the frame."""
    (height, width), (rows, columns) = frame.shape, frame.window
    return np.ix_((y + np.arange(rows)) % height, (x + np.arange(columns)) % width)


def _corners(frame: Frame, unknown: Mask) -> list[tuple[int, int]]:
    """Corners of windows that cover the holes, each group of holes spirally inwards."""
    if not unknown.any():
        return []
    overlap = frame.method.boundary_width
    assert overlap
    grids = []
    for axis in (0, 1):
        there = np.flatnonzero(unknown.any(axis=1 - axis))
        start, stop = int(there[0]) - overlap, int(there[-1]) + 1 + overlap
        length, window = unknown.shape[axis], frame.window[axis]
        if not frame.canvas.wrap[axis]:
            start, stop = max(start, 0), min(stop, length)
        slack = max(window - (stop - start), 0)
        start -= slack // 2
        if not frame.canvas.wrap[axis]:
            start = min(max(start, 0), max(length - window, 0))
        shared = min(overlap, window - 1)
        offsets = patch_starts(max(stop - start, window), window, shared, wrap=False)
        grids.append([(start + k) % length for k in offsets])
    cells = np.array([[unknown[_window_at(frame, y, x)].any() for x in grids[1]] for y in grids[0]])
    return [(grids[0][i], grids[1][j]) for i, j in spiral(cells)]


def _useful(corners: list[tuple[int, int]], frame: Frame, unknown: Mask) -> NDArray[np.int32]:
    """Leave out windows that earlier ones cover whole."""
    left, useful = unknown.copy(), []
    for y, x in corners:
        at = _window_at(frame, y, x)
        if left[at].any():
            useful.append((y, x))
            left[at] = False
    return np.array(useful, np.int32).reshape(-1, 2)


def spiral(cells: Mask) -> Iterator[tuple[int, int]]:
    """Yield (row, column) of each connected group of cells, from its border inward, clockwise."""
    for group in _groups(cells):
        rows, columns = np.nonzero(group)
        top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
        while top <= bottom and left <= right:
            ring = [(top, x) for x in range(left, right + 1)]
            ring += [(y, right) for y in range(top + 1, bottom + 1)]
            if top < bottom:
                ring += [(bottom, x) for x in range(right - 1, left - 1, -1)]
            if left < right:
                ring += [(y, left) for y in range(bottom - 1, top, -1)]
            yield from ((int(y), int(x)) for y, x in ring if group[y, x])
            top, bottom, left, right = top + 1, bottom - 1, left + 1, right - 1


def _groups(cells: Mask) -> Iterator[Mask]:
    left = cells.copy()
    while left.any():
        group = np.zeros_like(left)
        wider = np.arange(left.size).reshape(left.shape) == left.argmax()
        while (wider != group).any():
            group, wider = wider, grown(wider, 1, (False, False)) & left
        left &= ~group
        yield group
