"""Belts along the seams between patches."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.masks import grown

if TYPE_CHECKING:
    from numpy.typing import NDArray


def seam_belts(
    source: NDArray[np.int32],
    reach: int,
    wrap: tuple[bool, bool],
    period: tuple[int, int] | None = None,
) -> NDArray[np.bool_]:
    """Mask (H, W) of the pixels within `reach` of a seam, where neighbors have no adjacent sources.

    `source` is (H, W, 2); `period` is the size of a tileable sample.
    """
    belts = np.zeros(source.shape[:2], bool)
    for axis in (0, 1):
        step = np.roll(source, -1, axis) - source - np.eye(2, dtype=np.int32)[axis]
        broken = ((step if period is None else step % np.array(period)) != 0).any(axis=2)
        if not wrap[axis]:
            broken.swapaxes(0, axis)[-1] = False
        belts |= broken | np.roll(broken, 1, axis)
    return grown(belts, reach - 1, wrap)
