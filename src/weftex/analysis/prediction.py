"""Whether a lattice maps edges onto edges, and lying pieces not onto standing ones.

Pieces have any color, so a shift may map the joints of a lying brick onto those of a standing one.
In the correlation of edges by direction a wrong lattice has high and low multiples, in every half
of the sample alike. The high ones are the larger tile, as of herringbone.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from weftex.analysis.autocorrelations import Autocorrelations
from weftex.analysis.correlation import correlate
from weftex.analysis.lines import edges_of, joints_of
from weftex.analysis.pairs import fitted, multiples, reduced
from weftex.analysis.relief import Relief, means
from weftex.raster.arrays import Floats, Ints, fast_size, median

_COARSE = 20.0  # pixels of the shorter vector, from which 2x2 pixels are averaged against grain
_CLOSE = 9.0  # pixels of the shorter vector, below which nothing is tested
_REACH = 0.7  # of a side: the farthest shift
_FAR = 24  # multiples of a vector that are compared
_SIDE = 12  # rows to each side whose multiples are averaged
_MOST = 6  # multiples of one vector that are tested
_PHASES = np.array([0, 1 / 4, 1 / 3, 2 / 5, 1 / 2, 3 / 5, 2 / 3, 3 / 4])  # and places between them
_FAINT = 0.15  # contrast of a vector beside the other one's, that is chance: rows of 0.03 to 0.10
_BELOW = -0.02  # contrast beside the highest place between, of a vector that is wrong
_SECOND = (0.1, 0.25)  # contrast of every second multiple; share of it that the others lack then
_UNEQUAL = 0.08  # spread of multiples beside their mean, from which halves are compared
_INDEX = 18  # tiles in a larger one, at most
_FEWEST = 5  # multiples that a larger tile must have
#: Share by which its multiples are higher in each half, share of all spread that they explain,
#: numbers of tiles: any. Uneven bricks had (0.13, 0.59, 4), two lattices (0.5, 0.35, 3).
_HIGHER = ((0.19, 0.3, range(8, _INDEX + 1)), (0.19, 0.42, range(8)), (0.15, 0.6, range(5)))
_ROUNDS = 3  # larger tiles of larger tiles, at most
_OFF = 0.75  # of the first share, that its multiples off any line must have


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
    larger = vectors is not given
    (one, above, twice), (other, over, double) = edges.contrasts(vectors)
    if twice or double:
        vectors = fitted(fields.field, reduced(np.diag([1 + twice, 1 + double]) @ vectors))
        (one, above, _), (other, over, _) = edges.contrasts(vectors)
    sure = min(one, other) > _FAINT * max(one, other) and min(above, over) > _BELOW
    # Of a larger tile multiples off any line are higher, so neither vector is chance.
    return vectors if sure or larger else None


def correlation_across(flat: Relief, rows: Floats) -> Floats:
    """Return the correlation of the edges across rows, less those along them."""
    (one, both, other), inner = joints_of(flat)[:2]
    x, y = rows / np.hypot(*rows)
    edges = ((y * y - x * x) * (one - other) - 4 * x * y * both) * inner
    return correlate(edges[None], inner)


class Edges:
    """The correlation of edges by direction; shifts are in steps of `step` pixels of the relief."""

    def __init__(self, flat: Relief, shortest: float) -> None:
        self.step = 2 if shortest >= _COARSE else 1
        coarse = Relief(means(flat.levels, 2), means(flat.usable, 2), 2 * flat.step)
        joints = joints_of(flat) if self.step == 1 else edges_of(coarse)
        inner = joints.inner
        self.sides = np.array(inner.shape)[::-1]
        self._size = fast_size(2 * inner.shape[0]), fast_size(2 * inner.shape[1])
        mean = joints.parts.sum(axis=(1, 2), keepdims=True) / max(int(inner.sum()), 1)
        self._parts = (joints.parts - mean) * inner
        self._waves = one, both, other = np.fft.rfft2(self._parts, self._size)
        mask = abs(np.fft.rfft2(inner.astype(np.float64), self._size)) ** 2
        self._overlap = np.maximum(np.fft.irfft2(mask, self._size), 1)
        # Without their strength, which speckles share in any direction.
        self.all = self._correlation(abs(one - other) ** 2 / 2 + 2 * abs(both) ** 2)

    def _correlation(self, power: Floats) -> Floats:
        return np.fft.irfft2(power, self._size) / self._overlap

    @cached_property
    def _halves(self) -> list[Floats]:
        """The correlations of edges in the left half, the right, the upper and the lower."""
        (one, both, other), (first, second, third) = self._waves, self._parts
        found: list[Floats] = []
        for half in (np.s_[:, : self.sides[0] // 2], np.s_[: self.sides[1] // 2]):
            parts = np.zeros((2, *first.shape))
            parts[0][half], parts[1][half] = (first - third)[half] / 2, 2 * second[half]
            power = np.fft.rfft2(parts, self._size) * np.stack([one - other, both]).conj()
            own = 2 * self._correlation(power.real.sum(axis=0))
            found += [own, 2 * self.all - own]
        return found

    def at(self, correlation: Floats, shifts: Floats, mean: bool = True) -> tuple[Floats, Floats]:
        """Return the mean or highest value around shifts (..., 2), and weights, 0 beyond reach."""
        parts = 1 - abs(shifts) / self.sides
        weights = parts.prod(axis=-1) * (parts >= 1 - _REACH).all(axis=-1)
        x, y = np.rint(np.where(weights[..., None] > 0, shifts, 0)).astype(int).T
        around = [correlation[y + i, x + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
        return (np.mean if mean else np.max)(around, axis=0).T, weights

    def contrasts(self, vectors: Floats) -> list[tuple[float, float, bool]]:
        """Return for each vector, in pixels, what `_contrast` says of edges across it."""
        return [self._contrast(pair / self.step) for pair in (vectors, vectors[::-1])]

    def _contrast(self, vectors: Floats) -> tuple[float, float, bool]:
        """Return the contrast of edges across the first vector at its multiples.

        Above the mean of places between them, the median of all multiples; above the highest; and
        whether only every second multiple has any.
        """
        (one, both, other), (vector, along) = self._waves, vectors
        x, y = np.array([along[1], -along[0]]) / np.hypot(*along)
        correlation = self._correlation(abs(x * x * one + 2 * x * y * both + y * y * other) ** 2)
        times = np.arange(1, _MOST + 1)[:, None] - _PHASES
        rows = np.arange(-_SIDE, _SIDE + 1)[:, None] * along
        values, weights = self.at(correlation, times[..., None, None] * vector + rows, mean=False)
        total = weights.sum(axis=2)
        seen = total[:, 0] > 0
        if not seen.any():
            return 0.0, 0.0, False
        values /= max(float(correlation[0, 0]), 1e-12)
        own, *between = ((values * weights).sum(axis=2) / np.maximum(total, 1e-9))[seen].T
        each, most = own - np.mean(between, axis=0), (own - np.max(between, axis=0)).mean()
        second = each[1::2].mean() if len(each) > 1 else 0.0
        skips = second > _SECOND[0] and each[::2].mean() < _SECOND[1] * second
        return median(each), float(most), bool(skips)

    def larger_tile(self, vectors: Floats) -> Floats | None:
        """Return `whole`, where `whole @ vectors` explain best how multiples differ, or None.

        Left and right, above and below: what differs by chance differs in one half.
        """
        times = multiples(_FAR, (0, 0))
        heights, weights = self.at(self.all, times @ vectors)
        seen = weights > 0
        times, heights, weights = times[seen], heights[seen], weights[seen] / weights.sum()
        tiles, (a, b) = _larger_tiles(), times.astype(int).T
        own = (a % tiles[0] == 0) & ((b - a // tiles[0] * tiles[1]) % tiles[2] == 0)
        enough = np.minimum(own.sum(axis=1), (~own).sum(axis=1)) >= _FEWEST
        if not enough.any() or heights.std() <= _UNEQUAL * (heights @ weights):
            return None
        own, halves = own[enough], np.stack([self.at(x, times @ vectors)[0] for x in self._halves])
        share = (own @ weights)[:, None]
        high = own @ (halves * weights).T / share
        gaps = np.maximum(high - (halves @ weights - high * share) / (1 - share), 0)
        both = (gaps[:, ::2] * gaps[:, 1::2]).min(axis=1) * (share * (1 - share))[:, 0]
        k = int(both.argmax())
        inside, (across, slant, down) = own[k], tiles[:, enough][:, k, 0].tolist()
        told = both[k] / max(float(np.cov(heights, aweights=weights, ddof=0)), 1e-12)
        gap, least = gaps[k].min() / high[k].mean(), high[k].mean() - (1 - _OFF) * gaps[k].mean()
        # Courses match themselves along one line, and by chance those of another one.
        off = [(inside & (line != 0), line) for line in (a, b, a - b, a + b)]
        sure = any(gap >= x and told >= y and across * down in z for x, y, z in _HIGHER) and all(
            len(set(line[x].tolist())) > 1 and np.average(heights[x], None, weights[x]) >= least
            for x, line in off
        )
        return np.array([[across, slant], [0, down]]) if sure else None


@lru_cache(maxsize=1)
def _larger_tiles() -> Ints:
    """Return the vectors (a, b), (0, c) of every sublattice up to the largest index, (3, n, 1)."""
    sides = range(1, _INDEX + 1)
    pairs = [(a, c) for c in sides for a in sides if 1 < a * c <= _INDEX]
    return np.array([(a, b, c) for a, c in pairs for b in range(c)]).T[..., None]
