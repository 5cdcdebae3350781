# mypy: ignore-errors
"""Kernels of the figures: connected pieces, and the prediction of steps; see setup.py.

Sums are taken in one order, without fused products, so they are the same on every machine.
"""

import cython
from cython.cimports.libc.math import sqrt


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def root(parents: cython.p_int, i: cython.int) -> cython.int:
    """Return the first pixel that a pixel is known to be connected with."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def join(parents: cython.p_int, i: cython.int, j: cython.int) -> cython.void:
    i = root(parents, i)
    j = root(parents, j)
    if i < j:
        parents[j] = i
    else:
        parents[i] = j


def number_pieces(
    shift: cython.const[cython.int][:, :, ::1],
    known: cython.const[cython.uchar][:, ::1],
    names: cython.int[:, ::1],
) -> cython.Py_ssize_t:
    """Number the connected areas of one shift in the order of their first pixels.

    A pixel that is not known is an area of its own. Returns how many areas there are.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.int, count=cython.int)
    width: cython.int = cython.cast(cython.int, shift.shape[1])
    size: cython.int = cython.cast(cython.int, shift.shape[0] * shift.shape[1])
    parents: cython.p_int = cython.address(names[0, 0])
    count = 0
    with cython.nogil:
        for i in range(size):
            parents[i] = i
        for y in range(shift.shape[0]):
            for x in range(shift.shape[1]):
                if not known[y, x]:
                    continue
                i = cython.cast(cython.int, y * width + x)
                if (
                    x > 0
                    and known[y, x - 1]
                    and shift[y, x, 0] == shift[y, x - 1, 0]
                    and shift[y, x, 1] == shift[y, x - 1, 1]
                ):
                    join(parents, i - 1, i)
                if (
                    y > 0
                    and known[y - 1, x]
                    and shift[y, x, 0] == shift[y - 1, x, 0]
                    and shift[y, x, 1] == shift[y - 1, x, 1]
                ):
                    join(parents, i - width, i)
        # A pixel's parent is never after it, so it has its number already.
        for i in range(size):
            if parents[i] == i:
                parents[i] = count
                count += 1
            else:
                parents[i] = parents[parents[i]]
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def between(
    x: cython.double,
    knots: cython.const[cython.double][::1],
    values: cython.const[cython.double][::1],
) -> cython.double:
    """Return the value at x of lines from knot to knot, as `numpy.interp` does."""
    cython.declare(low=cython.Py_ssize_t, high=cython.Py_ssize_t, k=cython.Py_ssize_t)
    high = knots.shape[0] - 1
    if x <= knots[0]:
        return values[0]
    if x >= knots[high]:
        return values[high]
    low = 0  # knots[low] <= x < knots[high]
    while high - low > 1:
        k = (low + high) // 2
        if x < knots[k]:
            high = k
        else:
            low = k
    return (values[high] - values[low]) / (knots[high] - knots[low]) * (x - knots[low]) + values[
        low
    ]


def surprise(
    steps: cython.const[cython.float][:, ::1],
    shifts: cython.const[cython.longlong][::1],
    weights: cython.const[cython.float][::1],
    knots: cython.const[cython.double][::1],
    usual: cython.const[cython.double][::1],
    top: cython.Py_ssize_t,
    side: cython.Py_ssize_t,
    left: cython.float[:, ::1],
    sums: cython.double[:, ::1],
    out: cython.float[:, ::1],
):
    """Write the prediction errors of steps over the usual ones, averaged down the columns.

    `shifts` are flat offsets of the k steps that predict one, `weights` theirs; `knots` and
    `usual` (n,) the mean square of those steps, and the usual squared error there. `top` rows and
    `side` columns at the borders are not predicted. `left` (2, W - 2 * side) and `sums` (m, W - 2
    * side), zeros, are scratch; m rows are averaged.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(here=cython.p_const_float, weight=cython.float, step=cython.float)
    cython.declare(total=cython.double, sum_before=cython.double, off=cython.float)
    cython.declare(before=cython.p_double, last=cython.p_double)
    rows: cython.Py_ssize_t = steps.shape[0] - 2 * top
    columns: cython.Py_ssize_t = out.shape[1]
    number: cython.float = shifts.shape[0]
    pooled: cython.Py_ssize_t = sums.shape[0]
    activity: cython.p_float = cython.address(left[1, 0])
    error: cython.p_float = cython.address(left[0, 0])
    with cython.nogil:
        for y in range(rows):
            here = cython.address(steps[top + y, side])
            for x in range(columns):
                error[x] = here[x]
                activity[x] = 0
            for k in range(shifts.shape[0]):
                here = cython.address(steps[top + y, side]) + shifts[k]
                weight = weights[k]
                for x in range(columns):
                    step = here[x]
                    error[x] -= weight * step
                    activity[x] += step * step
            # The sum of all rows so far, less that of `pooled` rows ago.
            last = cython.address(sums[y % pooled, 0])
            before = cython.address(sums[(y + 1) % pooled, 0])
            for x in range(columns):
                off = error[x] * error[x]
                off = cython.cast(
                    cython.float, sqrt(off / between(activity[x] / number, knots, usual))
                )
                total = last[x] + off
                sum_before = before[x]
                before[x] = total
                if y + 1 >= pooled:
                    out[y + 1 - pooled, x] = cython.cast(
                        cython.float, (total - sum_before) / pooled
                    )
