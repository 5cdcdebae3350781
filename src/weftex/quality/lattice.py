"""Lattice kept: whether the result repeats at the vectors at which the sample does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice
    from weftex.quality.view import View

_CONFIDENCE = 0.5  # a lattice of less is not looked for in the result
_MULTIPLES = 3
_STEADY = 0.4  # of the sample's contrast, which its halves must have
_ROWS = 3  # rows that the sample must hold: fewer are no order
_FAINT = 0.08  # contrast of correlations, which the sample must have


def lattice_kept(sample: View, result: View, lattice: Lattice | None) -> float | None:
    """Say how much of the sample's lattice is left.

    *Definition.* At the multiples of the lattice's vectors, up to three and up to half the
    sample's size, the highest correlation with itself within two pixels, less that half-way
    between multiples; its sum in the result over its sum in the sample.

    *Unit.* Share: 1 is as strongly periodic as the sample, 0 is not periodic. *Good.* High;
    somewhat above 1 where a result is more regular than the sample. *Blind to* order over more
    than three repetitions, and to what repeats: a lattice of blurs is one.

    Parameters
    ----------
    sample, result : View
        From `views`.
    lattice : Lattice or None
        From `weftex.analysis.lattice.find_lattice`.

    Returns
    -------
    float or None
        None without a lattice of confidence 0.5, for rows of which the sample holds fewer than
        three, where the sample's halves hardly have it, and for results smaller than its vectors.
    """
    if lattice is None or lattice.confidence < _CONFIDENCE:
        return None
    if len(lattice.vectors) == 1:
        (x, y), (height, width) = lattice.vectors[0], sample.shape
        if abs(_ROWS * x) > width or abs(_ROWS * y) > height:
            return None
    halves = [half for pair in sample.halves for half in pair]
    own, made = (_contrast(view, lattice, sample.shape) for view in (sample, result))
    if own is None or made is None or own < _FAINT:
        return None
    parts = [_contrast(half, lattice, sample.shape) for half in halves]
    steady = [part for part in parts if part is not None]
    if not steady or np.mean(steady) < _STEADY * own:
        return None
    return max(0.0, made / own)


def _contrast(view: View, lattice: Lattice, sample: tuple[int, int]) -> float | None:
    """The correlation at multiples that lie in half the sample, less that between them."""
    limit = np.minimum(np.array(sample) // 2, 0.75 * np.array(view.shape))[::-1]
    multiples, between = (places[(abs(places) < limit).all(axis=1)] for places in _places(lattice))
    if not len(multiples) or not len(between):
        return None
    at = _at(view.correlation, multiples, 2).mean() - _at(view.correlation, between, 0).mean()
    return float(at)


def _places(lattice: Lattice) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Multiples of the vectors as (x, y), and what is half-way between them."""
    vectors = np.array(lattice.vectors)
    steps = np.arange(-_MULTIPLES, _MULTIPLES + 1)
    if len(vectors) == 1:
        return steps[steps > 0][:, None] * vectors, (steps[steps > 0] - 0.5)[:, None] * vectors
    i, j = (part.ravel() for part in np.meshgrid(steps, steps))
    later = (j > 0) | ((j == 0) & (i > 0))  # the rest mirrors it
    times = np.stack([i[later], j[later]], axis=1).astype(np.float64)
    halves = np.concatenate([times - (0.5, 0), times - (0, 0.5), times - (0.5, 0.5)])
    return times @ vectors, halves @ vectors


def _at(
    correlation: NDArray[np.float64], places: NDArray[np.float64], reach: int
) -> NDArray[np.float64]:
    """The highest correlation around each place."""
    side = np.arange(-reach, reach + 1)
    x, y = np.rint(places).astype(int).T
    rows = (y + correlation.shape[0] // 2)[:, None, None] + side[:, None]
    columns = (x + correlation.shape[1] // 2)[:, None, None] + side
    rows, columns = (
        index.clip(0, limit - 1)
        for index, limit in zip((rows, columns), correlation.shape, strict=True)
    )
    highest: NDArray[np.float64] = correlation[rows, columns].max(axis=(1, 2))
    return highest
