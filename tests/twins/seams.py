"""Minimum-error paths, and cuts along them."""

import itertools

import numpy as np

from weftex.reference.image_quilting import minimum_error_boundary


def path_by_exhaustion(cost):
    """The cheapest path from the first row to the last, one step aside a row at most.

    Of equally cheap ones, the one that, read backwards, stays nearest to the first column.
    """
    rows, columns = cost.shape
    best = None
    for path in itertools.product(range(columns), repeat=rows):
        if any(abs(a - b) > 1 for a, b in itertools.pairwise(path)):
            continue
        key = (sum(int(cost[i, k]) for i, k in enumerate(path)), path[::-1])
        if best is None or key < best:
            best = key
    return list(best[1][::-1])


def path_around(cost, closed):
    """The cheapest path; a closed one starts where the cheapest twice around crosses."""
    if not closed:
        return minimum_error_boundary(cost).tolist()
    start = int(minimum_error_boundary(np.concatenate([cost, cost]))[len(cost)])
    held = np.concatenate([cost, cost[:1]])
    for row in (0, -1):
        held[row] = [cost[0][k] if k == start else 10**15 for k in range(cost.shape[1])]
    return minimum_error_boundary(held)[:-1].tolist()


def cut_weights(weights, cut):
    """The weights in force: in the zone all or nothing, on either side of the paths."""
    rows, columns = weights.shape
    first_column, last_column, first_row, last_row = np.split(
        cut.astype(int), np.cumsum([rows, rows, columns])
    )
    result = weights.copy()
    for v, u in itertools.product(range(rows), range(columns)):
        if 0 < weights[v, u] < 256:
            own = first_column[v] <= u < last_column[v] and first_row[u] <= v < last_row[u]
            result[v, u] = 256 if own else 0
    return result
