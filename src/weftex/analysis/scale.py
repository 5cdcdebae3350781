"""The scale of the structure in a sample: of its lattice, its spectrum or its things.

Section 3, "Window Size Estimation", of the paper on iterative refinement takes the power spectrum,
sums it over rings of equal distance r from zero frequency (r waves to a sample side of N pixels; a
ring is d = 0.1 thick), and calls the ring with the most power dominant: the scale is N / r. That is
right for stripes. A joint's overtones have more power than its period, strewn things have no period
at all, and slow lighting has the most power of all. So the scale is the first of these:

* The distance of those lines of its lattice that hold the most power, or of its rows.
* The strongest ring of at least 2.5 waves, if it stands out, or is surer than the things are.
* The size of the things: the distance of stones by their joints (`widths.between_joints`), or the
  geometric mean of two measures that fail on different materials: how far apart two places are
  alike to 1/e, and the width of squares whose openings or closings take off most (granulometry,
  after Matheron, 1975).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from weftex.analysis.relief import Relief, relief
from weftex.analysis.widths import between_joints, distance_at, feature_width
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Floats, Mask, median

if TYPE_CHECKING:
    from weftex.analysis.lattice import Lattice

THICKNESS = 0.1  # of a ring: the paper's d
_FEWEST = 2.5  # repetitions that a sample must show of a structure
_FINEST = 3.0  # pixels; finer structure is grain
_SIGMAS = 5.0  # how far a peak may stand out by chance
_PERIOD = 0.3  # confidence from which a period says more than the size of things
_SAME = 0.06  # to which a period is that of the lattice
_MORE = 1.01  # times the power, that finer lines must have
#: What each measure is to be multiplied by, so that it is the size that a person reads: medians
#: over 14 surfaces; docs/lab/scale-of-features.md has the errors on 12 others.
_LENGTHS, _WIDTHS = 6.07, 1.04
#: The distance at which the correlation is 1/2, over that at which it is 1/4: where it falls
#: straight, as for things of one size, and where the size is right in one sample of ten.
_ONE_SIZE, _MANY = 0.633, 0.27
_SUREST = 0.95


class StructureScale(NamedTuple):
    """The scale of the structure in a sample.

    The three arrays are empty for a constant sample and for one of less than 8 pixels a side.
    """

    scale: float  # in pixels of the sample, rounded to hundredths; 1 where there is no curve
    #: From 0 to 1: that of the lattice; the share of the ring's power that neither the spectrum
    #: around it nor chance explains; or how often the size of things is what a person reads.
    confidence: float
    source: str  # "lattice", "period" (of the strongest ring), "things", or "none"
    frequencies: Floats  # (n,) of the rings, in waves a pixel, rising
    power: Floats  # (n,) of the spectrum over each ring; the largest is 1
    background: Floats  # (n,): the median power from half to twice each frequency
    lattice: Lattice | None = None  # None too where the sample does not come back to itself

    @property
    def window_width(self) -> int:
        """Twice the scale, as the paper sets the window: one scale to each side of a pixel."""
        return 2 * max(1, round(self.scale)) + 1


#: Cached, as windows, seed points, patches and belts of one sample depend on its scale.
_ESTIMATED: WeakKeyDictionary[Exemplar, StructureScale] = WeakKeyDictionary()


def structure_scale(
    exemplar: Exemplar, lattice: Lattice | Literal["find"] | None = "find"
) -> StructureScale:
    """Estimate the scale of the dominant structure: pebbles' size, bricks' or threads' distance.

    The paper's own estimate is `weftex.reference.iterative_refinement.dominant_scale`.
    """
    if lattice != "find":
        return _estimated(exemplar, lattice)
    if exemplar not in _ESTIMATED:
        _ESTIMATED[exemplar] = _estimated(exemplar, lattice)
    return _ESTIMATED[exemplar]


def sure_lattice(exemplar: Exemplar) -> Lattice | None:
    """Return the lattice of a sample if it is sure enough to place blocks by it."""
    from weftex.analysis.canvas_lattice import is_sure  # only where methods ask

    lattice = structure_scale(exemplar).lattice
    return lattice if is_sure(lattice, int(np.count_nonzero(exemplar.usable))) else None


def _estimated(exemplar: Exemplar, lattice: Lattice | Literal["find"] | None) -> StructureScale:
    flat = relief(exemplar)
    height, width = flat.usable.shape
    side = max(height, width)  # the paper's N
    power, places, spectrum = _ring_power(flat)
    radii = np.arange(len(power)) * THICKNESS
    looked_at = (radii >= _FEWEST) & (radii <= side / _FINEST)
    top = float(power[looked_at].max(initial=0.0))
    if top <= 0:
        none = np.zeros(0)
        return StructureScale(float(flat.step), 0.0, "none", none, none, none)
    power = np.rint(power / top * 1e6) / 1e6
    background = _octave_medians(power)
    curve = radii[looked_at] / side / flat.step, power[looked_at], background[looked_at]
    correlation = np.fft.fftshift(np.fft.irfft2(spectrum, s=_padded(flat)))
    if lattice == "find":
        from weftex.analysis.lattice import find_lattice  # only where methods ask

        lattice = find_lattice(exemplar)
    radius, peaked = _strongest(power, background, places, looked_at)
    if lattice is not None:
        scale, confidence = _period(lattice, spectrum, flat), lattice.confidence
        if radius > 0 and abs(side / radius * flat.step - scale) < _SAME * scale:
            confidence = max(confidence, peaked)
        return StructureScale(round(scale, 2), confidence, "lattice", *curve, lattice)
    scale, confidence = size_of_things(flat, _fall(correlation))
    source = "things"
    if peaked > min(confidence, _PERIOD):
        scale, confidence, source = side / radius, peaked, "period"
    return StructureScale(round(scale * flat.step, 2), round(confidence, 2), source, *curve)


def _period(lattice: Lattice, spectrum: Floats, flat: Relief) -> float:
    """Return the distance of those lines of the lattice that have the most power."""
    vectors = np.array(lattice.vectors)
    if len(vectors) == 1:
        return float(np.hypot(*vectors[0]))
    rows, columns = _padded(flat)
    waves = np.linalg.inv(vectors / flat.step).T
    families = [waves[0], waves[1], waves[0] + waves[1], waves[0] - waves[1]]
    best, most = 0.0, -1.0
    for x, y in sorted(families, key=lambda wave: round(float(np.hypot(*wave)), 6)):
        times = np.arange(1, int(0.5 / max(abs(x), abs(y))) + 1)
        u, v = np.rint(times * x * columns).astype(int), np.rint(times * y * rows).astype(int)
        held = 0.0
        for dv, du in np.ndindex(3, 3):
            right = np.where(u + du - 1 < 0, -1, 1)  # the left half mirrors the right one
            at = right * (v + dv - 1) % rows, np.minimum(right * (u + du - 1), columns // 2)
            held += float(spectrum[at].sum())
        if held > most * _MORE:
            best, most = flat.step / float(np.hypot(x, y)), held
    return best


def _strongest(
    power: Floats, background: Floats, places: Floats, looked_at: Mask
) -> tuple[float, float]:
    """Return waves a side of the strongest ring, and its power beyond background and chance."""
    peak = looked_at & (power >= np.roll(power, 1)) & (power > np.roll(power, -1))
    if not peak.any():
        return 0.0, 0.0
    strongest = int(np.where(peak, power, -1).argmax())
    # Half of a ring mirrors the other half; fading leaves 4 of 9 places independent, and the
    # power of each spreads as much as its mean.
    chance = 1 + _SIGMAS / float(places[strongest] / 2 * 4 / 9) ** 0.5
    expected = chance * float(background[strongest] / power[strongest])
    return strongest * THICKNESS, round(max(0.0, 1 - expected), 2)


def _fall(correlation: Floats) -> Floats:
    """Return the mean correlation at each distance from no shift."""
    height, width = correlation.shape
    y, x = np.ogrid[-(height // 2) : height - height // 2, -(width // 2) : width - width // 2]
    distance = np.rint(np.hypot(y, x)).astype(np.int64).ravel()
    near = max(2, min(height, width) // 2)
    sums = np.bincount(distance, correlation.ravel())[:near]
    return np.asarray(sums / np.bincount(distance)[:near] / correlation.max())


def _padded(flat: Relief) -> tuple[int, int]:
    """Return the size with zeros added, so that rings are as dense along the shorter side."""
    height, width = flat.usable.shape
    side = max(height, width)
    return min(side, 2 * height), min(side, 2 * width)


def _ring_power(flat: Relief) -> tuple[Floats, Floats, Floats]:
    """Return P(r) for r = 0, 0.1, 0.2 ..., the number of places of each, and the spectrum."""
    height, width = flat.usable.shape
    side = max(height, width)  # the paper's N
    rows, columns = _padded(flat)
    fade = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 for n in (height, width)))
    kept = fade * flat.usable
    power = np.zeros((rows, columns // 2 + 1))
    for level in flat.levels:
        faded = level * fade
        faded -= kept * (faded.sum() / kept.sum())  # fading brought a mean back
        waves = np.fft.rfft2(faded, (rows, columns))
        power += waves.real**2 + waves.imag**2
    power[power < 1e-12 * power.sum()] = 0  # the transforms' own rounding
    v, u = abs(np.fft.fftfreq(rows))[:, None], np.fft.rfftfreq(columns)  # waves a pixel
    power[(v * height < 1.49) & (u * width < 1.49)] = 0  # what fading spreads of slow lighting
    # Each column stands for its mirror image too.
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
    places = places * (height * width / (rows * columns))
    return np.maximum(circle, 2) * THICKNESS * mean, places, power


def _octave_medians(power: Floats) -> Floats:
    """Return the median power from half to twice each radius, interpolated between tenths."""
    count = len(power)
    octaves = np.arange(0, np.log2(count) + 0.1, 0.1)
    # Not np.unique, which loads masked arrays.
    found = sorted(set(np.rint(2**octaves).astype(int).clip(max=count - 1).tolist()))
    medians = [median(power[k // 2 : 2 * k + 1]) for k in found]
    return np.interp(np.arange(count), found, medians)


def size_of_things(flat: Relief, fall: Floats) -> tuple[float, float]:
    """Return the size of the features in a sample in pixels of the relief, and its confidence."""
    apart = between_joints(flat)
    if apart:
        return apart, _SUREST
    length, width = distance_at(fall, float(np.exp(-1))), feature_width(flat)
    straight = distance_at(fall, 0.5) / max(distance_at(fall, 0.25), 1e-9)
    sure = (straight - _MANY) / (0.8 * _ONE_SIZE - _MANY)
    size = (max(_LENGTHS * length, 1.0) * max(_WIDTHS * width, 1.0)) ** 0.5
    return size, min(max(sure, 0.0), _SUREST)
