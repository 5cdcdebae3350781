"""Rows: the period of a sample that repeats along one direction only, as boards or courses do.

Along a row nothing repeats, so the autocorrelation has ridges and no peaks. Its mean along lines
of one direction leaves the ridges. The rows have the direction and distance at which the ridges
are highest above the places half and a third of the way between them.
"""

from __future__ import annotations

import numpy as np

from weftex.analysis import kernels
from weftex.analysis.correlation import correlate
from weftex.analysis.pairs import PHASES
from weftex.analysis.relief import Relief, mixed
from weftex.raster.arrays import Floats

_CLOSEST = 5.0  # pixels from row to row, at least
_STEP = 0.25  # pixels between distances that are tried
_RIDGES = 8  # rows whose ridges are rated, as far as the sample has them
_FEWEST = 2  # ridges that a sample must have
_REACH = 0.7  # of the shorter side: the farthest ridge that is rated
_UNSURE = 0.1  # standard error of one ridge, about
_COLORED = 0.05  # of the variance of all channels: the most that their mean has in colors alone
_SAMPLES = 61  # places along a line whose correlations are averaged
_PARTS = 7  # closer rows that are tried
_AS_HIGH = 0.8  # of the contrast, that closer rows must have
_HIGHER = 0.8  # of its height: the most that every second ridge lies above the others


def find_rows(flat: Relief) -> tuple[Floats, float] | None:
    """Find the vector from one row to the next, and the height of its ridges."""
    height, width = flat.usable.shape
    reach = int(_REACH * min(height, width))
    if (reach - 1) / _FEWEST <= _CLOSEST:
        return None
    correlation = correlate(_with_edges(flat.levels), flat.usable >= 0.5)
    coarse = np.deg2rad(np.arange(0, 180, 3.0))
    angle, _, _ = _highest(correlation, coarse, reach)
    near = angle + np.deg2rad(np.arange(-2.5, 2.51, 0.5))
    angle, distance, contrast = _highest(correlation, near, reach)
    if contrast <= 0:
        return None
    profile = _profiles(correlation, np.array([angle]), reach)[0]
    distance = _divided(profile, distance)
    if _alternates(profile, distance):
        distance *= 2
    return distance * np.array([-np.sin(angle), np.cos(angle)]), contrast


def ridges(correlation: Floats, vector: Floats) -> tuple[float, int]:
    """The height of the ridges of rows in a correlation without the highest, and their number.

    Rows of many heights have some ridges by chance, which are not at all multiples.
    """
    reach = int(_REACH * min(side // 2 + 1 for side in correlation.shape))
    angle = np.arctan2(-vector[0], vector[1])
    stand = _stand(_profiles(correlation, np.array([angle]), reach)[0], float(np.hypot(*vector)))
    lower = np.sort(stand)[: max(1, len(stand) - 1)]
    return float(lower.mean()), len(stand)


def _divided(profile: Floats, distance: float) -> float:
    """The closest rows that include these at regular intervals, with ridges as high."""
    least = _AS_HIGH * float(_stand(profile, distance).mean())
    for parts in range(_PARTS, 1, -1):
        closer = distance / parts * np.linspace(0.97, 1.03, 25)
        heights = [float(_stand(profile, one).mean()) for one in closer]
        best = int(np.argmax(heights))
        if closer[best] >= _CLOSEST and heights[best] >= least:
            return float(closer[best])
    return distance


def _stand(profile: Floats, distance: float) -> Floats:
    """The height of each ridge above the highest at half and at a third of its distance."""
    places = np.arange(len(profile))
    times = np.arange(1, max(1, min(_RIDGES, int((len(profile) - 1) / distance))) + 1)
    ridges, *others = (np.interp((times - phase) * distance, places, profile) for phase in PHASES)
    found: Floats = ridges - np.max(others, axis=0)
    return found


def _alternates(profile: Floats, distance: float) -> bool:
    """Whether every second ridge is higher: each element of the rows has an edge at both sides."""
    times = np.arange(1, int((len(profile) - 1) / distance) + 1)
    heights = np.interp(times * distance, np.arange(len(profile)), profile)
    if len(heights) < 2:
        return False
    return bool(heights[1::2].mean() - heights[::2].mean() > _HIGHER * heights[1::2].mean())


def _with_edges(levels: Floats) -> Floats:
    """The mean level; steps down and to the right, of equal energy."""
    steps = [np.sqrt((np.gradient(levels, axis=axis) ** 2).sum(axis=0)) for axis in (1, 2)]
    edges = np.stack(steps)
    gray = levels.mean(axis=0, keepdims=True)
    if gray.var() < _COLORED * mixed(levels).var():  # colors of one brightness
        gray = mixed(levels)[None]
    share = levels.var(axis=(1, 2)).mean() / max(edges.var(axis=(1, 2)).sum(), 1e-12)
    found: Floats = np.concatenate([gray, edges * share**0.5])
    return found


def _highest(correlation: Floats, angles: Floats, reach: int) -> tuple[float, float, float]:
    """Angle, distance and contrast of the best rows of these directions."""
    profiles = _profiles(correlation, angles, reach)
    distances = np.arange(_CLOSEST, (reach - 1) / _FEWEST, _STEP)
    counts = np.minimum(_RIDGES, ((reach - 1) / distances).astype(int))

    def mean_at(phase: float) -> Floats:
        total = np.zeros((len(angles), len(distances)))
        for k in range(1, _RIDGES + 1):
            place = np.minimum((k - phase) * distances, reach - 1)
            before = np.minimum(place.astype(int), reach - 2)
            part = place - before
            total += (profiles[:, before] * (1 - part) + profiles[:, before + 1] * part) * (
                k <= counts
            )
        mean: Floats = total / counts
        return mean

    between = np.maximum(np.maximum(mean_at(1 / 2), mean_at(1 / 3)), mean_at(2 / 3))
    contrast = mean_at(0) - between - _UNSURE / np.sqrt(counts)
    # Contrast that still grows at the farthest distance tried belongs to rows that are farther.
    peaks = contrast.copy()
    peaks[:, -1] = -1.0
    peaks[:, :-1][contrast[:, :-1] < contrast[:, 1:]] = -1.0
    i, j = np.unravel_index(int(peaks.argmax()), peaks.shape)
    return float(angles[i]), float(distances[j]), float(contrast[i, j])


def _profiles(correlation: Floats, angles: Floats, reach: int) -> Floats:
    """Mean correlation along lines of each angle, at distances 0 to reach - 1 from no shift."""
    middle, center = (side // 2 for side in correlation.shape)
    cosines, sines = np.cos(angles), np.sin(angles)
    # As far along as shifts in this direction leave half of the sample to overlap.
    far = np.minimum(
        (center + 1) / np.maximum(abs(cosines), 1e-9), (middle + 1) / np.maximum(abs(sines), 1e-9)
    )
    result = np.empty((len(angles), reach))
    along = np.linspace(-0.5, 0.5, _SAMPLES)
    kernels.means_along(correlation, cosines, sines, far, along, result)
    return result
