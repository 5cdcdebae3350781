"""Correlation (chapter 3 of the thesis on near-regular textures)."""

import itertools

import numpy as np


def normalized_correlation(f, mask=None):
    """Equations 3.2 and 3.10 shift by shift; [y + h - 1, x + w - 1] is the shift (x, y)."""
    height, width = f.shape[:2]
    f = f.reshape(height, width, -1)
    mask = np.ones((height, width), bool) if mask is None else mask
    result = np.zeros((2 * height - 1, 2 * width - 1))
    for y, x in itertools.product(range(1 - height, height), range(1 - width, width)):
        here = slice(max(0, y), min(height, y + height)), slice(max(0, x), min(width, x + width))
        there = tuple(slice(s.start - by, s.stop - by) for s, by in zip(here, (y, x), strict=True))
        both = mask[here] & mask[there]
        if both.sum() < 2:
            continue
        a, b = f[here][both], f[there][both]
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        weights = np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0))
        if weights.sum() > 1e-9:
            result[y + height - 1, x + width - 1] = (a * b).sum() / weights.sum()
    return result
