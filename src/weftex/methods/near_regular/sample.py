"""A sample prepared for near-regular synthesis: windows, borders, rows, rectified pixels.

Rows are for samples that repeat from row to row only and whose rows have a color each, such as
boards: blocks beside each other get the same rows, or every board would end with its block.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice, MeanTile
from weftex.exemplar import Exemplar
from weftex.methods.near_regular.defaults import vectors_around
from weftex.random import draw
from weftex.raster.boxes import extended_sums, sums_along
from weftex.raster.masks import row_runs
from weftex.search.picture_kernels import Sample
from weftex.search.windows import Windows, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SOFT = 40  # squared difference of a channel, two pixels apart, that halves the visibility
_ROUNDS = 2  # the mean tile gets sharper by the first
_GRID = 4  # px between the places where the shift is found
_GAIN = (3, 4)  # pixels move only if that leaves at most 3/4 of the difference
_NEAREST, _FARTHEST = 4, 12  # px around a place that are compared
_SLANT = 0.1  # of rows that blocks still follow
_SHARE = (2, 5)  # of the variance of colors, from which rows continue; boards 0.5 to 0.8, roofs 0.1
_JOINT = 12  # of a row's height, over which a joint is looked for


@dataclass(frozen=True)
class Courses:
    """Rows that blocks keep to: their height in pixels, and where the first joint is."""

    height: float
    joint: int

    def division(self, size: int, height: float | None = None) -> tuple[int, int]:
        """How many rows a block no larger than `size` has, and how many blocks share a row.

        One of the two is 1. On a canvas that wraps rows have another `height`.

        >>> Courses(8.0, 0).division(20), Courses(50.0, 0).division(20)
        ((2, 1), (1, 3))
        """
        height = height or self.height
        return max(1, int(size / height + 1e-9)), math.ceil(height / size - 1e-9)


class Border(NamedTuple):
    """The pixels of a gap's window that must match."""

    wedges: NDArray[np.uint8]  # 1 to 4: of the neighbor above, left, below, right; 0 off the border
    runs: NDArray[np.int32]  # (n, 3): the border as runs of pixels, y, x and length, shuffled


@dataclass(frozen=True, eq=False)
class BlockSample:
    """All that outputs of one sample have in common.

    An offset leads from a block's phase to a similar window: a sum of multiples of the lattice
    vectors in 1/65536 pixel.
    """

    exemplar: Exemplar
    windows: Windows  # by their upper left corners
    lookup: NDArray[np.int32] | None  # (H, W): the pixel at each place, if the sample is rectified
    pixels: NDArray[np.uint8]  # (H', W', K), the windows' pixels, rectified
    visibility: NDArray[np.uint16]  # (H', W'), of a seam at each of them
    offsets: NDArray[np.int64]  # (n, 2), shuffled
    multiples: NDArray[np.int64]  # (n,), of the first vector in each
    row_axis: int | None  # along which rows change that have a color each, see `axis_of_rows`
    courses: tuple[Courses | None, ...]  # rows that blocks keep to, along both axes
    _borders: dict[tuple[int, ...], Border] = field(default_factory=dict, repr=False)

    def border(self, height: int, width: int, margin: int, half: int) -> Border:
        """The border of gaps of one size, see `wedges_of`."""
        key = int(height), int(width), margin, half
        if key not in self._borders:
            wedges = wedges_of(*key)
            start, stop, row = row_runs(wedges > 0)
            runs = np.stack([row, start, stop - start], axis=1).astype(np.int32)
            self._borders[key] = Border(wedges, shuffled(runs))
        return self._borders[key]

    @property
    def kernel(self) -> Sample:
        """The windows as kernels take them."""
        return Sample(self.pixels, self.windows.usable, self.windows.period)


def prepare(method: Any, exemplar: Exemplar) -> BlockSample:
    """Analyze a sample for a resolved method: its windows, rectified pixels, similar windows."""
    vectors, reach = method.lattice, method.window_side - 1
    if exemplar.tileable and vectors_around(vectors, exemplar) is None:
        windows = windows_of(exemplar.changed(tileable=False), (0, reach, 0, reach))
    else:
        windows = windows_of(exemplar, (0, reach, 0, reach))
    pixels, lookup = windows.pixels, None
    if method.rectify:
        lookup = rectified(pixels, vectors, method.rectify, by_rows=method.by_rows)
        pixels = np.ascontiguousarray(pixels.reshape(-1, pixels.shape[2])[lookup])
    row_axis = None
    courses: list[Courses | None] = [None, None]
    lattice = CanvasLattice(vectors)
    offsets = shuffled(lattice.steps(*exemplar.shape), "steps")
    if method.by_rows and exemplar.mask is None:
        row_axis = axis_of_rows(pixels, vectors)
    if row_axis is not None:
        courses[row_axis] = courses_of(pixels, vectors, row_axis)
    return BlockSample(
        exemplar=exemplar,
        windows=windows,
        lookup=lookup,
        pixels=pixels,
        visibility=visibility(pixels, method.seam_cost == "gradient"),
        offsets=offsets,
        multiples=np.rint(offsets @ lattice.inverse[:, 0] / 65536).astype(np.int64),
        row_axis=row_axis,
        courses=tuple(courses),
    )


