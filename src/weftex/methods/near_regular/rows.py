"""Samples that repeat by rows only and whose rows have a color each: boards.

There, blocks beside each other get the same rows of the sample, or every board would end with its
block.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.lattices.mean_tile import MeanTile
from weftex.random import draw
from weftex.raster.boxes import sums_along

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SLANT = 0.1  # of rows that blocks still follow
_SHARE = (2, 5)  # of the variance of colors, from which rows continue; boards 0.5 to 0.8, roofs 0.1
_JOINT = 12  # of a row's height, over which a joint is looked for
#: Stands for any rows.
ANY = -(2**31)


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


def choose_rows(
    whole: NDArray[np.bool_],
    period: int,
    multiples: NDArray[np.int64],
    places: NDArray[np.int64],
    reach: NDArray[np.int64],
    numbers: NDArray[np.int64],
    seed: int,
) -> NDArray[np.int64]:
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
    result: NDArray[np.int64] = np.where(there.any(axis=-1), multiples[first], ANY)
    return result
