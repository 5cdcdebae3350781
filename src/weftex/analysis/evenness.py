"""Whether a sample looks the same everywhere: its light, how much it shows, its perspective.

Synthesis assumes that a sample is a window of an endless, uniform material. Three faults of a photo
break that, and no method can repair them: uneven light, one object (or a few) instead of many, and
perspective.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import relief

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

    Floats = NDArray[np.float64]

_CELLS = 8  # along each side; what is larger than one is a large form
_BINS = 8  # of the spectrum, an octave
_COARSE, _FINE = 2.0**-5, 0.5  # waves a pixel between which spectra are compared
_SMALLEST_PART = 32  # pixels of the parts whose spectra are compared
_REACH = 8  # bins that a spectrum is shifted by at most
_LIKE, _UNLIKE = 0.6, 0.2  # correlations of spectra: of the same things, and of others


@dataclass(frozen=True)
class Evenness:
    """How far a sample is from looking the same everywhere; 0 throughout is even.

    Attributes
    ----------
    light : float
        Share of the variance that slow lighting has, a quadratic surface; up to 0.2 by chance.
    light_range : float
        By how many gray levels of 255 that surface differs from its darkest to its lightest place.
    large_forms : float
        Share of the rest of the variance that forms larger than an eighth of the sample have; up
        to 0.3 in a sample that shows many things.
    perspective : (float, float)
        How many times larger things are at the bottom than at the top, and at the right than at
        the left; 1 where they are of one size, or that cannot be told.
    """

    light: float
    light_range: float
    large_forms: float
    perspective: tuple[float, float]


def evenness(exemplar: Exemplar) -> Evenness:
    """Return how far a sample is from looking the same everywhere."""
    flat = relief(exemplar)
    levels = flat.levels.mean(axis=0)
    surface = _gray(exemplar, levels.shape, flat.step) * flat.usable - levels
    inside = flat.usable > 0
    rest, slow = float((levels[inside] ** 2).mean()), float(surface[inside].var())
    return Evenness(
        light=_share(slow, slow + rest),
        light_range=round(float(np.ptp(surface[inside])), 2),
        large_forms=_share(_cell_variance(levels, flat.usable), rest),
        perspective=(_growth(levels), _growth(levels.T)),
    )


def _share(part: float, whole: float) -> float:
    return round(min(1.0, part / whole), 2) if whole > 1e-6 else 0.0


def _gray(exemplar: Exemplar, shape: tuple[int, ...], step: int) -> Floats:
    """Return the mean channel of the box of the relief, at its resolution."""
    levels = exemplar.matching().mean(axis=2)
    if exemplar.mask is not None:
        levels = np.where(exemplar.mask, levels, 0)
        rows, columns = (np.flatnonzero(exemplar.mask.any(axis=k)) for k in (1, 0))
        levels = levels[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    if step > 1:
        high, wide = (min(step, side) for side in levels.shape)
        cut = levels[: shape[0] * high, : shape[1] * wide]
        levels = cut.reshape(shape[0], high, shape[1], wide).mean(axis=(1, 3))
    result: Floats = levels
    return result


def _cell_variance(levels: Floats, usable: Floats) -> float:
    """Return the variance of the means over cells of an eighth of the sides."""
    if min(levels.shape) < 2 * _CELLS:
        return 0.0
    starts = [np.arange(_CELLS) * side // _CELLS for side in levels.shape]
    sums = [
        np.add.reduceat(np.add.reduceat(values, starts[0], axis=0), starts[1], axis=1)
        for values in (levels, usable)
    ]
    size = levels.size / _CELLS**2
    filled = sums[1] > size / 4
    return float(((sums[0][filled] / sums[1][filled]) ** 2).mean()) if filled.any() else 0.0


def _growth(levels: Floats) -> float:
    """Return how many times larger features are in the last third of the rows than in the first.

    Features twice as large have the same spectrum an octave lower, so the spectra of the thirds are
    compared over the logarithm of the frequency. 1 where they do not agree on a shift.
    """
    third = len(levels) // 3
    if third < _SMALLEST_PART or levels.shape[1] < _SMALLEST_PART:
        return 1.0
    first, middle, last = _spectra([levels[k * third : (k + 1) * third] for k in range(3)])
    shift, alike, unshifted = _best_shift(first, last)
    steps = _best_shift(first, middle)[0], _best_shift(middle, last)[0]
    agree = min(step * shift for step in steps) > 0 and abs(sum(steps) - shift) <= _BINS / 4
    if not agree or alike < _LIKE or unshifted > _UNLIKE:
        return 1.0
    return round(float(2.0 ** (shift / _BINS)), 2)


def _spectra(parts: list[Floats]) -> list[Floats]:
    """Return log power at each log frequency, less a quadratic trend."""
    side = max(256, *parts[0].shape)
    waves = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side))
    count = int(_BINS * np.log2(_FINE / _COARSE))
    edges = _COARSE * 2.0 ** (np.arange(count + 1) / _BINS)
    band = np.digitize(waves, edges)
    places = np.bincount(band.ravel(), minlength=count + 2)[1 : count + 1]
    fade = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in parts[0].shape))
    along = np.arange(count)
    found = []
    for part in parts:
        power = np.abs(np.fft.rfft2((part - part.mean()) * fade, (side, side))) ** 2
        sums = np.bincount(band.ravel(), power.ravel(), count + 2)[1 : count + 1]
        mean = sums / np.maximum(places, 1) * edges[:-1] ** 2
        logs = np.log(mean + 1e-9 * (mean.max() or 1))
        found.append(logs - np.polyval(np.polyfit(along, logs, 2), along))
    return found


def _best_shift(one: Floats, other: Floats) -> tuple[int, float, float]:
    """Return the shift of `one` most like `other`, the correlation there, and without shift."""
    found = []
    for shift in range(-_REACH, _REACH + 1):
        a, b = one[max(0, shift) :], other[max(0, -shift) :]
        a, b = a[: len(b)] - a[: len(b)].mean(), b[: len(a)] - b[: len(a)].mean()
        scale = float(np.sqrt((a**2).sum() * (b**2).sum()))
        found.append(round(float((a * b).sum()) / scale, 2) if scale > 1e-9 else 0.0)
    best = int(np.argmax(found))
    return best - _REACH, found[best], found[_REACH]
