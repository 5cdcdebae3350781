"""Pyramids and stacks of pictures and masks."""

from __future__ import annotations

import itertools

import numpy as np


def coarser(levels, wrap, start=(0, 0)):
    """Every second pixel of the 1 4 6 4 1 mean, rounded; beyond a border the last pixel goes on."""
    height, width = levels.shape[:2]
    shape = (height + 1 - start[0]) // 2, (width + 1 - start[1]) // 2
    result = np.zeros((*shape, levels.shape[2]), np.uint8)
    for y, x in np.ndindex(result.shape[:2]):
        total = np.full(levels.shape[2], 128)
        for v, u in itertools.product(range(-2, 3), repeat=2):
            weight = (1, 4, 6, 4, 1)[v + 2] * (1, 4, 6, 4, 1)[u + 2]
            at = 2 * y + start[0] + v, 2 * x + start[1] + u
            at = _tap(at[0], height, wrap[0]), _tap(at[1], width, wrap[1])
            total += weight * levels[at].astype(int)
        result[y, x] = total // 256
    return result


def coarser_mask(mask, wrap, start=(0, 0)):
    """Whether all pixels that count for a coarser one are in the mask."""
    height, width = mask.shape
    result = np.ones(((height + 1 - start[0]) // 2, (width + 1 - start[1]) // 2), bool)
    for y, x in np.ndindex(result.shape):
        for v, u in itertools.product(range(-2, 3), repeat=2):
            at = 2 * y + start[0] + v, 2 * x + start[1] + u
            result[y, x] &= mask[_tap(at[0], height, wrap[0]), _tap(at[1], width, wrap[1])]
    return result


def pyramid(pixels, mask, wrap, count):
    """Pictures and masks of `count` levels, the finest first."""
    pictures, masks = [pixels], [mask]
    for _ in range(count - 1):
        pictures.append(coarser(pictures[-1], wrap))
        masks.append(coarser_mask(masks[-1], wrap))
    return pictures, masks


def stacked(levels, number, wrap, halve=coarser):
    """A coarser level, which is every 2**number-th pixel, for each pixel to be the first."""
    if not number:
        return levels
    result = np.empty_like(levels)
    for y, x in itertools.product((0, 1), repeat=2):
        result[y::2, x::2] = stacked(halve(levels, wrap, (y, x)), number - 1, wrap, halve)
    return result


def _tap(at, length, wraps):
    return at % length if wraps else min(max(at, 0), length - 1)
