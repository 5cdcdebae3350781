# mypy: ignore-errors
"""Kernels of tree-structured vector quantisation; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.zone_kernels import squared


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def span_distance(
    a: cython.p_const_uchar,
    b: cython.p_const_uchar,
    spans: cython.const[cython.int][:, ::1],
    n: cython.Py_ssize_t,
    bound: cython.longlong,
) -> cython.longlong:
    """Sum of squared differences over the spans (start, length); stops past a bound >= 0."""
    s: cython.Py_ssize_t
    at: cython.Py_ssize_t
    stop: cython.Py_ssize_t
    part: cython.Py_ssize_t
    total: cython.longlong = 0
    for s in range(n):
        at = spans[s, 0]
        stop = at + spans[s, 1]
        while at < stop:
            part = 64 if bound >= 0 and stop - at > 64 else stop - at
            total += squared(a + at, b + at, part)
            if total > bound and bound >= 0:
                return total
            at += part
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def before(
    key: cython.longlong, node: cython.int, other_key: cython.longlong, other: cython.int
) -> cython.bint:
    """Whether a node is to be looked at before another one; of equally near ones the older."""
    return key < other_key or (key == other_key and node < other)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def push(
    key: cython.longlong,
    node: cython.int,
    count: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    pending: cython.int[::1],
) -> cython.void:
    """Put a node into the heap of those that wait, nearest first."""
    i: cython.Py_ssize_t = count
    while i > 0 and before(key, node, keys[(i - 1) // 2], pending[(i - 1) // 2]):
        keys[i] = keys[(i - 1) // 2]
        pending[i] = pending[(i - 1) // 2]
        i = (i - 1) // 2
    keys[i] = key
    pending[i] = node


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def pop(
    count: cython.Py_ssize_t, keys: cython.longlong[::1], pending: cython.int[::1]
) -> cython.int:
    """Take the nearest of `count` waiting nodes."""
    result: cython.int = pending[0]
    key: cython.longlong = keys[count - 1]
    node: cython.int = pending[count - 1]
    i: cython.Py_ssize_t = 0
    child: cython.Py_ssize_t
    while True:
        child = 2 * i + 1
        if child >= count - 1:
            break
        if child + 1 < count - 1 and before(
            keys[child + 1], pending[child + 1], keys[child], pending[child]
        ):
            child += 1
        if not before(keys[child], pending[child], key, node):
            break
        keys[i] = keys[child]
        pending[i] = pending[child]
        i = child
    keys[i] = key
    pending[i] = node
    return result


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest(
    rows: cython.const[cython.uchar][:, ::1],
    places: cython.const[cython.int][::1],
    nodes: cython.const[cython.int][:, ::1],
    centroids: cython.const[cython.uchar][:, ::1],
    query: cython.const[cython.uchar][::1],
    spans: cython.const[cython.int][:, ::1],
    n: cython.Py_ssize_t,
    leaves: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    pending: cython.int[::1],
) -> cython.Py_ssize_t:
    """The row nearest to the query in the leaves that are looked at; the first place of a tie."""
    node: cython.int = 0
    child: cython.int
    near: cython.longlong
    far: cython.longlong
    waiting: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    d: cython.longlong
    best: cython.Py_ssize_t = -1
    least: cython.longlong = -1
    q: cython.p_const_uchar = cython.address(query[0])
    while True:
        while nodes[node, 0] >= 0:
            child = nodes[node, 0]
            near = span_distance(cython.address(centroids[child, 0]), q, spans, n, -1)
            far = span_distance(cython.address(centroids[child + 1, 0]), q, spans, n, -1)
            if far < near:
                push(near, child, waiting, keys, pending)
                node = child + 1
            else:
                push(far, child + 1, waiting, keys, pending)
                node = child
            waiting += 1
        for i in range(nodes[node, 1], nodes[node, 2]):
            d = span_distance(cython.address(rows[i, 0]), q, spans, n, least)
            if best < 0 or d < least or (d == least and places[i] < places[best]):
                best = i
                least = d
        leaves -= 1
        if leaves <= 0 or waiting == 0:
            return best
        node = pop(waiting, keys, pending)
        waiting -= 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def means(
    vectors: cython.const[cython.uchar][:, ::1],
    order: cython.const[cython.int][::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    side: cython.const[cython.uchar][::1],
    total: cython.longlong[:, ::1],
    centroids: cython.uchar[:, ::1],
    child: cython.Py_ssize_t,
) -> cython.void:
    """The centroids of both sides, rounded."""
    size: cython.Py_ssize_t = vectors.shape[1]
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    s: cython.Py_ssize_t
    count: cython.longlong
    row: cython.p_const_uchar
    sums: cython.p_longlong
    for s in range(2):
        sums = cython.address(total[s, 0])
        count = 0
        for k in range(size):
            sums[k] = 0
        for i in range(start, stop):
            if side[i] == s:
                count += 1
                row = cython.address(vectors[order[i], 0])
                for k in range(size):
                    sums[k] += row[k]
        for k in range(size):
            centroids[child + s, k] = cython.cast(cython.uchar, (sums[k] + count // 2) // count)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def halve(
    vectors: cython.const[cython.uchar][:, ::1],
    order: cython.const[cython.int][::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    side: cython.uchar[::1],
    total: cython.longlong[:, ::1],
) -> cython.void:
    """A first guess: above the mean or not, in the byte with the largest variance."""
    size: cython.Py_ssize_t = vectors.shape[1]
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    widest: cython.Py_ssize_t = 0
    d: cython.longlong
    row: cython.p_const_uchar
    for k in range(size):
        total[0, k] = 0
        total[1, k] = 0
    for i in range(start, stop):
        row = cython.address(vectors[order[i], 0])
        for k in range(size):
            total[0, k] += row[k]
    for k in range(size):
        total[0, k] //= stop - start  # rounded down, so that something is above it
    for i in range(start, stop):
        row = cython.address(vectors[order[i], 0])
        for k in range(size):
            d = row[k] - total[0, k]
            total[1, k] += d * d
    for k in range(size):
        if total[1, k] > total[1, widest]:
            widest = k
    for i in range(start, stop):
        side[i] = vectors[order[i], widest] > total[0, widest]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def split(
    vectors: cython.const[cython.uchar][:, ::1],
    order: cython.int[::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    centroids: cython.uchar[:, ::1],
    spread: cython.longlong[::1],
    child: cython.Py_ssize_t,
    rounds: cython.Py_ssize_t,
    side: cython.uchar[:, ::1],
    kept: cython.int[::1],
    total: cython.longlong[:, ::1],
) -> cython.Py_ssize_t:
    """Split a node in two by Lloyd's algorithm; return where its second half begins.

    The node's vectors must not all be equal. `side` (2, n), `kept` and `total` are scratch space.
    """
    size: cython.Py_ssize_t = vectors.shape[1]
    i: cython.Py_ssize_t
    s: cython.Py_ssize_t
    r: cython.Py_ssize_t
    moved: cython.Py_ssize_t
    second: cython.Py_ssize_t
    now: cython.Py_ssize_t = 0
    row: cython.p_const_uchar
    halve(vectors, order, start, stop, side[0], total)
    means(vectors, order, start, stop, side[0], total, centroids, child)
    for r in range(rounds):
        moved = 0
        second = 0
        for i in range(start, stop):
            row = cython.address(vectors[order[i], 0])
            s = squared(row, cython.address(centroids[child + 1, 0]), size) < squared(
                row, cython.address(centroids[child, 0]), size
            )
            side[1 - now, i] = cython.cast(cython.uchar, s)
            moved += s != side[now, i]
            second += s
        if moved == 0 or second == 0 or second == stop - start:
            break
        now = 1 - now
        means(vectors, order, start, stop, side[now], total, centroids, child)
    spread[child] = 0
    spread[child + 1] = 0
    second = 0
    s = start
    for i in range(start, stop):
        row = cython.address(vectors[order[i], 0])
        if side[now, i]:
            spread[child + 1] += squared(row, cython.address(centroids[child + 1, 0]), size)
            kept[second] = order[i]
            second += 1
        else:
            spread[child] += squared(row, cython.address(centroids[child, 0]), size)
            order[s] = order[i]
            s += 1
    for i in range(second):
        order[s + i] = kept[i]
    return s


def split_node(
    vectors, order, start, stop, centroids, spread, child, rounds, side, kept, total
):  # fmt: skip
    """Call `split`."""
    v: cython.const[cython.uchar][:, ::1] = vectors
    o: cython.int[::1] = order
    c: cython.uchar[:, ::1] = centroids
    sp: cython.longlong[::1] = spread
    si: cython.uchar[:, ::1] = side
    k: cython.int[::1] = kept
    t: cython.longlong[:, ::1] = total
    return split(v, o, start, stop, c, sp, child, rounds, si, k, t)


def nearest_rows(rows, places, nodes, centroids, queries, spans, leaves, keys, pending, found):
    """Call `nearest` for each of `queries`."""
    r: cython.const[cython.uchar][:, ::1] = rows
    p: cython.const[cython.int][::1] = places
    m: cython.const[cython.int][:, ::1] = nodes
    c: cython.const[cython.uchar][:, ::1] = centroids
    q: cython.const[cython.uchar][:, ::1] = queries
    s: cython.const[cython.int][:, ::1] = spans
    ks: cython.longlong[::1] = keys
    pe: cython.int[::1] = pending
    f: cython.int[::1] = found
    for i in range(q.shape[0]):
        f[i] = nearest(r, p, m, c, q[i], s, s.shape[0], leaves, ks, pe)
