"""What a sample is like: whether it repeats, tiles, has an orientation, and looks even.

Synthesis assumes that a sample is a window of an endless, uniform material. Two faults of a photo
break that, and no method can repair them: uneven light, and one object (or a few) instead of many.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from weftex.analysis.autocorrelations import highest_around
from weftex.analysis.correlation import correlate
from weftex.analysis.relief import means, relief, usable_box
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats, Mask, median

_STRIP = 256  # lines that are read at a time, for little memory
#: Rows and columns between the two pixels; the other half of all directions has the other sign.
_SHIFTS = [(0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (2, -1), (2, -2), (1, -2)]
_CELLS = 8  # along each side; what is larger than one is a large form
#: Above these, forms are large, and the light is uneven: samples of many evenly lit features have
#: up to 0.33, and 0.2 by chance; the last are gray levels.
FORMS, _LIGHT, _LIGHT_RANGE = 0.45, 0.25, 40.0


def regularity(exemplar: Exemplar) -> float:
    """Return how well a sample repeats at some shift of up to half its sides, from 0 to 1.

    The correlation at a shift, less the lowest on the straight way to it where that is above 0, so
    long lines and slow changes do not count. Irregular samples have 0.1 to 0.3, bricks 0.6 to 0.9.
    """
    flat = relief(exemplar)
    height, width = flat.usable.shape
    correlation = correlate(flat.levels, flat.usable >= 0.5, (height // 2, width // 2))
    return round(highest_return(correlation), 2)


def highest_return(correlation: Floats) -> float:
    """Return the highest correlation at any shift above the lowest on the straight way to it."""
    middle, center = correlation.shape[0] // 2, correlation.shape[1] // 2
    half = correlation[middle:]  # the other one is its mirror image
    y, x = (half >= highest_around(correlation)[middle:]).nonzero()
    best = 0.0
    for k in np.argsort(-half[y, x], kind="stable"):
        reached = float(half[y[k], x[k]])
        if reached <= best:
            break  # no other shift can come back any higher
        steps = np.linspace(0, 1, 1 + max(int(y[k]), abs(int(x[k]) - center)))
        down, along = (np.rint(steps * far).astype(int) for far in (y[k], x[k] - center))
        best = max(best, reached - max(0.0, float(half[down, center + along].min())))
    return best


def border_steps(exemplar: Exemplar) -> tuple[float, float]:
    """Return the step across the border over the steps inside, downwards and to the right.

    A step is the mean squared difference of neighboring lines. The step at the border is divided
    by the median of the others, or by the first or last where larger, as on a joint. Equal lines,
    as in an image that was enlarged by repeating pixels, do not count.
    """
    found = []
    for axis in (0, 1):
        lines, whole = (np.moveaxis(a, axis, 0) for a in (exemplar.matching(), exemplar.usable))
        total = np.zeros(len(lines), np.int64)
        for start in range(0, lines.shape[1], _STRIP):
            strip = lines[:, start : start + _STRIP].astype(np.int32)
            changes = ((strip - np.roll(strip, 1, 0)) ** 2).sum(axis=2)
            part = whole[:, start : start + _STRIP]
            total += (changes * (part & np.roll(part, 1, 0))).sum(axis=1)
        steps = total / np.maximum((whole & np.roll(whole, 1, 0)).sum(axis=1), 1)
        inside = steps[1:] if len(steps) > 1 else steps  # one line borders on itself
        changing = inside[inside > 0] if inside.any() else inside
        usual = max(median(changing), float(changing[0]), float(changing[-1]), 1.0)
        found.append(round(float(steps[0]) / usual, 2))
    return found[0], found[1]


def sidedness(exemplar: Exemplar) -> tuple[float, float]:
    """Return how far a sample is from looking the same upside down, and turned by 90 degrees.

    The first is the skewness of the differences of pixels. The second compares their squares in
    directions that a quarter turn or a mirror exchanges: grain and light make these unequal.
    """
    flat = relief(exemplar)
    levels, usable = flat.levels.mean(axis=0), flat.usable > 0
    skews, squares = np.zeros((2, len(_SHIFTS)))
    for half in (False, True):
        if half:
            rows, columns = (n // 2 * 2 for n in levels.shape)
            corners = [np.s_[y:rows:2, x:columns:2] for y in (0, 1) for x in (0, 1)]
            levels = sum(levels[c] for c in corners)
            usable = np.logical_and.reduce([usable[c] for c in corners])
        found = np.array([_skew_and_square(levels, usable, shift) for shift in _SHIFTS])
        skews += found[:, 0]
        squares += found[:, 1] / max(float(found[:, 1].max()), 1e-9)
    alike = [squares[0::4], squares[2::4], squares[1::2]]  # directions that copies exchange
    apart = [float(np.ptp(one) / max(one.max() + one.min(), 1e-9)) for one in alike]
    return round(float(np.abs(skews).max()) / 2, 2), round(max(apart), 2)


def _skew_and_square(levels: Floats, usable: Mask, shift: tuple[int, int]) -> tuple[float, float]:
    """Return the skew and the mean square of the differences of usable pixels."""
    height, width = levels.shape
    down, along = shift
    one = np.s_[: height - down, max(0, -along) : width - max(0, along)]
    other = np.s_[down:, max(0, along) : width + min(0, along)]
    apart = (levels[other] - levels[one])[usable[one] & usable[other]]
    squares = apart * apart
    cubes = squares * apart
    size = float(np.abs(cubes).sum())
    skew = float(cubes.sum()) / size if size else 0.0
    return skew, float(squares.sum()) / max(len(apart), 1)


@dataclass(frozen=True)
class Evenness:
    """How much a sample differs from place to place.

    Attributes
    ----------
    light : float
        Share of the variance that slow changes of light explain; up to 0.2 by chance.
    light_range : float
        Difference between the darkest and the brightest of this light, in gray levels of 255.
    large_forms : float
        Share of the remaining variance that forms larger than an eighth of the sample explain. A
        sample of many features has up to 0.3.
    """

    light: float
    light_range: float
    large_forms: float

    @property
    def lit_unevenly(self) -> bool:
        """Whether uneven light should be removed; False if large forms may be the cause."""
        return self.light > _LIGHT and self.light_range > _LIGHT_RANGE and self.large_forms <= FORMS


def evenness(exemplar: Exemplar) -> Evenness:
    """Return how far a sample is from looking the same everywhere."""
    flat = relief(exemplar)
    levels = flat.levels.mean(axis=0)
    gray = np.where(exemplar.usable, exemplar.matching().mean(axis=2), 0)
    surface = means(gray[usable_box(exemplar)], flat.step) * flat.usable - levels
    inside = flat.usable > 0
    rest, slow = float((levels[inside] ** 2).mean()), float(surface[inside].var())
    return Evenness(
        light=_share(slow, slow + rest),
        light_range=round(float(np.ptp(surface[inside])), 2),
        large_forms=_share(_cell_variance(levels, flat.usable), rest),
    )


def _share(part: float, whole: float) -> float:
    return round(min(1.0, part / whole), 2) if whole > 1e-6 else 0.0


def _cell_variance(levels: Floats, usable: Floats) -> float:
    """Return the variance of the means over cells of an eighth of the sides."""
    if min(levels.shape) < 2 * _CELLS:
        return 0.0
    starts = [np.arange(_CELLS) * side // _CELLS for side in levels.shape]
    sums = [
        np.add.reduceat(np.add.reduceat(values, starts[0], axis=0), starts[1], axis=1)
        for values in (levels, usable)
    ]
    filled = sums[1] > levels.size / _CELLS**2 / 4
    return float(((sums[0][filled] / sums[1][filled]) ** 2).mean()) if filled.any() else 0.0
