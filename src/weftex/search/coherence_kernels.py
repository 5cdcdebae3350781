# mypy: ignore-errors
"""Kernels that follow the sources of neighbors; compiled by Cython, see setup.py.

Types are declared in coherence_kernels.pxd.
"""

import cython
from cython.cimports.weftex.search.window_kernels import usable_place


def coherent_places(source, y, x, runs, n, usable, period, places, count):
    """List where the neighbors' sources go on at (y, x), after the `count` places already listed.

    The neighbors are the pixels of the runs, from the last to the first. Each place is listed
    once; -1 stands once for all places that no window may be centered at, where the first of them
    was met. The runs reach no further along x than the windows do, so a step along a row of the
    sample never ends in a usable place of another row. Returns the length of the list.
    """
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, across=cython.Py_ssize_t)
    cython.declare(size=cython.Py_ssize_t, may=cython.p_const_uchar, before=cython.Py_ssize_t)
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, dx=cython.Py_ssize_t)
    cython.declare(own=cython.Py_ssize_t, at=cython.Py_ssize_t)
    height, width = source.shape[0], source.shape[1]
    across = usable.shape[1]
    size = usable.shape[0] * across
    may = cython.address(usable[0, 0])
    before = -1 - size
    for r in range(n - 1, -1, -1):
        cy = y + runs[r, 0]
        if cy < 0:
            cy += height
        elif cy >= height:
            cy -= height
        for i in range(runs[r, 2] - 1, -1, -1):
            dx = runs[r, 1] + i
            cx = x + dx
            if cx < 0:
                cx += width
            elif cx >= width:
                cx -= width
            own = source[cy, cx]
            at = own - runs[r, 0] * across - dx
            if own < 0 or at == before:
                continue
            before = at
            if at < 0 or at >= size or not may[at]:
                at = -1
                if period[2]:
                    at = usable_place(usable, period, own // across - runs[r, 0], own % across - dx)
            k = 0
            while k < count and places[k] != at:
                k += 1
            if k == count:
                places[count] = cython.cast(cython.int, at)
                count += 1
    return count


def places_at(source, y, x, runs, n, usable, period, places):
    """`coherent_places`; returns their number."""
    s: cython.const[cython.int][:, ::1] = source
    r: cython.const[cython.int][:, ::1] = runs
    u: cython.const[cython.uchar][:, ::1] = usable
    p: cython.const[cython.int][::1] = period
    out: cython.int[::1] = places
    return coherent_places(s, y, x, r, n, u, p, out, 0)
