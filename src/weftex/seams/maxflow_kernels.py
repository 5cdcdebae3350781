# mypy: ignore-errors
"""The minimum cut of a grid, by augmenting paths in two search trees that are kept.

Boykov and Kolmogorov, An experimental comparison of min-cut/max-flow algorithms for energy
minimization in vision (2004), section 3; distances and time stamps as in its section 3.2. A node is
a row of `nodes`, and the grid has a border of nodes without capacity, so no neighbour is missing.
Compiled by Cython, see setup.py.
"""

import cython

# What a node's row holds: the residual capacities of its arcs to the right, down, left and up (the
# opposite of direction d is d ^ 2), and of its arc from the source (negative: to the sink) ...
TERMINAL = cython.declare(cython.int, 4)
# ... the direction of its parent, or TERMINAL, NOBODY (in no tree) or LOST (an orphan) ...
PARENT = cython.declare(cython.int, 5)
NOBODY = cython.declare(cython.int, 5)
LOST = cython.declare(cython.int, 6)
# ... its tree, how far the root is, when that was looked up, and whether it waits to grow.
TREE = cython.declare(cython.int, 6)
SOURCE = cython.declare(cython.int, 1)
SINK = cython.declare(cython.int, 2)
DISTANCE = cython.declare(cython.int, 7)
STAMP = cython.declare(cython.int, 8)
WAITS = cython.declare(cython.int, 9)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def beside(i: cython.Py_ssize_t, d: cython.int, width: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """The neighbour of node i in direction d."""
    along: cython.Py_ssize_t = width if d & 1 else 1
    return i - along if d & 2 else i + along


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def put(ring: cython.int[::1], i: cython.Py_ssize_t) -> cython.void:
    """Add a node to a ring, whose last two entries are its first place and how many it holds."""
    room: cython.Py_ssize_t = ring.shape[0] - 2
    at: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, ring[room]) + ring[room + 1]
    ring[at if at < room else at - room] = cython.cast(cython.int, i)
    ring[room + 1] += 1


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def take(ring: cython.int[::1]) -> cython.Py_ssize_t:
    """Remove a ring's first node; -1 if there is none."""
    room: cython.Py_ssize_t = ring.shape[0] - 2
    i: cython.Py_ssize_t
    if ring[room + 1] == 0:
        return -1
    i = ring[ring[room]]
    ring[room] += 1
    if ring[room] == room:
        ring[room] = 0
    ring[room + 1] -= 1
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def wake(nodes: cython.int[:, ::1], active: cython.int[::1], i: cython.Py_ssize_t) -> cython.void:
    """Let a node's tree grow from it."""
    if not nodes[i, WAITS]:
        nodes[i, WAITS] = 1
        put(active, i)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def grow(
    nodes: cython.int[:, ::1],
    active: cython.int[::1],
    i: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
) -> cython.int:
    """Grow a tree from node i; return the direction in which it meets the other tree, or -1."""
    d: cython.int
    tree: cython.int = nodes[i, TREE]
    left: cython.int
    j: cython.Py_ssize_t
    for d in range(4):
        j = beside(i, d, width)
        left = nodes[i, d] if tree == SOURCE else nodes[j, d ^ 2]
        if left == 0:
            continue
        if nodes[j, PARENT] == NOBODY:
            nodes[j, TREE] = tree
            nodes[j, PARENT] = d ^ 2
            nodes[j, STAMP] = nodes[i, STAMP]
            nodes[j, DISTANCE] = nodes[i, DISTANCE] + 1
            wake(nodes, active, j)
        elif nodes[j, TREE] != tree:
            return d
        elif nodes[j, STAMP] <= nodes[i, STAMP] and nodes[j, DISTANCE] > nodes[i, DISTANCE]:
            nodes[j, PARENT] = d ^ 2  # a shorter way to the root
            nodes[j, STAMP] = nodes[i, STAMP]
            nodes[j, DISTANCE] = nodes[i, DISTANCE] + 1
    return -1


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def lose(nodes: cython.int[:, ::1], orphans: cython.int[::1], i: cython.Py_ssize_t) -> cython.void:
    nodes[i, PARENT] = LOST
    put(orphans, i)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def augment(
    nodes: cython.int[:, ::1],
    orphans: cython.int[::1],
    i: cython.Py_ssize_t,
    d: cython.int,
    width: cython.Py_ssize_t,
) -> cython.int:
    """Push what the path through node i and its neighbour in direction d can take.

    Nodes whose arc to their parent is full become orphans.
    """
    start: cython.Py_ssize_t = i  # in the tree of the source
    end: cython.Py_ssize_t = beside(i, d, width)
    k: cython.Py_ssize_t
    up: cython.Py_ssize_t
    p: cython.int
    flow: cython.int
    if nodes[i, TREE] == SINK:
        start = end
        end = i
        d ^= 2
    flow = nodes[start, d]
    k = start
    while nodes[k, PARENT] != TERMINAL:
        p = nodes[k, PARENT]
        k = beside(k, p, width)
        flow = min(flow, nodes[k, p ^ 2])
    flow = min(flow, nodes[k, TERMINAL])
    k = end
    while nodes[k, PARENT] != TERMINAL:
        flow = min(flow, nodes[k, nodes[k, PARENT]])
        k = beside(k, nodes[k, PARENT], width)
    flow = min(flow, -nodes[k, TERMINAL])

    nodes[start, d] -= flow
    nodes[end, d ^ 2] += flow
    k = start
    while nodes[k, PARENT] != TERMINAL:
        p = nodes[k, PARENT]
        up = beside(k, p, width)
        nodes[up, p ^ 2] -= flow
        nodes[k, p] += flow
        if nodes[up, p ^ 2] == 0:
            lose(nodes, orphans, k)
        k = up
    nodes[k, TERMINAL] -= flow
    if nodes[k, TERMINAL] == 0:
        lose(nodes, orphans, k)
    k = end
    while nodes[k, PARENT] != TERMINAL:
        p = nodes[k, PARENT]
        up = beside(k, p, width)
        nodes[k, p] -= flow
        nodes[up, p ^ 2] += flow
        if nodes[k, p] == 0:
            lose(nodes, orphans, k)
        k = up
    nodes[k, TERMINAL] += flow
    if nodes[k, TERMINAL] == 0:
        lose(nodes, orphans, k)
    return flow


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def distance_to_root(
    nodes: cython.int[:, ::1], i: cython.Py_ssize_t, now: cython.int, width: cython.Py_ssize_t
) -> cython.int:
    """How many arcs a node is from its terminal; -1 if an orphan is on the way."""
    k: cython.Py_ssize_t = i
    away: cython.int = 0
    left: cython.int
    while nodes[k, STAMP] != now:
        if nodes[k, PARENT] == LOST:
            return -1
        away += 1
        if nodes[k, PARENT] == TERMINAL:
            nodes[k, STAMP] = now
            nodes[k, DISTANCE] = 1
            break
        k = beside(k, nodes[k, PARENT], width)
    else:
        away += nodes[k, DISTANCE]
    left = away
    k = i
    while nodes[k, STAMP] != now:
        nodes[k, STAMP] = now
        nodes[k, DISTANCE] = left
        left -= 1
        k = beside(k, nodes[k, PARENT], width)
    return away


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def adopt(
    nodes: cython.int[:, ::1],
    active: cython.int[::1],
    orphans: cython.int[::1],
    i: cython.Py_ssize_t,
    now: cython.int,
    width: cython.Py_ssize_t,
) -> cython.void:
    """Find an orphan the parent that is nearest to the terminal, or let it and its children go."""
    tree: cython.int = nodes[i, TREE]
    best: cython.int = NOBODY
    least: cython.int = 0
    away: cython.int
    left: cython.int
    d: cython.int
    j: cython.Py_ssize_t
    for d in range(4):
        j = beside(i, d, width)
        if nodes[j, TREE] != tree or nodes[j, PARENT] == NOBODY:
            continue
        left = nodes[j, d ^ 2] if tree == SOURCE else nodes[i, d]
        if left == 0:
            continue
        away = distance_to_root(nodes, j, now, width)
        if away >= 0 and (best == NOBODY or away < least):
            best = d
            least = away
    nodes[i, PARENT] = best
    if best != NOBODY:
        nodes[i, STAMP] = now
        nodes[i, DISTANCE] = least + 1
        return
    for d in range(4):
        j = beside(i, d, width)
        if nodes[j, TREE] != tree or nodes[j, PARENT] == NOBODY:
            continue
        left = nodes[j, d ^ 2] if tree == SOURCE else nodes[i, d]
        if left > 0:
            wake(nodes, active, j)
        if nodes[j, PARENT] == d ^ 2:
            lose(nodes, orphans, j)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def minimum_cut(
    arcs: cython.const[cython.int][:, :, ::1],
    source: cython.const[cython.int][:, ::1],
    sink: cython.const[cython.int][:, ::1],
    nodes: cython.int[:, ::1],
    active: cython.int[::1],
    orphans: cython.int[::1],
    side: cython.uchar[:, ::1],
) -> cython.longlong:
    """Fill `side` with 1 where the source reaches through what is left of the arcs.

    That set is the same for every maximum flow. Returns the flow, which is the value of the cut.
    """
    height: cython.Py_ssize_t = side.shape[0]
    width: cython.Py_ssize_t = side.shape[1] + 2
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    i: cython.Py_ssize_t
    d: cython.int
    now: cython.int = 1
    flow: cython.longlong = 0
    for i in range(nodes.shape[0]):
        for d in range(10):
            nodes[i, d] = 0
        nodes[i, PARENT] = NOBODY
    for i in range(2):
        active[active.shape[0] - 2 + i] = 0
        orphans[orphans.shape[0] - 2 + i] = 0
    for y in range(height):
        for x in range(width - 2):
            i = (y + 1) * width + x + 1
            if x + 3 < width:
                nodes[i, 0] = arcs[y, x, 0]
            if y + 1 < height:
                nodes[i, 1] = arcs[y, x, 1]
            if x > 0:
                nodes[i, 2] = arcs[y, x, 2]
            if y > 0:
                nodes[i, 3] = arcs[y, x, 3]
            flow += min(source[y, x], sink[y, x])
            nodes[i, TERMINAL] = source[y, x] - sink[y, x]
            if nodes[i, TERMINAL] != 0:
                nodes[i, TREE] = SOURCE if nodes[i, TERMINAL] > 0 else SINK
                nodes[i, PARENT] = TERMINAL
                nodes[i, DISTANCE] = 1
                wake(nodes, active, i)
    while True:
        i = take(active)
        if i < 0:
            break
        nodes[i, WAITS] = 0
        while nodes[i, PARENT] != NOBODY:  # a path was found, and i may lead to more of them
            d = grow(nodes, active, i, width)
            if d < 0:
                break
            now += 1
            flow += augment(nodes, orphans, i, d, width)
            while orphans[orphans.shape[0] - 1] > 0:
                adopt(nodes, active, orphans, take(orphans), now, width)
    for y in range(height):
        for x in range(width - 2):
            i = (y + 1) * width + x + 1
            side[y, x] = nodes[i, PARENT] != NOBODY and nodes[i, TREE] == SOURCE
    return flow


def cut_grid(
    arcs: cython.const[cython.int][:, :, ::1],
    source: cython.const[cython.int][:, ::1],
    sink: cython.const[cython.int][:, ::1],
    nodes: cython.int[:, ::1],
    active: cython.int[::1],
    orphans: cython.int[::1],
    side: cython.uchar[:, ::1],
):
    """Call `minimum_cut`, beside other threads."""
    flow: cython.longlong
    with cython.nogil:
        flow = minimum_cut(arcs, source, sink, nodes, active, orphans, side)
    return flow
