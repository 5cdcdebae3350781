"""Gaussian pyramids and Gaussian stacks of bytes, in integers.

A pixel of a coarser level of a pyramid lies on every second one of the finer level and is the
binomial mean, 1 4 6 4 1 along each axis, of the pixels around it; so the pixel at (y, x) has the
one at (y // 2, x // 2) as its parent, at odd sizes too. Sums are of integers, so every machine
gets these bytes.

A pyramid keeps every second pixel. A stack keeps them all, so a place on any of its levels is a
pixel of the finest (Lefebvre and Hoppe, 2005). Pixels that lie side by side on a coarse level are
two or more apart on the finest; those that belong together are a phase, a picture of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Bytes, Mask

_STARTS = ((0, 0), (0, 1), (1, 0), (1, 1))


def gaussian_pyramid(
    pixels: Bytes, count: int, wrap: tuple[bool, bool] = (False, False)
) -> list[Bytes]:
    """`pixels` (H, W, K) and its coarser levels, each half the size, rounded up; `count` in all.

    Axes wrap, or border pixels are repeated outside.
    """
    return [level for (level,) in _levels(pixels, count, _halved, wrap, _STARTS[:1])]


def mask_pyramid(mask: Mask, count: int, wrap: tuple[bool, bool] = (False, False)) -> list[Mask]:
    """For each level, which pixels are means of pixels of the mask alone."""
    return [level for (level,) in _levels(mask, count, _halved_mask, wrap, _STARTS[:1])]


def children(
    parents: NDArray[np.int32], columns: int, y: NDArray[np.integer], x: NDArray[np.integer]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Rows and columns of the sources at the next finer level, for pixels (y, x) of that level.

    `parents` (H, W) is the flat source index of each pixel's parent, in a level of `columns`
    columns; results may lie one beyond the finer level's last row or column.
    """
    above = np.divmod(parents, np.int32(columns))
    return 2 * above[0] + y % 2, 2 * above[1] + x % 2


def gaussian_stack(pixels: Bytes, count: int, wrap: tuple[bool, bool]) -> list[list[Bytes]]:
    """The phases of each level of a Gaussian stack of `pixels` (H, W, K), finest level first.

    Each level has four times the phases of the one before, in the order of `phase_starts`; the
    first phase is the level of the pyramid.
    """
    return _levels(pixels, count, _halved, wrap)


def mask_stack(mask: Mask, count: int, wrap: tuple[bool, bool]) -> list[list[Mask]]:
    """Return for each phase of `gaussian_stack` which pixels are means of the mask's alone."""
    return _levels(mask, count, _halved_mask, wrap)


def _levels(
    finest: Any, count: int, halved: Any, wrap: tuple[bool, bool], starts: Any = _STARTS
) -> list[list[Any]]:
    """The phases of each level, `halved` from those of the level before at each of `starts`."""
    levels = [[finest]]
    for _ in range(count - 1):
        levels.append([halved(phase, wrap, at) for at in starts for phase in levels[-1]])
    return levels


def phase_starts(number: int) -> list[tuple[int, int]]:
    """The first pixel (y, x) of each phase of level `number`, 0 being the finest."""
    starts = [(0, 0)]
    for k in range(number):
        starts = [(y + (v << k), x + (u << k)) for v, u in _STARTS for y, x in starts]
    return starts


def _halved(pixels: Bytes, wrap: tuple[bool, bool], start: tuple[int, int] = (0, 0)) -> Bytes:
    """The next coarser level, whose first pixel lies on the one at `start`."""
    # Weights of 1, 4, 6, 4 and 1.
    total = pixels.astype(np.uint16)  # 255 * 16 * 16 + 128 fits
    for axis in (0, 1):
        around = _reached(total.shape[axis], wrap[axis], start[axis])
        even, odd = total.take(around[::2], axis), total.take(around[1::2], axis)
        ends = [slice(k, even.shape[axis] - 2 + k) for k in range(3)]
        first, middle, last = (even[(slice(None),) * axis + (part,)] for part in ends)
        total = 6 * middle
        for part in ends[:2]:
            total += 4 * odd[(slice(None),) * axis + (part,)]
        total += first
        total += last
    total += np.uint16(128)
    total >>= np.uint16(8)
    return np.ascontiguousarray(total, np.uint8)


def _halved_mask(mask: Mask, wrap: tuple[bool, bool], start: tuple[int, int] = (0, 0)) -> Mask:
    """Which pixels of `_halved` are means of pixels of the mask alone."""
    if mask.all():
        height, width = mask.shape
        return np.ones((len(range(start[0], height, 2)), len(range(start[1], width, 2))), bool)
    for axis in (0, 1):
        around = _reached(mask.shape[axis], wrap[axis], start[axis])
        taps = [around[k : len(around) - 3 + k : 2] for k in range(5)]  # one for each weight
        mask = np.logical_and.reduce([mask.take(t, axis) for t in taps])
    return np.ascontiguousarray(mask)


def _reached(length: int, wrap: bool, start: int) -> NDArray[np.intp]:
    """The pixels of an axis from two before the first that is kept to two after the last."""
    if start >= length:
        return np.zeros(0, np.intp)
    last = length - 1 - (length - 1 - start) % 2
    around = np.arange(start - 2, last + 3)
    return around % length if wrap else around.clip(0, length - 1)
