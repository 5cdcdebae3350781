# mypy: ignore-errors
"""Kernel that projects a window of the canvas on components; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def run_coordinates(
    runs: cython.const[cython.int][:, ::1],
    n: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    mean: cython.const[cython.uchar][::1],
    basis: cython.const[cython.short][:, :, ::1],
    level: cython.const[cython.longlong][::1],
    offset: cython.const[cython.int][::1],
    shift: cython.int,
    difference: cython.short[::1],
    totals: cython.longlong[::1],
    features: cython.short[::1],
) -> cython.void:
    """Coordinates of a window of which the runs are known, rounded as `WindowComponents` does.

    The rest is taken to differ from the mean colour, along each component, as what is known.
    """
    channels: cython.Py_ssize_t = mean.shape[0]
    reach: cython.Py_ssize_t = (basis.shape[0] - 1) // 2
    whole: cython.Py_ssize_t = basis.shape[0] * basis.shape[0] * channels - channels
    row: cython.p_const_short
    r: cython.Py_ssize_t
    d: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    length: cython.Py_ssize_t
    at: cython.Py_ssize_t = 0
    total: cython.int
    value: cython.longlong
    rise: cython.longlong
    for d in range(totals.shape[0]):
        totals[d] = 0
    for r in range(n):
        length = runs[r, 2] * channels
        k = 0
        for i in range(length):
            difference[i] = cython.cast(
                cython.short, cython.cast(cython.short, query[at + i]) - mean[k]
            )
            k = k + 1 if k + 1 < channels else 0
        for d in range(totals.shape[0]):
            row = cython.address(basis[runs[r, 0] + reach, d, (runs[r, 1] + reach) * channels])
            total = 0
            for i in range(length):  # components are 2000 long, so no sum passes 2**31
                total += cython.cast(cython.int, row[i]) * difference[i]
            totals[d] += total
        at += length
    rise = whole * 256 // at if at else 0
    for d in range(totals.shape[0]):
        value = ((totals[d] * rise + 128) >> 8) + level[d] - offset[d]
        value = (value + ((1 << shift) >> 1)) >> shift
        features[d] = cython.cast(
            cython.short, -4095 if value < -4095 else 4095 if value > 4095 else value
        )


def coordinates_of_runs(
    runs, n, query, mean, basis, level, offset, shift, difference, totals, features
):
    """`run_coordinates`."""
    ru: cython.const[cython.int][:, ::1] = runs
    qu: cython.const[cython.uchar][::1] = query
    me: cython.const[cython.uchar][::1] = mean
    ba: cython.const[cython.short][:, :, ::1] = basis
    le: cython.const[cython.longlong][::1] = level
    of: cython.const[cython.int][::1] = offset
    di: cython.short[::1] = difference
    to: cython.longlong[::1] = totals
    fe: cython.short[::1] = features
    run_coordinates(ru, n, qu, me, ba, le, of, shift, di, to, fe)
