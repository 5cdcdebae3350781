"""The pair of peaks of an autocorrelation that are the vectors of the lattice, by their goodness.

Section 3.3 of the thesis, steps 2 to 6. Pairs are rated by their nearest multiples; the best are
fitted below a pixel and rated by all multiples whose overlap holds at least 85 % of a tile.

`height` is the correlation there (eq. 3.22). A ridge, such as the courses of a wall, is high
everywhere, so weftex's own `contrast` is what multiples have above places between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from weftex.analysis.autocorrelations import SHORTEST, Field, Peaks, fit_vectors
from weftex.raster.arrays import Floats, Ints, Mask

MOST_MULTIPLES = 24  # multiples of each vector that are rated

_PEAKS = 40  # that pairs are made of, of each octave of lengths the highest
_DOMINANT = 0.25  # of the shorter vector: the region that both peaks must dominate
_PAIRS = 24  # pairs that are fitted, and rated by all their multiples

ALPHA = 1.12  # of eq. 3.22, the thesis's; above 1 it prefers smaller tiles
SIGNIFICANT = 0.85  # share of a tile that an overlap must hold (section 3.3.1)
UNSURE = 0.25  # standard error of the contrast of one multiple, about

#: Multiples themselves, and half and a third of the way between them.
PHASES = (0.0, 1 / 2, 1 / 3, 2 / 3)
# Half and a third of the way between multiples, in both directions: every lattice of two or three
# times the tile has multiples of the right one at some of these, and so no contrast.
_BETWEEN = [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5)]
_BETWEEN += [(1 / 3, 0.0), (0.0, 1 / 3), (1 / 3, 1 / 3), (1 / 3, 2 / 3)]


def highest(tried: Sequence[tuple[Floats, float]]) -> Floats | None:
    """Return the pair with the highest goodness (step 6)."""
    best, most = None, 0.0
    for vectors, rated in tried:
        if rated > most * (1 + 1e-9):  # of pairs that differ by rounding alone, the first
            best, most = vectors, rated
    return best


def rated_pairs(field: Field, goodness: str) -> list[tuple[Floats, float]]:
    """Return the best pairs, fitted, and the goodness of each (steps 2 to 5)."""
    pairs = _candidates(field.peaks)
    if not len(pairs):
        return []
    first = rate(field, pairs, 2, goodness).goodness
    tried: list[tuple[Floats, float]] = []
    for k in np.argsort(-first, kind="stable")[:_PAIRS]:
        if first[k] <= 0:
            break
        found = fitted(field, pairs[k])
        if any(abs(found - other).max() < 0.5 for other, _ in tried):
            continue
        rated = rate(field, found[None], reach_of(field, found), goodness, exact=True)
        tried.append((found, float(rated.goodness[0])))
    return tried


def fitted(field: Field, vectors: Floats) -> Floats:
    """Return the vectors fitted below a pixel, or as they are where the fit collapses."""
    found = fit_vectors(field.correlation, vectors, MOST_MULTIPLES)[0]
    areas = [abs(np.linalg.det(pair)) for pair in (found, vectors)]
    return found if areas[0] > areas[1] / 2 else vectors


def reduced(vectors: Floats) -> Floats:
    """Return the shortest two vectors of the same lattice, the shorter first (observation iv).

    >>> reduced(np.array([[9.0, 1.0], [4.0, 0.0]])).tolist()
    [[1.0, 1.0], [2.0, -2.0]]
    """
    first, second = (np.array(v, np.float64) for v in vectors)
    while True:  # Gauss
        if second @ second < first @ first:
            first, second = second, first
        times = np.ceil(first @ second / (first @ first) - 0.5 - 1e-9)
        if times == 0:
            return np.stack([first, second])
        second = second - times * first


def _candidates(peaks: Peaks) -> Floats:
    """Return pairs of peaks that are reduced already (step 4 of the thesis), no two alike."""
    lengths = np.hypot(peaks.shifts[:, 0], peaks.shifts[:, 1])
    wide = (peaks.dominance >= 2) & (lengths >= SHORTEST)
    octave = np.log2(np.maximum(lengths, 1)).astype(int)
    # Multiples outnumber the vectors themselves, so each octave of lengths has its own highest.
    octaves = range(octave.max(initial=0) + 1)
    chosen = np.concatenate([np.flatnonzero(wide & (octave == k))[:_PEAKS] for k in octaves])
    chosen = chosen[np.argsort(lengths[chosen], kind="stable")]
    shifts, dominance = peaks.shifts[chosen], peaks.dominance[chosen]
    i, j = np.triu_indices(len(shifts), 1)
    shorter = lengths[chosen][i]
    # Of all equivalent pairs the one with the greatest angle; a pixel of doubt for rounding.
    angle = 2 * abs((shifts[i] * shifts[j]).sum(axis=1)) <= shorter**2 + 2 * shorter
    keep = angle & (np.minimum(dominance[i], dominance[j]) >= _DOMINANT * shorter)
    return np.stack([shifts[i[keep]], shifts[j[keep]]], axis=1).astype(np.float64)


@dataclass(frozen=True, eq=False)
class Rating:
    """The goodness of n pairs of vectors."""

    goodness: Floats  # (n,); 0 is no lattice
    value: Floats  # (n,): the mean correlation of eq. 3.24, or the contrast in its place
    count: Floats  # (n,) of significant multiples


def rate(field: Field, pairs: Floats, reach: int, kind: str, *, exact: bool = False) -> Rating:
    """Rate pairs of vectors (n, 2, 2) by multiples of up to `reach` times each vector.

    `exact` counts the wrapped positions of each overlap (section 3.3.1); otherwise its sides and
    area say whether it is significant.
    """
    area = abs(pairs[:, 0, 0] * pairs[:, 1, 1] - pairs[:, 0, 1] * pairs[:, 1, 0])
    times = multiples(reach, (0, 0))
    x, y, significant = places(field, pairs, times, exact)
    ones = np.array([[1.0, 0.0], [0.0, 1.0]])
    both = places(field, pairs, ones, exact)[2].all(axis=1)  # each vector itself is significant
    count = significant.sum(axis=1).astype(np.float64)
    heights = field.values(x, y, pairs)
    if kind == "height":
        value = _mean(heights, significant)
    else:
        weights = significant * field.shares(x, y)
        contrasts = heights - _between(field, pairs, reach)[:, None]
        if field.unsure is None:
            value = _mean(contrasts, weights)
        else:
            value = _above_chance(contrasts, weights, times, field.unsure)
    number = count if exact else 2 * field.width * field.height / np.maximum(area, 1)
    return Rating(np.where(both, goodness_of(value, number), 0), value, count)


def goodness_of(mean: Floats | float, number: Floats | float) -> Floats:
    """Return the goodness of means over a number of multiples (eq. 3.23)."""
    return np.maximum(mean, 0) ** ALPHA * np.maximum(number, 1) ** (ALPHA - 1)


def contrast_of(field: Field, pair: Floats) -> float:
    """Return the correlation at multiples above that between them, less its error."""
    found = rate(field, pair[None], reach_of(field, pair), "contrast")
    if field.unsure is not None:
        return float(found.value[0])
    return float(found.value[0] - UNSURE / max(found.count[0], 1) ** 0.5)


def tile_shares(vectors: Ints, wide: Floats, high: Floats) -> Floats:
    """Return the share of the tile that rectangles hold, by wrapped positions (eqs. 3.25-3.30).

    Positions that differ by multiples are one. Multiples of whole vectors come in rows q apart,
    where they are p apart and each row is moved by s; so rows of a rectangle are arcs of a circle
    of p positions, and what they cover together is counted.
    """
    (ux, uy), (vx, vy) = ((int(x), int(y)) for x, y in vectors)
    area = abs(ux * vy - vx * uy)
    (r, a, b), (t, c, d) = (uy, 1, 0), (vy, 0, 1)
    while t:
        times = r // t
        (r, a, b), (t, c, d) = (t, c, d), (r - times * t, a - times * c, b - times * d)
    apart = abs(r)
    around = area // apart
    moved = (a * ux + b * vx) * (1 if r > 0 else -1)
    shares = np.empty(len(wide))
    for k, (w, h) in enumerate(zip(wide, high, strict=True)):
        rows = -(-int(h) // apart)
        full = int(h) - (rows - 1) * apart  # this many have `rows` arcs, the others one less
        covered = full * _arcs(rows, moved, around, int(w))
        covered += (apart - full) * _arcs(rows - 1, moved, around, int(w))
        shares[k] = covered / area
    return shares


def _arcs(rows: int, moved: int, around: int, length: int) -> int:
    """Return how many positions of a circle arcs cover, each shifted from the one before."""
    if rows <= 0 or length <= 0:
        return 0
    starts = np.arange(rows) * moved % around
    starts.sort()
    last = int(starts[0]) + around - int(starts[-1])
    return int(np.minimum(starts[1:] - starts[:-1], length).sum()) + min(last, length)


def reach_of(field: Field, vectors: Floats) -> int:
    """Return how many times each vector, at most 24, leads to a shift within the picture."""
    far = abs(np.linalg.inv(vectors)).T @ [field.width, field.height]
    return max(1, min(MOST_MULTIPLES, int(np.ceil(far.max()))))


@lru_cache(maxsize=256)
def multiples(reach: int, phase: tuple[float, float]) -> Floats:
    """Return multiples of each vector: whole ones in the right half, or those off by a phase."""
    b, a = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
    times = np.stack([a, b], axis=1).astype(np.float64)
    chosen: Floats = times + phase if any(phase) else times[(b > 0) | ((b == 0) & (a > 0))]
    chosen.flags.writeable = False
    return chosen


@lru_cache(maxsize=64)
def _multiples_between(reach: int) -> Floats:
    """Return the multiples off by each phase of `_BETWEEN`, one after the other."""
    chosen = np.concatenate([multiples(reach, phase) for phase in _BETWEEN])
    chosen.flags.writeable = False
    return chosen


def places(
    field: Field, pairs: Floats, times: Floats, exact: bool = False
) -> tuple[Floats, Floats, Mask]:
    """Return where multiples lie, each (n, m), and whether their overlaps are significant."""
    x = times[:, 0] * pairs[:, 0, :1] + times[:, 1] * pairs[:, 1, :1]
    y = times[:, 0] * pairs[:, 0, 1:] + times[:, 1] * pairs[:, 1, 1:]
    wide, high = field.width - abs(x), field.height - abs(y)
    area = abs(pairs[:, 0, 0] * pairs[:, 1, 1] - pairs[:, 0, 1] * pairs[:, 1, 0])[:, None]
    box = abs(pairs).sum(axis=1)  # sides of the box around the tile
    significant = (wide >= 1) & (high >= 1) & (wide * high >= SIGNIFICANT * area)
    if not exact:
        significant &= (wide >= box[:, :1] / 2) & (high >= box[:, 1:] / 2) & (wide * high >= area)
        return x, y, significant
    unsure = significant & ~((wide >= box[:, :1]) & (high >= box[:, 1:]))
    for k in np.flatnonzero(unsure.any(axis=1)):
        at = unsure[k]
        whole = np.rint(pairs[k]).astype(np.int64)
        significant[k, at] = tile_shares(whole, wide[k, at], high[k, at]) >= SIGNIFICANT
    return x, y, significant


def _between(field: Field, pairs: Floats, reach: int) -> Floats:
    """Return the highest mean correlation half or a third of the way between multiples."""
    x, y, significant = places(field, pairs, _multiples_between(reach))
    weights = significant * field.shares(x, y)
    sums = weights * field.values(x, y, pairs)
    highest = np.full(len(pairs), -1.0)
    for part, weight in zip(*(np.split(a, len(_BETWEEN), 1) for a in (sums, weights)), strict=True):
        highest = np.maximum(highest, part.sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-9))
    return highest


def _above_chance(contrasts: Floats, weights: Floats, times: Floats, unsure: float) -> Floats:
    """Return the least mean contrast, less chance, with the highest multiple or a line left out.

    One multiple may be high by chance or by a copied part, and rows are high along one line.
    """
    parts = contrasts * weights
    total, weight = parts.sum(axis=1), weights.sum(axis=1)
    at = parts.argmax(axis=1)[:, None]
    out = [(np.take_along_axis(parts, at, 1)[:, 0], np.take_along_axis(weights, at, 1)[:, 0])]
    x, y = times.T
    lines = (y == 0, x == 0, x == y, x == -y)
    out += [(parts[:, line].sum(axis=1), weights[:, line].sum(axis=1)) for line in lines]
    least = _mean(contrasts, weights)
    for part, share in out:
        left = weight - share
        mean = (total - part) / np.maximum(left, 1e-9) - unsure / np.sqrt(np.maximum(left, 1e-9))
        least = np.where(left > 1e-9, np.minimum(least, mean), -1.0)
    return least


def _mean(values: Floats, weights: Floats | Mask) -> Floats:
    return np.asarray((values * weights).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-9))
