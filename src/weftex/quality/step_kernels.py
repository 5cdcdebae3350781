# mypy: ignore-errors
"""Kernels that predict steps from those beside them; compiled by Cython, see setup.py.

Sums are taken in one order, without fused products, so they are the same on every machine.
"""

import cython
from cython.cimports.libc.math import sqrt


def beside(
    steps: cython.const[cython.float][:, ::1],
    places: cython.const[cython.longlong][::1],
    shifts: cython.const[cython.longlong][::1],
    out: cython.double[:, ::1],
    gram: cython.double[:, ::1],
):
    """Gather the steps at some shifts from each place, and the sums of their products.

    Parameters
    ----------
    steps : float32 array (H, W)
    places : int64 array (n,)
        Flat indices.
    shifts : int64 array (k,)
        What is added to these.
    out : float64 array (n, k)
    gram : float64 array (k, k)
        Zeros, to which products are added.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(row=cython.p_double, sums=cython.p_double, one=cython.double)
    cython.declare(here=cython.p_const_float)
    number: cython.Py_ssize_t = shifts.shape[0]
    with cython.nogil:
        for i in range(places.shape[0]):
            row = cython.address(out[i, 0])
            here = cython.address(steps[0, 0]) + places[i]
            for k in range(number):
                row[k] = here[shifts[k]]
            for j in range(number):
                one = row[j]
                sums = cython.address(gram[j, 0])
                for k in range(number):
                    sums[k] += one * row[k]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def between(
    x: cython.double,
    knots: cython.const[cython.double][::1],
    values: cython.const[cython.double][::1],
) -> cython.double:
    """The value at x of lines from knot to knot, as `numpy.interp` has it."""
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
    """Say how far steps are from what is predicted, over what is usual; means down the columns.

    Parameters
    ----------
    steps : float32 array (H, W)
    shifts : int64 array (k,)
        Where the steps that predict one lie, as differences of flat indices.
    weights : float32 array (k,)
        Of these.
    knots, usual : float64 arrays (n,)
        The mean square of the steps beside, and the usual square of the error there.
    top, side : int
        Rows above and below, and columns to either side, whose steps are not predicted.
    left : float32 array (2, W - 2 * side)
        Scratch.
    sums : float64 array (m, W - 2 * side)
        Scratch, of zeros; m rows are averaged.
    out : float32 array (H - 2 * top - m + 1, W - 2 * side)
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
            # Sums of all rows so far, less those of so many rows ago.
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
