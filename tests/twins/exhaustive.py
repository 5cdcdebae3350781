"""Weighted distances of half-known windows, and the choice among all windows."""

from __future__ import annotations

import math

import numpy as np

from twins.randomness import pick
from twins.windows import known_window


def bell_weights(width):
    """A Gaussian with a sigma of width / 6.4, in whole numbers from 1 to 127."""
    sigma, middle = width / 6.4, width // 2
    return [
        [
            max(1, round(127 * math.exp(-((v - middle) ** 2 + (u - middle) ** 2) / 2 / sigma**2)))
            for u in range(width)
        ]
        for v in range(width)
    ]


def weighted_distances(levels, y, x, known, exemplar, centers, weights):
    """Sum of w d**2 over the known steps, to the window around each of the sample's centers."""
    pixels, middle = exemplar.matching().astype(int), len(weights) // 2
    around = np.pad(pixels, ((middle, middle), (middle, middle), (0, 0)), mode="wrap")
    height, width = exemplar.shape
    totals = np.zeros(exemplar.shape, int)
    for dy, dx in known:  # around all pixels of the sample at once
        here = levels[(y + dy) % len(levels), (x + dx) % levels.shape[1]].astype(int)
        top, left = dy + middle, dx + middle
        apart = around[top : top + height, left : left + width] - here
        totals += weights[top][left] * np.einsum("yxk,yxk->yx", apart, apart)
    return [int(totals[center]) for center in centers]


def choice_of_all(search, exemplar, levels, done, wrap, place, bits, tolerance, candidates=None):
    """(chosen, distance, weight) of one pixel, over all windows or some candidates."""
    width, weights = len(search.weights), search.weights.tolist()
    y, x = divmod(int(place), done.shape[1])
    known = known_window(done, y, x, wrap, [width // 2] * 4)
    places = search.windows.centers.tolist() if candidates is None else sorted(candidates)
    flat = search.windows.to_sample(np.array(places, np.int32))
    centers = [divmod(int(p), exemplar.shape[1]) for p in flat]
    distances = weighted_distances(levels, y, x, known, exemplar, centers, weights)
    limit = min(distances) * (1 + tolerance)
    similar = [n for n, d in enumerate(distances) if d <= limit]
    drawn = similar[pick(bits, len(similar))]
    total = sum(weights[dy + width // 2][dx + width // 2] for dy, dx in known)
    return places[drawn], distances[drawn], total
