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
    """Find the pixels near a seam: where the next pixel is not from the next place in the sample.

    Parameters
    ----------
    source : int32 array (H, W, 2)
        Row and column of the sample that each pixel was copied from.
    reach : int
        Half the width of a belt in pixels, 1 or more.
    wrap : (bool, bool)
        Whether the picture goes around from bottom to top and from right to left.
    period : (int, int), optional
        Height and width of a sample that tiles.

    Returns
    -------
    bool array (H, W)

    Examples
    --------
    >>> import numpy as np
    >>> row = np.array([0, 1, 2, 7, 8, 9])
    >>> seam_belts(np.stack([0 * row, row], axis=1)[None], 1, (False, False))[0].tolist()
    [False, False, True, True, False, False]
    """
    belts = np.zeros(source.shape[:2], bool)
    for axis in (0, 1):
        step = np.roll(source, -1, axis) - source - np.eye(2, dtype=np.int32)[axis]
        broken = ((step if period is None else step % np.array(period)) != 0).any(axis=2)
        if not wrap[axis]:
            broken.swapaxes(0, axis)[-1] = False
        belts |= broken | np.roll(broken, 1, axis)
    return grown(belts, reach - 1, wrap)
