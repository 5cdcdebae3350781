"""Correlation and goodness of lattices (chapter 3 of the paper on near-regular textures)."""

from __future__ import annotations

import itertools

import numpy as np


def normalized_correlation(f, g=None, f_mask=None, g_mask=None):
    """Equations 3.2 and 3.10 shift by shift; [y + h - 1, x + w - 1] moves g by (x, y)."""
    f = np.asarray(f, np.float64)
    f = f.reshape(*f.shape[:2], -1)
    g, g_mask = (f, f_mask) if g is None else (np.asarray(g, np.float64), g_mask)
    g = g.reshape(*g.shape[:2], -1)
    (height, width), (h, w) = f.shape[:2], g.shape[:2]
    f_mask = np.ones((height, width), bool) if f_mask is None else f_mask
    g_mask = np.ones((h, w), bool) if g_mask is None else g_mask
    result = np.zeros((height + h - 1, width + w - 1))
    for y, x in itertools.product(range(1 - h, height), range(1 - w, width)):
        here = slice(max(0, y), min(height, y + h)), slice(max(0, x), min(width, x + w))
        there = tuple(slice(s.start - by, s.stop - by) for s, by in zip(here, (y, x), strict=True))
        both = f_mask[here] & g_mask[there]
        if both.sum() < 2:
            continue
        a, b = f[here][both], g[there][both]
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        weights = np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0))
        if weights.sum() > 1e-9:
            result[y + h - 1, x + w - 1] = (a * b).sum() / weights.sum()
    return result


def share_of_tile(vectors, width, height):
    """Section 3.3.1: different wrapped positions of a rectangle, by the number a tile has."""
    (ux, uy), (vx, vy) = vectors
    area = abs(ux * vy - vx * uy)
    wrapped = set()
    for y, x in itertools.product(range(height), range(width)):
        # Equations 3.28 and 3.29 in whole numbers: coordinates in the tile times its area.
        a, b = (x * vy - y * vx) % area, (y * ux - x * uy) % area
        wrapped.add((a, b))
    return len(wrapped) / area


def goodness_of_vectors(correlation, vectors):
    """Equation 3.22 for whole vectors, over all significant multiples of the right half."""
    (ux, uy), (vx, vy) = vectors
    height, width = (side // 2 + 1 for side in correlation.shape)
    total, number = 0.0, 0
    for a, b in itertools.product(range(-width - height, width + height + 1), repeat=2):
        x, y = a * ux + b * vx, a * uy + b * vy
        if abs(x) >= width or abs(y) >= height or (b, a) <= (0, 0):
            continue
        if share_of_tile(vectors, width - abs(x), height - abs(y)) >= 0.85:
            total += correlation[y + height - 1, x + width - 1]
            number += 1
    return max(total, 0.0) ** 1.12 / max(number, 1), number
