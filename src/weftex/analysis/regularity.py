"""Regularity: how well a sample matches itself when it is shifted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.relief import relief
from weftex.exemplar import Exemplar

if TYPE_CHECKING:
    from numpy.typing import NDArray


def regularity(exemplar: Exemplar) -> float:
    """Return how well a sample repeats at some shift of up to half its sides, from 0 to 1.

    The correlation at a shift, less the lowest on the straight way to it where that is above 0, so
    long lines and slow changes do not count. Irregular samples have 0.1 to 0.3, bricks 0.6 to 0.9.
    """
    return round(min(highest_return(autocorrelation(exemplar)), 1.0), 2)


def highest_return(correlation: NDArray[np.float64]) -> float:
    """Return the highest correlation at any shift above the lowest on the straight way to it."""
    middle, center = correlation.shape[0] // 2, correlation.shape[1] // 2
    half = correlation[middle:]  # the other one is its mirror image
    around = np.pad(correlation, 1, constant_values=-np.inf)[middle:]
    peak = np.ones(half.shape, bool)
    for dy in range(3):
        for dx in range(3):
            peak &= half >= around[dy : dy + half.shape[0], dx : dx + half.shape[1]]
    y, x = peak.nonzero()
    best = 0.0
    for k in np.argsort(-half[y, x], kind="stable"):
        reached = float(half[y[k], x[k]])
        if reached <= best:
            break  # no other shift can come back any higher
        steps = np.linspace(0, 1, 1 + max(int(y[k]), abs(int(x[k]) - center)))
        way = half[
            np.rint(steps * y[k]).astype(int), center + np.rint(steps * (x[k] - center)).astype(int)
        ]
        best = max(best, reached - max(0.0, float(way.min())))
    return best


def autocorrelation(exemplar: Exemplar) -> NDArray[np.float64]:
    """Return the correlation of a sample with itself at every shift of up to half its sides.

    Slow lighting is removed first. Products of the overlap are divided by the mean of the two
    parts' energies, so it is 1 where the parts are equal and never more.
    """
    flat = relief(exemplar)
    height, width = flat.usable.shape
    reach = height // 2, width // 2
    size = height + reach[0], width + reach[1]  # so far that no shift wraps around
    power = np.zeros((size[0], size[1] // 2 + 1))
    for level in flat.levels:
        power += np.abs(np.fft.rfft2(level, size)) ** 2
    products = np.fft.irfft2(power, size)
    usable = np.fft.rfft2(flat.usable, size)
    energy = np.fft.rfft2((flat.levels**2).sum(axis=0), size)
    energies = np.fft.irfft2((energy * usable.conj()).real, size)
    places = [np.arange(-r, r + 1) for r in reach]
    products, energies = products[np.ix_(*places)], energies[np.ix_(*places)]
    # Below this the transforms' own rounding is all there is.
    floor = 1e-9 * max(1.0, float(energies.max()))
    result: NDArray[np.float64] = np.where(
        energies > floor, products / np.maximum(energies, floor), 0
    )
    return result
