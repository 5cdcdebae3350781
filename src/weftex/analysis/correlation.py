"""The autocorrelation of a sample: as it is (sections 3.1 and 3.2 of the thesis), and whitened.

The normalized correlation (GNCC) of what overlaps, for every shift at which anything overlaps. The
correlation itself is a product of spectra, the sums that normalize it come from running sums (with
masks, from spectra too).

Stones behind a wire mesh, and courses over the joints within them, have most of the power of a
sample, and their broad peaks hide the narrow peaks of a lattice. A lattice has its power in single
frequencies, far above those around them. So the whitened power spectrum is divided by its own
smoothed version: anything that does not repeat leaves noise of one strength, which measures chance.
"""

from __future__ import annotations

import numpy as np

from weftex.analysis import kernels
from weftex.analysis.relief import Relief
from weftex.raster.arrays import Floats, Ints, Mask, fast_size, median

#: An overlap that varies less than this beside the whole picture passes for constant: its own
#: correlation is lost in the rounding of the transform.
_FLAT = 1e-11
_NEAR = 6.0  # waves to the sample's side: the Gaussian that a spectrum is smoothed by
_FINEST = 0.25  # waves a pixel, from which on frequencies count less than 1/e
_LEAST = 0.02  # of the sample, that must overlap
_ENOUGH = 0.2  # the same, where chance is measured
_EMPTY = 1e-9  # of the highest power; less is rounding


def correlate(
    levels: Floats, usable: Mask | None = None, reach: tuple[int, int] | None = None
) -> Floats:
    """Return the correlation of (K, H, W) with itself at every shift, or at those within reach.

    Eq. 3.13: each channel counts as much as it varies in both overlaps, a constant one not at all.
    Shift 0 is in the middle of the result.
    """
    if usable is None or usable.all():
        return correlation_and_power(levels, reach)[0]
    mean = (levels * usable).sum(axis=(1, 2), keepdims=True) / max(1, int(usable.sum()))
    size, far = _padded(usable.shape, reach), _farthest(usable.shape, reach)
    mask = np.fft.rfft2(usable.astype(np.float64), size)

    def over_overlaps(values: Floats) -> Floats:
        return _unwrapped(np.fft.irfft2(np.fft.rfft2(values, size) * mask.conj(), size), far)

    count = np.rint(_unwrapped(np.fft.irfft2(mask * mask.conj(), size), far))
    above, below, spectrum = 0 * count, 0 * count, np.zeros(mask.shape, np.complex128)
    for level in (levels - mean) * usable:
        waves = np.fft.rfft2(level, size)
        spectrum += waves * waves.conj()
        sums, squares = over_overlaps(level), over_overlaps(level**2)
        spread = count * squares - sums * sums
        spread *= spread > _FLAT * float(squares.max()) * count
        # The other part of the overlap is what the opposite shift leaves.
        above -= sums * sums[::-1, ::-1]
        below += np.sqrt(spread * spread[::-1, ::-1])
    above += count * _unwrapped(np.fft.irfft2(spectrum, size), far)
    result = np.divide(above, below, out=np.zeros(below.shape), where=below > 0)
    return np.asarray(np.clip(result, -1, 1, out=result))


def correlation_and_power(
    levels: Floats, reach: tuple[int, int] | None = None
) -> tuple[Floats, Floats]:
    """Return `correlate(levels)` and the power spectrum of the levels around their mean."""
    around = levels - levels.mean(axis=(1, 2), keepdims=True)
    power = power_of(around, _padded(levels.shape[1:], reach))
    return _normalized(around, power, reach), power


def power_of(levels: Floats, size: tuple[int, int]) -> Floats:
    """Return the power spectrum of all channels, as `numpy.fft.rfft2` orders it."""
    power = np.zeros((size[0], size[1] // 2 + 1))
    for level in levels:
        waves = np.fft.rfft2(level, size)
        power += waves.real**2 + waves.imag**2
    return power


def whitened(flat: Relief, power: Floats | None = None) -> tuple[Floats, float]:
    """Return the correlation with all frequencies as strong as those around them, and chance."""
    height, width = flat.usable.shape
    size = _padded((height, width))
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
    far = height - 1, width - 1
    if flat.usable.all() and flat.usable.max() == 1:
        overlap = np.outer(*(side - abs(np.arange(1.0 - side, side)) for side in (height, width)))
    else:
        usable = np.fft.rfft2(flat.usable, size)
        overlap = _unwrapped(np.fft.irfft2(abs(usable) ** 2, size), far)
    found = _unwrapped(np.fft.irfft2(power, size), far)
    shared = overlap / overlap[far]
    found *= (shared >= _LEAST) / np.maximum(shared, _LEAST)
    found /= max(float(found[far]), 1e-12)
    enough = shared >= _ENOUGH
    return found, median(abs(found[enough]) * np.sqrt(shared[enough])) / 0.6745


def _normalized(levels: Floats, power: Floats, reach: tuple[int, int] | None) -> Floats:
    """Return the correlation of levels around 0, from their power spectrum."""
    _, height, width = levels.shape
    far = _farthest((height, width), reach)
    (rows, high), (columns, wide) = map(_overlaps, (height, width), far)
    shape = len(high), len(wide)
    above, below = np.zeros(shape), np.zeros(shape)
    sums, squares = np.empty(shape), np.empty(shape)
    down, along = np.empty((2, height + 1, width)), np.empty((2, width + 1))
    for level in np.ascontiguousarray(levels):
        most = kernels.overlap_sums(level, rows, columns, down, along, sums, squares)
        kernels.add_channel(sums, squares, high, wide, _FLAT * most, above, below)
    kernels.divide(above, below, high, wide, np.fft.irfft2(power, _padded((height, width), reach)))
    return above


def _farthest(shape: tuple[int, ...], reach: tuple[int, int] | None) -> tuple[int, int]:
    """Return the farthest shift, downwards and to the right."""
    down, along = shape[0] - 1, shape[1] - 1
    return (down, along) if reach is None else (min(down, reach[0]), min(along, reach[1]))


def _padded(shape: tuple[int, ...], reach: tuple[int, int] | None = None) -> tuple[int, int]:
    """Return the sides at which nothing wraps around into a shift within reach."""
    down, along = map(sum, zip(shape, _farthest(shape, reach), strict=True))
    return fast_size(down), fast_size(along)


def _overlaps(side: int, most: int) -> tuple[Ints, Floats]:
    """Return the first and last of what overlaps at shifts of at most so much, and its length."""
    shifts = np.arange(-most, most + 1)
    ends = np.stack([np.maximum(shifts, 0), side + np.minimum(shifts, 0)], axis=1)
    return ends, (side - abs(shifts)).astype(np.float64)


def _unwrapped(values: Floats, far: tuple[int, int]) -> Floats:
    """Return shifts in rising order, from the wrapped ones of a transform."""
    rows, columns = (np.arange(-most, most + 1) for most in far)
    return values[rows[:, None], columns]
