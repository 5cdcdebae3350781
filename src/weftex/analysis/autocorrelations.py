"""The autocorrelations in which a sample's lattice is searched: as it is, and whitened.

Stones behind a wire mesh, and courses over the joints within them, have most of the power of a
sample, and their broad peaks hide the narrow peaks of a lattice. A lattice has its power in single
frequencies, far above those around them. So the whitened power spectrum is divided by its own
smoothed version: anything that does not repeat leaves noise of one strength, which measures chance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.correlation import correlate, correlation_and_power, power_of, wrapped_length
from weftex.analysis.goodness import ALPHA, SIGNIFICANT, Field
from weftex.analysis.peaks import find_peaks
from weftex.analysis.relief import Relief, relief
from weftex.raster.medians import median

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

    Floats = NDArray[np.float64]

_SIGMAS = 3.0  # standard errors of one multiple that count as chance
_NEAR = 6.0  # waves to the sample's side: the Gaussian that a spectrum is smoothed by
_FINEST = 0.25  # waves a pixel, from which on frequencies count less than 1/e
_LEAST = 0.02  # of the sample, that must overlap
_ENOUGH = 0.2  # the same, where chance is measured
_EMPTY = 1e-9  # of the highest power; less is rounding


@dataclass(frozen=True, eq=False)
class Autocorrelations:
    """A sample without slow lighting, its correlation, the whitened one, and chance in that."""

    flat: Relief
    field: Field
    white: Field
    chance: float


def autocorrelations(
    exemplar: Exemplar, alpha: float = ALPHA, significant: float = SIGNIFICANT
) -> Autocorrelations:
    """Return the autocorrelations of a sample; alpha and significant as for `find_lattice`."""
    flat = relief(exemplar)
    usable, power = flat.usable >= 0.5, None
    if usable.all():
        own, power = correlation_and_power(flat.levels)
    else:
        own = correlate(np.moveaxis(flat.levels, 0, 2), first_mask=usable)
    even, chance = whitened(flat, power)
    white = Field(even, find_peaks(even), alpha, significant, _SIGMAS * chance)
    return Autocorrelations(flat, Field(own, find_peaks(own), alpha, significant), white, chance)


def whitened(flat: Relief, power: Floats | None = None) -> tuple[Floats, float]:
    """Correlate a sample with itself, all frequencies being as strong as those around them."""
    height, width = flat.usable.shape
    size = wrapped_length(2 * height - 1), wrapped_length(2 * width - 1)
    if power is None:
        power = power_of(flat.levels, size)
    v, u = np.fft.fftfreq(size[0])[:, None], np.fft.rfftfreq(size[1])
    # A product of the correlation with a Gaussian is the spectrum smoothed by one.
    down, along = (
        np.exp(-2 * (np.pi * _NEAR * np.fft.fftfreq(n) * n / side) ** 2)
        for n, side in zip(size, (height, width), strict=True)
    )
    around = np.fft.irfft2(power, size)
    around *= down[:, None]
    around *= along
    smoothed = np.fft.rfft2(around).real
    power /= np.maximum(smoothed, max(_EMPTY * float(smoothed.max()), 1e-300))
    power *= np.exp(-((v / _FINEST) ** 2)) * np.exp(-((u / _FINEST) ** 2))
    if flat.usable.all() and flat.usable.max() == 1:
        overlap = np.outer(*(side - abs(np.arange(1.0 - side, side)) for side in (height, width)))
    else:
        usable = np.fft.rfft2(flat.usable, size)
        overlap = _unwrapped(np.fft.irfft2(abs(usable) ** 2, size), height, width)
    found = _unwrapped(np.fft.irfft2(power, size), height, width)
    shared = overlap / overlap[height - 1, width - 1]
    found *= (shared >= _LEAST) / np.maximum(shared, _LEAST)
    found /= max(float(found[height - 1, width - 1]), 1e-12)
    enough = shared >= _ENOUGH
    chance = median(abs(found[enough]) * np.sqrt(shared[enough])) / 0.6745
    return found, chance


def _unwrapped(values: Floats, height: int, width: int) -> Floats:
    """Shifts in rising order, from the wrapped ones of a transform."""
    rows, columns = np.arange(1 - height, height), np.arange(1 - width, width)
    found: Floats = values[rows[:, None], columns]
    return found