def wedges_of(height: int, width: int, margin: int, half: int) -> NDArray[np.uint8]:
    """Wedge-shaped borders (Fig. 4.8b), 2 * `half` wide, of a block's window, see `Border`.

    >>> wedges_of(4, 4, 1, 1)[:3]
    array([[1, 1, 1, 1, 1, 1],
           [2, 1, 1, 1, 1, 4],
           [2, 2, 0, 0, 4, 4]], dtype=uint8)
    """
    v, u = np.indices((height + 2 * margin, width + 2 * margin))
    away = np.stack([v, u, v[::-1], u[:, ::-1]]) - (margin - half)
    nearest = away.min(axis=0)
    border = (nearest >= 0) & (nearest < 2 * half)
    return np.where(border, away.argmin(axis=0) + 1, 0).astype(np.uint8)


def shuffled(values: NDArray[Any], purpose: str = "runs") -> NDArray[Any]:
    """Shuffle rows: the first few then tell about all, such as runs on all sides of a border."""
    order = np.argsort(draw(0, purpose, np.arange(len(values))), kind="stable")
    return np.ascontiguousarray(values[order])


def visibility(pixels: NDArray[np.uint8], gradient: bool) -> NDArray[np.uint16]:
    """How visible a seam is at each pixel, at least 1: less on edges of the sample's own.

    Unless by `gradient` it is the same everywhere.

    >>> step = np.array([[[10], [10], [10], [90], [90]]], np.uint8)
    >>> visibility(step, gradient=True).tolist()
    [[4096, 4096, 25, 25, 4096]]
    """
    if not gradient:
        return np.ones(pixels.shape[:2], np.uint16)
    wide = np.pad(pixels.astype(np.int32), ((1, 1), (1, 1), (0, 0)), mode="edge")
    steep = (wide[2:, 1:-1] - wide[:-2, 1:-1]) ** 2
    steep += (wide[1:-1, 2:] - wide[1:-1, :-2]) ** 2
    soft = _SOFT * pixels.shape[2]
    result: NDArray[np.uint16] = np.maximum(4096 * soft // (soft + steep.sum(axis=2)), 1).astype(
        np.uint16
    )
    return result


