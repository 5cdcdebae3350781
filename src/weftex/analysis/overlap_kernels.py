# mypy: ignore-errors
"""Kernels that normalize a picture's correlation with itself; compiled by Cython, see setup.py.

Sums are taken in one order, without fused products, so they are the same on every machine.
"""

import cython
from cython.cimports.libc.math import sqrt


def overlap_sums(
    level: cython.const[cython.double][:, ::1],
    rows: cython.const[cython.longlong][:, ::1],
    columns: cython.const[cython.longlong][:, ::1],
    down: cython.double[:, :, ::1],
    along: cython.double[:, ::1],
    sums: cython.double[:, ::1],
    squares: cython.double[:, ::1],
) -> cython.double:
    """Add up values and their squares over what overlaps at each shift."""
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(j=cython.Py_ssize_t, one=cython.double, first=cython.Py_ssize_t)
    cython.declare(last=cython.Py_ssize_t, most=cython.double)
    width: cython.Py_ssize_t = level.shape[1]
    most = 0
    with cython.nogil:
        for x in range(width):
            down[0, 0, x] = 0
            down[1, 0, x] = 0
        for y in range(level.shape[0]):
            for x in range(width):
                one = level[y, x]
                down[0, y + 1, x] = down[0, y, x] + one
                down[1, y + 1, x] = down[1, y, x] + one * one
        along[0, 0] = 0
        along[1, 0] = 0
        for i in range(rows.shape[0]):
            first = rows[i, 0]
            last = rows[i, 1]
            for x in range(width):
                along[0, x + 1] = along[0, x] + (down[0, last, x] - down[0, first, x])
                along[1, x + 1] = along[1, x] + (down[1, last, x] - down[1, first, x])
            for j in range(columns.shape[0]):
                sums[i, j] = along[0, columns[j, 1]] - along[0, columns[j, 0]]
                squares[i, j] = along[1, columns[j, 1]] - along[1, columns[j, 0]]
                most = max(most, squares[i, j])
    return most


def add_channel(
    sums: cython.const[cython.double][:, ::1],
    squares: cython.double[:, ::1],
    high: cython.const[cython.double][::1],
    wide: cython.const[cython.double][::1],
    least: cython.double,
    above: cython.double[:, ::1],
    below: cython.double[:, ::1],
):
    """Add what a channel has of the numerator, but for its products, and of the denominator."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, count=cython.double)
    cython.declare(one=cython.double)
    rows: cython.Py_ssize_t = sums.shape[0]
    columns: cython.Py_ssize_t = sums.shape[1]
    with cython.nogil:
        for i in range(rows):
            for j in range(columns):
                count = high[i] * wide[j]
                one = count * squares[i, j] - sums[i, j] * sums[i, j]
                squares[i, j] = one if one > least * count else 0
        for i in range(rows):
            for j in range(columns):
                above[i, j] -= sums[i, j] * sums[rows - 1 - i, columns - 1 - j]
                below[i, j] += sqrt(squares[i, j] * squares[rows - 1 - i, columns - 1 - j])


def divide(
    above: cython.double[:, ::1],
    below: cython.const[cython.double][:, ::1],
    high: cython.const[cython.double][::1],
    wide: cython.const[cython.double][::1],
    products: cython.const[cython.double][:, ::1],
):
    """Turn numerators without their products into coefficients from -1 to 1."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, y=cython.Py_ssize_t)
    cython.declare(x=cython.Py_ssize_t, one=cython.double)
    middle: cython.Py_ssize_t = above.shape[0] // 2
    center: cython.Py_ssize_t = above.shape[1] // 2
    with cython.nogil:
        for i in range(above.shape[0]):
            y = i - middle if i >= middle else products.shape[0] + i - middle
            for j in range(above.shape[1]):
                x = j - center if j >= center else products.shape[1] + j - center
                one = 0
                if below[i, j] > 0:
                    one = (above[i, j] + high[i] * wide[j] * products[y, x]) / below[i, j]
                above[i, j] = min(max(one, -1), 1)
