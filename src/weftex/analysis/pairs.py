"""The pair of peaks of an autocorrelation that are the vectors of the lattice.

Section 3.3 of the paper on near-regular textures, steps 2 to 6. Pairs of up to some hundred peaks
are rated by their nearest multiples; the best are fitted below a pixel and rated by all multiples.
Then the smaller tiles that the best one could consist of are tried, because some larger tile is
better by chance; and two or three times the tile, because colors may alternate.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.goodness import Field, contrast_of, rate, reach_of, stand_out
from weftex.analysis.peaks import Peaks, fit_vectors

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_PEAKS = 40  # that pairs are made of, of each octave of lengths the highest
_SHORTEST = 3.0  # pixels; a shorter vector is grain
_DOMINANT = 0.25  # of the shorter vector: the region that both peaks must dominate
_PAIRS = 24  # pairs that are fitted, and rated by all their multiples
MOST_MULTIPLES = 24  # multiples of each vector that are rated
_INDEX = 7  # smaller tiles that a tile is divided into, at most
# A gap is the share by which a larger tile's multiples are above the smaller tile's others.
_LOWER = 0.1  # a gap below which the smaller tile is as good
_REFIT = 2.0  # times that, below which the smaller tile is fitted and tested again
_UNSURE = (0.35, 4.0)  # a gap below which it is too, if it is of fewer standard errors
_HIGHER = ((0.2, 5.0), (0.15, 20.0))  # gaps, and standard errors, above which the larger is better
_TURNED = (0.2, 10.0)  # the same, of tiles of more than three, of which there are many more
_MOST_TURNED = 18  # smaller tiles in one whose parts turn
_OFF = 0.15  # of a vector, that multiples of smaller tiles may be off a larger one
_OWN = 6  # multiples that the larger tile must have for that
_NEAR = 0.3  # pixels from a whole shift within which the smaller tile's multiples are compared


def best_pair(field: Field, goodness: str) -> tuple[Floats, Floats] | None:
    """Return the pair with the highest goodness, and the pair after division and multiples."""
    best, highest = None, 0.0
    tried = rated_pairs(field, goodness)
    for vectors, rated in tried:
        if rated > highest * (1 + 1e-9):  # of pairs that differ by rounding alone, the first
            best, highest = vectors, rated
    if best is None:
        return None
    if goodness != "contrast":
        return best, best
    settled = _multiply(field, _divide(field, best))
    # In the whitened sample threads are clear, and checks are made of them.
    if field.unsure is None:
        settled = _turned(field, settled, [vectors for vectors, _ in tried])
    return best, settled


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
    wide = (peaks.dominance >= 2) & (lengths >= _SHORTEST)
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


def _divide(field: Field, vectors: Floats) -> Floats:
    """Return the smallest tile that this one consists of and that is as good at its multiples."""
    own = contrast_of(field, vectors, reach_of(field, vectors, MOST_MULTIPLES))
    for index in range(_INDEX, 1, -1):
        for across in (n for n in range(1, index + 1) if index % n == 0):
            for slant in range(index // across):
                whole = np.array([[across, 0.0], [slant, index // across]])
                finer = np.linalg.inv(whole) @ vectors
                basis = reduced(finer)
                if np.hypot(*basis[0]) < _SHORTEST:
                    continue
                whole = np.rint(vectors @ np.linalg.inv(basis))
                reach = reach_of(field, basis, MOST_MULTIPLES)
                # Multiples that fall between pixels are lower, the more the closer they are.
                lower = _LOWER + 0.5 / float(np.hypot(*basis[0]))
                gap, errors, count = stand_out(field, basis, whole, reach)
                if count and lower <= gap < _REFIT * lower:
                    # A tile whose own vectors are a little off divides into some that are too.
                    basis = fitted(field, basis)
                    gap, errors, count = stand_out(field, basis, whole, reach)
                alike = gap < lower or (gap < _UNSURE[0] and errors < _UNSURE[1])
                if count and alike and contrast_of(field, basis, reach) > own / 2:
                    return fitted(field, basis)
    return vectors


def fitted(field: Field, vectors: Floats) -> Floats:
    """Return the vectors fitted below a pixel, or as they are where the fit collapses."""
    found = fit_vectors(field.correlation, vectors, MOST_MULTIPLES)[0]
    areas = [abs(np.linalg.det(pair)) for pair in (found, vectors)]
    return found if areas[0] > areas[1] / 2 else vectors


def _multiply(field: Field, vectors: Floats) -> Floats:
    """Return two or three times the tile where its multiples stand out: colors alternate."""
    reach = reach_of(field, vectors, MOST_MULTIPLES)
    for index in (2, 3):
        for across in (1, index):
            for slant in range(index // across):
                whole = np.array([[across, slant], [0.0, index // across]])
                gap, errors, count = stand_out(field, vectors, whole, reach, _NEAR)
                higher = any(gap > least and errors > sure for least, sure in _HIGHER)
                if not count:  # all of them lie between pixels, which explains half of a gap
                    gap, _, count = stand_out(field, vectors, whole, reach)
                    higher = gap > 0.5
                if higher and count >= _OWN:
                    larger = reduced(whole @ vectors)
                    return fitted(field, larger)
    return vectors


def made_of(larger: Floats, smaller: Floats) -> Floats | None:
    """Return the larger tile's vectors as multiples of the smaller one's, or None.

    >>> made_of(np.array([[6.1, 0.0], [3.0, 8.0]]), np.array([[3.0, 0.0], [0.0, 4.0]])).tolist()
    [[2.0, 0.0], [1.0, 2.0]]
    """
    times = larger @ np.linalg.inv(smaller)
    whole: Floats = np.rint(times)
    apart = abs(times - whole).max() < _OFF and abs(np.linalg.det(whole)) > 0.5
    return whole if apart else None


def _turned(field: Field, vectors: Floats, tried: Sequence[Floats]) -> Floats:
    """The larger tile of those tried whose own multiples stand out most, if they do.

    Blocks of bricks that turn, as in a basket weave, match their neighbors in part; so the bricks
    are found, and two blocks are four to eighteen of them.
    """
    reach, best, surest = reach_of(field, vectors, MOST_MULTIPLES), vectors, _TURNED[1]
    for larger in tried:
        whole = made_of(larger, vectors)
        if whole is None or not 3.5 < abs(np.linalg.det(whole)) < _MOST_TURNED + 0.5:
            continue
        gap, errors, count = stand_out(field, vectors, whole, reach)
        if gap > _TURNED[0] and errors > surest and count >= _OWN:
            best, surest = reduced(larger), errors
    return best
