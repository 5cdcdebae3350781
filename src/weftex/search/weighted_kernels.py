# mypy: ignore-errors
"""Kernels that compare what is known around a pixel with weights; compiled by Cython, see setup.py.

The distance is a sum of w d**2 over known pixels, w from 1 to 127, in integers. What is known lies
in rows as long as the window, with the weight 0 where nothing is known, so that no loop has holes.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.window_kernels import known_runs


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look(
    levels: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    weights: cython.const[cython.short][:, ::1],
    stride: cython.Py_ssize_t,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    known: cython.short[::1],
    rows: cython.int[::1],
) -> cython.longlong:
    """Copy what is known around a pixel of the canvas, with its weights; return their sum.

    `rows` receives the number of rows with anything known, and which they are, the nearest first.
    """
    height: cython.Py_ssize_t = done.shape[0]
    width: cython.Py_ssize_t = done.shape[1]
    channels: cython.Py_ssize_t = levels.shape[2]
    reach: cython.Py_ssize_t = weights.shape[0] // 2
    n: cython.Py_ssize_t = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
    r: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    row: cython.Py_ssize_t
    column: cython.Py_ssize_t
    at: cython.Py_ssize_t
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    count: cython.int = 0
    total: cython.longlong = 0
    memset(cython.address(known[0]), 0, cython.cast(cython.size_t, known.shape[0]) * 2)
    for r in range(n):
        row = runs[r, 0] + reach
        column = runs[r, 1] + reach
        cy = y + runs[r, 0]
        cy = cy + height if cy < 0 else (cy - height if cy >= height else cy)
        cx = x + runs[r, 1]
        cx = cx + width if cx < 0 else (cx - width if cx >= width else cx)
        at = row * stride + column * channels
        for i in range(runs[r, 2]):
            total += weights[row, column + i]
            for k in range(channels):
                query[at] = levels[cy, cx, k]
                known[at] = weights[row, column + i]
                at += 1
            cx = cx + 1 if cx + 1 < width else 0
    # The runs are sorted by row: take them from the middle outwards.
    last = 0
    while last < n and runs[last, 0] < 0:
        last += 1
    first = last - 1
    while first >= 0 or last < n:
        if last < n and (first < 0 or runs[last, 0] <= -runs[first, 0]):
            r = last
            last += 1
        else:
            r = first
            first -= 1
        row = runs[r, 0] + reach
        if count == 0 or rows[count] != row:
            count += 1
            rows[count] = cython.cast(cython.int, row)
    rows[0] = count
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def weighted(
    a: cython.p_const_uchar, b: cython.p_const_uchar, w: cython.p_const_short, n: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of w d**2 of two rows of bytes."""
    i: cython.Py_ssize_t
    stop: cython.Py_ssize_t
    start: cython.Py_ssize_t = 0
    d: cython.short
    e: cython.short
    part: cython.int
    total: cython.longlong = 0
    while start < n:
        stop = start + 256 if start + 256 < n else n  # 256 * 127 * 255**2 < 2**31
        part = 0
        for i in range(start, stop):
            d = cython.cast(cython.short, a[i]) - cython.cast(cython.short, b[i])
            e = w[i] * d  # 127 * 255 < 2**15
            part += cython.cast(cython.int, e) * d
        total += part
        start = stop
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def window_distance(
    flat: cython.const[cython.uchar][::1],
    place: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    channels: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    stride: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    known: cython.const[cython.short][::1],
    rows: cython.const[cython.int][::1],
    bound: cython.longlong,
) -> cython.longlong:
    """Distance to the window at a flat index; stops past `bound` (negative: never)."""
    r: cython.Py_ssize_t
    row: cython.Py_ssize_t
    total: cython.longlong = 0
    for r in range(1, rows[0] + 1):
        row = rows[r]
        total += weighted(
            cython.address(flat[(place + (row - reach) * width - reach) * channels]),
            cython.address(query[row * stride]),
            cython.address(known[row * stride]),
            stride,
        )
        if total > bound and bound >= 0:
            break
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def limit_of(best: cython.longlong, tolerance: cython.double) -> cython.longlong:
    """The largest distance within (1 + tolerance) of the best."""
    return cython.cast(cython.longlong, cython.cast(cython.double, best) * (1 + tolerance))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def draw_one(
    found: cython.int[::1],
    distances: cython.longlong[::1],
    count: cython.Py_ssize_t,
    limit: cython.longlong,
    bits: cython.ulonglong,
) -> cython.Py_ssize_t:
    """Index of one of the windows found whose distance is within the limit, each as likely."""
    j: cython.Py_ssize_t
    kept: cython.Py_ssize_t = 0
    for j in range(count):
        if distances[j] <= limit:
            found[kept] = found[j]
            distances[kept] = distances[j]
            kept += 1
    return cython.cast(
        cython.Py_ssize_t, ((bits >> 32) * cython.cast(cython.ulonglong, kept)) >> 32
    )
