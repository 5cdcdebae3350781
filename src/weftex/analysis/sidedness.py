"""Whether a material has a fixed orientation: light from one side, drips, grass that grows.

Upside down, every difference of two pixels changes its sign. So a sample that looks the same
upside down has differences without skew in any direction; stones lit from one side have few steep
bright edges on that side, and many soft dark ones on the other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import relief

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

    Floats = NDArray[np.float64]

#: Rows and columns between the two pixels; the other half of all directions has the other sign.
_SHIFTS = [(0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (2, -1), (2, -2), (1, -2)]


def sidedness(exemplar: Exemplar) -> float:
    """Return how far a sample is from looking the same upside down: the skew of differences."""
    flat = relief(exemplar)
    levels, usable = flat.levels.mean(axis=0), flat.usable > 0
    skews = np.zeros(len(_SHIFTS))
    for half in (False, True):
        if half:
            rows, columns = (n // 2 * 2 for n in levels.shape)
            corners = [np.s_[y:rows:2, x:columns:2] for y in (0, 1) for x in (0, 1)]
            levels = sum(levels[c] for c in corners)
            usable = np.logical_and.reduce([usable[c] for c in corners])
        skews += [_skew(levels, usable, shift) for shift in _SHIFTS]
    return round(float(np.abs(skews).max()) / 2, 2)


def _skew(levels: Floats, usable: NDArray[np.bool_], shift: tuple[int, int]) -> float:
    """Return the skew of the differences of usable pixels."""
    height, width = levels.shape
    down, along = shift
    one = np.s_[: height - down, max(0, -along) : width - max(0, along)]
    other = np.s_[down:, max(0, along) : width + min(0, along)]
    apart = (levels[other] - levels[one])[usable[one] & usable[other]]
    cubes = apart * apart * apart
    size = float(np.abs(cubes).sum())
    return float(cubes.sum()) / size if size else 0.0
