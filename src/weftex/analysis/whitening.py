"""The correlation of a sample in which near frequencies have equal power.

Stones behind a wire mesh, and courses over the joints within them, have most of the power of a
sample, and their broad bumps hide the narrow peaks of what repeats. A lattice has its power in
single frequencies, far above those around them. So the power spectrum is divided by itself,
smoothed: what is left of anything that does not repeat is noise of one strength, and chance can be
told by it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.correlation import power_of, wrapped_length
from weftex.raster.medians import median

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.relief import Relief

    Floats = NDArray[np.float64]

_NEAR = 6.0  # waves to the sample's side: the Gaussian that a spectrum is smoothed by
_FINEST = 0.25  # waves a pixel, from which on frequencies count less than 1/e
_LEAST = 0.02  # of the sample, that must overlap
_ENOUGH = 0.2  # the same, where chance is measured
_EMPTY = 1e-9  # of the highest power; less is rounding


def whitened(flat: Relief, power: Floats | None = None) -> tuple[Floats, float]:
    """Correlate a sample with itself, all frequencies being as strong as those around them.

    Parameters
    ----------
    flat : Relief
        The sample without slow lighting.
    power : float64 array, optional
        What `correlation_and_power` says of its levels, if that is at hand. It is changed.

    Returns
    -------
    (float64 array (2 * H - 1, 2 * W - 1), float)
        The correlation, 1 in the middle, which is no shift; 0 where less than a fiftieth of the
        sample overlaps, and everywhere if it is constant. And its spread by chance, of a shift at
        which the whole sample overlaps: it grows as one over the root of the overlap.

    Examples
    --------
    >>> from weftex.analysis.relief import Relief
    >>> noise = np.random.default_rng(0).normal(size=(1, 90, 90))
    >>> correlation, chance = whitened(Relief(noise, np.ones((90, 90)), 1))
    >>> correlation.shape, chance < 0.05
    ((179, 179), True)
    """
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
