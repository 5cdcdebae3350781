# mypy: ignore-errors
# cython: infer_types=True
"""Kernel that finds the nearest of all windows; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.search.approximate_nearest_kernels import all_distances, project
from cython.cimports.weftex.search.window_kernels import run_distance


class NearestWindows:
    """The windows of a sample with a `LowerBound`, and scratch.

    That is a window as numbers, its coordinates, and its distances from all windows in these.
    """

    def __init__(self, windows, reach, bound, query, coordinates, apart):
        self.pixels, self.centers, self.reach = windows.pixels, windows.centers, reach
        components = bound.components
        self.basis, self.offset = components.basis, components.offset
        self.shift, self.features = components.shift, components.coordinates
        self.length = bound.length
        self.query, self.coordinates, self.apart = query, coordinates, apart


def leading(search, query):
    """Pixels of a window, in scan order and without its middle, before the first unknown one."""
    cython.declare(x=cython.Py_ssize_t, pixels=cython.Py_ssize_t)
    y = x = -search.reach
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


def bound_all(search, query):
    """Find how far all windows are from one in coordinates, of which the first bytes are known."""
    for i in range(search.query.shape[0]):
        search.query[i] = query[i]
    project(search.basis, search.offset, search.shift, search.query, search.coordinates)
    all_distances(search.features, search.coordinates, search.apart)


def farthest(search, distance):
    """Return the largest squared distance in coordinates of windows that are `distance` apart.

    Each window's coordinates are rounded by at most a half.
    """
    apart: cython.double = search.length * sqrt(cython.cast(cython.double, distance))
    apart += sqrt(cython.cast(cython.double, search.features.shape[0])) + 1
    return cython.cast(cython.longlong, apart * apart)


def nearest_within(search, bounded, query, near, near_count):
    """`nearest_window`; where `bounded`, without windows whose coordinates are too far."""
    cython.declare(best=cython.Py_ssize_t, least=cython.longlong, limit=cython.longlong)
    columns = search.pixels.shape[1]
    if bounded:
        bound_all(search, query.values)
    best = least = -1
    limit = 0
    for i in range(near_count + search.centers.shape[0]):
        n = i - near_count
        place = near[i] if n < 0 else search.centers[n]
        if place < 0 or (bounded and n >= 0 and best >= 0 and search.apart[n] > limit):
            continue
        y, x = place // columns, place % columns
        distance = run_distance(search.pixels, y, x, query.runs, query.count, query.values, least)
        if best < 0 or distance < least or (distance == least and place < best):
            best = place
            if distance != least:
                least = distance
                limit = farthest(search, least)
    return best


def nearest_window(whole, above, query, near, near_count):
    """Return the nearest window to one that is partly known; of equals the first.

    `whole` and `above` bound distances by all of a window or by what is before its center in scan
    order. The `near` windows, -1 for none, and those similar to them are compared first.
    """
    known = leading(whole, query) * whole.pixels.shape[2]
    if known >= whole.query.shape[0]:
        return nearest_within(whole, True, query, near, near_count)
    return nearest_within(above, known >= above.query.shape[0], query, near, near_count)
