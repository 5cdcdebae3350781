"""Whether a lattice maps edges onto edges, and lying pieces not onto standing ones.

Pieces have any color, so a shift may map the joints of a lying brick onto those of a standing one.
In the correlation of edges by direction a wrong lattice has high and low multiples, and the high
ones are the larger tile, as of herringbone.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from weftex.analysis.autocorrelations import Autocorrelations
from weftex.analysis.lines import edges_of, joints_of
from weftex.analysis.pairs import fitted, multiples, reduced
from weftex.analysis.relief import Relief, means
from weftex.raster.arrays import Floats, fast_size, median

_COARSE = 20.0  # pixels of the shorter vector, from which 2x2 pixels are averaged against grain
_CLOSE = 9.0  # pixels of the shorter vector, below which nothing is tested
_REACH = 0.7  # of a side: the farthest shift
_FAR = 24  # multiples of a vector that are compared
_SIDE = 12  # rows to each side whose multiples are averaged
_MOST = 6  # multiples of one vector that are tested
_PHASES = np.array([0, 1 / 4, 1 / 3, 2 / 5, 1 / 2, 3 / 5, 2 / 3, 3 / 4])  # and places between them
_FAINT = 0.15  # contrast of a vector beside the other one's, that is chance: rows of 0.03 to 0.10
_BELOW = -0.02  # contrast beside the highest place between, of a vector that is wrong
_UNEQUAL = 0.12  # spread of multiples beside their mean, from which a larger tile is looked for
_INDEX = 18  # tiles in a larger one, at most
_FEWEST, _MANY = 6, 8  # multiples that a larger tile must have; from which they are not few
#: Share and standard errors by which a larger tile's multiples are higher, if many or few. Pairs
#: in herringbone have 0.27 and 30, others 0.41 and 6.6 or more; uneven bricks had 0.30 and 7.2.
_HIGHER = ((0.33, 6.35, True), (0.27, 9.0, True), (0.22, 20.0, True), (0.28, 6.7, False))
_OFF = 0.75  # of the mean of a larger tile's multiples off any line, that is above the others
_ROUNDS = 3  # larger tiles of larger tiles, at most


def predicting(fields: Autocorrelations, vectors: Floats) -> Floats | None:
    """Return the vectors, or those of a larger tile, if they map edges onto edges, else None.

    Places between multiples of very short vectors are too close to tell.
    """
    shortest = float(np.hypot(*vectors.T).min())
    if shortest < _CLOSE:
        return vectors
    edges, given = Edges(fields.flat, shortest), vectors
    for _ in range(_ROUNDS):
        whole = edges.larger_tile(vectors / edges.step)
        if whole is None:
            break
        vectors = fitted(fields.field, reduced(whole @ vectors))
    pairs = vectors / edges.step
    (one, above), (other, over) = (edges.contrast(pair) for pair in (pairs, pairs[::-1]))
    sure = min(one, other) > _FAINT * max(one, other) and min(above, over) > _BELOW
    # Of a larger tile multiples off any line are higher, so neither vector is chance.
    return vectors if sure or vectors is not given else None


class Edges:
    """The correlation of edges by direction; shifts are in steps of `step` pixels of the relief."""

    def __init__(self, flat: Relief, shortest: float) -> None:
        self.step = 2 if shortest >= _COARSE else 1
        if self.step == 1:
            joints = joints_of(flat)
        else:
            levels, usable = (means(flat.levels, self.step), means(flat.usable, self.step))
            joints = edges_of(Relief(levels, usable, flat.step * self.step))
        inner = joints.inner
        self.sides = np.array(inner.shape)[::-1]
        self._size = fast_size(2 * inner.shape[0]), fast_size(2 * inner.shape[1])
        mean = joints.parts.sum(axis=(1, 2), keepdims=True) / max(int(inner.sum()), 1)
        self._waves = [np.fft.rfft2(one * inner, self._size) for one in joints.parts - mean]
        mask = abs(np.fft.rfft2(inner.astype(np.float64), self._size)) ** 2
        self._overlap = np.maximum(np.fft.irfft2(mask, self._size), 1)

    def correlation(self, normal: Floats | None = None) -> Floats:
        """Return the correlation of all edges, or of those across a direction, wrapped."""
        one, both, other = self._waves
        if normal is None:
            # Without their strength, which speckles share in any direction.
            power = abs(one - other) ** 2 / 2 + 2 * abs(both) ** 2
        else:
            x, y = normal
            power = abs(x * x * one + 2 * x * y * both + y * y * other) ** 2
        found: Floats = np.fft.irfft2(power, self._size) / self._overlap
        return found / max(float(found[0, 0]), 1e-12)

    def at(self, correlation: Floats, shifts: Floats) -> tuple[Floats, Floats]:
        """Return the highest value around each shift (..., 2), and its weight, 0 beyond reach."""
        parts = 1 - abs(shifts) / self.sides
        weights = parts.prod(axis=-1) * (parts >= 1 - _REACH).all(axis=-1)
        x, y = np.rint(np.where(weights[..., None] > 0, shifts, 0)).astype(int).T
        around = [correlation[y + i, x + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
        return np.max(around, axis=0).T, weights

    def contrast(self, vectors: Floats) -> tuple[float, float]:
        """Return the contrast of edges across the first vector at its multiples.

        Above the mean of places between them, the median of all multiples; and above the highest.
        """
        vector, along = vectors
        correlation = self.correlation(np.array([along[1], -along[0]]) / np.hypot(*along))
        times = np.arange(1, _MOST + 1)[:, None] - _PHASES
        rows = np.arange(-_SIDE, _SIDE + 1)[:, None] * along
        values, weights = self.at(correlation, times[..., None, None] * vector + rows)
        total = weights.sum(axis=2)
        seen = total[:, 0] > 0
        if not seen.any():
            return 0.0, 0.0
        own, *between = ((values * weights).sum(axis=2) / np.maximum(total, 1e-9))[seen].T
        return median(own - np.mean(between, axis=0)), float((own - np.max(between, axis=0)).mean())

    def larger_tile(self, vectors: Floats) -> Floats | None:
        """Return `whole`, where edges correlate most at multiples of `whole @ vectors`, or None."""
        times = multiples(_FAR, (0, 0))
        heights, weights = self.at(self.correlation(), times @ vectors)
        seen = weights > 0
        times, heights, weights = times[seen].astype(int), heights[seen], weights[seen]
        spread = heights.std() if len(times) >= 2 * _MANY else 0.0
        if spread <= _UNEQUAL * np.average(heights, None, weights):
            return None
        a, b = times.T
        best, most = None, 0.0
        for across, slant, down in _larger_tiles():
            own = (a % across == 0) & ((b - a // across * slant) % down == 0)
            if min(own.sum(), (~own).sum()) < _FEWEST:
                continue
            (high, error), (low, other) = (_mean(heights[x], weights[x]) for x in (own, ~own))
            gap, sure = (1 - low / max(high, 1e-9), (high - low) / (error + other + 1e-9) ** 0.5)
            explained = (high - low) ** 2 * weights[own].sum() * weights[~own].sum()
            limits = [one[:2] for one in _HIGHER if one[2] == (own.sum() >= _MANY)]
            if explained <= most or not any(gap > least and sure > n for least, n in limits):
                continue
            # Courses match themselves along one line, and by chance those of another one.
            off = [(own & (line != 0), line) for line in (a, b, a - b, a + b)]
            if all(
                len(set(line[x].tolist())) > 1 and _mean(heights[x], weights[x])[0] * _OFF > low
                for x, line in off
            ):
                best, most = np.array([[across, slant], [0.0, down]]), explained
        return best


@lru_cache(maxsize=1)
def _larger_tiles() -> list[tuple[int, int, int]]:
    """Return every sublattice of an index up to the largest: (a, b), (0, c)."""
    sides = range(1, _INDEX + 1)
    pairs = [(a, c) for c in sides for a in sides if 1 < a * c <= _INDEX]
    return [(across, slant, down) for across, down in pairs for slant in range(down)]


def _mean(values: Floats, weights: Floats) -> tuple[float, float]:
    """Return the weighted mean and the square of its standard error."""
    mean = float(np.average(values, None, weights))
    return mean, float(np.average((values - mean) ** 2, None, weights)) / len(values)
