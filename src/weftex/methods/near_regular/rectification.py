"""Rectifying a near-regular sample: its pixels moved to where the lattice wants them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.lattices.mean_tile import MeanTile
from weftex.raster.boxes import extended_sums, sums_along

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ROUNDS = 2  # the mean tile gets sharper by the first
_GRID = 4  # px between the places where the shift is found
_GAIN = (3, 4)  # pixels move only if that leaves at most 3/4 of the difference
_NEAREST, _FARTHEST = 4, 12  # px around a place that are compared


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
