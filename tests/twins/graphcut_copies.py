"""Smaller and smaller copies of pictures, and how far they are from a sample."""

from __future__ import annotations

import math

import numpy as np


def halved(pixels, mask):
    """Rounded means of four pixels; those count all of which do."""
    height, width = (n // 2 for n in mask.shape)
    means = np.zeros((height, width, pixels.shape[2]), int)
    counts = np.zeros((height, width), bool)
    for y, x in np.ndindex(height, width):
        four = pixels[2 * y : 2 * y + 2, 2 * x : 2 * x + 2]
        means[y, x] = (four.sum(axis=(0, 1)) + 2) // 4
        counts[y, x] = mask[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].all()
    return means, counts


def copies(pixels, mask, reduction):
    """A picture and its mask, and halved again and again."""
    result = [(np.asarray(pixels, int), np.asarray(mask, bool))]
    while 1 << len(result) <= reduction:
        result.append(halved(*result[-1]))
    return result


def mismatch(box, sample, top, left):
    """Mean squared difference where both count, the box's corner on (top, left) of the sample."""
    total = area = 0
    for y, x in np.argwhere(box[1]):
        v, u = y + top, x + left
        if 0 <= v < sample[1].shape[0] and 0 <= u < sample[1].shape[1] and sample[1][v, u]:
            total += int(((box[0][y, x] - sample[0][v, u]) ** 2).sum())
            area += 1
    return total / area if area else math.inf
