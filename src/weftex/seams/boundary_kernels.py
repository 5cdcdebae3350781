# mypy: ignore-errors
"""Kernels that find the least boundary between the pixels of a band; see setup.py and the .pxd."""

import cython

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any boundary costs


class Band:
    """The costs of a band: `error` (lines, depth), `beyond` (lines or 0, depth + 1) of crossings.

    `total`, `came` are scratch; `path` (lines,) receives the boundary.
    """

    def __init__(self, error, beyond, total, came, path):
        self.error, self.beyond, self.total, self.came = error, beyond, total, came
        self.path = path


def least_boundary(band, length, depth, begin, end):
    """Find the cheapest boundary along a band between two given positions.

    Line i belongs to one side up to path[i]. The pixels on both sides of each piece count, also
    where it crosses lines; it moves one position a line, and can always reach both ends.
    """
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, low=cython.Py_ssize_t)
    cython.declare(high=cython.Py_ssize_t, left=cython.longlong)
    for k in range(depth + 1):
        band.total[0, k] = NEVER
    band.total[0, begin] = 0
    band.came[0, begin] = cython.cast(cython.int, begin)
    for i in range(1, length):
        low = max(1, begin - i, end - (length - 1 - i))
        high = min(depth - 1, begin + i, end + (length - 1 - i))
        for k in range(depth + 1):
            band.total[i, k] = band.total[i - 1, k]
            band.came[i, k] = cython.cast(cython.int, k)
        for k in range(1, depth + 1):  # across to the right, then to the left
            if band.total[i, k - 1] < NEVER:
                left = band.total[i, k - 1]
                left += band.error[i - 1, k - 1] + band.error[i, k - 1]
                if left < band.total[i, k]:
                    band.total[i, k] = left
                    band.came[i, k] = band.came[i, k - 1]
        for k in range(depth - 1, -1, -1):
            if band.total[i, k + 1] < NEVER:
                left = band.total[i, k + 1] + band.error[i - 1, k] + band.error[i, k]
                if left < band.total[i, k]:
                    band.total[i, k] = left
                    band.came[i, k] = band.came[i, k + 1]
        for k in range(depth + 1):
            if k < low or k > high:
                band.total[i, k] = NEVER
            elif band.total[i, k] < NEVER:
                band.total[i, k] += band.error[i, k - 1] + band.error[i, k]
                if band.beyond.shape[0]:
                    band.total[i, k] += band.beyond[i, k]
    k = end
    for i in range(length - 1, -1, -1):
        band.path[i] = cython.cast(cython.int, k)
        k = band.came[i, k]


def boundary_through(band: Band, begin, end):
    """Fill `band.path` with the least boundary through a whole band."""
    least_boundary(band, band.error.shape[0], band.error.shape[1], begin, end)
