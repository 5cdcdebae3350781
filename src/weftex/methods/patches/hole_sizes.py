"""The patch size that suits a hole."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.boxes import box_sums

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Patch sizes; a hole gets the largest of which it holds a square `_LEAP` times as wide.
_SIZES = (128, 96, 64, 48)
_LEAP = 2.5


def patch_size_for(hole: NDArray[np.bool_], usable: NDArray[np.bool_], least: int) -> int:
    """Return the side of patches for a hole, in pixels.

    Parameters
    ----------
    hole : bool array (H, W)
        What is to be filled.
    usable : bool array (H', W')
        The pixels that patches are taken from.
    least : int
        The smallest side.

    Examples
    --------
    >>> hole = np.zeros((200, 200), bool)
    >>> hole[60:120, 60:120] = True
    >>> patch_size_for(hole, ~hole, 2)
    40
    """
    fits = (s for s in _SIZES if s == _SIZES[-1] or _windows(hole, round(_LEAP * s)))
    size: int = max(min(next(fits), min(*hole.shape, *usable.shape) // 5), least)
    enough = np.count_nonzero(usable) // 4
    while size > least:
        # With few windows to choose from none of them matches.
        if _windows(usable, size) > (enough if size > 8 else 0):
            break
        size = max(size * 3 // 4, least)
    return size


def _windows(mask: NDArray[np.bool_], side: int) -> int:
    """Count the square windows that are True all over."""
    if side > min(mask.shape):
        return 0
    return int(np.count_nonzero(box_sums(mask, side, side) == side * side))
