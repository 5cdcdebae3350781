# mypy: ignore-errors
"""Kernels that follow the sources of neighbors; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.weftex.search.vocabulary_kernels import Picture, Query, Sample
from cython.cimports.weftex.search.window_kernels import usable_place


def coherent_places(picture, sample, y, x, query, places, count):
    """List the continued sources of (y, x)'s neighbors after `count` places; return the length.

    Neighbors are the pixels of the query's runs, last run first; each place is listed once, and -1
    once for all unusable ones. Runs reach no further along x than windows, so no row is left.
    """
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, across=cython.Py_ssize_t)
    cython.declare(size=cython.Py_ssize_t, may=cython.p_const_uchar, before=cython.Py_ssize_t)
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, dx=cython.Py_ssize_t)
    cython.declare(own=cython.Py_ssize_t, at=cython.Py_ssize_t)
    height, width = picture.source.shape[0], picture.source.shape[1]
    across = sample.usable.shape[1]
    size = sample.usable.shape[0] * across
    may = cython.address(sample.usable[0, 0])
    before = -1 - size
    for r in range(query.count - 1, -1, -1):
        cy = y + query.runs[r, 0]
        if cy < 0:
            cy += height
        elif cy >= height:
            cy -= height
        for i in range(query.runs[r, 2] - 1, -1, -1):
            dx = query.runs[r, 1] + i
            cx = x + dx
            if cx < 0:
                cx += width
            elif cx >= width:
                cx -= width
            own = picture.source[cy, cx]
            at = own - query.runs[r, 0] * across - dx
            if own < 0 or at == before:
                continue
            before = at
            if at < 0 or at >= size or not may[at]:
                at = -1
                if sample.period[2]:
                    at = usable_place(
                        sample.usable,
                        sample.period,
                        own // across - query.runs[r, 0],
                        own % across - dx,
                    )
            k = 0
            while k < count and places[k] != at:
                k += 1
            if k == count:
                places[count] = cython.cast(cython.int, at)
                count += 1
    return count


def places_at(picture: Picture, sample: Sample, y, x, query: Query, n, places):
    """`coherent_places` for the first `n` runs of a query; returns their number."""
    out: cython.int[::1] = places
    query.count = n
    return coherent_places(picture, sample, y, x, query, out, 0)
