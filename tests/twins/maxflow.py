"""Minimum cuts of grids."""

import numpy as np

from twins.windows import ARCS
from weftex.reference.graphcut import Graph


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

    Of all that do, the one with the fewest 1; by the reference of graph cut.
    """
    graph, count = Graph(), len(unary)
    graph.numbers |= {i: i + 2 for i in range(count)}  # after the terminals
    graph.arcs += [(0, i + 2, -u) for i, u in enumerate(unary) if u < 0]
    graph.arcs += [(i + 2, 1, u) for i, u in enumerate(unary) if u > 0]
    graph.arcs += [(i + 2, j + 2, weight) for (i, j), weight in arc.items() if weight]
    side = graph.new_side()
    cut = sum(c for i, j, c in graph.arcs if (i == 0 or i - 2 in side) and j - 2 not in side)
    return [i in side for i in range(count)], cut + sum(u for u in unary if u < 0)
