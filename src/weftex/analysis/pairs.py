"""The pair of peaks of an autocorrelation that are the vectors of the lattice.

Section 3.3 of the thesis, steps 2 to 6: pairs of up to some hundred peaks are rated by their
nearest multiples; the best are fitted below a pixel and rated by all multiples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.autocorrelations import Field, Peaks, fit_vectors
from weftex.analysis.goodness import rate, reach_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SHORTEST = 3.0  # pixels; a shorter vector is grain
MOST_MULTIPLES = 24  # multiples of each vector that are rated

_PEAKS = 40  # that pairs are made of, of each octave of lengths the highest
_DOMINANT = 0.25  # of the shorter vector: the region that both peaks must dominate
_PAIRS = 24  # pairs that are fitted, and rated by all their multiples


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
        reach = reach_of(field, found, MOST_MULTIPLES)
        rated = rate(field, found[None], reach, goodness, exact=True)
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
    """Return reduced pairs of peaks (step 4 of the paper), neither close to a higher one."""
    lengths = np.hypot(peaks.shifts[:, 0], peaks.shifts[:, 1])
    wide = (peaks.dominance >= 2) & (lengths >= SHORTEST)
    octave = np.log2(np.maximum(lengths, 1)).astype(int)
    # Multiples outnumber the vectors themselves, so each octave of lengths has its own highest.
    chosen = np.concatenate(
        [np.flatnonzero(wide & (octave == k))[:_PEAKS] for k in range(octave.max(initial=0) + 1)]
    )
    chosen = chosen[np.argsort(lengths[chosen], kind="stable")]
    shifts, dominance = peaks.shifts[chosen], peaks.dominance[chosen]
    i, j = np.triu_indices(len(shifts), 1)
    shorter = lengths[chosen][i]
    # Of all equivalent pairs the one with the greatest angle; a pixel of doubt for rounding.
    angle = 2 * abs((shifts[i] * shifts[j]).sum(axis=1)) <= shorter**2 + 2 * shorter
    keep = angle & (np.minimum(dominance[i], dominance[j]) >= _DOMINANT * shorter)
    return np.stack([shifts[i[keep]], shifts[j[keep]]], axis=1).astype(np.float64)
