# cython: language_level=3
"""Kernels that find seams; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def band_error(
    canvas: cython.const[cython.uchar][:, :, ::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    cy: cython.Py_ssize_t,
    cx: cython.Py_ssize_t,
    sy: cython.Py_ssize_t,
    sx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels."""
    k: cython.Py_ssize_t
    d: cython.int
    total: cython.longlong = 0
    for k in range(canvas.shape[2]):
        d = cython.cast(cython.int, canvas[cy, cx, k]) - pixels[sy, sx, k]
        total += d * d
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut_bands(
    canvas: cython.const[cython.uchar][:, :, ::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    sy: cython.Py_ssize_t,
    sx: cython.Py_ssize_t,
    weights: cython.const[cython.ushort][:, :, ::1],
    bands: cython.const[cython.int][::1],
    cost: cython.longlong[:, ::1],
    cuts: cython.ushort[:, ::1],
    p: cython.Py_ssize_t,
) -> cython.void:
    """Find the minimum-error path along each band of the zone, by dynamic programming.

    `bands` is (depth, rows, columns, left, top, right, bottom): how deep a band is, the window's
    extent, and which sides have one. Ties go to the pixel nearest to the window's border. A pixel
    outside the zone costs nothing, for nothing is blended there. Row `p` of `cuts` is as `paste` reads it.
    """
    depth: cython.Py_ssize_t = bands[0]
    full_rows: cython.Py_ssize_t = weights.shape[1]
    full_columns: cython.Py_ssize_t = weights.shape[2]
    rows: cython.Py_ssize_t = bands[1]
    columns: cython.Py_ssize_t = bands[2]
    side: cython.Py_ssize_t
    length: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    j: cython.Py_ssize_t
    best: cython.Py_ssize_t
    least: cython.longlong
    upright: cython.bint
    for v in range(full_rows):
        cuts[p, v] = 0
        cuts[p, full_rows + v] = cython.cast(cython.ushort, full_columns)
    for u in range(full_columns):
        cuts[p, 2 * full_rows + u] = 0
        cuts[p, 2 * full_rows + full_columns + u] = cython.cast(cython.ushort, full_rows)
    for side in range(4):
        if not bands[3 + side]:
            continue
        upright = side == 0 or side == 2
        length = rows if upright else columns
        for i in range(length):
            for k in range(depth):
                if upright:
                    v = i
                    u = k if side == 0 else columns - 1 - k
                else:
                    u = i
                    v = k if side == 1 else rows - 1 - k
                cost[i, k] = 0
                if 0 < weights[0, v, u] < 256:
                    cost[i, k] = band_error(
                        canvas, pixels, (y + v) % canvas.shape[0], (x + u) % canvas.shape[1],
                        sy + v, sx + u,
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
                cuts[p, i] = cython.cast(cython.ushort, best)
            elif side == 1:
                cuts[p, 2 * full_rows + i] = cython.cast(cython.ushort, best)
            elif side == 2:
                cuts[p, full_rows + i] = cython.cast(cython.ushort, columns - best)
            else:
                cuts[p, 2 * full_rows + full_columns + i] = cython.cast(cython.ushort, rows - best)


def find_cuts(canvas, pixels, y, x, sy, sx, weights, bands, cost, cuts, p):
    """Fill row `p` of `cuts` with the minimum-error paths of one patch."""
    cut_bands(canvas, pixels, y, x, sy, sx, weights, bands, cost, cuts, p)
