"""Minimum cuts of grids by max-flow: which of two pictures each pixel is taken from.

Used here for boundaries and merging, in `methods.graphcut` for patches. Cuts along a path are
dynamic programs: `methods.patches.cut_kernels.cut_bands` and `methods.ashikhmin.least_path`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.raster.arrays import Indices, Mask
from weftex.seams import maxflow_kernels as kernels

#: So that no sum of four capacities overflows.
LARGEST_CAPACITY = 2**28

_WHOLE, _SMALL = ("terminal", "distance", "stamp"), ("parent", "tree", "waits", "unused")
_NODE = np.dtype(
    [("arcs", np.int32, 4), *((n, np.int32) for n in _WHOLE), *((n, np.int8) for n in _SMALL)]
)


def minimum_cut(arcs: Indices, source: Indices, sink: Indices) -> tuple[Mask, int]:
    """The minimum cut of a 4-connected grid: its smallest source side (H, W), and its value.

    `arcs` (H, W, 4) are capacities to the right, lower, left and upper neighbor; `source` and
    `sink` (H, W) those of the terminals. Capacities are 0 to `LARGEST_CAPACITY`, else it raises.
    """
    shape = source.shape
    if arcs.shape != (*shape, 4) or sink.shape != shape or len(shape) != 2:
        raise InvalidInputError(
            f"arcs, source and sink are {arcs.shape}, {shape} and {sink.shape}; "
            "they must be (H, W, 4), (H, W) and (H, W)"
        )
    for given in (arcs, source, sink):
        if given.size and (given.min() < 0 or given.max() > LARGEST_CAPACITY):
            raise InvalidInputError(f"capacities must be from 0 to {LARGEST_CAPACITY}")
    height, width = shape
    side = np.zeros(shape, np.uint8)
    capacities = (np.ascontiguousarray(given, np.int32) for given in (arcs, source, sink))
    value: int = kernels.cut_grid(kernels.Grid(*capacities, **search_trees(height, width)), side)
    return side.astype(bool), value


def search_trees(height: int, width: int) -> dict[str, NDArray[Any]]:
    """Memory for the search trees of a grid up to this size."""
    count = (height + 2) * (width + 2)
    active, orphans = np.zeros((2, count + 2), np.int32)
    return {"nodes": np.empty(count, _NODE), "active": active, "orphans": orphans}
