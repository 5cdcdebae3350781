"""Feature size: how large stones, leaves, blades or stains are where nothing repeats.

Two measures that fail on different materials, and their geometric mean:

* The correlation length: how far apart two places are alike to 1/e, in the mean over directions.
  Pits in a tile and grain in a stone make it short, slow changes of tone make it long.
* The granulometry (after Matheron, 1975): openings by squares take off what is bright and narrower
  than the square, closings what is dark and narrower. What each square takes off beyond the one
  before it is the share of things of that width; joints and pits do not hide the stones between
  them. Those shares count by their fourth power, which makes the highest of them decide.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import mixed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.relief import Relief

    Floats = NDArray[np.float64]

#: What each measure is to be multiplied by, so that it is the size that a person reads: medians
#: over 14 surfaces; docs/lab/scale-of-features.md has the errors on 12 others.
_LENGTHS, _WIDTHS = 6.07, 1.04
_CONTRAST = 40.0  # levels of 255 to a standard deviation
#: The distance at which the correlation is 1/2, over that at which it is 1/4: where it falls
#: straight, as for things of one size, and where the size is right in one sample of ten.
_ONE_SIZE, _MANY = 0.633, 0.27
_SUREST = 0.95


def size_of_things(flat: Relief, fall: Floats) -> tuple[float, float]:
    """Return the size of the features in a sample in pixels of the relief, and its confidence."""
    length, width = distance_at(fall, float(np.exp(-1))), _width(_bytes(flat))
    straight = distance_at(fall, 0.5) / max(distance_at(fall, 0.25), 1e-9)
    sure = (straight - _MANY) / (0.8 * _ONE_SIZE - _MANY)
    size = (max(_LENGTHS * length, 1.0) * max(_WIDTHS * width, 1.0)) ** 0.5
    return size, min(max(sure, 0.0), _SUREST)


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


def _bytes(flat: Relief) -> NDArray[np.uint8]:
    """Return the mixture of channels that varies most, at one contrast for all samples."""
    levels = mixed(flat.levels)
    levels *= _CONTRAST / max(float(levels.std()), 1e-12)
    return np.clip(np.rint(levels + 127.5), 0, 255).astype(np.uint8)


def _width(levels: NDArray[np.uint8]) -> float:
    """Return the width of the bright or of the dark features, the greater; 0 without any."""
    widest = min(levels.shape) // 2
    sizes = sorted(size for k in range(16) for size in (2 << k, 3 << k) if size <= widest)
    octaves = np.log2([1, *sizes])
    steps = np.diff(octaves)
    greater = 0.0
    for lowest, highest, end in ((np.minimum, np.maximum, 0), (np.maximum, np.minimum, 255)):
        left, eroded = [float(levels.mean())], {1: levels}
        for size in sizes:
            before = 2 if size == 3 else size // 2
            eroded[size] = _extremes(eroded[before], size - before, lowest)
            around = np.pad(eroded[size], size - 1, constant_values=end)
            left.append(float(_over_squares(around, size, highest).mean()))
        share = (abs(np.diff(left)) / steps) ** 4 * steps
        if share.sum() > 0:
            middle = (share * (octaves[1:] - steps / 2)).sum() / share.sum()
            greater = max(greater, float(2**middle))
    return greater


def _over_squares(levels: NDArray[np.uint8], size: int, pick: np.ufunc) -> NDArray[np.uint8]:
    """Return extremes over all squares of `size` pixels a side."""
    reach = 1
    while reach < size:
        by = min(reach, size - reach)
        levels, reach = _extremes(levels, by, pick), reach + by
    return levels


def _extremes(levels: NDArray[np.uint8], by: int, pick: np.ufunc) -> NDArray[np.uint8]:
    """Return the extreme of each pixel and those `by` to the right, below, and both."""
    across: NDArray[np.uint8] = pick(levels[:, :-by], levels[:, by:])
    found: NDArray[np.uint8] = pick(across[:-by], across[by:])
    return found
