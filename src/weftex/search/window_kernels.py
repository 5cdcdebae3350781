# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that compare the windows around two pixels.

A window is a list of runs (dy, dx, length): stretches of a row, seen from its center. All
distances are sums of squared differences of bytes, so any order of summation gives the same.
Compiled by Cython, see setup.py and the .pxd.
"""

import cython
from cython.cimports.libc.string import memcpy
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.search.picture_kernels import around


def causal_runs(y, x, width, wrap_x, up, left, right, runs):
    """Write the L-shaped window of a pixel on the canvas in scan order; return the number of runs.

    Where the canvas wraps along x the rows above are whole, and the end of a row includes its
    beginning. No pixel occurs twice.
    """
    n = 0
    for dy in range(-up if up < y else -y, 1):
        first = -left
        last = right if dy < 0 else -1
        if wrap_x and dy < 0:
            if last - first + 1 > width:
                first = -((width - 1) // 2) if left > (width - 1) // 2 else -left
                last = first + width - 1
        else:
            if first < -x:
                first = -x
            if last > width - 1 - x:
                last = width - 1 - x
        if first <= last:
            runs[n, 0], runs[n, 1], runs[n, 2] = dy, first, last - first + 1
            n += 1
    if wrap_x:
        first = width - x
        last = width - 1 - (left if left < x else x)
        if last > right:
            last = right
        if x > 0 and first <= last:
            runs[n, 0], runs[n, 1], runs[n, 2] = 0, first, last - first + 1
            n += 1
    return n


def turn_runs(runs, n):
    """Put the last run first, so that comparisons begin beside the pixel and end sooner."""
    for i in range(n // 2):
        for k in range(3):
            runs[i, k], runs[n - 1 - i, k] = runs[n - 1 - i, k], runs[i, k]


def gather_runs(levels, y, x, runs, n, query):
    """Copy the bytes of a window of the canvas, around its borders; return their number."""
    cython.declare(left=cython.Py_ssize_t, at=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    height, width, channels = levels.shape[0], levels.shape[1], levels.shape[2]
    at = 0
    for r in range(n):
        cy, cx = around(y + runs[r, 0], height), around(x + runs[r, 1], width)
        left = runs[r, 2]
        while left > 0:
            part = min(left, width - cx)
            memcpy(cython.address(query[at]), cython.address(levels[cy, cx, 0]), part * channels)
            at += part * channels
            left -= part
            cx = 0
    return at


def run_distance(pixels, y, x, runs, n, query, bound):
    """Return the sum of squared differences to the window of the sample at (y, x).

    Stops past `bound` unless that is negative. Rows nearest to the pixel differ most in a causal
    window, so they are compared first.
    """
    cython.declare(at=cython.Py_ssize_t, total=cython.longlong)
    channels = pixels.shape[2]
    at = 0
    total = 0
    for r in range(n):
        at += runs[r, 2] * channels
    for r in range(n - 1, -1, -1):
        length = runs[r, 2] * channels
        at -= length
        total += squared(
            cython.address(pixels[y + runs[r, 0], x + runs[r, 1], 0]),
            cython.address(query[at]),
            length,
        )
        if total > bound and bound >= 0:
            break
    return total


def copy_pixel(sample, place, pixels, source, y, x):
    """Copy the sample's pixel at a flat index to the pixel (y, x) of a canvas."""
    v, u = place // sample.shape[1], place % sample.shape[1]
    source[y, x] = place
    for k in range(sample.shape[2]):
        pixels[y, x, k] = sample[v, u, k]


def distances(
    pixels: cython.const[cython.uchar][:, :, ::1],
    centers: cython.const[cython.int][::1],
    runs: cython.const[cython.int][:, ::1],
    n: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    out: cython.longlong[::1],
):
    """Fill `out` with the distances of a window to those at `centers`, without a bound.

    This is the minimum cost of an exhaustive search, against which searches are measured.
    """
    width = pixels.shape[1]
    with cython.nogil:
        for i in range(centers.shape[0]):
            out[i] = run_distance(
                pixels, centers[i] // width, centers[i] % width, runs, n, query, -1
            )
