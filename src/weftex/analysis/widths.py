"""Widths of the features in a sample: of the squares that take them off, or between joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.relief import LOOK, Relief, means, mixed
from weftex.raster.arrays import Bytes, Floats

_CONTRAST = 40.0  # levels of 255 to a standard deviation
_JOINT = 7  # pixels: wider is no joint
_RUN = 21  # pixels that joints run on
_SMALLEST = 120  # pixels a side; smaller samples show too few joints
_WAYS = 8  # directions that are tried
_LINE = 2.55  # standard deviations of the mean along runs, from which pixels are joints
#: The same from the highest 8 to the lowest 40 % of the pixels, from which there are joints, and
#: its ratio to that of the other sign: of things that overlap, bright and dark rests are narrow.
_CLEAR, _ONE_SIGN = (2.0, 1.8), (1.12, 1.17)  # then in pixels twice as large, against grain
_ONE_WAY = 0.6  # of joints in one direction; of grain and boards
_PITCH = 1.55  # distance of stones over the width of squares between joints, which fit half of them


def between_joints(flat: Relief, coarser: int = 0) -> float:
    """Return the distance of stones by the joints around them, in pixels; 0 without joints.

    What is narrow (top-hats) is averaged along short lines: joints run on, texture and pits do not.
    """
    step = -(-max(flat.usable.shape) // LOOK) << coarser
    if min(flat.usable.shape) < _SMALLEST * step:
        return 0.0
    levels, found = _bytes(means(flat.levels, step)), []
    around = np.pad(levels, _JOINT - 1, mode="edge")
    for first, second in ((np.maximum, np.minimum), (np.minimum, np.maximum)):
        flatter = over_squares(over_squares(around, _JOINT, first), _JOINT, second)
        runs = _along_runs(abs(flatter.astype(np.float32) - levels))
        runs /= max(float(runs.var(axis=(1, 2)).mean()) ** 0.5, 1e-6)
        ranked = np.sort(runs.max(axis=0), axis=None)
        high, low = (float(ranked[len(ranked) * share // 100]) for share in (92, 40))
        found.append((high - low, runs))
    (other, _), (clear, runs) = sorted(found, key=lambda one: one[0])
    joints = runs.max(axis=0) > _LINE
    ways = np.exp(2j * np.pi / _WAYS * runs.argmax(axis=0)[joints])
    if clear < max(_CLEAR[coarser], _ONE_SIGN[coarser] * other) or abs(ways.mean()) > _ONE_WAY:
        return 0.0 if coarser else between_joints(flat, 1)
    octaves, left = _openings(np.where(joints, 0, 255).astype(np.uint8), 0)
    half = distance_at(left / left[0], 0.5)
    width = float(np.exp2(np.interp(half, np.arange(len(left)), octaves)))
    return float(_PITCH * step * width)


def _along_runs(narrow: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean along a line through each pixel in each direction, less that of all."""
    reach, (height, width) = _RUN // 2, narrow.shape
    wide = np.pad(narrow - narrow.mean(), reach, mode="reflect")
    runs = np.zeros((_WAYS, height, width), np.float32)
    at = np.arange(-reach, reach + 1)
    for run, angle in zip(runs, np.pi / _WAYS * np.arange(_WAYS), strict=True):
        down, along = (np.rint(at * f(angle)).astype(int) + reach for f in (np.sin, np.cos))
        for y, x in zip(down, along, strict=True):
            run += wide[y : y + height, x : x + width]
    runs /= _RUN
    return runs


def distance_at(fall: Floats, value: float) -> float:
    """Return the distance at which a curve first falls below a value, or its end.

    >>> distance_at(np.array([1.0, 0.8, 0.4, 0.0]), 0.6)
    1.5
    """
    below = np.flatnonzero(fall < value)
    if not len(below):
        return float(len(fall))
    k = int(below[0])
    return k - 1 + float((fall[k - 1] - value) / (fall[k - 1] - fall[k])) if k else 0.0


def _bytes(levels: Floats) -> Bytes:
    """Return the mixture of channels that varies most, at one contrast for all samples."""
    levels = mixed(levels)
    levels *= _CONTRAST / max(float(levels.std()), 1e-12)
    return np.clip(np.rint(levels + 127.5), 0, 255).astype(np.uint8)


def feature_width(flat: Relief) -> float:
    """Return the width of the bright or of the dark features, the greater; 0 without any."""
    levels, greater = _bytes(flat.levels), 0.0
    for end in (0, 255):
        octaves, left = _openings(levels, end)
        steps = np.diff(octaves)
        share = (abs(np.diff(left)) / steps) ** 4 * steps
        if share.sum() > 0:
            middle = (share * (octaves[1:] - steps / 2)).sum() / share.sum()
            greater = max(greater, float(2**middle))
    return greater


def _openings(levels: Bytes, end: int) -> tuple[Floats, Floats]:
    """Return octaves of widths of squares, and the mean level after an opening by each.

    After a closing if `end` is 255, the level around the picture.
    """
    lowest, highest = (np.maximum, np.minimum) if end else (np.minimum, np.maximum)
    widest = min(levels.shape) // 2
    sizes = sorted(size for k in range(16) for size in (2 << k, 3 << k) if size <= widest)
    left, eroded = [float(levels.mean())], {1: levels}
    for size in sizes:
        before = 2 if size == 3 else size // 2
        eroded[size] = _extremes(eroded[before], size - before, lowest)
        around = np.pad(eroded[size], size - 1, constant_values=end)
        left.append(float(over_squares(around, size, highest).mean()))
    return np.log2([1, *sizes]), np.array(left)


def over_squares(levels: Bytes, size: int, pick: np.ufunc) -> Bytes:
    """Return extremes over all squares of `size` pixels a side."""
    reach = 1
    while reach < size:
        by = min(reach, size - reach)
        levels, reach = _extremes(levels, by, pick), reach + by
    return levels


def _extremes(levels: Bytes, by: int, pick: np.ufunc) -> Bytes:
    """Return the extreme of each pixel and those `by` to the right, below, and both."""
    across: Bytes = pick(levels[:, :-by], levels[:, by:])
    return np.asarray(pick(across[:-by], across[by:]))
