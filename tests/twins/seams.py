"""Minimum-error paths, and cuts along them."""

from __future__ import annotations

import itertools

import numpy as np

from weftex.reference.image_quilting import minimum_error_boundary

#: What a step of a path costs where the patch cannot show: more than any path where it can.
OUTSIDE = 2**44


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


def box_of(weights):
    """(top, left, bottom, right) of where a patch can show; all of the window if it cannot."""
    shown = np.argwhere(weights > 0)
    if not len(shown):
        return (0, 0, *weights.shape)
    return (*shown.min(axis=0).tolist(), *(shown.max(axis=0) + 1).tolist())


def band_depth(weights, width, hole=False):
    """How far bands reach into the box: the zone's width, or in a hole half of the shorter side."""
    top, left, bottom, right = box_of(weights)
    shorter = min(bottom - top, right - left)
    return max(min(width, shorter), shorter // 2) if hole else min(width, shorter)


def cut_sides(canvas_window, new_window, weights, zone, width, hole=False):
    """{side: {line: position}}: for each row or column of the box where the older pixels end.

    A side of the box has a band if the zone is all along it; of a hole, if any of it is there. A
    step of its path costs the squared
    difference where pixels are blended, nothing where none was known, and as good as never goes
    where the canvas stays.
    """
    top, left, bottom, right = box_of(weights)
    depth = band_depth(weights, width, hole)
    cost = ((canvas_window.astype(int) - new_window.astype(int)) ** 2).sum(axis=2)
    cost[weights == 0] = OUTSIDE
    cost[weights == 256] = 0
    cost, there = cost[top:bottom, left:right], zone[top:bottom, left:right]
    turned = {  # so that each border lies to the left
        "left": (cost, there, top, lambda k: left + k),
        "top": (cost.T, there.T, left, lambda k: top + k),
        "right": (cost[:, ::-1], there[:, ::-1], top, lambda k: right - k),
        "bottom": (cost[::-1].T, there[::-1].T, left, lambda k: bottom - k),
    }
    return {
        side: {first + i: at(k) for i, k in enumerate(minimum_error_boundary(c[:, :depth]))}
        for side, (c, z, first, at) in turned.items()
        if (z[:, :depth].any() if hole else z[:, :depth].any(axis=1).all())
    }


def cut_row(paths, rows, columns):
    """The paths as `Synthesis.cuts` stores them: first and past-the-last own columns and rows."""
    lines = {
        "left": [0] * rows,
        "right": [columns] * rows,
        "top": [0] * columns,
        "bottom": [rows] * columns,
    }
    for side, path in paths.items():
        for i, k in path.items():
            lines[side][i] = k
    return np.concatenate([*lines.values()]).astype(np.uint16)


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
