# mypy: ignore-errors
"""Kernels that find seams; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.weftex.results.paste_kernels import Layout
from cython.cimports.weftex.seams.boundary_kernels import pixel_difference

# More than any path of real differences: 2**16 pixels of 2**10 channels.
OUTSIDE = cython.declare(cython.longlong, 1 << 44)


def cut_bands(canvas, pixels, layout, bands, p, cost, cuts):
    """Find the minimum-error path along each band of the boundary zone, by dynamic programming.

    `bands` is depth, the box (top, left, bottom, right) and four flags for left, top, right,
    bottom; row `p` of `cuts` is filled as `paste` reads it. Ties go to the pixel nearest the box's
    border.
    """
    placement: cython.p_const_int = cython.address(layout.placements[p, 0])
    y: cython.Py_ssize_t = placement[0]
    x: cython.Py_ssize_t = placement[1]
    source_y: cython.Py_ssize_t = placement[2]
    source_x: cython.Py_ssize_t = placement[3]
    full_rows: cython.Py_ssize_t = layout.weights.shape[1]
    full_columns: cython.Py_ssize_t = layout.weights.shape[2]
    depth: cython.Py_ssize_t = bands[0]
    top: cython.Py_ssize_t = bands[1]
    left: cython.Py_ssize_t = bands[2]
    bottom: cython.Py_ssize_t = bands[3]
    right: cython.Py_ssize_t = bands[4]
    weight: cython.int
    least: cython.longlong
    upright: cython.bint
    cython.declare(side=cython.Py_ssize_t, first=cython.Py_ssize_t, length=cython.Py_ssize_t)
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, j=cython.Py_ssize_t, best=cython.Py_ssize_t)
    for v in range(full_rows):
        cuts[p, v] = 0
        cuts[p, full_rows + v] = cython.cast(cython.ushort, full_columns)
    for u in range(full_columns):
        cuts[p, 2 * full_rows + u] = 0
        cuts[p, 2 * full_rows + full_columns + u] = cython.cast(cython.ushort, full_rows)
    for side in range(4):
        if not bands[5 + side]:
            continue
        upright = side == 0 or side == 2
        first = top if upright else left
        length = bottom - top if upright else right - left
        for i in range(length):
            for k in range(depth):
                if upright:
                    v = top + i
                    u = left + k if side == 0 else right - 1 - k
                else:
                    u = left + i
                    v = top + k if side == 1 else bottom - 1 - k
                cost[i, k] = 0
                weight = layout.weights[0, v, u]
                if weight == 0:
                    cost[i, k] = OUTSIDE
                elif weight < 256:
                    cost[i, k] = pixel_difference(
                        canvas, (y + v) % canvas.shape[0], (x + u) % canvas.shape[1],
                        pixels, source_y + v, source_x + u,
                    )  # fmt: skip
                if i > 0:
                    least = cost[i - 1, k]
                    if k > 0 and cost[i - 1, k - 1] < least:
                        least = cost[i - 1, k - 1]
                    if k + 1 < depth and cost[i - 1, k + 1] < least:
                        least = cost[i - 1, k + 1]
                    cost[i, k] += least
        best = 0
        for k in range(1, depth):
            if cost[length - 1, k] < cost[length - 1, best]:
                best = k
        for j in range(length):
            i = length - 1 - j
            if j > 0:
                k = best
                if k > 0 and cost[i, k - 1] <= cost[i, best]:
                    best = k - 1
                if k + 1 < depth and cost[i, k + 1] < cost[i, best]:
                    best = k + 1
            if side == 0:
                cuts[p, first + i] = cython.cast(cython.ushort, left + best)
            elif side == 1:
                cuts[p, 2 * full_rows + first + i] = cython.cast(cython.ushort, top + best)
            elif side == 2:
                cuts[p, full_rows + first + i] = cython.cast(cython.ushort, right - best)
            else:
                cuts[p, 2 * full_rows + full_columns + first + i] = cython.cast(
                    cython.ushort, bottom - best
                )


def find_cuts(canvas, pixels, layout: Layout, bands, p, cost, cuts):
    """Fill row `p` of `cuts` with the minimum-error paths of one patch."""
    cut_bands(canvas, pixels, layout, bands, p, cost, cuts)
