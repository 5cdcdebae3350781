# mypy: ignore-errors
"""Kernels that walk a tree of colours; compiled by Cython, see setup.py.

The tree is that of `ColorIndex`: node i at level l, counted from 2**l, has the colours
(i - 2**l) C >> l to (i + 1 - 2**l) C >> l, and lies in the box from low[i] to high[i].
"""

import cython
from cython.cimports.weftex.search.zone_kernels import offer, squared


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def box_distance(
    color: cython.p_const_uchar,
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    node: cython.Py_ssize_t,
    farthest: cython.bint,
) -> cython.longlong:
    """Squared distance from a colour to the nearest or the farthest point of a node's box."""
    k: cython.Py_ssize_t
    below: cython.int
    above: cython.int
    d: cython.int
    total: cython.longlong = 0
    for k in range(low.shape[1]):
        below = cython.cast(cython.int, color[k]) - low[node, k]
        above = cython.cast(cython.int, high[node, k]) - color[k]
        if farthest:
            d = below if below > above else above
        else:
            d = below if below < above else above
            if d > 0:
                d = 0
        total += d * d
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def near_colors(
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    number: cython.Py_ssize_t,
    radius: cython.longlong,
    intervals: cython.int[:, ::1],
    row: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Find the colours within a squared distance of one of them.

    Their numbers are written to a row of `intervals` as first and last + 1, in rising order; with
    one gap at least between two intervals, twice their number is at most C + 1.
    """
    stack = cython.declare(cython.Py_ssize_t[128])
    color: cython.p_const_uchar = cython.address(colors[number, 0])
    channels: cython.Py_ssize_t = colors.shape[1]
    total: cython.longlong = colors.shape[0]
    top: cython.Py_ssize_t = 1
    n: cython.Py_ssize_t = 0
    node: cython.Py_ssize_t
    level: cython.Py_ssize_t
    first: cython.Py_ssize_t
    last: cython.Py_ssize_t
    i: cython.Py_ssize_t
    whole: cython.bint
    stack[0] = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if box_distance(color, low, high, node, False) > radius:
            continue
        whole = box_distance(color, low, high, node, True) <= radius
        if not whole and node >> depth == 0:
            stack[top] = 2 * node + 1
            stack[top + 1] = 2 * node
            top += 2
            continue
        level = 0
        while node >> level > 1:
            level += 1
        i = node - (cython.cast(cython.Py_ssize_t, 1) << level)
        first = i * total >> level
        last = (i + 1) * total >> level
        for i in range(first, last):
            if whole or squared(cython.address(colors[i, 0]), color, channels) <= radius:
                if n > 0 and intervals[row, 2 * n - 1] == i:
                    intervals[row, 2 * n - 1] += 1
                else:
                    intervals[row, 2 * n] = cython.cast(cython.int, i)
                    intervals[row, 2 * n + 1] = cython.cast(cython.int, i + 1)
                    n += 1
    return n


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest_colors(
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    color: cython.p_const_uchar,
    wanted: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    """Find the `wanted` nearest colours; `keys` and `places` are a heap, the farthest first."""
    stack = cython.declare(cython.Py_ssize_t[128])
    channels: cython.Py_ssize_t = colors.shape[1]
    total: cython.longlong = colors.shape[0]
    top: cython.Py_ssize_t = 1
    count: cython.Py_ssize_t = 0
    node: cython.Py_ssize_t
    i: cython.Py_ssize_t
    leaf: cython.Py_ssize_t
    stack[0] = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if count == wanted and box_distance(color, low, high, node, False) > keys[0]:
            continue
        if node >> depth == 0:
            i = 2 * node
            if box_distance(color, low, high, i + 1, False) < box_distance(
                color, low, high, i, False
            ):
                i += 1  # the nearer child next
            stack[top] = i ^ 1
            stack[top + 1] = i
            top += 2
            continue
        leaf = node - (cython.cast(cython.Py_ssize_t, 1) << depth)
        for i in range(leaf * total >> depth, (leaf + 1) * total >> depth):
            count = offer(
                squared(cython.address(colors[i, 0]), color, channels),
                cython.cast(cython.int, i),
                count,
                wanted,
                cython.address(keys[0]),
                cython.address(places[0]),
            )
    return count


def near_one(colors, low, high, depth, number, radius, intervals):
    """`near_colors` into the first row; returns the number of intervals."""
    return near_colors(colors, low, high, depth, number, radius, intervals, 0)


def reach_each(
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    places: cython.int[::1],
    found: cython.longlong[::1],
):
    """The squared distance of each colour's farthest among its nearest, as many as `keys` holds."""
    i: cython.Py_ssize_t
    with cython.nogil:
        for i in range(colors.shape[0]):
            nearest_colors(
                colors, low, high, depth, cython.address(colors[i, 0]), keys.shape[0], keys, places
            )
            found[i] = keys[0]


def nearest_each(
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    rank: cython.const[cython.int][::1],
    pixels: cython.const[cython.uchar][:, ::1],
    found: cython.int[::1],
):
    """The number of the colour nearest to each pixel; of equally near ones that of lowest rank."""
    stack = cython.declare(cython.Py_ssize_t[128])
    channels: cython.Py_ssize_t = colors.shape[1]
    total: cython.longlong = colors.shape[0]
    top: cython.Py_ssize_t
    node: cython.Py_ssize_t
    p: cython.Py_ssize_t
    i: cython.Py_ssize_t
    leaf: cython.Py_ssize_t
    d: cython.longlong
    best: cython.longlong
    color: cython.p_const_uchar
    with cython.nogil:
        for p in range(pixels.shape[0]):
            color = cython.address(pixels[p, 0])
            best = -1
            top = 1
            stack[0] = 1
            while top > 0:
                top -= 1
                node = stack[top]
                if best >= 0 and box_distance(color, low, high, node, False) > best:
                    continue
                if node >> depth == 0:
                    i = 2 * node
                    if box_distance(color, low, high, i + 1, False) < box_distance(
                        color, low, high, i, False
                    ):
                        i += 1
                    stack[top] = i ^ 1
                    stack[top + 1] = i
                    top += 2
                    continue
                leaf = node - (cython.cast(cython.Py_ssize_t, 1) << depth)
                for i in range(leaf * total >> depth, (leaf + 1) * total >> depth):
                    d = squared(cython.address(colors[i, 0]), color, channels)
                    if best < 0 or d < best or (d == best and rank[i] < rank[found[p]]):
                        best = d
                        found[p] = cython.cast(cython.int, i)
