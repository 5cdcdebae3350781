# mypy: ignore-errors
# cython: infer_types=True
"""Kernel that finds the windows of a sample that look alike; compiled, see setup.py."""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared


def near(step, apart):
    """Whether two places are at most `apart` from each other along an axis."""
    return -apart <= step <= apart


def nearest_windows(
    pixels: cython.const[cython.uchar][:, :, ::1],
    queries: cython.const[cython.int][::1],
    candidates: cython.const[cython.int][:, ::1],
    reach: cython.Py_ssize_t,
    apart: cython.Py_ssize_t,
    best: cython.longlong[::1],
    out: cython.int[:, ::1],
):
    """Fill rows of `out` with the windows most similar to each query's, nearest first, -1 for none.

    `candidates` has one row for each query, or one for all. None lies within `apart` of the query
    or of a better one. `best` is scratch for one row's distances.
    """
    cython.declare(count=cython.Py_ssize_t, d=cython.longlong)
    columns, wanted = pixels.shape[1], out.shape[1]
    length = (2 * reach + 1) * pixels.shape[2]
    with cython.nogil:
        for i in range(queries.shape[0]):
            y, x = queries[i] // columns, queries[i] % columns
            row = i if candidates.shape[0] > 1 else 0
            count = 0
            for j in range(candidates.shape[1]):
                if candidates[row, j] < 0:
                    continue
                v, u = candidates[row, j] // columns, candidates[row, j] % columns
                if near(v - y, apart) and near(u - x, apart):
                    continue
                d = 0
                for r in range(-reach, reach + 1):
                    d += squared(
                        cython.address(pixels[y + r, x - reach, 0]),
                        cython.address(pixels[v + r, u - reach, 0]),
                        length,
                    )
                    if count == wanted and d >= best[wanted - 1]:
                        break
                if count == wanted and d >= best[wanted - 1]:
                    continue
                k = 0
                while k < count and not (
                    near(out[i, k] // columns - v, apart) and near(out[i, k] % columns - u, apart)
                ):
                    k += 1
                if k < count:
                    if d >= best[k]:
                        continue
                else:
                    if count < wanted:
                        count += 1
                    k = count - 1
                while k > 0 and best[k - 1] > d:
                    best[k] = best[k - 1]
                    out[i, k] = out[i, k - 1]
                    k -= 1
                best[k] = d
                out[i, k] = candidates[row, j]
            for k in range(count, wanted):
                out[i, k] = -1
