"""The scale of the structure in a sample, from its power spectrum.

Section 3, "Window Size Estimation", of the paper on iterative refinement. It takes the power
spectrum, sums it over rings of equal distance r from zero frequency (r waves to a sample side of
N pixels; a ring is d = 0.1 thick), and calls the ring with the most power dominant: the scale is
N / r. Three things are added, because photos have no clean peak where they are lit unevenly or
have no structure:

* Slow lighting is taken off and the borders are faded out; what repeats less than 2.5 times is not
  looked at, since nothing tells it from lighting.
* Faded borders spread each wave over its neighbors, so rings are averaged over a distance of 1.
* A peak counts only if it stands out of the spectrum around it by more than chance. Without one
  the scale is that of half the power: as much lies in coarser structure as in finer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import Relief, relief
from weftex.exemplar import Exemplar

if TYPE_CHECKING:
    from numpy.typing import NDArray

THICKNESS = 0.1  # of a ring: the paper's d
_FEWEST = 2.5  # repetitions that a sample must show of a structure
_FINEST = 3.0  # pixels; finer structure is grain
_SIGMAS = 5.0  # how far a peak may stand out by chance


@dataclass(frozen=True, eq=False)
class DominantScale:
    """The scale of the structure in a sample.

    Attributes
    ----------
    scale : float
        In pixels of the sample, rounded to hundredths; 1 where there is no curve.
    confidence : float
        From 0 to 1: the share of the peak's power that neither the spectrum around it nor chance
        explains, rounded to hundredths. At 0 there is no peak, and the scale is that of half the
        power.
    frequencies : float64 array (n,)
        Of the rings, in waves a pixel, rising.
    power : float64 array (n,)
        Sum of the power spectrum over each ring; the largest is 1.
    background : float64 array (n,)
        Median of `power` from half to twice each frequency.

    Notes
    -----
    The three arrays are empty for a constant sample and for one of less than 8 pixels a side.
    """

    scale: float
    confidence: float
    frequencies: NDArray[np.float64]
    power: NDArray[np.float64]
    background: NDArray[np.float64]

    @property
    def window_width(self) -> int:
        """Twice the scale, as the paper sets the window: one scale to each side of a pixel."""
        return 2 * max(1, round(self.scale)) + 1


def dominant_scale(exemplar: Exemplar) -> DominantScale:
    """Estimate the scale of the dominant structure: pebbles' size, bricks' or threads' distance.

    Parameters
    ----------
    exemplar : Exemplar
        The sample, of any size and aspect; its mask may leave out parts of it.

    Returns
    -------
    DominantScale
        The same on every machine: transforms round differently, but powers within a millionth of
        the highest are equal here, and of equal peaks the coarsest is taken.

    Examples
    --------
    >>> import numpy as np
    >>> from weftex.exemplar import Exemplar
    >>> x = np.arange(128)
    >>> stripes = np.tile(np.rint(127 + 100 * np.sin(x * 2 * np.pi / 16)), (96, 1))
    >>> found = dominant_scale(Exemplar(stripes.astype(np.uint8)))
    >>> abs(found.scale - 16) < 0.5 and found.confidence > 0.9
    True
    """
    flat = relief(exemplar)
    height, width = flat.usable.shape
    side = max(height, width)  # the paper's N
    power, places = _ring_power(flat)
    radii = np.arange(len(power)) * THICKNESS
    looked_at = (radii >= _FEWEST) & (radii <= side / _FINEST)
    top = float(power[looked_at].max(initial=0.0))
    if top <= 0:
        none = np.zeros(0)
        return DominantScale(float(flat.step), 0.0, none, none, none)
    power = np.rint(power / top * 1e6) / 1e6
    background = _octave_medians(power)
    peak = looked_at & (power >= np.roll(power, 1)) & (power > np.roll(power, -1))
    radius, confidence = 0.0, 0.0
    if peak.any():
        strongest = int(np.where(peak, power, -1).argmax())
        radius = float(radii[strongest])
        # Half of a ring mirrors the other half; fading leaves 4 of 9 places independent, and the
        # power of each spreads as much as its mean.
        chance = 1 + _SIGMAS / float(places[strongest] / 2 * 4 / 9) ** 0.5
        expected = chance * float(background[strongest] / power[strongest])
        confidence = round(max(0.0, 1 - expected), 2)
    radii, power, background = radii[looked_at], power[looked_at], background[looked_at]
    if confidence == 0:
        below = np.rint(np.cumsum(power) / power.sum() * 1e6)
        radius = float(radii[np.argmax(below >= 5e5)])
    scale = round(side / radius * flat.step, 2)
    return DominantScale(scale, confidence, radii / side / flat.step, power, background)


def _ring_power(flat: Relief) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """P(r) for r = 0, 0.1, 0.2 ... of all channels, and from how many places each comes."""
    height, width = flat.usable.shape
    side = max(height, width)  # the paper's N
    # Rings need places as dense along the shorter side; zeros beside the picture put them there.
    rows, columns = (min(side, 2 * n) for n in (height, width))
    fade = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in (height, width)))
    kept = fade * flat.usable
    power = np.zeros((rows, columns // 2 + 1))
    for level in flat.levels:
        faded = level * fade
        faded -= kept * (faded.sum() / kept.sum())  # fading brought a mean back
        power += np.abs(np.fft.rfft2(faded, (rows, columns))) ** 2
    power[power < 1e-12 * power.sum()] = 0  # the transforms' own rounding
    v, u = abs(np.fft.fftfreq(rows))[:, None], np.fft.rfftfreq(columns)  # waves a pixel
    # Each column stands for its mirror image too; what fading spreads of slow lighting goes.
    weight = np.where((u == 0) | (u == 0.5), 1.0, 2.0) * np.ones((rows, 1))
    weight[(v * height < 1.49) & (u * width < 1.49)] = 0
    # The nudge settles radii half-way between two rings alike everywhere.
    ring = np.floor(side * np.hypot(v, u) / THICKNESS + 0.5 + 1e-9).astype(np.int64)
    sums = np.bincount(ring.ravel(), (weight * power).ravel())
    places = np.bincount(ring.ravel(), weight.ravel())
    # The average over a distance of 1: a mean a place, times the places of a ring; a row has two.
    near = np.sin(np.pi * np.arange(1, 20) / 20) ** 2
    sums, places = (np.convolve(values, near)[9:-9] for values in (sums, places))
    circle = 2 * np.pi * THICKNESS * np.arange(len(sums)) * height * width / side**2
    mean = sums / np.maximum(places, 1e-9)
    return np.maximum(circle, 2) * THICKNESS * mean, places * (height * width / (rows * columns))


def _octave_medians(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Median power from half to twice each radius; ten times an octave, and in a line between."""
    count = len(power)
    octaves = np.arange(0, np.log2(count) + 0.1, 0.1)
    found = np.unique(np.rint(2**octaves).astype(int).clip(max=count - 1))
    medians = [np.median(power[k // 2 : 2 * k + 1]) for k in found]
    return np.interp(np.arange(count), found, medians)
