"""Rows of a sample that keep a color each, such as boards."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.raster.boxes import sums_along

_SLANT = 0.1  # of rows that are still taken for level, or upright
_SHARE = (2, 5)  # of the variance of colors, from which rows keep their color; boards 0.5 to 0.8
_JOINT = 12  # of a row's height, over which a joint is looked for


class ColoredRows(NamedTuple):
    """The rows of a sample whose rows keep a color each."""

    axis: int  # along which they change: 0 where they lie, 1 where they stand
    height: float  # pixels
    joint: int  # where the first one ends, along the axis

    def division(self, size: int, height: float | None = None) -> tuple[int, int]:
        """How many rows a block no larger than `size` has, and how many blocks share a row.

        One of the two is 1. On a canvas that wraps rows have another `height`.

        >>> ColoredRows(0, 8.0, 0).division(20), ColoredRows(0, 50.0, 0).division(20)
        ((2, 1), (1, 3))
        """
        height = height or self.height
        return max(1, int(size / height + 1e-9)), math.ceil(height / size - 1e-9)


def find_colored_rows(pixels: NDArray[np.uint8], vectors: tuple[float, ...]) -> ColoredRows | None:
    """Find rows that keep a color each; None if rows are slanted or of mixed colors.

    The first of the vectors x1, y1, x2, y2 leads from row to row.

    >>> boards = np.repeat(np.uint8([90, 120, 100, 140, 95, 130]), 8)
    >>> boards[4::8] = 30
    >>> find_colored_rows(np.tile(boards, (48, 1))[..., None], (8, 0, 0, 7))
    ColoredRows(axis=1, height=8, joint=4)
    """
    x, y = abs(vectors[0]), abs(vectors[1])
    if min(x, y) > _SLANT * max(x, y):
        return None
    axis = 0 if y > x else 1
    period = round(max(x, y))
    rest = np.moveaxis(pixels.astype(np.int64) - mean_tiles(pixels, vectors), axis, 0)
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
        return ColoredRows(axis, max(x, y), _first_joint(pixels, max(x, y), axis))
    return None


def mean_tiles(pixels: NDArray[np.uint8], vectors: tuple[float, ...]) -> NDArray[np.uint8]:
    """Replace each pixel by the mean of all at its place of the tile, to about a pixel."""
    lattice = CanvasLattice(vectors)
    sides = [max(1, round(float(np.hypot(*v)))) for v in lattice.sample]
    y, x = np.indices(pixels.shape[:2])
    cell = lattice.cell(y, x, sides)
    flat, count = cell.ravel(), np.bincount(cell.ravel())
    total = np.stack([np.bincount(flat, c.ravel()) for c in np.moveaxis(pixels, 2, 0)], axis=1)
    mean: NDArray[np.uint8] = np.rint(total / np.maximum(count, 1)[:, None]).astype(np.uint8)
    return mean[cell]


def _first_joint(pixels: NDArray[np.uint8], period: float, axis: int) -> int:
    """Where all rows look most alike, as they do in joints."""
    lines = np.moveaxis(pixels, axis, 0).sum(axis=1, dtype=np.int64)
    at = np.arange(len(lines))
    place = np.floor(at - np.floor(at / period) * period).astype(np.int64)
    count = np.bincount(place)
    variance = np.zeros(len(count), np.int64)
    for line in lines.T:
        total, squares = (np.bincount(place, k).astype(np.int64) for k in (line, line**2))
        variance += (squares * count - total**2) // count**2
    near = max(0, round(period / _JOINT) // 2)
    around = np.stack([np.roll(variance, k) for k in range(-near, near + 1)]).sum(axis=0)
    return int(around.argmin())
