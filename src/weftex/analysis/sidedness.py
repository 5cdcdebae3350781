"""Whether a material has a way up: light from one side, drips, grass that grows.

Upside down, every difference of two pixels has the other sign. So of a sample that looks as right
upside down, differences in any direction are as often large upwards as downwards; stones lit from
one side have few steep bright edges there, and many soft dark ones beyond.
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
    """Measure how far a sample is from looking the same upside down.

    Parameters
    ----------
    exemplar : Exemplar
        The sample; a mask may leave out parts of it.

    Returns
    -------
    float
        The largest skewness of differences in any direction, of cubes over those of sizes, mean of
        single pixels and of means of 2x2: 0 of what has no way up, 1 of edges all of one sign.
        Rounded to hundredths, so that it is the same on every machine.

    Examples
    --------
    >>> from weftex.exemplar import Exemplar
    >>> noise = np.random.default_rng(0).integers(0, 256, (96, 96)).astype(np.uint8)
    >>> sidedness(Exemplar(noise)) < 0.05
    True
    >>> steps = np.arange(96)[:, None] % 12 * np.ones(96) * 20  # bright below, and a steep edge
    >>> sidedness(Exemplar(steps.astype(np.uint8))) > 0.5
    True
    """
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
    """Of the differences of two pixels that are usable."""
    height, width = levels.shape
    down, along = shift
    one = np.s_[: height - down, max(0, -along) : width - max(0, along)]
    other = np.s_[down:, max(0, along) : width + min(0, along)]
    apart = (levels[other] - levels[one])[usable[one] & usable[other]]
    cubes = apart * apart * apart
    size = float(np.abs(cubes).sum())
    return float(cubes.sum()) / size if size else 0.0
