"""Spectrum and autocorrelation: the power at each period and direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.quality.view import View, over_halves, some, window_corners

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_LARGEST_WINDOW = 64  # pixels of a window
_NARROWEST = 8
_WINDOWS = 96
_PER_OCTAVE = 2
_ANGLES = 4
_FLOOR = 0.5  # decibels
_LAGS = 64  # pixels
_SAME = 0.02  # of correlations, which differ so much by chance


def spectrum_distance(sample: View, result: View) -> tuple[float | None, float | None]:
    """Compare power spectra, by period and direction.

    *Definition.* The mean power spectrum of windows of 64 pixels a side (fewer in small samples),
    in half octaves and four directions; the root mean square difference in decibels, over the
    same between the sample's halves.

    *Unit.* Decibels, and 1 is as near as the sample's halves, or half a decibel if these are
    nearer. *Good.* Low. *Blind to* phase: edges and noise of one spectrum are the same to it, and
    so are copies.

    Returns
    -------
    (float or None, float or None)
        In decibels, and relative to the sample's halves. None for samples of less than 16 pixels,
        results of less than 8, and masks without whole windows.
    """
    width = _window(sample, result)
    if width is None:
        return None, None

    def apart(first: View, second: View) -> float | None:
        powers = [_bands(view, width) for view in (first, second)]
        if powers[0] is None or powers[1] is None:
            return None
        return float(np.sqrt(np.mean((powers[0] - powers[1]) ** 2)))

    made, own = apart(sample, result), over_halves(sample, apart)
    return made, None if own is None or made is None else made / max(own, _FLOOR)


def mean_power(view: View, width: int) -> Floats | None:
    """Mean power of windows, (width, width) as `numpy.fft.fft2` orders it, or None if none fits."""
    corners = window_corners(view.usable, width)
    if not len(corners):
        return None
    y, x = np.divmod(some(corners, _WINDOWS, "spectrum"), view.shape[1])
    windows = np.lib.stride_tricks.sliding_window_view(view.gray, (width, width))[y, x]
    bell = np.sin(np.pi * (np.arange(width) + 0.5) / width) ** 2
    bell = np.outer(bell, bell)
    around = windows - windows.mean(axis=(1, 2), keepdims=True, dtype=np.float64)
    around *= bell
    waves = np.fft.rfft2(around)
    power = waves.real**2
    power += waves.imag**2
    mean: Floats = power.mean(axis=0) / (bell**2).sum()
    return mean


def _window(sample: View, result: View) -> int | None:
    """The widest power of two that fits halves of the sample and the result."""
    side = min(min(sample.shape) // 2, *result.shape, _LARGEST_WINDOW)
    width = _LARGEST_WINDOW
    while width > side:
        width //= 2
    return width if width >= _NARROWEST else None


def _bands(view: View, width: int) -> Floats | None:
    """Decibels in each half octave and direction."""
    power = mean_power(view, width)
    if power is None:
        return None
    y, x = np.fft.fftfreq(width)[:, None], np.fft.rfftfreq(width)[None]
    frequency, angle = np.hypot(y, x), np.arctan2(y, x) % np.pi
    inside = (frequency * width >= 1.5) & (frequency <= 0.5)
    ring = np.floor(_PER_OCTAVE * np.log2(frequency[inside] * width)).astype(int)
    sector = np.floor(angle[inside] * _ANGLES / np.pi + 0.5).astype(int) % _ANGLES
    band = ring * _ANGLES + sector
    count = np.bincount(band)
    total = np.bincount(band, power[inside])
    # Rounding to bytes has a power of 1/12 at every period.
    result: Floats = 10 * np.log10(total[count > 0] / count[count > 0] + 1 / 12)
    return result


def autocorrelation_distance(sample: View, result: View) -> float | None:
    """Compare autocorrelations at short shifts.

    *Definition.* The root mean square difference of the normalized autocorrelations (slow lighting
    subtracted) at shifts of up to a quarter of the sample's side, 64 pixels at most; over the same
    between the sample's halves.

    *Unit.* 1 is as near as the sample's halves. *Good.* Low. *Blind to* content: blurred and sharp
    pictures of one period are near each other.
    """
    reach = min(_LAGS, min(sample.shape) // 4, min(result.shape) - 1)
    if reach < 2:
        return None

    def apart(first: View, second: View) -> float | None:
        parts = [_near(view, reach) for view in (first, second)]
        return float(np.sqrt(np.mean((parts[0] - parts[1]) ** 2)))

    own, made = over_halves(sample, apart), apart(sample, result)
    return None if own is None or made is None else made / max(own, _SAME)


def _near(view: View, reach: int) -> Floats:
    """The correlation at shifts of up to `reach` pixels; all but a mirror image."""
    y, x = (side // 2 for side in view.correlation.shape)
    return view.correlation[y : y + reach + 1, x - reach : x + reach + 1]
