"""The boundary between a photo and what fills its holes, as a minimum cut."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.seams.maxflow import LARGEST_CAPACITY, minimum_cut

if TYPE_CHECKING:
    from numpy.typing import NDArray


def cut_around(
    old: NDArray[np.uint8], new: NDArray[np.uint8], wide: NDArray[np.bool_], hole: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Mask (H, W) of the pixels to take from `new`: within `wide`, covering `hole`.

    Its border is a minimum cut; a seam costs the differences of the two pixels (H, W, K) beside it.
    """
    difference = np.abs(old.astype(np.int32) - new).sum(axis=2, dtype=np.int32)
    difference[~wide] = 0
    arcs = np.zeros((*hole.shape, 4), np.int32)
    arcs[:, :-1, 0] = arcs[:, 1:, 2] = _seam_costs(difference, wide)
    arcs[:-1, :, 1] = arcs[1:, :, 3] = _seam_costs(difference.T, wide.T).T
    must, never = (np.where(mask, LARGEST_CAPACITY, 0).astype(np.int32) for mask in (hole, ~wide))
    return minimum_cut(arcs, must, never)[0]


def _seam_costs(difference: NDArray[np.int32], wide: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Costs of seams between the pixels of each row: (H, W - 1)."""
    costs: NDArray[np.int32] = difference[:, :-1] + difference[:, 1:]
    # At the outer border only one of the two pixels has a filling to differ, so it counts twice.
    costs[wide[:, :-1] ^ wide[:, 1:]] *= 2
    return costs
