"""Minimum cuts of grids: which of two pictures each pixel is taken from (graph cuts)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.seams import maxflow_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: So that no sum of four capacities overflows.
LARGEST_CAPACITY = 2**28

_WHOLE, _SMALL = ("terminal", "distance", "stamp"), ("parent", "tree", "waits", "unused")
_NODE = np.dtype(
    [("arcs", np.int32, 4), *((n, np.int32) for n in _WHOLE), *((n, np.int8) for n in _SMALL)]
)


def minimum_cut(
    arcs: NDArray[np.int32], source: NDArray[np.int32], sink: NDArray[np.int32]
) -> tuple[NDArray[np.bool_], int]:
    """Cut a grid of nodes, each joined to its four neighbors, between a source and a sink.

    Parameters
    ----------
    arcs : int32 array (H, W, 4)
        Capacity of the arc from each node to its right, lower, left and upper neighbor, 0 to
        `LARGEST_CAPACITY`. Those that lead out of the grid do not count.
    source, sink : int32 array (H, W)
        Capacity of the arc from the source to each node, and from each node to the sink.

    Returns
    -------
    side : bool array (H, W)
        True for the nodes on the source's side; of all minimum cuts, the one with the fewest.
    value : int
        Capacity of the arcs that are cut, which is the largest flow.

    Raises
    ------
    InvalidInputError
        If a shape does not fit, or a capacity is negative or above `LARGEST_CAPACITY`.

    Examples
    --------
    >>> import numpy as np
    >>> arcs = np.full((1, 3, 4), 5, np.int32)
    >>> arcs[0, 1, 0] = 2  # from the second node to the third
    >>> side, value = minimum_cut(arcs, np.int32([[9, 0, 0]]), np.int32([[0, 0, 9]]))
    >>> side.tolist(), value
    ([[True, True, False]], 2)
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
    capacities = kernels.Capacities(
        np.ascontiguousarray(arcs, np.int32),
        np.ascontiguousarray(source, np.int32),
        np.ascontiguousarray(sink, np.int32),
    )
    value: int = kernels.cut_grid(capacities, search_trees(height, width), side)
    return side.astype(bool), value


def search_trees(height: int, width: int) -> kernels.Trees:
    """Make room for the search trees of grids up to this size."""
    count = (height + 2) * (width + 2)
    active, orphans = np.zeros((2, count + 2), np.int32)
    return kernels.Trees(np.empty(count, _NODE), active, orphans)
