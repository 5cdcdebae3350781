"""Cells that alternate: tiles of a lattice that differ in turn, as over and under in a weave.

The correlation of a faint checkerboard is nearly as high from dark to light as from dark to dark,
so peaks do not tell. Means do: over many tiles what is of one tile alone cancels, and what every
second tile has in common stays. A difference that is there in one random half of the tiles is
there in the other; in place of drawing halves, the variance of single tiles says what the mean
over all ways to halve them is (analysis of variance).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.relief import Relief

    Floats = NDArray[np.float64]

_LEAST = 8  # tiles of each kind
_TURNS = 3  # times that each kind must come
_MOST = 12  # places along a side that a tile is looked at
_FAINT = 2.5e-4  # of the sample's variance: what sampling makes kinds differ by
_SLOPES = 100  # tiles whose mean says how it changes when moved
_ALIKE = 0.85  # correlation of the difference between halves, from which it is one


def alternating(flat: Relief, vectors: Floats) -> Floats | None:
    """Two or three times the tile whose kinds of tile differ most surely, as whole numbers.

    Parameters
    ----------
    flat : Relief
        The sample without slow lighting.
    vectors : float64 array (2, 2)
        Its lattice, as (x, y).

    Returns
    -------
    float64 array (2, 2) or None
        The larger tile is `whole @ vectors`; None where tiles are of one kind.
    """
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
    tiles: Floats,
    kinds: NDArray[np.int64],
    number: int,
    least: float = 0.0,
    lines: NDArray[np.int64] | None = None,
) -> float:
    """How the differences of the kinds' means correlate between random halves of the tiles.

    Parameters
    ----------
    tiles : float64 array (n, m)
        m values of each tile.
    kinds : int64 array (n,)
        From 0 to `number - 1`.
    number : int
        2 or more.
    least : float
        The least that chance makes the means differ by, as a sum of squares.
    lines : int64 array (n,), optional
        Which line of the lattice a tile is on; all of a line are of one kind. Threads and courses
        have tones of their own, so tiles of a line may be alike, and lines are what chance draws.

    Returns
    -------
    float
        The mean over all halves: S / (S + 2 N), where S is what the means differ by beyond
        chance, and N what chance makes them differ by. 0 where a kind has too few tiles.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> tiles, kinds = rng.normal(size=(40, 900)), np.arange(40) % 2
    >>> turns = tiles + 3 * kinds[:, None]
    >>> round(halves_agree(tiles, kinds, 2), 1), round(halves_agree(turns, kinds, 2), 1)
    (0.0, 1.0)
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


def _of_lines(
    tiles: Floats, kinds: NDArray[np.int64], means: Floats, lines: NDArray[np.int64]
) -> float:
    """The variance of single tiles, as the means of lines of one kind differ."""
    order = np.argsort(lines, kind="stable")
    _, starts, counts = np.unique(lines[order], return_index=True, return_counts=True)
    freedom = len(counts) - len(means)
    if freedom < 1:
        return 0.0
    off = np.add.reduceat(tiles[order], starts, axis=0) / counts[:, None]
    off -= means[kinds[order[starts]]]
    return float(((off**2).sum(axis=1) * counts).sum()) / freedom


def _turns(cells: NDArray[np.int64], index: int) -> list[tuple[Floats, NDArray[np.int64]]]:
    """Every sublattice of an index that is prime, and on which line each cell is.

    Which coset it is in is the line's number modulo the index.
    """
    turns = [(np.array([[1.0, 0.0], [0.0, index]]), cells[:, 1])]
    for slant in range(index):
        turns.append((np.array([[index, 0.0], [-slant, 1.0]]), cells[:, 0] + slant * cells[:, 1]))
    # Tiles of one row may all be alike, so each kind must come back.
    return [(whole, turn) for whole, turn in turns if np.ptp(turn) + 1 >= _TURNS * index]


def _tiles(flat: Relief, vectors: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Tiles that are wholly within the sample (n, m), times of both vectors (n, 2), slopes (4, m).

    Slopes are how the mean tile changes if it is moved a little or blurred, along x and y.
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

    def tiles(where: NDArray[np.int64]) -> Floats:
        found: Floats = (
            levels[:, where].swapaxes(0, 1).reshape(len(where), len(levels) * len(inner))
        )
        return found

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
    """The levels by the binomial filter of five pixels: edges are steps in no place alone."""
    framed = np.pad(levels, [(0, 0), (2, 2), (2, 2)], mode="edge")
    tall = framed[:, :-4] + framed[:, 4:] + 4 * (framed[:, 1:-3] + framed[:, 3:-1])
    tall += 6 * framed[:, 2:-2]
    soft: Floats = tall[..., :-4] + tall[..., 4:] + 4 * (tall[..., 1:-3] + tall[..., 3:-1])
    soft += 6 * tall[..., 2:-2]
    return soft / 256
