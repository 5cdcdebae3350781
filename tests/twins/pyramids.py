"""Pyramids and stacks of pictures and masks."""

import itertools

import numpy as np


def coarser(levels, wrap, start=(0, 0)):
    """Every second pixel of the 1 4 6 4 1 mean, rounded; beyond a border the last pixel goes on."""
    total = 128
    for v, u in itertools.product(range(-2, 3), repeat=2):
        weight = (1, 4, 6, 4, 1)[v + 2] * (1, 4, 6, 4, 1)[u + 2]
        total = total + weight * _taps(levels, wrap, start, (v, u)).astype(int)
    return (total // 256).astype(np.uint8)


def coarser_mask(mask, wrap, start=(0, 0)):
    """Whether all pixels that count for a coarser one are in the mask."""
    steps = itertools.product(range(-2, 3), repeat=2)
    return np.logical_and.reduce([_taps(mask, wrap, start, step) for step in steps])


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


def _taps(levels, wrap, start, step):
    """For each coarser pixel the one this step away from its own."""
    places = []
    for length, wraps, first, off in zip(levels.shape, wrap, start, step, strict=False):
        at = np.arange(first, length, 2) + off
        places.append(at % length if wraps else at.clip(0, length - 1))
    return levels[np.ix_(*places)]
