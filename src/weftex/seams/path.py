"""The path of least cost through a band, open or closed; for the borders of wrapped outputs.

Quilting's paths are cut by `weftex.methods.patches.patch_kernels.cut_bands`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_FORBIDDEN = 2**62  # the cost of a forbidden place; any path costs less


def least_path(cost: NDArray[np.int64], *, closed: bool = False) -> NDArray[np.int64]:
    """The cheapest path (n,) along the first axis of `cost` (n, width), moving at most one a row.

    With `closed` the band wraps and the path ends within one of its start. Ties: the first place in
    the last row, then in the row before. Costs are 0 or more, together below 2**62.
    """
    if not closed:
        return _open_path(cost)
    crossing = _open_path(np.concatenate([cost, cost]))[len(cost)]
    held = np.concatenate([cost, cost[:1]])
    excluded = np.arange(cost.shape[1]) != crossing
    held[0, excluded] = held[-1, excluded] = _FORBIDDEN
    return _open_path(held)[:-1]


def _open_path(cost: NDArray[np.int64]) -> NDArray[np.int64]:
    total = np.full((len(cost), cost.shape[1] + 2), _FORBIDDEN)
    total[0, 1:-1] = cost[0]
    came = np.zeros(cost.shape, np.int64)
    for row in range(1, len(cost)):
        before = np.stack([total[row - 1, :-2], total[row - 1, 1:-1], total[row - 1, 2:]])
        came[row] = before.argmin(axis=0) - 1
        total[row, 1:-1] = np.minimum(before.min(axis=0), _FORBIDDEN - cost[row]) + cost[row]
    path = np.empty(len(cost), np.int64)
    path[-1] = total[-1, 1:-1].argmin()
    for row in range(len(cost) - 1, 0, -1):
        path[row - 1] = path[row] + came[row, path[row]]
    return path
