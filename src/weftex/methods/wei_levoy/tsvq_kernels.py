# mypy: ignore-errors
"""Kernels of tree-structured vector quantization; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared


class Tree:
    """A tree over vectors, the vector that is searched, and scratch for a search."""

    def __init__(self, rows, places, nodes, centroids, keys, waiting, query, spans):
        self.rows, self.places, self.nodes, self.centroids = rows, places, nodes, centroids
        self.keys, self.waiting, self.first, self.last = keys, waiting, 0, 0
        self.query, self.spans, self.known = query, spans, len(spans)


@cython.cclass
class Splitting:
    """A tree in the making."""

    vectors: cython.const[cython.uchar][:, ::1]
    order: cython.int[::1]  # numbers of the vectors, leaf after leaf
    centroids: cython.uchar[:, ::1]
    spread: cython.longlong[::1]  # sum of squared differences from the centroid
    side: cython.uchar[:, ::1]  # scratch (2, n): 1 for vectors of the second half
    kept: cython.int[::1]  # scratch (n,)
    total: cython.longlong[:, ::1]  # scratch, two vectors

    def __init__(self, vectors, order, centroids, spread, side, kept, total):
        self.vectors, self.order, self.centroids, self.spread = vectors, order, centroids, spread
        self.side, self.kept, self.total = side, kept, total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def span_distance(
    row: cython.p_const_uchar,
    values: cython.p_const_uchar,
    spans: cython.p_const_int,
    count: cython.Py_ssize_t,
    bound: cython.longlong,
) -> cython.longlong:
    """Sum of squared differences over spans (first byte, length); stops past a bound >= 0."""
    cython.declare(s=cython.Py_ssize_t, at=cython.Py_ssize_t, stop=cython.Py_ssize_t)
    cython.declare(part=cython.Py_ssize_t, total=cython.longlong)
    total = 0
    for s in range(count):
        at = spans[2 * s]
        stop = at + spans[2 * s + 1]
        while at < stop:
            part = 64 if bound >= 0 and stop - at > 64 else stop - at
            total += squared(row + at, values + at, part)
            if total > bound and bound >= 0:
                return total
            at += part
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def wait(
    tree: Tree, key: cython.longlong, node: cython.int, most: cython.Py_ssize_t
) -> cython.void:
    """Add a node to the `most` waiting ones, nearest first; of equally near ones the older."""
    cython.declare(i=cython.Py_ssize_t)
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
    cython.declare(node=cython.int, child=cython.int, i=cython.Py_ssize_t, best=cython.Py_ssize_t)
    cython.declare(near=cython.longlong, far=cython.longlong, d=cython.longlong)
    cython.declare(least=cython.longlong, n=cython.Py_ssize_t)
    cython.declare(values=cython.p_const_uchar, spans=cython.p_const_int)
    values = cython.address(tree.query[0])
    spans = cython.address(tree.spans[0, 0])
    n = tree.known
    tree.first = tree.last = 0
    node = 0
    best = -1
    least = -1
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


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def vector(tree: Splitting, i: cython.Py_ssize_t) -> cython.p_const_uchar:
    """The vector that is the ith in order."""
    return cython.address(tree.vectors[tree.order[i], 0])


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def means(
    tree: Splitting,
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    side: cython.p_const_uchar,
    child: cython.Py_ssize_t,
) -> cython.void:
    """The centroids of both sides, rounded."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, s=cython.Py_ssize_t)
    cython.declare(count=cython.longlong, row=cython.p_const_uchar, sums=cython.p_longlong)
    cython.declare(size=cython.Py_ssize_t)
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
            tree.centroids[child + s, k] = cython.cast(
                cython.uchar, (sums[k] + count // 2) // count
            )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def halve(
    tree: Splitting, start: cython.Py_ssize_t, stop: cython.Py_ssize_t, side: cython.p_uchar
) -> cython.void:
    """A first guess: above the mean or not, in the byte with the largest variance."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, widest=cython.Py_ssize_t)
    cython.declare(d=cython.longlong, row=cython.p_const_uchar, size=cython.Py_ssize_t)
    cython.declare(mean=cython.p_longlong, variance=cython.p_longlong)
    size = tree.vectors.shape[1]
    mean = cython.address(tree.total[0, 0])
    variance = cython.address(tree.total[1, 0])
    for k in range(size):
        mean[k] = 0
        variance[k] = 0
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
    widest = 0
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
    cython.declare(i=cython.Py_ssize_t, s=cython.Py_ssize_t, r=cython.Py_ssize_t)
    cython.declare(moved=cython.Py_ssize_t, second=cython.Py_ssize_t, now=cython.Py_ssize_t)
    cython.declare(row=cython.p_const_uchar, size=cython.Py_ssize_t)
    cython.declare(one=cython.p_const_uchar, other=cython.p_const_uchar)
    size = tree.vectors.shape[1]
    one = cython.address(tree.centroids[child, 0])
    other = cython.address(tree.centroids[child + 1, 0])
    with cython.nogil:
        now = 0
        halve(tree, start, stop, cython.address(tree.side[0, 0]))
        means(tree, start, stop, cython.address(tree.side[0, 0]), child)
        for r in range(rounds):
            moved = 0
            second = 0
            for i in range(start, stop):
                row = vector(tree, i)
                s = squared(row, other, size) < squared(row, one, size)
                tree.side[1 - now, i] = cython.cast(cython.uchar, s)
                moved += s != tree.side[now, i]
                second += s
            if moved == 0 or second == 0 or second == stop - start:
                break
            now = 1 - now
            means(tree, start, stop, cython.address(tree.side[now, 0]), child)
        tree.spread[child] = 0
        tree.spread[child + 1] = 0
        second = 0
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
