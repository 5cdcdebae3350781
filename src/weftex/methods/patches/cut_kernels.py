# mypy: ignore-errors
# cython: infer_types=True
"""The minimum error boundary cut (Efros and Freeman, section 2.1); compiled, see the .pxd."""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.results.paste_kernels import BOTTOM, LEFT, RIGHT, TOP, start_of

# More than any path of real differences: 2**16 pixels of 2**10 channels.
OUTSIDE = cython.declare(cython.longlong, 1 << 44)


def cut_bands(canvas, pixels, layout, bands, p, cost, cuts):
    """Cut patch `p` along the path of least error at each side that overlaps older patches.

    The cuts of two sides, each found by itself, cross: together they are the L-shaped boundary of a
    patch, see `paste_kernels.effective`. `bands` is that of `BoundaryZone`, `cost` is scratch, and
    row `p` of `cuts` is filled. Ties go to the pixel nearest the side.
    """
    rows, columns = layout.weights.shape[1], layout.weights.shape[2]
    cut = cython.address(cuts[p, 0])
    for v in range(rows):
        cut[start_of(LEFT, rows, columns) + v] = 0
        cut[start_of(RIGHT, rows, columns) + v] = columns
    for u in range(columns):
        cut[start_of(TOP, rows, columns) + u] = 0
        cut[start_of(BOTTOM, rows, columns) + u] = rows
    for side in range(4):
        if bands[5 + side]:
            across = LEFT if side >= TOP else TOP  # the side where the path begins
            first = bands[1 + across]
            add_up(canvas, pixels, layout, bands, p, side, cost)
            trace_back(
                cost, bands[2 + across] - first, bands[0],
                bands[1 + side], -1 if side in (RIGHT, BOTTOM) else 1,
                cython.address(cut[start_of(side, rows, columns) + first]),
            )  # fmt: skip


def add_up(canvas, pixels, layout, bands, p, side, cost):
    """Fill `cost` (steps, depth): the least error of a path along a side up to each pixel.

    E[i, k] = e[i, k] + min(E[i - 1, k - 1], E[i - 1, k], E[i - 1, k + 1]).
    """
    placement = cython.address(layout.placements[p, 0])
    least: cython.longlong
    upright: cython.bint = side < TOP
    across = TOP if upright else LEFT
    first, depth, edge = bands[1 + across], bands[0], bands[1 + side]
    for i in range(bands[2 + across] - first):
        for k in range(depth):
            inward = edge - 1 - k if side in (RIGHT, BOTTOM) else edge + k
            v = first + i if upright else inward
            u = inward if upright else first + i
            cost[i, k] = 0
            if layout.weights[0, v, u] == 0:  # the canvas stays
                cost[i, k] = OUTSIDE
            elif layout.weights[0, v, u] < 256:  # in the overlap
                cost[i, k] = squared(
                    cython.address(
                        canvas[
                            (placement[0] + v) % canvas.shape[0],
                            (placement[1] + u) % canvas.shape[1],
                            0,
                        ]
                    ),
                    cython.address(pixels[placement[2] + v, placement[3] + u, 0]),
                    canvas.shape[2],
                )
            if i > 0:
                least = cost[i - 1, k]
                if k > 0:
                    least = min(least, cost[i - 1, k - 1])
                if k + 1 < depth:
                    least = min(least, cost[i - 1, k + 1])
                cost[i, k] += least


def trace_back(cost, length, depth, edge, inward, cut):
    """Write the path of least error from its end back to its start."""
    best: cython.Py_ssize_t = 0
    for k in range(1, depth):
        if cost[length - 1, k] < cost[length - 1, best]:
            best = k
    cut[length - 1] = edge + inward * best
    for i in range(length - 2, -1, -1):
        k = best
        if k > 0 and cost[i, k - 1] <= cost[i, best]:
            best = k - 1
        if k + 1 < depth and cost[i, k + 1] < cost[i, best]:
            best = k + 1
        cut[i] = edge + inward * best
