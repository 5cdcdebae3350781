"""Rows, such as boards or courses: by ridges of the autocorrelation, and by joints.

Along a row nothing repeats, so the mean autocorrelation along lines of one direction has ridges.
The rows have the direction and distance at which these are highest above what is between them.

A joint is thin, and often faint beside the tones that it separates, but long. So edges are added
up along lines in strips across the sample: rows are at the same places in each, stones are not.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from weftex.analysis import kernels
from weftex.analysis.correlation import correlate
from weftex.analysis.pairs import PHASES
from weftex.analysis.relief import Relief, means, mixed
from weftex.raster.arrays import Floats, Ints, Mask, fast_size, median

_STRIPS = 4
_STRONGEST = 3.0  # times the median edge; more counts as that
_CLOSEST = 5.0  # pixels from row to row, at least
_FINEST = 3.0  # of the pixels that all directions are tried on
_SIDES = (128, 256)  # pixels a side, about, of what all directions are tried on, and near ones
_COARSE = np.deg2rad(np.arange(0, 180, 3.0))
_FINE = [np.deg2rad([-step, 0, step]) for step in (1.2, 0.5, 0.25)]  # the last of near ones
_CROSSING = 0.42  # sine of the least angle between lines that cross
_STEP = 0.5  # pixels between distances that are tried
_NEARBY = np.deg2rad(np.arange(-2.5, 2.51, 0.5))  # directions of ridges near the best one
_SAMPLES = 61  # places along a line whose correlations are averaged
_COLORED = 0.05  # of the variance of all channels: the most that their mean has in colors alone
_NEAR = np.linspace(0.94, 1.06, 25)  # of a distance, that a finer look tries
_RIDGES = 8  # rows away that are rated, as far as the sample has them
_FARTHEST = 0.05  # what ridges count at least, as near ones count 1
_PHASES = np.array(PHASES)
_FEWEST = 2  # that it must have
_REACH = 0.75  # of what is across: the farthest that is rated
_NEARER = 0.7  # the same of ridges of known rows
_CHANCE = 0.1  # standard error of one ridge, about
_BLUR = 0.04  # of the distance, by which rows may be off
_PARTS = 7  # closer rows that are tried
_AS_HIGH = 0.8  # of the contrast, that closer rows must have
_HIGHER = 0.8  # of its height: the most that every second ridge lies above the others


#: Cached by `Joints.step`, as rows and the joints that cross them use the same edges.
_TAKEN: WeakKeyDictionary[Relief, dict[int, Joints]] = WeakKeyDictionary()
_TRIED: WeakKeyDictionary[Relief, list[Floats]] = WeakKeyDictionary()  # `Joints.alike` of `_COARSE`


class Courses(NamedTuple):
    """Rows and the evidence of joints for them, by the correlation of different strips."""

    vector: Floats  # (x, y) from one row to the next
    contrast: float  # of the correlation at multiples above that between them
    alike: float  # the correlation at no shift; 1 for a sample of lines only

    @property
    def sure(self) -> float:
        """The geometric mean of contrast and likeness, 0 where one of them is below 0."""
        return math.sqrt(max(self.contrast, 0.0) * max(self.alike, 0.0))


class Joints(NamedTuple):
    """The edges of a sample, which can be added up along lines of any direction."""

    parts: Floats  # (3, H, W): products of the slopes: along twice, along and down, down twice
    inner: Mask  # (H, W): where there are edges
    step: int = 1  # pixels of the relief to one here

    def averaged(self, step: int) -> Joints:
        """Return the edges averaged over squares."""
        return Joints(means(self.parts, step), means(self.inner, step) >= 0.5, step)

    def lines(self, angle: float) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return sums and counts of edges (strip, line) along lines a pixel apart."""
        c, s = np.cos(angle), np.sin(angle)
        height, width = self.inner.shape
        # Half of what is across and along: as far as one of the sides goes.
        across = min(height / max(abs(c), 1e-9), width / max(abs(s), 1e-9)) / 2
        along = min(height / max(abs(s), 1e-9), width / max(abs(c), 1e-9)) / 2
        number = int(2 * across)
        y, x = (np.arange(side) - (side - 1) / 2 for side in (height, width))
        down = np.stack([c * y + number / 2, s * y + along])
        across_them = np.stack([-s * x, c * x])
        direction = np.array([s * s, 2 * s * c, c * c, _STRIPS / (2 * along)])
        total, count = np.zeros((_STRIPS, number)), np.zeros((_STRIPS, number), np.int64)
        parts, inner = np.ascontiguousarray(self.parts), self.inner.view(np.uint8)
        kernels.edges_along(parts, inner, direction, down, across_them, total, count)
        return total, count

    def alike(self, angle: float) -> Floats:
        """Return the correlation of each strip with the others at distances of 0, 1, ... lines."""
        total, count = self.lines(angle)
        known = count > 0
        mean = total.sum(axis=1) / np.maximum(count.sum(axis=1), 1)
        values = np.where(known, total / np.maximum(count, 1) - mean[:, None], 0)
        number = values.shape[1]
        size = fast_size(2 * number)
        waves, masks = (np.fft.rfft(part, size, axis=1) for part in (values, known * 1.0))
        # The sum over all pairs of strips, less that of each with itself.
        own = (abs(waves) ** 2).sum(axis=0), (abs(masks) ** 2).sum(axis=0)
        others = abs(waves.sum(axis=0)) ** 2 - own[0], abs(masks.sum(axis=0)) ** 2 - own[1]
        products, overlap = (np.fft.irfft(part, size)[:number] for part in others)
        power = float((values**2).sum()) / max(float(known.sum()), 1)
        return products / np.maximum(overlap, 1) / max(power, 1e-12)


