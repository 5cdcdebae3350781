"""The autocorrelations in which a sample's lattice is searched, and their peaks."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from weftex.analysis import kernels
from weftex.analysis.correlation import correlate, correlation_and_power, whitened
from weftex.analysis.relief import Relief, relief
from weftex.exemplar import Exemplar
from weftex.progress import counted
from weftex.raster.arrays import Floats, Ints

SHORTEST = 3.0  # pixels; a shorter vector is grain
_SIGMAS = 3.0  # standard errors of one multiple that count as chance
_CLOSE = 10.0  # pixels; shorter vectors are rated by single pixels
_ONE_LINE = 1e-10  # of the square of its trace: what the determinant of multiples on a line has
_LARGEST_DOMINANCE = 64  # pixels; larger regions count as this


class Autocorrelations(NamedTuple):
    """A sample without slow lighting, its correlation, the whitened one, and chance in that."""

    flat: Relief
    field: Field
    white: Field
    chance: float


def autocorrelations(exemplar: Exemplar) -> Autocorrelations:
    """Return the autocorrelations of a sample."""
    with counted(4, "analysis") as step:
        flat = relief(exemplar)
        usable, power = flat.usable >= 0.5, None
        if usable.all():
            own, power = correlation_and_power(flat.levels)
        else:
            own = correlate(flat.levels, usable)
        step(2)
        even, chance = whitened(flat, power)
        step(1)
        return Autocorrelations(flat, Field(own), Field(even, _SIGMAS * chance), chance)


class Field:
    """An autocorrelation and its peaks, to be read at multiples of vectors.

    `unsure` is the contrast of one multiple by chance, if all of the sample overlaps.
    """

    def __init__(self, correlation: Floats, unsure: float | None = None) -> None:
        self.correlation, self.peaks, self.unsure = correlation, find_peaks(correlation), unsure
        self.height, self.width = (side // 2 + 1 for side in correlation.shape)
        # Multiples lie between pixels, and material is not exact: of a place and its neighbors
        # the highest counts, also at the places between multiples.
        self.tables = np.stack([correlation, highest_around(correlation)])

    def values(self, x: Floats, y: Floats, pairs: Floats) -> Floats:
        """Return the correlation at shifts (n, m) of n pairs, or the highest around them."""
        # A neighbor of a place between close multiples would itself be a multiple.
        return self.tables[(shortest(pairs) >= _CLOSE).astype(np.int64), *self._at(x, y)]

    def around(self, x: Floats, y: Floats) -> Floats:
        """Return the highest correlation around each shift."""
        return np.asarray(self.tables[1][self._at(x, y)])

    def shares(self, x: Floats, y: Floats) -> Floats:
        """Return the share of the sample that overlaps at each shift."""
        return np.asarray((1 - abs(x) / self.width) * (1 - abs(y) / self.height))

    def _at(self, x: Floats, y: Floats) -> tuple[Ints, Ints]:
        found = []
        for at, side in ((y, self.height), (x, self.width)):
            place = np.rint(at).astype(np.int64)
            place += side - 1
            np.maximum(place, 0, out=place)  # np.clip takes as long again to look at its limits
            found.append(np.minimum(place, 2 * side - 2, out=place))
        return found[0], found[1]


class Peaks(NamedTuple):
    """Local maxima of the right half of an autocorrelation, the highest first (observation i).

    `dominance` is half the side of the largest square around a peak, 1, 2, 4 ... 64 pixels, in
    which it is the highest (after Liu, Collins, Tsin: A computational model for periodic pattern
    perception based on frieze and wallpaper groups).
    """

    shifts: Ints  # (n, 2) as (x, y)
    heights: Floats  # (n,)
    dominance: Ints  # (n,)


def find_peaks(correlation: Floats) -> Peaks:
    """Find the maxima among the eight neighbors, above 0."""
    middle, center = (side // 2 for side in correlation.shape)
    margin = min(_LARGEST_DOMINANCE, center)  # columns of the left half, for squares around peaks
    # Rounded, so that peaks that differ by rounding alone are equal on every machine.
    part = np.rint(correlation[:, center - margin :] * 1e9) / 1e9
    around, radius = highest_around(part), 1
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


def _wider(values: Floats, by: int) -> Floats:
    """Maxima over squares that reach `by` pixels further than the squares of `values`."""
    for axis in (0, 1):
        place = np.arange(values.shape[axis])
        before = values.take(np.maximum(place - by, 0), axis)
        after = values.take(np.minimum(place + by, len(place) - 1), axis)
        values = np.maximum(before, after)
    return values


def fit_vectors(correlation: Floats, vectors: Floats, reach: int) -> tuple[Floats, int]:
    """Fit one or two vectors to the peaks at all multiples that agree with them, below a pixel.

    From the nearest multiples outwards, twice as far each time, a parabola through each peak and
    its neighbors says where it is; least squares over all multiples say what the vectors are.
    """
    height, width = (side // 2 + 1 for side in correlation.shape)
    window = max(1, min(3, int(np.hypot(*vectors.T).min() // 5)))
    agreed, limit = 0, 1
    # Far shifts compare a small part of the sample; half of each side is enough.
    far = 0.6 * np.array([width, height])
    while True:
        times = all_times(min(limit, _most_times(vectors, far)), len(vectors))
        places = times @ vectors
        keep = (abs(places) <= far).all(axis=1)
        times, nearest = times[keep], np.rint(places[keep]).astype(int)
        if len(times):  # none is near where a vector is longer than that
            found, heights = np.empty((len(nearest), 2)), np.empty(len(nearest))
            kernels.tops(correlation, nearest, window, found, heights)  # 0 where there is no peak
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


def _most_times(vectors: Floats, far: Floats) -> int:
    """The number of times a vector from which on every multiple is beyond `far`."""
    if len(vectors) == 1:
        return int((far / np.maximum(abs(vectors[0]), 1e-9)).min()) + 1
    (ax, ay), (bx, by) = abs(vectors).tolist()
    area = abs(float(vectors[0, 0] * vectors[1, 1] - vectors[0, 1] * vectors[1, 0]))
    most = max(far[0] * by + far[1] * bx, far[0] * ay + far[1] * ax)
    return int(min(most / max(area, 1e-9), 1e6)) + 1


@lru_cache(maxsize=64)
def all_times(limit: int, number: int) -> Ints:
    """Return multiples of one or two vectors up to a number of times each; not the zero shift."""
    ranges = [np.arange(-limit, limit + 1)] * number
    times = np.stack(np.meshgrid(*ranges), axis=-1).reshape(-1, number)
    times = times[times.any(axis=1)]
    times.flags.writeable = False
    return times


def highest_around(table: Floats) -> Floats:
    """Return the maximum of each place and its eight neighbors."""
    framed = np.pad(table, 1, mode="edge")
    tall = np.maximum(np.maximum(framed[:-2], framed[1:-1]), framed[2:])
    return np.maximum(np.maximum(tall[:, :-2], tall[:, 1:-1]), tall[:, 2:])


def shortest(pairs: Floats) -> Floats:
    """Return the length of the shorter vector of each pair, (n, 1)."""
    return np.asarray(np.hypot(pairs[..., 0], pairs[..., 1]).min(axis=1)[:, None])
