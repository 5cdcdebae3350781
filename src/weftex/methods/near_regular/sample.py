"""A sample prepared for near-regular synthesis: windows, borders, rows.

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
from weftex.raster.boxes import sums_along
from weftex.raster.masks import row_runs
from weftex.search.windows import Windows, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SOFT = 40  # squared difference of a channel, two pixels apart, that halves the visibility
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
    def pixels(self) -> NDArray[np.uint8]:
        """(H', W', K): those of the windows."""
        return self.windows.pixels


def prepare(method: Any, exemplar: Exemplar) -> BlockSample:
    """Analyze a sample for a resolved method: its windows, rows, similar windows."""
    vectors, reach = method.lattice, method.window_side - 1
    if exemplar.tileable and vectors_around(vectors, exemplar) is None:
        windows = windows_of(exemplar.changed(tileable=False), (0, reach, 0, reach))
    else:
        windows = windows_of(exemplar, (0, reach, 0, reach))
    pixels, row_axis = windows.pixels, None
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
