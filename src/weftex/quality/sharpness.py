"""Sharpness: whether the finest detail is as strong as in the sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weftex.quality.view import View

_ROUNDING = 1 / 12  # the variance of an error of up to half


def sharpness(sample: View, result: View) -> float | None:
    """Return the ratio of the root mean squares of detail, the difference from a 3x3 blur.

    Below 1 the result is blurred, above it has noise or hard edges. None for sides below 3, and
    masks that leave no detail.
    """
    own, made = _detail(sample), _detail(result)
    if own is None or made is None:
        return None
    return float(np.sqrt((made + _ROUNDING) / (own + _ROUNDING)))


def _detail(view: View) -> float | None:
    """Return the mean squared detail where all pixels of the blur are usable."""
    if min(view.shape) < 3:
        return None
    smooth, usable = view.gray.astype(np.float64), view.usable
    for axis in (0, 1):
        before, center, after = (
            tuple(
                slice(k, smooth.shape[axis] - 2 + k) if a == axis else slice(None) for a in (0, 1)
            )
            for k in range(3)
        )
        smooth = (smooth[before] + 2 * smooth[center] + smooth[after]) / 4
        usable = usable[before] & usable[center] & usable[after]
    if not usable.any():
        return None
    return float(((view.gray[1:-1, 1:-1] - smooth) ** 2)[usable].mean())
