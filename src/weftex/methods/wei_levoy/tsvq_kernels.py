# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of tree-structured vector quantization; compiled, see setup.py and the .pxd."""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared


class Tree:
    """A tree over vectors, the vector that is searched, and scratch for a search."""

    def __init__(self, rows, places, nodes, centroids, keys, waiting, query, spans):
        self.rows, self.places, self.nodes, self.centroids = rows, places, nodes, centroids
        self.keys, self.waiting, self.first, self.last = keys, waiting, 0, 0
        self.query, self.spans, self.known = query, spans, len(spans)


class Splitting:
    """A tree in the making."""

    def __init__(self, vectors, order, centroids, spread, side, kept, total):
        self.vectors, self.order, self.centroids, self.spread = vectors, order, centroids, spread
        self.side, self.kept, self.total = side, kept, total


# Typed here, or it cannot be inlined, which costs a search 7 %.
@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def span_distance(
    row: cython.p_const_uchar, values: cython.p_const_uchar, spans: cython.p_const_int,
    count: cython.Py_ssize_t, bound: cython.longlong,
) -> cython.longlong:  # fmt: skip
    """Sum of squared differences over spans (first byte, length); stops past a bound >= 0."""
    cython.declare(at=cython.Py_ssize_t, total=cython.longlong)
    total = 0
    for s in range(count):
        at = spans[2 * s]
        stop = at + spans[2 * s + 1]
        while at < stop:
            part = min(64, stop - at) if bound >= 0 else stop - at
            total += squared(row + at, values + at, part)
            if total > bound and bound >= 0:
                return total
            at += part
    return total


def wait(tree, key, node, most):
    """Add a node to the `most` waiting ones, nearest first; of equally near ones the older."""
    i = tree.last
    while i > tree.first and (
        key < tree.keys[i - 1] or (key == tree.keys[i - 1] and node < tree.waiting[i - 1])
    ):
        tree.keys[i] = tree.keys[i - 1]
        tree.waiting[i] = tree.waiting[i - 1]
        i -= 1
    tree.keys[i] = key
    tree.waiting[i] = node
    tree.last = min(tree.last + 1, tree.first + most)


def nearest(tree, leaves):
    """The row nearest to the query in the nearest leaves; of equal ones, the first."""
    cython.declare(node=cython.int, best=cython.Py_ssize_t, least=cython.longlong)
    values, spans, n = cython.address(tree.query[0]), cython.address(tree.spans[0, 0]), tree.known
    tree.first = tree.last = node = 0
    best = least = -1
    while True:
        while tree.nodes[node, 0] >= 0:
            child = tree.nodes[node, 0]
            near = span_distance(cython.address(tree.centroids[child, 0]), values, spans, n, -1)
            far = span_distance(cython.address(tree.centroids[child + 1, 0]), values, spans, n, -1)
            if far < near:
                wait(tree, near, child, leaves - 1)
                node = child + 1
            else:
                wait(tree, far, child + 1, leaves - 1)
                node = child
        for i in range(tree.nodes[node, 1], tree.nodes[node, 2]):
            d = span_distance(cython.address(tree.rows[i, 0]), values, spans, n, least)
            if best < 0 or d < least or (d == least and tree.places[i] < tree.places[best]):
                best = i
                least = d
        leaves -= 1
        if leaves <= 0 or tree.first == tree.last:
            return best
        node = tree.waiting[tree.first]
        tree.first += 1


def means(tree, start, stop, side, child):
    """The centroids of both sides, rounded."""
    count: cython.longlong
    size = tree.vectors.shape[1]
    for s in range(2):
        sums = cython.address(tree.total[s, 0])
        count = 0
        for k in range(size):
            sums[k] = 0
        for i in range(start, stop):
            if side[i] == s:
                count += 1
                row = vector(tree, i)
                for k in range(size):
                    sums[k] += row[k]
        for k in range(size):
            tree.centroids[child + s, k] = (sums[k] + count // 2) // count


def halve(tree, start, stop, side):
    """A first guess: above the mean or not, in the byte with the largest variance."""
    widest: cython.Py_ssize_t = 0
    size = tree.vectors.shape[1]
    mean, variance = cython.address(tree.total[0, 0]), cython.address(tree.total[1, 0])
    for k in range(size):
        mean[k] = variance[k] = 0
    for i in range(start, stop):
        row = vector(tree, i)
        for k in range(size):
            mean[k] += row[k]
    for k in range(size):
        mean[k] //= stop - start  # rounded down, so that something is above it
    for i in range(start, stop):
        row = vector(tree, i)
        for k in range(size):
            d = row[k] - mean[k]
            variance[k] += d * d
    for k in range(size):
        if variance[k] > variance[widest]:
            widest = k
    for i in range(start, stop):
        side[i] = vector(tree, i)[widest] > mean[widest]


def split(
    tree: Splitting,
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    child: cython.Py_ssize_t,
    rounds: cython.Py_ssize_t,
):
    """Split a node in two by Lloyd's algorithm; return where its second half begins.

    The node's vectors must not all be equal. Its children are the nodes `child` and `child` + 1.
    """
    cython.declare(moved=cython.Py_ssize_t, second=cython.Py_ssize_t, now=cython.Py_ssize_t)
    s: cython.Py_ssize_t
    size = tree.vectors.shape[1]
    one = cython.address(tree.centroids[child, 0])
    other = cython.address(tree.centroids[child + 1, 0])
    with cython.nogil:
        now = 0
        halve(tree, start, stop, cython.address(tree.side[0, 0]))
        means(tree, start, stop, cython.address(tree.side[0, 0]), child)
        for r in range(rounds):
            moved = second = 0
            for i in range(start, stop):
                row = vector(tree, i)
                s = squared(row, other, size) < squared(row, one, size)
                tree.side[1 - now, i] = s
                moved += s != tree.side[now, i]
                second += s
            if moved == 0 or second == 0 or second == stop - start:
                break
            now = 1 - now
            means(tree, start, stop, cython.address(tree.side[now, 0]), child)
        tree.spread[child] = tree.spread[child + 1] = second = 0
        s = start
        for i in range(start, stop):
            row = vector(tree, i)
            if tree.side[now, i]:
                tree.spread[child + 1] += squared(row, other, size)
                tree.kept[second] = tree.order[i]
                second += 1
            else:
                tree.spread[child] += squared(row, one, size)
                tree.order[s] = tree.order[i]
                s += 1
        for i in range(second):
            tree.order[s + i] = tree.kept[i]
    return s
