# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that list the windows nearest at a low resolution; compiled, see setup.py and the .pxd.

A window is described by the means of squares in it, or by their principal components (Liang et al.,
2001, sections 3.2 and 3.3). Distances are sums of squared differences of integers, so every order
of summation, vector width and machine gives the same one.
"""

import cython

#: The largest coordinate of a query. Those of the sample are at most 2047: sums of 48 squares fit.
FARTHEST = cython.declare(cython.int, 4095)


def square_means(canvas, y, x, squares, side, means):
    """Mean of each side x side block of a window of the canvas, around its borders, per channel.

    It is rounded as `QuadtreePyramid` rounds the sample's.
    """
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, total=cython.int)
    height, width, channels = canvas.shape[0], canvas.shape[1], canvas.shape[2]
    for b in range(squares.shape[0]):
        for k in range(channels):
            total = 0
            cy = (y + squares[b, 0]) % height
            for i in range(side):
                cx = (x + squares[b, 1]) % width
                for j in range(side):
                    total += canvas[cy, cx, k]
                    cx = cx + 1 if cx + 1 < width else 0
                cy = cy + 1 if cy + 1 < height else 0
            means[b * channels + k] = (total + side * side // 2) // (side * side)


# Typed here too, or it cannot be inlined, which costs a search 5 %.
@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def offer(
    key: cython.longlong, place: cython.int, count: cython.Py_ssize_t, wanted: cython.Py_ssize_t,
    keys: cython.p_longlong, places: cython.p_int,
) -> cython.Py_ssize_t:  # fmt: skip
    """Put a candidate into a heap that keeps the `wanted` smallest keys; return its new size."""
    cython.declare(i=cython.Py_ssize_t, child=cython.Py_ssize_t)
    if count < wanted:
        i = count
        while i > 0 and keys[(i - 1) // 2] < key:
            keys[i] = keys[(i - 1) // 2]
            places[i] = places[(i - 1) // 2]
            i = (i - 1) // 2
        keys[i] = key
        places[i] = place
        return count + 1
    if key >= keys[0]:
        return count
    i = 0
    while True:
        child = 2 * i + 1
        if child >= count:
            break
        if child + 1 < count and keys[child + 1] > keys[child]:
            child += 1
        if keys[child] <= key:
            break
        keys[i] = keys[child]
        places[i] = places[child]
        i = child
    keys[i] = key
    places[i] = place
    return count


def nearest_by_squares(nodes, squares, query, usable, wanted, distances, corners):
    """Find the windows whose squares are nearest to the query's, over one node of the pyramid each.

    `nodes` is (channel, shift y, shift x, row, column): with a stride of s, the window at (s * i, s
    * j) reads the block at (v, u) in node (v % s, u % s) at (i + v // s, j + u // s).
    """
    total = cython.declare(cython.int[1024])  # fits 33,000 numbers a window; it has some 300
    cython.declare(d=cython.short, q=cython.short)
    channels, stride = nodes.shape[0], nodes.shape[1]
    columns = (usable.shape[1] + stride - 1) // stride
    nearest, theirs = cython.address(distances[0]), cython.address(corners[0])
    count: cython.Py_ssize_t = 0
    for i in range((usable.shape[0] + stride - 1) // stride):
        for start in range(0, columns, 1024):
            n = min(1024, columns - start)
            for j in range(n):
                total[j] = 0
            for b in range(squares.shape[0]):
                v, u = squares[b, 0], squares[b, 1]
                for k in range(channels):
                    q = cython.cast(cython.short, query[b * channels + k])
                    node = cython.address(
                        nodes[k, v % stride, u % stride, i + v // stride, start + u // stride]
                    )
                    for j in range(n):
                        d = cython.cast(cython.short, node[j]) - q
                        total[j] += cython.cast(cython.int, d) * d
            for j in range(n):
                x = (start + j) * stride
                if (count < wanted or total[j] < nearest[0]) and usable[i * stride, x]:
                    corner = i * stride * usable.shape[1] + x
                    count = offer(total[j], corner, count, wanted, nearest, theirs)
    return count


def project(basis, offset, shift, query, coordinates):
    """Coordinates of a query in the principal components, rounded as `Components` rounds."""
    total: cython.int
    for d in range(basis.shape[0]):
        total = -offset[d] + ((1 << shift) >> 1)
        for k in range(basis.shape[1]):
            total += cython.cast(cython.int, basis[d, k]) * query[k]
        total >>= shift
        coordinates[d] = cython.cast(cython.short, min(max(total, -FARTHEST), FARTHEST))


def some_distances(coordinates, query, start, n, total):
    """Squared distances of n windows in coordinates, of which one component is one row."""
    cython.declare(q=cython.short, next_q=cython.short, diff=cython.short, next_diff=cython.short)
    for j in range(n):
        total[j] = 0
    for d in range(0, coordinates.shape[0] - 1, 2):  # two at a time halve the traffic of sums
        row = cython.address(coordinates[d, start])
        next_row = cython.address(coordinates[d + 1, start])
        q, next_q = query[d], query[d + 1]
        for j in range(n):
            diff = row[j] - q
            next_diff = next_row[j] - next_q
            total[j] += (
                cython.cast(cython.int, diff) * diff
                + cython.cast(cython.int, next_diff) * next_diff
            )
    if coordinates.shape[0] % 2:
        row = cython.address(coordinates[coordinates.shape[0] - 1, start])
        q = query[coordinates.shape[0] - 1]
        for j in range(n):
            diff = row[j] - q
            total[j] += cython.cast(cython.int, diff) * diff


def all_distances(coordinates, query, total):
    """Squared distances in principal components of all windows."""
    for start in range(0, total.shape[0], 1024):
        n = min(1024, total.shape[0] - start)
        some_distances(coordinates, query, start, n, cython.address(total[start]))


def nearest_by_coordinates(coordinates, at, query, wanted, distances, corners):
    """Find the windows nearest in principal components; their corners are `at`."""
    total = cython.declare(cython.int[1024])
    nearest, theirs = cython.address(distances[0]), cython.address(corners[0])
    count: cython.Py_ssize_t = 0
    worst: cython.longlong = 0
    for start in range(0, at.shape[0], 1024):
        n = min(1024, at.shape[0] - start)
        some_distances(coordinates, query, start, n, cython.address(total[0]))
        for j in range(n):
            if total[j] < worst or count < wanted:
                count = offer(total[j], at[start + j], count, wanted, nearest, theirs)
                worst = nearest[0]
    return count
