"""Gaussian pyramids of bytes, in integers.

A pixel of a coarser level lies on every second one of the finer level and is the binomial mean,
1 4 6 4 1 along each axis, of what is around it; so the pixel at (y, x) has the one at (y // 2,
x // 2) as its parent, at odd sizes too. Sums are of integers, so every machine gets these bytes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_WEIGHTS = (1, 4, 6, 4, 1)


def gaussian_pyramid(
    levels: NDArray[np.uint8], count: int, wrap: tuple[bool, bool] = (False, False)
) -> list[NDArray[np.uint8]]:
    """Return `levels` and its coarser versions, each half as high and wide, rounded up.

    Parameters
    ----------
    levels : uint8 array (H, W, K)
        The finest level, which is returned as it is.
    count : int
        How many levels; sides of one pixel stay so.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis go around; otherwise the outermost pixels
        are repeated beyond the border.

    Examples
    --------
    >>> import numpy as np
    >>> pyramid = gaussian_pyramid(np.full((9, 6, 3), 77, np.uint8), 3)
    >>> [level.shape for level in pyramid], bool((pyramid[2] == 77).all())
    ([(9, 6, 3), (5, 3, 3), (3, 2, 3)], True)
    """
    result = [levels]
    for _ in range(count - 1):
        levels = halve(levels, wrap)
        result.append(levels)
    return result


def mask_pyramid(
    mask: NDArray[np.bool_], count: int, wrap: tuple[bool, bool] = (False, False)
) -> list[NDArray[np.bool_]]:
    """Return for each level which pixels are means of pixels of the mask alone.

    Examples
    --------
    >>> import numpy as np
    >>> mask_pyramid(np.arange(8) < np.full((8, 1), 6), 2)[1][0].tolist()
    [True, True, False, False]
    """
    result = [mask]
    for _ in range(count - 1):
        mask = halve_mask(mask, wrap)
        result.append(mask)
    return result


def halve(
    levels: NDArray[np.uint8], wrap: tuple[bool, bool], start: tuple[int, int] = (0, 0)
) -> NDArray[np.uint8]:
    """Return the next coarser level; `start` is which of its pixels the first one lies on."""
    total = levels.astype(np.uint16)  # 255 * 16 * 16 + 128 fits
    for axis in (0, 1):
        taps = _taps(total.shape[axis], wrap[axis], start[axis])
        total = np.sum(
            [np.uint16(w) * total.take(t, axis) for w, t in zip(_WEIGHTS, taps, strict=True)],
            axis=0,
            dtype=np.uint16,
        )
    return np.ascontiguousarray((total + np.uint16(128)) >> np.uint16(8), np.uint8)


def halve_mask(
    mask: NDArray[np.bool_], wrap: tuple[bool, bool], start: tuple[int, int] = (0, 0)
) -> NDArray[np.bool_]:
    """Return which pixels of `halve` are means of pixels of the mask alone."""
    for axis in (0, 1):
        taps = _taps(mask.shape[axis], wrap[axis], start[axis])
        mask = np.logical_and.reduce([mask.take(t, axis) for t in taps])
    return np.ascontiguousarray(mask)


def _taps(length: int, wrap: bool, start: int = 0) -> list[NDArray[np.intp]]:
    """For each weight, the pixels of an axis that it goes to."""
    every = np.arange(start, length, 2)
    reach = range(-2, 3)
    return [(every + k) % length if wrap else (every + k).clip(0, length - 1) for k in reach]
