"""Minimum cuts of grids."""

from __future__ import annotations

import numpy as np

from twins.windows import ARCS


def cut_value(side, arcs, source, sink):
    """Capacity of what leads from the source's side to the sink's."""
    height, width = side.shape
    value = source[~side].sum() + sink[side].sum()
    for y, x in np.argwhere(side):
        for d, (dy, dx) in enumerate(ARCS):
            if 0 <= y + dy < height and 0 <= x + dx < width and not side[y + dy, x + dx]:
                value += arcs[y, x, d]
    return int(value)


def cut_by_scipy(arcs, source, sink):
    """The source's side of the minimum cut of a grid, the smallest one, and its value."""
    height, width = source.shape
    arc = {}
    for y, x, d in np.argwhere(arcs).tolist():
        v, u = y + ARCS[d][0], x + ARCS[d][1]
        if 0 <= v < height and 0 <= u < width:
            arc[y * width + x, v * width + u] = int(arcs[y, x, d])
    side, value = least_labelling((sink - source).ravel().tolist(), arc)
    return np.reshape(side, source.shape), value + int(source.sum())


def least_labelling(unary, arc):
    """Labels 0 and 1 that minimize sum of unary[i] x_i + sum of arc[i, j] x_i (1 - x_j).

    Of all that do, the one with the fewest 1; from SciPy's maximum flow.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(unary)
    edges = [(count, i, -u) for i, u in enumerate(unary) if u < 0]
    edges += [(i, count + 1, u) for i, u in enumerate(unary) if u > 0]
    edges += [(i, j, weight) for (i, j), weight in arc.items() if weight]
    if not edges:
        return [False] * count, 0
    rows, columns, weights = zip(*edges, strict=True)
    shape = count + 2, count + 2
    graph = coo_array((np.array(weights, np.int32), (rows, columns)), shape).tocsr()
    flow = maximum_flow(graph, count, count + 1)
    residual = graph - flow.flow
    residual.eliminate_zeros()
    reached = set(breadth_first_order(residual, count, return_predecessors=False).tolist())
    value = flow.flow_value + sum(u for u in unary if u < 0)
    return [i in reached for i in range(count)], int(value)
