"""Autocorrelation at short shifts, and at the vectors of the sample's lattice."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.quality.view import View, over_halves

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.analysis.lattice import Lattice

    Floats = NDArray[np.float64]

_LAGS = 64  # pixels
_SAME = 0.02  # of correlations, which differ so much by chance
_CONFIDENCE = 0.5  # a lattice of less is not looked for in the result
_MULTIPLES = 3
_STEADY = 0.4  # of the sample's contrast, which its halves must have
_ROWS = 3  # rows that the sample must hold: fewer are no order
_FAINT = 0.08  # contrast of correlations, which the sample must have


def autocorrelation_distance(sample: View, result: View) -> float | None:
    """Return the distance of autocorrelations at short shifts; 1 is that of the sample's halves.

    The root mean square difference of the normalized autocorrelations (slow lighting subtracted)
    at shifts of up to a quarter of the sample's side, at most 64 pixels.
    """
    reach = min(_LAGS, min(sample.shape) // 4, min(result.shape) - 1)
    if reach < 2:
        return None

    def apart(first: View, second: View) -> float:
        parts = [_at_short_shifts(view, reach) for view in (first, second)]
        return float(np.sqrt(np.mean((parts[0] - parts[1]) ** 2)))

    own = over_halves(sample, apart)
    return None if own is None else apart(sample, result) / max(own, _SAME)


def _at_short_shifts(view: View, reach: int) -> Floats:
    """Return the correlation at shifts of up to `reach` pixels, without the mirror image."""
    y, x = (side // 2 for side in view.correlation.shape)
    return view.correlation[y : y + reach + 1, x - reach : x + reach + 1]


def lattice_kept(sample: View, result: View, lattice: Lattice | None) -> float | None:
    """Return how periodic the result is at the sample's lattice: 1 as the sample, 0 not at all.

    At multiples of the vectors, up to three and half the sample's size: the highest correlation
    within two pixels, less that half-way between multiples; in the result over in the sample.
    None without a sure and steady lattice, and for results smaller than its vectors.
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
    """Return the correlation at multiples within half the sample, less that between them."""
    limit = np.minimum(np.array(sample) // 2, 0.75 * np.array(view.shape))[::-1]
    multiples, between = (places[(abs(places) < limit).all(axis=1)] for places in _places(lattice))
    if not len(multiples) or not len(between):
        return None
    at = _highest(view.correlation, multiples, 2).mean()
    return float(at - _highest(view.correlation, between, 0).mean())


def _places(lattice: Lattice) -> tuple[Floats, Floats]:
    """Return multiples of the vectors as (x, y), and the places half-way between them."""
    vectors = np.array(lattice.vectors)
    steps = np.arange(-_MULTIPLES, _MULTIPLES + 1)
    if len(vectors) == 1:
        return steps[steps > 0][:, None] * vectors, (steps[steps > 0] - 0.5)[:, None] * vectors
    i, j = (part.ravel() for part in np.meshgrid(steps, steps))
    later = (j > 0) | ((j == 0) & (i > 0))  # the rest mirrors it
    times = np.stack([i[later], j[later]], axis=1).astype(np.float64)
    halves = np.concatenate([times - (0.5, 0), times - (0, 0.5), times - (0.5, 0.5)])
    return times @ vectors, halves @ vectors


def _highest(correlation: Floats, places: Floats, reach: int) -> Floats:
    """Return the highest correlation within `reach` of each place."""
    side = np.arange(-reach, reach + 1)
    x, y = np.rint(places).astype(int).T
    rows = (y + correlation.shape[0] // 2)[:, None, None] + side[:, None]
    columns = (x + correlation.shape[1] // 2)[:, None, None] + side
    rows, columns = (
        index.clip(0, limit - 1)
        for index, limit in zip((rows, columns), correlation.shape, strict=True)
    )
    highest: Floats = correlation[rows, columns].max(axis=(1, 2))
    return highest
