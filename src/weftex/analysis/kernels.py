# mypy: ignore-errors
"""Kernel that finds peaks near places; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def offset(before: cython.double, top: cython.double, after: cython.double) -> cython.double:
    """Where a parabola through three values is highest, from -1/2 to 1/2."""
    return min(max(0.5 * (before - after) / min(before - 2 * top + after, -1e-12), -0.5), 0.5)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def inside(at: cython.Py_ssize_t, side: cython.Py_ssize_t) -> cython.Py_ssize_t:
    return min(max(at, 0), side - 1)


def tops(
    correlation: cython.const[cython.double][:, ::1],
    places: cython.const[cython.longlong][:, ::1],
    window: cython.Py_ssize_t,
    found: cython.double[:, ::1],
    heights: cython.double[::1],
):
    """Find the peak within a window around each shift, below a pixel."""
    cython.declare(i=cython.Py_ssize_t, v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, b=cython.Py_ssize_t)
    cython.declare(a=cython.Py_ssize_t, top=cython.double, left=cython.double)
    cython.declare(right=cython.double, above=cython.double, below=cython.double)
    rows: cython.Py_ssize_t = correlation.shape[0]
    columns: cython.Py_ssize_t = correlation.shape[1]
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i, 1] + rows // 2
            x = places[i, 0] + columns // 2
            b = y - window
            a = x - window
            top = correlation[inside(b, rows), inside(a, columns)]
            for v in range(y - window, y + window + 1):
                for u in range(x - window, x + window + 1):
                    if correlation[inside(v, rows), inside(u, columns)] > top:
                        top = correlation[inside(v, rows), inside(u, columns)]
                        b = v
                        a = u
            left = correlation[inside(b, rows), inside(a - 1, columns)]
            right = correlation[inside(b, rows), inside(a + 1, columns)]
            above = correlation[inside(b - 1, rows), inside(a, columns)]
            below = correlation[inside(b + 1, rows), inside(a, columns)]
            found[i, 0] = a - columns // 2 + offset(left, top, right)
            found[i, 1] = b - rows // 2 + offset(above, top, below)
            heights[i] = 0
            if top >= max(left, right) and top >= max(above, below) and top > 0:
                heights[i] = top
