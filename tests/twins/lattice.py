"""Correlation (chapter 3 of the paper on near-regular textures)."""

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
