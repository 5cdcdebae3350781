"""Which multiple of a tile is the tile: smaller ones it consists of, larger ones that alternate.

Chance makes some larger tile better than the right one, so the smaller tiles that the best could
consist of are tried. Two or three times the tile is better where its multiples stand out.
Peaks do not show a faint checkerboard; means of every second tile do, in random halves of them.
"""

from __future__ import annotations

import numpy as np

from weftex.analysis.autocorrelations import SHORTEST, Field
from weftex.analysis.pairs import contrast_of, fitted, multiples, places, reach_of, reduced
from weftex.analysis.relief import Relief
from weftex.raster.arrays import Floats, Ints

_INDEX = 7  # smaller tiles that a tile is divided into, at most
# A gap is the share by which a larger tile's multiples are above the smaller tile's others.
_LOWER = 0.1  # a gap below which the smaller tile is as good
_REFIT = 2.0  # times that, below which the smaller tile is fitted and tested again
_UNSURE = (0.35, 4.0)  # a gap below which it is too, if it is of fewer standard errors
_HIGHER = ((0.2, 5.0), (0.15, 20.0))  # gaps, and standard errors, above which the larger is better
_OFF = 0.15  # of a vector, that multiples of smaller tiles may be off a larger one
_OWN = 6  # multiples that the larger tile must have for that
_NEAR = 0.3  # pixels from a whole shift within which the smaller tile's multiples are compared

_LEAST = 8  # tiles of each kind
_TURNS = 3  # times that each kind must come
_MOST = 12  # places along a side that a tile is looked at
_FAINT = 2.5e-4  # of the sample's variance: what sampling makes kinds differ by
_SLOPES = 100  # tiles whose mean says how it changes when moved
_ALIKE = 0.85  # correlation of the difference between halves, from which it is one


def settled(field: Field, vectors: Floats) -> Floats:
    """Return the tile of the sample by two vectors, after division and multiples."""
    return _multiply(field, _divide(field, vectors))