def axis_of_rows(pixels: NDArray[np.uint8], vectors: tuple[float, ...]) -> int | None:
    """Along which axis the rows of a sample change, if each row keeps its color.

    0 if rows lie, 1 if they stand, None if they are slanted or of mixed colors. The first vector
    leads from row to row.

    >>> boards = np.repeat(np.uint8([90, 120, 100, 140, 95, 130]), 8)
    >>> axis_of_rows(np.tile(boards, (48, 1))[..., None], (8, 0, 0, 7))
    1
    """
    x, y = abs(vectors[0]), abs(vectors[1])
    if min(x, y) > _SLANT * max(x, y):
        return None
    axis = 0 if y > x else 1
    period = round(max(x, y))
    tile = MeanTile(pixels, vectors).at(*np.indices(pixels.shape[:2]))
    rest = np.moveaxis(pixels.astype(np.int64) - tile, axis, 0)
    # Colors of boxes as long as rows are high, or half the sample, and half as high.
    high, period = max(1, period // 2), min(period, rest.shape[1] // 2)
    count = rest.shape[1] // max(1, period)
    if count < 2 or len(rest) < high:
        return None
    parts = rest[:, : count * period].reshape(len(rest), count, period, -1).sum(axis=2)
    first = np.arange(len(parts) - high + 1)
    parts = sums_along(parts, 0, first, first + high)
    whole = parts.sum(axis=(0, 1)) ** 2
    number = parts.shape[0] * count
    rows = (parts.sum(axis=1) ** 2).sum(axis=0) * len(parts) - whole
    total = (parts**2).sum(axis=(0, 1)) * number - whole
    if total.sum() > 0 and _SHARE[1] * int(rows.sum()) >= _SHARE[0] * int(total.sum()):
        return axis
    return None


def courses_of(pixels: NDArray[np.uint8], vectors: tuple[float, ...], axis: int) -> Courses:
    """Find where the rows of a sample end: where all rows look most alike, in joints.

    >>> rows = np.repeat(np.uint8([90, 120, 100, 140, 95, 130]), 8)
    >>> rows[4::8] = 30
    >>> boards = np.tile(rows[:, None, None], (1, 48, 1))
    >>> courses_of(boards, (0, 8, 7, 0), 0)
    Courses(height=8, joint=4)
    """
    period = abs(vectors[1 - axis])
    lines = np.moveaxis(pixels, axis, 0).sum(axis=1, dtype=np.int64)
    at = np.arange(len(lines))
    number = np.floor(at / period).astype(np.int64)
    place = np.floor(at - number * period).astype(np.int64)
    count = np.bincount(place)
    variance = np.zeros(len(count), np.int64)
    for line in lines.T:
        total, squares = np.zeros_like(count), np.zeros_like(count)
        np.add.at(total, place, line)
        np.add.at(squares, place, line**2)
        variance += (squares * count - total**2) // count**2
    near = max(0, round(period / _JOINT) // 2)
    around = np.stack([np.roll(variance, k) for k in range(-near, near + 1)]).sum(axis=0)
    return Courses(period, int(around.argmin()))


def rectified(
    pixels: NDArray[np.uint8], vectors: tuple[float, ...], reach: int, *, by_rows: bool = False
) -> NDArray[np.int32]:
    """Flat index (H, W) of the pixel that belongs at each place if all tiles had one shape.

    Pixels move at most `reach`, by whole pixels, to agree with the mean tile; those that could be
    anywhere follow the others. With `by_rows`, only the first vector is a period to move along.

    >>> tile = np.random.default_rng(0).integers(0, 255, (12, 10, 1), np.uint8)
    >>> found = rectified(np.tile(tile, (4, 4, 1)), (10, 0, 0, 12), 2)
    >>> bool((found == np.arange(48 * 40).reshape(48, 40)).all())  # it is regular
    True
    """
    x1, y1, x2, y2 = vectors
    height, width = pixels.shape[:2]
    side = round(abs(x1 * y2 - x2 * y1) ** 0.5 / 6)
    radius = min(max(side, _NEAREST), _FARTHEST)
    steps = range(-reach, reach + 1)
    shifts = sorted(
        ((a, b) for a in steps for b in steps), key=lambda s: (s[0] ** 2 + s[1] ** 2, s)
    )
    if by_rows:
        length = float(np.hypot(x1, y1))
        along = [(round(n * y1 / length), round(n * x1 / length)) for n in steps]
        shifts = sorted(set(along), key=lambda s: (s[0] ** 2 + s[1] ** 2, s))
    place = np.indices((height, width))
    moved = np.zeros((2, height, width), np.int64)
    sample = pixels.astype(np.int32)
    for _ in range(_ROUNDS):
        y, x = np.clip(place + moved, 0, np.array([height - 1, width - 1])[:, None, None])
        tile = MeanTile(pixels[y, x], vectors).at(*place).astype(np.int32)
        moved = _moved(sample, tile, shifts, radius)
    y, x = np.clip(place + moved, 0, np.array([height - 1, width - 1])[:, None, None])
    result: NDArray[np.int32] = (y * width + x).astype(np.int32)
    return result


def _moved(
    sample: NDArray[np.int32], tile: NDArray[np.int32], shifts: list[tuple[int, int]], radius: int
) -> NDArray[np.int64]:
    """The best shift of each pixel, smoothed with its advantage over the mean shift as weight."""
    height, width = sample.shape[:2]
    grid = [np.arange(0, n + _GRID - 1, _GRID).clip(max=n - 1) for n in (height, width)]
    area = _sums(np.ones((height, width), np.uint32), grid, radius)
    best = np.full(area.shape, np.iinfo(np.int64).max)
    found = np.zeros((2, *area.shape), np.int64)
    total, still = np.zeros(area.shape, np.int64), area
    rows, columns = np.arange(height), np.arange(width)
    for dy, dx in shifts:
        lines = sample[(rows + dy).clip(0, height - 1)]
        error = lines[:, (columns + dx).clip(0, width - 1)] - tile
        error *= error
        mean = _sums(error.sum(axis=2).astype(np.uint32), grid, radius) // area
        total += mean
        still = mean if (dy, dx) == (0, 0) else still
        better = mean < best
        best[better] = mean[better]
        found[:, better] = np.array([[dy], [dx]])
    found[:, best * _GAIN[1] > still * _GAIN[0]] = 0
    sure = total // len(shifts) - best
    around = max(2, radius // 2)
    weight = _even(sure, around)
    moved = []
    for k in (0, 1):
        evened = _even(sure * found[k], around) / np.maximum(weight, 1)
        for axis, n in enumerate((height, width)):  # linear between the places of the grid
            at = np.arange(n)
            low = at // _GRID
            high = np.minimum(low + 1, evened.shape[axis] - 1)
            part = ((at % _GRID) / _GRID).reshape((-1, 1) if axis == 0 else (1, -1))
            evened = np.take(evened, low, axis) * (1 - part) + np.take(evened, high, axis) * part
        moved.append(np.rint(evened).astype(np.int64))
    return np.stack(moved)


def _sums(
    values: NDArray[np.uint32], grid: list[NDArray[np.int64]], radius: int
) -> NDArray[np.int64]:
    """Sums over the box around each place of the grid, clipped to the picture."""
    for axis, at in enumerate(grid):
        values = sums_along(values, axis, at - radius, at + radius + 1)
    return values.astype(np.int64)


def _even(values: NDArray[np.int64], radius: int) -> NDArray[np.int64]:
    """Sums over boxes, twice; exact, since they are integers."""
    return extended_sums(extended_sums(values, radius), radius)
