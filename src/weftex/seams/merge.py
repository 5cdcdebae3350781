"""Merging two samples into one along a minimum cut (section 4 of the paper on texture fusion)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.seams.maxflow import LARGEST_CAPACITY, minimum_cut

if TYPE_CHECKING:
    from numpy.typing import NDArray

# As shares of the pictures' sides:
_CORE = 0.22  # half the side of the middle that is always inside
_RIM = 0.08  # width of the rim that is always outside


def island(outside: NDArray[np.uint8], inside: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Cut an island of one picture out, to lie in the other where the two differ least.

    A closed seam shows the two materials meeting in every direction.

    Parameters
    ----------
    outside, inside : uint8 array (H, W, K)
        Two pictures of the same size.

    Returns
    -------
    bool array (H, W)
        True on the island.

    Examples
    --------
    >>> import numpy as np
    >>> flat = np.zeros((40, 50, 1), np.uint8)
    >>> side = island(flat, flat + 9)
    >>> bool(side[20, 25]), bool(side[0].any())
    (True, False)
    """
    height, width = outside.shape[:2]
    differ = np.abs(outside.astype(np.int32) - inside).sum(axis=2)
    arcs = np.zeros((height, width, 4), np.int32)
    arcs[:, :-1, 0] = differ[:, :-1] + differ[:, 1:] + 1
    arcs[:-1, :, 1] = differ[:-1] + differ[1:] + 1
    arcs[:, 1:, 2] = arcs[:, :-1, 0]
    arcs[1:, :, 3] = arcs[:-1, :, 1]
    y, x = (np.abs(np.arange(n) - (n - 1) / 2) / n for n in (height, width))
    far = np.maximum(y[:, None], x)
    # At least one pixel is inside, and the border is outside, whatever the size.
    core = (far <= _CORE) | (far == far.min())
    source = np.where(core, LARGEST_CAPACITY, 0).astype(np.int32)
    sink = np.where((far >= 0.5 - _RIM) & ~core, LARGEST_CAPACITY, 0).astype(np.int32)
    return minimum_cut(arcs, source, sink)[0]