def _divide(field: Field, vectors: Floats) -> Floats:
    """Return the smallest tile that this one consists of and that is as good at its multiples."""
    own = contrast_of(field, vectors)
    for index in range(_INDEX, 1, -1):
        for across in (n for n in range(1, index + 1) if index % n == 0):
            for slant in range(index // across):
                whole = np.array([[across, 0.0], [slant, index // across]])
                basis = reduced(np.linalg.inv(whole) @ vectors)
                if np.hypot(*basis[0]) < SHORTEST:
                    continue
                whole = np.rint(vectors @ np.linalg.inv(basis))
                # Multiples that fall between pixels are lower, the more the closer they are.
                lower = _LOWER + 0.5 / float(np.hypot(*basis[0]))
                gap, errors, count = _stand_out(field, basis, whole)
                if count and lower <= gap < _REFIT * lower:
                    # A tile whose own vectors are a little off divides into some that are too.
                    basis = fitted(field, basis)
                    gap, errors, count = _stand_out(field, basis, whole)
                alike = gap < lower or (gap < _UNSURE[0] and errors < _UNSURE[1])
                if count and alike and contrast_of(field, basis) > own / 2:
                    return fitted(field, basis)
    return vectors


def _multiply(field: Field, vectors: Floats) -> Floats:
    """Return two or three times the tile where its multiples correlate more: colors alternate."""
    for index in (2, 3):
        for across in (1, index):
            for slant in range(index // across):
                whole = np.array([[across, slant], [0.0, index // across]])
                gap, errors, count = _stand_out(field, vectors, whole, _NEAR)
                higher = any(gap > least and errors > sure for least, sure in _HIGHER)
                if not count:  # all of them lie between pixels, which explains half of a gap
                    gap, _, count = _stand_out(field, vectors, whole)
                    higher = gap > 0.5
                if higher and count >= _OWN:
                    return fitted(field, reduced(whole @ vectors))
    return vectors


def made_of(larger: Floats, smaller: Floats) -> Floats | None:
    """Return the larger tile's vectors as multiples of the smaller one's, or None.

    >>> made_of(np.array([[6.1, 0.0], [3.0, 8.0]]), np.array([[3.0, 0.0], [0.0, 4.0]])).tolist()
    [[2.0, 0.0], [1.0, 2.0]]
    """
    times = larger @ np.linalg.inv(smaller)
    whole: Floats = np.rint(times)
    fits = abs(times - whole).max() < _OFF and abs(np.linalg.det(whole)) > 0.5
    return whole if fits else None


def _stand_out(
    field: Field, vectors: Floats, whole: Floats, near: float = 0.5
) -> tuple[float, float, int]:
    """Compare the multiples of a larger tile, `whole @ vectors`, with the smaller tile's others.

    Returns the gap as a share of the larger tile's mean, its size in standard errors, and how many
    multiples the larger tile has. Only others within `near` pixels of a whole shift are compared.
    """
    times = multiples(reach_of(field, vectors), (0, 0))
    x, y, significant = places(field, vectors[None], times)
    heights, far = field.values(x, y, vectors[None])[significant], np.hypot(x, y)[significant]
    parts = times[significant[0]] @ np.linalg.inv(whole)
    own = (abs(parts - np.rint(parts)) < 1e-6).all(axis=1)
    if own.all() or not own.any():
        return 0.0, 0.0, 0
    # Far correlations are lower in any sample, so each of the others is compared with the larger
    # tile's multiples that are at least as far.
    order = np.argsort(-far[own], kind="stable")
    further = np.cumsum(heights[own][order]) / np.arange(1, own.sum() + 1)
    number = np.searchsorted(-far[own][order], -far[~own], side="right")
    off = np.maximum(abs(x - np.rint(x)), abs(y - np.rint(y)))[significant][~own]
    gaps = (further[number - 1] - heights[~own])[(number > 0) & (off <= near)]
    if not len(gaps):
        return 0.0, 0.0, 0
    error = (gaps.var() / len(gaps) + heights[own].var() / own.sum() + 1e-9) ** 0.5
    gap = float(gaps.mean())
    return gap / max(float(heights[own].mean()), 1e-9), gap / error, int(own.sum())


def alternating(flat: Relief, vectors: Floats) -> Floats | None:
    """Return `whole`, where `whole @ vectors` is the larger tile of alternating ones, or None."""
    tiles, cells, moves = _tiles(flat, vectors)
    if len(cells) < 2 * _LEAST:
        return None
    # A period that is no whole number of pixels makes tiles differ in turn, as if moved by less
    # than a pixel or blurred: such differences are left out.
    basis = np.linalg.qr(moves.T)[0]
    tiles = tiles - (tiles @ basis) @ basis.T
    rounding = _FAINT * float((flat.levels**2).mean()) * tiles.shape[1]
    best, highest = None, _ALIKE
    for index in (2, 3):
        for whole, lines in _turns(cells, index):
            alike = halves_agree(tiles, lines % index, index, rounding, lines)
            if alike > highest:
                best, highest = whole, alike
    return best


def halves_agree(
    tiles: Floats, kinds: Ints, number: int, least: float = 0.0, lines: Ints | None = None
) -> float:
    """Return how the differences of the kinds' means correlate between halves of the tiles (n, m).

    S / (S + 2 N): S is the difference of the means beyond chance, N chance. `least` is the least
    chance; tiles of one of the `lines` are of one kind. 0 where a kind has too few tiles.
    """
    counts = np.bincount(kinds, minlength=number)
    if counts.min() < _LEAST:
        return 0.0
    order = np.argsort(kinds, kind="stable")
    starts = np.cumsum(counts) - counts
    sums = np.add.reduceat(tiles[order], starts, axis=0)
    means = sums / counts[:, None]
    within = float(np.einsum("ij,ij->", tiles, tiles) - (sums * means).sum())
    single = within / (len(tiles) - number)
    if lines is not None:
        single = max(single, _of_lines(tiles, kinds, means, lines))
    chance = single * float((1 / counts).mean()) * (number - 1)
    between = float(((means - means.mean(axis=0)) ** 2).sum())
    chance += least
    real = max(between - chance, 0.0)
    return real / max(real + 2 * chance, 1e-9)


def _of_lines(tiles: Floats, kinds: Ints, means: Floats, lines: Ints) -> float:
    """Return the variance of single tiles by the differences of lines of one kind."""
    order = np.argsort(lines, kind="stable")
    _, starts, counts = np.unique(lines[order], return_index=True, return_counts=True)
    freedom = len(counts) - len(means)
    if freedom < 1:
        return 0.0
    off = np.add.reduceat(tiles[order], starts, axis=0) / counts[:, None]
    off -= means[kinds[order[starts]]]
    return float(((off**2).sum(axis=1) * counts).sum()) / freedom


def _turns(cells: Ints, index: int) -> list[tuple[Floats, Ints]]:
    """Return every sublattice of a prime index, and the line of each cell.

    The line's number modulo the index is the coset of the cell.
    """
    turns = [(np.array([[1.0, 0.0], [0.0, index]]), cells[:, 1])]
    for slant in range(index):
        turns.append((np.array([[index, 0.0], [-slant, 1.0]]), cells[:, 0] + slant * cells[:, 1]))
    # Tiles of one row may all be alike, so each kind must come back.
    return [(whole, turn) for whole, turn in turns if np.ptp(turn) + 1 >= _TURNS * index]


def _tiles(flat: Relief, vectors: Floats) -> tuple[Floats, Ints, Floats]:
    """Return whole tiles (n, m), their multiples (n, 2), and slopes (4, m).

    Slopes are the changes of the mean tile when it is shifted or blurred along x and y.
    """
    height, width = flat.usable.shape
    lengths = np.hypot(*vectors.T)
    corners = np.array([[0, 0], [0, height - 1], [width - 1, 0], [width - 1, height - 1]])
    times = corners @ np.linalg.inv(vectors)
    low, high = np.floor(times.min(axis=0)).astype(int), np.ceil(times.max(axis=0)).astype(int)
    grid = np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True)), indexing="ij")
    cells = np.stack(grid, axis=-1).reshape(-1, 2)
    parts = [(np.arange(n) + 0.5) / n for n in np.clip(lengths, 2, _MOST).astype(int)]
    inner = np.stack(np.meshgrid(*parts, indexing="ij"), axis=-1).reshape(-1, 2) @ vectors
    # Rounded apart, so that rounding moves a tile as a whole.
    places = (np.rint(cells @ vectors)[:, None] + np.rint(inner)).astype(np.int64)
    x, y = places[..., 0], places[..., 1]
    # One pixel off the border, for the slopes.
    whole = ((x > 0) & (y > 0) & (x < width - 1) & (y < height - 1)).all(axis=1)
    x, y, cells = x[whole], y[whole], cells[whole]
    if not flat.usable.all():
        usable = (flat.usable[y, x] >= 0.5).all(axis=1)
        x, y, cells = x[usable], y[usable], cells[usable]
    at = y * width + x
    levels = _softened(flat.levels).reshape(len(flat.levels), -1)

    def tiles(where: Ints) -> Floats:
        return levels[:, where].swapaxes(0, 1).reshape(len(where), len(levels) * len(inner))

    own = tiles(at)
    some = at[:: -(-len(at) // _SLOPES) if len(at) else 1]
    slopes = np.zeros((4, own.shape[1]))
    if len(some):
        center = tiles(some).mean(axis=0)
        for k, step in enumerate((1, width)):
            before, after = tiles(some - step).mean(axis=0), tiles(some + step).mean(axis=0)
            slopes[k], slopes[2 + k] = after - before, after + before - 2 * center
        own -= own.mean(axis=0)
    return own, cells, slopes


def _softened(levels: Floats) -> Floats:
    """Return the levels blurred by the binomial filter of five pixels."""
    framed = np.pad(levels, [(0, 0), (2, 2), (2, 2)], mode="edge")
    tall = framed[:, :-4] + framed[:, 4:] + 4 * (framed[:, 1:-3] + framed[:, 3:-1])
    tall += 6 * framed[:, 2:-2]
    soft: Floats = tall[..., :-4] + tall[..., 4:] + 4 * (tall[..., 1:-3] + tall[..., 3:-1])
    soft += 6 * tall[..., 2:-2]
    return soft / 256
