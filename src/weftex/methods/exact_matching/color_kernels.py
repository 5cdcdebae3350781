# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that walk a kd-tree of colors; compiled, see setup.py and the .pxd.

The tree is that of `ColorIndex`: node i at level l, counted from 2**l, has the colors
(i - 2**l) C >> l to (i + 1 - 2**l) C >> l, and lies in the box from low[i] to high[i].
"""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.search.approximate_nearest_kernels import offer


class ColorTree:
    """The arrays of a `ColorIndex` for the kernels."""

    def __init__(self, colors, low, high, rank, depth):
        self.colors, self.low, self.high, self.rank = colors, low, high, rank
        self.depth = depth


def box_distance(tree, color, node, farthest):
    """Squared distance from a color to the nearest or the farthest point of a node's box."""
    d: cython.int
    total: cython.longlong = 0
    for k in range(tree.low.shape[1]):
        below = cython.cast(cython.int, color[k]) - tree.low[node, k]
        above = cython.cast(cython.int, tree.high[node, k]) - color[k]
        if farthest:
            d = below if below > above else above
        else:
            d = below if below < above else above
            if d > 0:
                d = 0
        total += d * d
    return total


def nearer_child(tree, color, node):
    """The child whose box is nearer to a color; the first of equally near ones."""
    first = 2 * node
    return first + (
        box_distance(tree, color, first + 1, False) < box_distance(tree, color, first, False)
    )


def near_colors(tree, number, radius, intervals, row):
    """Write to a row of `intervals` the colors within a squared distance of a color.

    Intervals are first and last + 1, ascending. Gaps separate them, so twice their number is at
    most C + 1.
    """
    stack = cython.declare(cython.Py_ssize_t[128])
    cython.declare(total=cython.longlong, whole=cython.bint)
    color = cython.address(tree.colors[number, 0])
    channels, total = tree.colors.shape[1], tree.colors.shape[0]
    n = 0
    top = 1
    stack[0] = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if box_distance(tree, color, node, False) > radius:
            continue
        whole = box_distance(tree, color, node, True) <= radius
        if not whole and node >> tree.depth == 0:
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
            if whole or squared(cython.address(tree.colors[i, 0]), color, channels) <= radius:
                if n > 0 and intervals[row, 2 * n - 1] == i:
                    intervals[row, 2 * n - 1] += 1
                else:
                    intervals[row, 2 * n] = cython.cast(cython.int, i)
                    intervals[row, 2 * n + 1] = cython.cast(cython.int, i + 1)
                    n += 1
    return n


def nearest_colors(tree, color, wanted, keys, places):
    """Find the `wanted` nearest colors, of equally near ones those of the lowest rank.

    `places` is a heap of them by `keys`, the squared distance << 32 | the rank, the farthest first.
    """
    stack = cython.declare(cython.Py_ssize_t[128])
    cython.declare(total=cython.longlong, key=cython.longlong)
    channels, total = tree.colors.shape[1], tree.colors.shape[0]
    count = 0
    top = 1
    stack[0] = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if count == wanted and box_distance(tree, color, node, False) > keys[0] >> 32:
            continue
        if node >> tree.depth == 0:
            i = nearer_child(tree, color, node)
            stack[top] = i ^ 1
            stack[top + 1] = i
            top += 2
            continue
        leaf = node - (cython.cast(cython.Py_ssize_t, 1) << tree.depth)
        for i in range(leaf * total >> tree.depth, (leaf + 1) * total >> tree.depth):
            key = squared(cython.address(tree.colors[i, 0]), color, channels) << 32 | tree.rank[i]
            count = offer(
                key, cython.cast(cython.int, i), count, wanted,
                cython.address(keys[0]), cython.address(places[0]),
            )  # fmt: skip
    return count


def reach_each(
    tree: ColorTree,
    keys: cython.longlong[::1],
    places: cython.int[::1],
    found: cython.longlong[::1],
):
    """Fill `found` with the squared distance of each color's last of `len(keys)` nearest ones."""
    with cython.nogil:
        for i in range(tree.colors.shape[0]):
            nearest_colors(tree, cython.address(tree.colors[i, 0]), keys.shape[0], keys, places)
            found[i] = keys[0] >> 32


def nearest_each(
    tree: ColorTree,
    pixels: cython.const[cython.uchar][:, ::1],
    key: cython.longlong[::1],
    found: cython.int[::1],
):
    """Fill `found` with the number of the color nearest to each pixel; `key` is scratch, (1,)."""
    with cython.nogil:
        for p in range(pixels.shape[0]):
            nearest_colors(tree, cython.address(pixels[p, 0]), 1, key, found[p:])