def edges_of(flat: Relief) -> Joints:
    """Return the edges of a relief."""
    inner = flat.usable >= 0.5
    if not inner.all():  # the border of a mask is no edge
        framed = np.pad(inner, 1, mode="edge")
        inner = inner & framed[:-2, 1:-1] & framed[2:, 1:-1]
        inner &= framed[1:-1, :-2] & framed[1:-1, 2:]
    down, along = (np.gradient(flat.levels, axis=axis) for axis in (1, 2))
    pairs = (along, along), (along, down), (down, down)
    parts = np.stack([(one * other).sum(axis=0) for one, other in pairs])
    square = parts[0] + parts[2]
    strength = np.sqrt(square)
    edges = strength[inner & (strength > 0)]
    most = _STRONGEST * median(edges) if len(edges) else 0.0
    parts *= inner * np.minimum(strength, most) / np.maximum(square, 1e-12)
    return Joints(parts, inner)


def joints_of(flat: Relief, side: int | None = None) -> Joints:
    """Return the edges of a relief, averaged to about `side` pixels a side."""
    known, shape = _TAKEN.setdefault(flat, {}), flat.usable.shape
    step = 1 if side is None else max(1, round(max(shape) / side))
    if step not in known:
        known[step] = edges_of(flat) if step == 1 else joints_of(flat).averaged(step)
    return known[step]


def find_courses(flat: Relief, across: Floats | None = None) -> Courses | None:
    """Return the rows with the best evidence of joints, right or not."""
    if min(flat.usable.shape) < _CLOSEST * (_FEWEST + 1):
        return None
    coarse, fine = (joints_of(flat, side) for side in _SIDES)
    if flat not in _TRIED:
        _TRIED[flat] = [coarse.alike(turn) for turn in _COARSE]
    best, angle, distance = 0.0, 0.0, 0.0
    for turn, profile in zip(_COARSE, _TRIED[flat], strict=True):
        if across is not None and abs(np.sin(turn - _angle(across))) <= _CROSSING:
            continue  # such lines do not cross the rows
        far = _REACH * len(profile) / _FEWEST
        distances = np.arange(max(_CLOSEST / coarse.step, _FINEST), far, _STEP)
        found, rated = _highest(profile, distances)
        if rated > best:
            best, angle, distance = rated, float(turn), found * coarse.step
    if best <= 0:
        return None
    for joints, offs in zip((coarse, coarse, fine), _FINE, strict=True):
        tried, away = [joints.alike(angle + off) for off in offs], distance / joints.step
        blurred = (_blurred(one, _BLUR * away) for one in tried)
        k = int(np.argmax([contrast(one, away * _NEAR)[0].max() for one in blurred]))
        angle, plain = angle + float(offs[k]), tried[k]
    distance /= fine.step
    distance = _settled(plain, distance, _CLOSEST / fine.step, 2 * _FEWEST)
    return _rated(fine, distance * fine.step * np.array([-np.sin(angle), np.cos(angle)]))


