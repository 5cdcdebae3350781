"""Local maxima of an autocorrelation: the shifts at which a picture matches itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis import peak_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ONE_LINE = 1e-10  # of the square of its trace: what the determinant of multiples on a line has
_LARGEST_DOMINANCE = 64  # pixels; larger regions count as this


@dataclass(frozen=True, eq=False)
class Peaks:
    """Local maxima of the right half of an autocorrelation, the highest first (observation i).

    `dominance` is half the side of the largest square around a peak, 1, 2, 4 ... 64 pixels, in
    which it is the highest (after Liu, Collins, Tsin: A computational model for periodic pattern
    perception based on frieze and wallpaper groups).
    """

    shifts: NDArray[np.int64]  # (n, 2) as (x, y)
    heights: NDArray[np.float64]  # (n,)
    dominance: NDArray[np.int64]  # (n,)


def find_peaks(correlation: NDArray[np.float64]) -> Peaks:
    """Find the maxima among the eight neighbors, above 0."""
    middle, center = (side // 2 for side in correlation.shape)
    margin = min(_LARGEST_DOMINANCE, center)  # columns of the left half, for squares around peaks
    # Rounded, so that peaks that differ by rounding alone are equal on every machine.
    part = np.rint(correlation[:, center - margin :] * 1e9) / 1e9
    around, radius = _wider(part, 1, first=True), 1
    high = (part > 0) & (part >= around)
    high[:, :margin] = False
    high[: middle + 1, margin] = False  # no shift at all, and mirror images of shifts straight down
    y, x = high.nonzero()
    heights = part[y, x]
    dominance = np.ones(len(y), np.int64)
    while radius < _LARGEST_DOMINANCE:
        around, radius = _wider(around, radius), 2 * radius
        dominance[heights >= around[y, x]] = radius
    shifts = np.stack([x - margin, y - middle], axis=1)
    order = np.lexsort((shifts[:, 1], shifts[:, 0], (shifts**2).sum(axis=1), -heights))
    return Peaks(shifts[order], heights[order], dominance[order])


def _wider(values: NDArray[np.float64], by: int, first: bool = False) -> NDArray[np.float64]:
    """Maxima over squares that reach `by` pixels further than those that `values` has."""
    for axis in (0, 1):
        place = np.arange(values.shape[axis])
        before = values.take(np.maximum(place - by, 0), axis)
        after = values.take(np.minimum(place + by, len(place) - 1), axis)
        both = np.maximum(before, after)
        values = np.maximum(both, values) if first else both
    return values


def fit_vectors(
    correlation: NDArray[np.float64], vectors: NDArray[np.float64], reach: int
) -> tuple[NDArray[np.float64], int]:
    """Fit one or two vectors to the peaks at all multiples that agree with them, below a pixel.

    From the nearest multiples outwards, twice as far each time, a parabola through each peak and
    its neighbors says where it is; least squares over all multiples say what the vectors are.
    """
    height, width = (side // 2 + 1 for side in correlation.shape)
    window = max(1, min(3, int(np.hypot(*vectors.T).min() // 5)))
    agreed, limit, before = 0, 1, np.zeros((0, 0))
    # Far shifts compare a small part of the sample; half of each side is enough.
    far = 0.6 * np.array([width, height])
    while True:
        times = _all_times(min(limit, _most_times(vectors, far)), len(vectors))
        places = times @ vectors
        keep = (abs(places) <= far).all(axis=1)
        times, nearest = times[keep], np.rint(places[keep]).astype(int)
        looked_at = np.column_stack([times, nearest, np.full(len(times), window)])
        # None is near where a vector is longer than that; the same say the same vectors again.
        if len(times) and not np.array_equal(looked_at, before):
            before = looked_at
            found, heights = _tops(correlation, nearest, window)
            good = heights > 0
            if good.any():
                share = (1 - abs(found[:, 0]) / width) * (1 - abs(found[:, 1]) / height)
                # Normal equations: of few small whole numbers they are as good as any other way.
                weighed = (np.where(good, heights * share, 0)[:, None] * times).T
                gram, sums = weighed @ times, weighed @ found
                if np.linalg.det(gram) > _ONE_LINE * np.trace(gram) ** len(vectors):
                    vectors, agreed = np.linalg.solve(gram, sums), int(good.sum())
        if limit >= reach:
            return vectors, agreed
        limit, window = min(2 * limit, reach), max(1, min(window, 2))


def _most_times(vectors: NDArray[np.float64], far: NDArray[np.float64]) -> int:
    """No multiple of more than so many times a vector is less far off, in x and in y."""
    if len(vectors) == 1:
        return int((far / np.maximum(abs(vectors[0]), 1e-9)).min()) + 1
    (ax, ay), (bx, by) = abs(vectors).tolist()
    area = abs(float(vectors[0, 0] * vectors[1, 1] - vectors[0, 1] * vectors[1, 0]))
    most = max(far[0] * by + far[1] * bx, far[0] * ay + far[1] * ax)
    return int(min(most / max(area, 1e-9), 1e6)) + 1


@lru_cache(maxsize=64)
def _all_times(limit: int, number: int) -> NDArray[np.int64]:
    """Up to so many times each of one or two vectors, but for none of either."""
    ranges = [np.arange(-limit, limit + 1)] * number
    times = np.stack(np.meshgrid(*ranges), axis=-1).reshape(-1, number)
    times = times[times.any(axis=1)]
    times.flags.writeable = False
    return times


def _tops(
    correlation: NDArray[np.float64], places: NDArray[np.int64], window: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The peak within a window around each place, below a pixel; height 0 where there is none."""
    found, heights = np.empty((len(places), 2)), np.empty(len(places))
    kernels.tops(correlation, places, window, found, heights)
    return found, heights
