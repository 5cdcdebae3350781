# mypy: ignore-errors
"""Kernel that finds the nearest of all windows; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.search.window_kernels import Query, run_distance
from cython.cimports.weftex.search.zone_kernels import distances_by_features, project


class Bound:
    """A `LowerBound`, and room for a window as numbers, its coordinates, and all distances."""

    def __init__(self, bound, query, coordinates, apart):
        components = bound.components
        self.basis, self.offset = components.basis, components.offset
        self.shift, self.features = components.shift, components.features
        self.length = bound.length
        self.query, self.coordinates, self.apart = query, coordinates, apart


class NearestWindows:
    """A `NearestSearch`."""

    def __init__(self, windows, reach, whole, above):
        self.pixels, self.centers, self.reach = windows.pixels, windows.centers, reach
        self.whole, self.above = whole, above


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def leading(search: NearestWindows, query: Query) -> cython.Py_ssize_t:
    """Pixels of a window, in scan order and without its middle, before the first unknown one."""
    cython.declare(r=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(pixels=cython.Py_ssize_t)
    y = -search.reach
    x = -search.reach
    pixels = 0
    for r in range(query.count):
        if query.runs[r, 0] != y or query.runs[r, 1] != x:
            break
        pixels += query.runs[r, 2]
        x += query.runs[r, 2]
        if y == 0 and x == 0:
            x = 1
        if x > search.reach:
            x = -search.reach
            y += 1
    return pixels


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def bound_all(bound: Bound, query: cython.const[cython.uchar][::1]) -> cython.void:
    """Find how far all windows are from one in coordinates, of which the first bytes are known."""
    cython.declare(i=cython.Py_ssize_t)
    for i in range(bound.query.shape[0]):
        bound.query[i] = query[i]
    project(bound.basis, bound.offset, bound.shift, bound.query, bound.coordinates)
    distances_by_features(bound.features, bound.coordinates, bound.apart)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def farthest(bound: Bound, distance: cython.longlong) -> cython.longlong:
    """Return the largest squared distance in coordinates of windows that are `distance` apart.

    Each window's coordinates are rounded by at most a half.
    """
    cython.declare(apart=cython.double)
    apart = bound.length * sqrt(cython.cast(cython.double, distance))
    apart += sqrt(cython.cast(cython.double, bound.features.shape[0])) + 1
    return cython.cast(cython.longlong, apart * apart)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest_within(
    search: NearestWindows, bound: Bound, bounded: cython.bint, query: Query,
    near: cython.const[cython.int][::1], near_count: cython.Py_ssize_t,
) -> cython.Py_ssize_t:  # fmt: skip
    """`nearest_window`, where `bounded` without those that are too far by their coordinates."""
    cython.declare(i=cython.Py_ssize_t, place=cython.Py_ssize_t, best=cython.Py_ssize_t)
    cython.declare(n=cython.Py_ssize_t, least=cython.longlong, distance=cython.longlong)
    cython.declare(limit=cython.longlong)
    columns: cython.Py_ssize_t = search.pixels.shape[1]
    if bounded:
        bound_all(bound, query.values)
    best = -1
    least = -1
    limit = 0
    for i in range(near_count + search.centers.shape[0]):
        n = i - near_count
        place = near[i] if n < 0 else search.centers[n]
        if place < 0 or (bounded and n >= 0 and best >= 0 and bound.apart[n] > limit):
            continue
        distance = run_distance(
            search.pixels,
            place // columns,
            place % columns,
            query.runs,
            query.count,
            query.values,
            least,
        )
        if best < 0 or distance < least or (distance == least and place < best):
            best = place
            if distance != least:
                least = distance
                limit = farthest(bound, least)
    return best


def nearest_window(search, query, near, near_count):
    """Return the nearest window to one that is partly known; of equals the first.

    The `near` windows, -1 for none, and those similar to them are compared first.
    """
    known: cython.Py_ssize_t = leading(search, query) * search.pixels.shape[2]
    if known >= search.whole.query.shape[0]:
        return nearest_within(search, search.whole, True, query, near, near_count)
    return nearest_within(
        search, search.above, known >= search.above.query.shape[0], query, near, near_count
    )


def nearest(search: NearestWindows, query: Query, count, near):
    """`nearest_window` from Python, for the first `count` runs of a query."""
    query.count = count
    return nearest_window(search, query, near, len(near))