def _angle(vector: Floats) -> float:
    """Return the direction of rows by the vector from one to the next."""
    return float(np.arctan2(-vector[0], vector[1]))


def find_rows(flat: Relief) -> tuple[Floats, float] | None:
    """Find the vector from one row to the next, and the height of its ridges."""
    reach = min(flat.usable.shape)
    if reach < _CLOSEST * (_FEWEST + 1):
        return None
    correlation = correlate(_with_edges(flat.levels), flat.usable >= 0.5)
    distances = np.arange(_CLOSEST, _REACH * reach / _FEWEST, _STEP / 2)
    angle, best = 0.0, (0.0, 0.0)
    for angles in (_COARSE, _NEARBY):
        angles = angle + angles
        profiles = _profiles(correlation, angles, reach)
        found = [_highest(profile, distances) for profile in profiles]
        k = max(range(len(found)), key=lambda k: found[k][1])
        angle, best, profile = float(angles[k]), found[k], profiles[k]
    if best[1] <= 0:
        return None
    distance = _settled(profile, best[0], _CLOSEST, _FEWEST)
    return distance * np.array([-np.sin(angle), np.cos(angle)]), best[1]


def ridges(correlation: Floats, vector: Floats) -> tuple[float, int]:
    """Return the height of the ridges of rows without the highest, and their number.

    Rows of many heights have some ridges by chance, which are not at all multiples.
    """
    reach = int(_NEARER * min(side // 2 + 1 for side in correlation.shape))
    distance = float(np.hypot(*vector))
    profile = _profiles(correlation, np.array([_angle(vector)]), reach)[0]
    number = max(1, min(_RIDGES, int((reach - 1) / distance)))
    times, places = np.arange(1, number + 1), np.arange(reach)
    own, *others = (np.interp((times - phase) * distance, places, profile) for phase in PHASES)
    lower = np.sort(own - np.max(others, axis=0))[: max(1, number - 1)]
    return float(lower.mean()), number


def rated(flat: Relief, vector: Floats) -> Courses:
    """Return the evidence of joints for rows with a given vector."""
    return _rated(joints_of(flat, _SIDES[1]), vector)


def checked(flat: Relief, vectors: Floats) -> Courses | None:
    """Return the weaker evidence of stripes along the two vectors, as checked cloth has."""
    gray = mixed(flat.levels)
    # Levels in place of edges, of any direction, averaged as edges are for all directions.
    tones = Joints(np.stack([gray, 0 * gray, gray]), flat.usable >= 0.5)
    stripes = tones.averaged(max(1, round(max(gray.shape) / _SIDES[0])))
    turned = vectors[::-1, ::-1] * [-1, 1]  # at right angles to the other vector
    rows = turned * (np.linalg.det(vectors) / (turned**2).sum(axis=1))[:, None]
    if np.hypot(*rows.T).min() < _CLOSEST * stripes.step:
        return None
    return min((_rated(stripes, row) for row in rows), key=lambda one: one.contrast * one.alike)


def _rated(joints: Joints, vector: Floats) -> Courses:
    distance = float(np.hypot(*vector)) / joints.step
    plain = joints.alike(_angle(vector))
    own = contrast(_blurred(plain, _BLUR * distance), np.array([distance]))[0]
    return Courses(vector, float(own[0]), float(plain[0]))


def contrast(profile: Floats, distances: Floats) -> tuple[Floats, Ints]:
    """Return how far multiples of distances are above places between them, and their number."""
    found, count = np.empty(len(distances)), np.empty(len(distances), np.int64)
    kernels.stand_out(profile, distances, _PHASES, _REACH, _RIDGES, _FARTHEST, found, count)
    return found, count


def _highest(profile: Floats, distances: Floats) -> tuple[float, float]:
    """Return the distance with the highest peak of contrast beyond chance, and that contrast."""
    if len(distances) < 3:
        return 0.0, 0.0
    found, number = contrast(_blurred(profile, 0.7), distances)
    # Contrast that still grows at the farthest distance tried belongs to rows that are farther.
    peak = np.append(found[:-1] >= found[1:], False)
    peak[1:] &= found[1:] >= found[:-1]
    rated = np.where(peak, found - _CHANCE / np.sqrt(number), -1.0)
    best = int(rated.argmax())
    return float(distances[best]), float(rated[best])


def _settled(profile: Floats, distance: float, closest: float, fewest: int) -> float:
    """Return the distance, that of closer rows with ridges as high, or twice the distance."""
    near = distance * _NEAR
    heights = contrast(_blurred(profile, _BLUR * distance), near)[0]
    distance, own = float(near[heights.argmax()]), float(heights.max())
    for parts in range(_PARTS, 1, -1):
        closer = near / parts
        heights = contrast(_blurred(profile, _BLUR * distance / parts), closer)[0]
        if closer[heights.argmax()] >= closest and heights.max() >= _AS_HIGH * own:
            distance = float(closer[heights.argmax()])
            break
    times = np.arange(1, int(_REACH * len(profile) / distance) + 1)
    heights = np.interp(times * distance, np.arange(len(profile)), profile)
    if len(times) >= fewest:  # edges lie at both sides of what repeats
        odd, even = float(heights[::2].mean()), float(heights[1::2].mean())
        if even - odd > _HIGHER * even > 0:
            distance *= 2
    return distance


def _blurred(profile: Floats, by: float) -> Floats:
    """Return a profile blurred by a Gaussian, extended at the ends."""
    by = max(by, 0.7)
    side = int(3 * by) + 1
    window = np.exp(-0.5 * (np.arange(-side, side + 1) / by) ** 2)
    before, after = profile[side:0:-1], np.repeat(profile[-1:], side)
    framed = np.concatenate([before, profile, after])
    return np.convolve(framed, window / window.sum(), "valid")


def _with_edges(levels: Floats) -> Floats:
    """Return the mean level; steps down and to the right, of equal energy."""
    steps = [np.sqrt((np.gradient(levels, axis=axis) ** 2).sum(axis=0)) for axis in (1, 2)]
    edges = np.stack(steps)
    gray = levels.mean(axis=0, keepdims=True)
    if gray.var() < _COLORED * mixed(levels).var():  # colors of one brightness
        gray = mixed(levels)[None]
    share = levels.var(axis=(1, 2)).mean() / max(edges.var(axis=(1, 2)).sum(), 1e-12)
    return np.concatenate([gray, edges * share**0.5])


def _profiles(correlation: Floats, angles: Floats, reach: int) -> Floats:
    """Return the mean correlation along lines of each angle, at distances 0, 1, ... of it."""
    middle, center = (side // 2 for side in correlation.shape)
    cosines, sines = np.cos(angles), np.sin(angles)
    # As far along as shifts in this direction leave half of the sample to overlap.
    across, down = (np.maximum(abs(one), 1e-9) for one in (cosines, sines))
    far = np.minimum((center + 1) / across, (middle + 1) / down)
    result = np.empty((len(angles), reach))
    along = np.linspace(-0.5, 0.5, _SAMPLES)
    kernels.means_along(correlation, cosines, sines, far, along, result)
    return result
