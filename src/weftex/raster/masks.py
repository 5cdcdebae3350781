"""Masks: growing them, peeling them from the border inwards, and how far it is to them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Ints, Mask


def grown(mask: Mask, steps: int, wrap: tuple[bool, bool]) -> Mask:
    """Dilate the mask by a square of `steps` pixels each way, across borders that wrap."""
    for axis in (0, 1):
        reach = min(steps, mask.shape[axis])
        pads = [(0, 0), (0, 0)]
        pads[axis] = (reach, reach)
        lines = np.pad(mask, pads, mode="wrap" if wrap[axis] else "constant").swapaxes(0, axis)
        width = 1  # lines that are joined
        while width < 2 * reach + 1:
            step = min(width, 2 * reach + 1 - width)
            lines = lines[:-step] | lines[step:]
            width += step
        mask = lines.swapaxes(0, axis)
    return np.ascontiguousarray(mask)


def peeled(unknown: Mask, wrap: tuple[bool, bool]) -> list[NDArray[np.int32]]:
    """Flat indices of unknown pixels in layers from the known pixels inward; one if none is known.

    Each pixel has a 4-neighbor in the layer before or among the known; layers are in scan order.
    """
    found, left = [], unknown.copy()
    while left.any():
        known = np.pad(~left, 1)
        for axis in (0, 1):
            if wrap[axis]:
                ends = known.swapaxes(0, axis)
                ends[0], ends[-1] = ends[-2].copy(), ends[1].copy()
        beside = known[:-2, 1:-1] | known[2:, 1:-1] | known[1:-1, :-2] | known[1:-1, 2:]
        layer = left & beside if (left & beside).any() else left
        found.append(np.flatnonzero(layer).astype(np.int32))
        left = left & ~layer
    return found


def squared_distance_to(mask: Mask, most: int, wrap: tuple[bool, bool] = (False, False)) -> Ints:
    """Squared distance (H, W) to the nearest True pixel; (most + 1)^2 if farther than `most`."""
    far = (most + 1) ** 2
    kind = np.int32 if far < 2**30 else np.int64  # a sum of two squares must fit
    square = np.minimum(_distance_along(mask, most, wrap[1]).astype(kind) ** 2, far)
    # Squares add up, so one axis can be done after the other.
    steps = min(most, len(square) - 1)
    best = square.copy()
    if wrap[0]:
        square = np.pad(square, [(steps, steps), (0, 0)], mode="wrap")
        for step in range(1, steps + 1):
            for at in (steps - step, steps + step):
                np.minimum(best, square[at : at + len(best)] + step**2, out=best)
    else:
        for step in range(1, steps + 1):
            np.minimum(best[step:], square[:-step] + step**2, out=best[step:])
            np.minimum(best[:-step], square[step:] + step**2, out=best[:-step])
    squares: Ints = np.minimum(best, far).astype(np.int64)
    return squares


def _distance_along(mask: Mask, most: int, wraps: bool) -> Ints:
    """Distance to the nearest True pixel of the same row; `most + 1` if none is that near."""
    around = min(most, mask.shape[1]) if wraps else 0
    mask = np.pad(mask, [(0, 0), (around, around)], mode="wrap")
    at = np.arange(mask.shape[1])
    nowhere = len(at) + most + 1
    before = np.maximum.accumulate(np.where(mask, at, -nowhere), axis=1)
    after = np.minimum.accumulate(np.where(mask, at, nowhere + len(at))[:, ::-1], axis=1)[:, ::-1]
    nearest = np.minimum(np.minimum(at - before, after - at), most + 1)
    return nearest[:, around : mask.shape[1] - around]


def steps_to(mask: Mask, most: int) -> NDArray[np.int32]:
    """Chessboard distance to the nearest True pixel; `most + 1` if farther than `most`."""
    distance = np.where(mask, 0, most + 1).astype(np.int32)
    reached = mask
    for step in range(1, most + 1):
        wide = reached.copy()
        wide[1:] |= reached[:-1]
        wide[:-1] |= reached[1:]
        reached = wide.copy()
        reached[:, 1:] |= wide[:, :-1]
        reached[:, :-1] |= wide[:, 1:]
        distance[reached & (distance > step)] = step
    return distance


def row_runs(mask: Mask) -> tuple[Ints, Ints, Ints]:
    """Return first column, last column + 1 and row of each run of True pixels, row by row."""
    change = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, start = np.nonzero(change == 1)
    return start, np.nonzero(change == -1)[1], row
