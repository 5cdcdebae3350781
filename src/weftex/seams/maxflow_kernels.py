# mypy: ignore-errors
"""The minimum cut of a grid, by augmenting paths in two search trees that are kept.

Boykov and Kolmogorov, An experimental comparison of min-cut/max-flow algorithms for energy
minimization in vision (2004), section 3; distances and time stamps as in its section 3.2. The grid
has a border of nodes without capacity, so no neighbor is missing.
Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX

# A direction is right, down, left or up; the opposite of d is d ^ 2. A Node: see the .pxd.


@cython.cclass
class Capacities:
    """The capacities of the grid's arcs, and of those from the source and to the sink.

    Arcs lead right, down, left and up. The grid may be set smaller than the arrays.
    """

    def __init__(self, arcs, source, sink):
        self.arcs = arcs
        self.source = source
        self.sink = sink
        self.height, self.width = source.shape


@cython.cclass
class Trees:
    """The two search trees, and two rings of nodes: those that may grow, and orphans.

    Nodes are row by row, in a grid with a border, `width` nodes wide. A ring's last two entries are
    the place of its first node and how many nodes it holds, zeros at first. `now`, a time stamp,
    is the number of augmentations.
    """

    def __init__(self, nodes, active, orphans):
        self.nodes = nodes
        self.active = active
        self.orphans = orphans


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def beside(i: cython.Py_ssize_t, d: cython.int, width: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """The neighbor of node i in direction d."""
    along: cython.Py_ssize_t = width if d & 1 else 1
    return i - along if d & 2 else i + along


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def put(ring: cython.int[::1], i: cython.Py_ssize_t) -> cython.void:
    """Add a node to a ring."""
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
    cython.declare(i=cython.Py_ssize_t)
    room: cython.Py_ssize_t = ring.shape[0] - 2
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
def wake(trees: Trees, i: cython.Py_ssize_t) -> cython.void:
    """Let a node's tree grow from it."""
    if not trees.nodes[i].waits:
        trees.nodes[i].waits = 1
        put(trees.active, i)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def lose(trees: Trees, i: cython.Py_ssize_t) -> cython.void:
    """Make a node an orphan."""
    trees.nodes[i].parent = LOST
    put(trees.orphans, i)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def grow(trees: Trees, i: cython.Py_ssize_t) -> cython.int:
    """Grow a tree from node i; return the direction in which it meets the other tree, or -1."""
    cython.declare(d=cython.int, left=cython.int, j=cython.Py_ssize_t)
    tree: cython.int = trees.nodes[i].tree
    for d in range(4):
        j = beside(i, d, trees.width)
        left = trees.nodes[i].arcs[d] if tree == SOURCE else trees.nodes[j].arcs[d ^ 2]
        if left == 0:
            continue
        if trees.nodes[j].parent == NOBODY:
            trees.nodes[j].tree = tree
            trees.nodes[j].parent = d ^ 2
            trees.nodes[j].stamp = trees.nodes[i].stamp
            trees.nodes[j].distance = trees.nodes[i].distance + 1
            wake(trees, j)
        elif trees.nodes[j].tree != tree:
            return d
        elif (
            trees.nodes[j].stamp <= trees.nodes[i].stamp
            and trees.nodes[j].distance > trees.nodes[i].distance
        ):
            trees.nodes[j].parent = d ^ 2  # a shorter way to the root
            trees.nodes[j].stamp = trees.nodes[i].stamp
            trees.nodes[j].distance = trees.nodes[i].distance + 1
    return -1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def augment(trees: Trees, i: cython.Py_ssize_t, d: cython.int) -> cython.int:
    """Push the largest flow along the path through node i and its neighbor in direction d.

    Nodes whose arc to their parent is full become orphans.
    """
    cython.declare(k=cython.Py_ssize_t, up=cython.Py_ssize_t, p=cython.int, flow=cython.int)
    width: cython.Py_ssize_t = trees.width
    start: cython.Py_ssize_t = i  # in the tree of the source
    end: cython.Py_ssize_t = beside(i, d, width)
    if trees.nodes[i].tree == SINK:
        start = end
        end = i
        d ^= 2
    flow = trees.nodes[start].arcs[d]
    k = start
    while trees.nodes[k].parent != ROOT:
        p = trees.nodes[k].parent
        k = beside(k, p, width)
        flow = min(flow, trees.nodes[k].arcs[p ^ 2])
    flow = min(flow, trees.nodes[k].terminal)
    k = end
    while trees.nodes[k].parent != ROOT:
        flow = min(flow, trees.nodes[k].arcs[trees.nodes[k].parent])
        k = beside(k, trees.nodes[k].parent, width)
    flow = min(flow, -trees.nodes[k].terminal)

    trees.nodes[start].arcs[d] -= flow
    trees.nodes[end].arcs[d ^ 2] += flow
    k = start
    while trees.nodes[k].parent != ROOT:
        p = trees.nodes[k].parent
        up = beside(k, p, width)
        trees.nodes[up].arcs[p ^ 2] -= flow
        trees.nodes[k].arcs[p] += flow
        if trees.nodes[up].arcs[p ^ 2] == 0:
            lose(trees, k)
        k = up
    trees.nodes[k].terminal -= flow
    if trees.nodes[k].terminal == 0:
        lose(trees, k)
    k = end
    while trees.nodes[k].parent != ROOT:
        p = trees.nodes[k].parent
        up = beside(k, p, width)
        trees.nodes[k].arcs[p] -= flow
        trees.nodes[up].arcs[p ^ 2] += flow
        if trees.nodes[k].arcs[p] == 0:
            lose(trees, k)
        k = up
    trees.nodes[k].terminal += flow
    if trees.nodes[k].terminal == 0:
        lose(trees, k)
    return flow


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def distance_to_root(trees: Trees, i: cython.Py_ssize_t) -> cython.int:
    """The number of arcs from a node to its terminal; -1 if an orphan is on the way."""
    cython.declare(left=cython.int)
    now: cython.int = trees.now
    k: cython.Py_ssize_t = i
    away: cython.int = 0
    while trees.nodes[k].stamp != now:
        if trees.nodes[k].parent == LOST:
            return -1
        away += 1
        if trees.nodes[k].parent == ROOT:
            trees.nodes[k].stamp = now
            trees.nodes[k].distance = 1
            break
        k = beside(k, trees.nodes[k].parent, trees.width)
    else:
        away += trees.nodes[k].distance
    left = away
    k = i
    while trees.nodes[k].stamp != now:
        trees.nodes[k].stamp = now
        trees.nodes[k].distance = left
        left -= 1
        k = beside(k, trees.nodes[k].parent, trees.width)
    return away


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def adopt(trees: Trees, i: cython.Py_ssize_t) -> cython.void:
    """Find an orphan the parent that is nearest to the terminal, or let it and its children go."""
    cython.declare(away=cython.int, left=cython.int, d=cython.int, j=cython.Py_ssize_t)
    tree: cython.int = trees.nodes[i].tree
    best: cython.int = NOBODY
    least: cython.int = 0
    for d in range(4):
        j = beside(i, d, trees.width)
        if trees.nodes[j].tree != tree or trees.nodes[j].parent == NOBODY:
            continue
        left = trees.nodes[j].arcs[d ^ 2] if tree == SOURCE else trees.nodes[i].arcs[d]
        if left == 0:
            continue
        away = distance_to_root(trees, j)
        if away >= 0 and (best == NOBODY or away < least):
            best = d
            least = away
    trees.nodes[i].parent = best
    if best != NOBODY:
        trees.nodes[i].stamp = trees.now
        trees.nodes[i].distance = least + 1
        return
    for d in range(4):
        j = beside(i, d, trees.width)
        if trees.nodes[j].tree != tree or trees.nodes[j].parent == NOBODY:
            continue
        left = trees.nodes[j].arcs[d ^ 2] if tree == SOURCE else trees.nodes[i].arcs[d]
        if left > 0:
            wake(trees, j)
        if trees.nodes[j].parent == d ^ 2:
            lose(trees, j)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def plant(capacities: Capacities, trees: Trees) -> cython.longlong:
    """Fill in the grid's nodes; each one with an arc to a terminal roots a tree.

    Returns the flow from the source through single nodes to the sink.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.Py_ssize_t, d=cython.int)
    cython.declare(arcs=cython.p_const_int, source=cython.int, sink=cython.int)
    height: cython.Py_ssize_t = capacities.height
    width: cython.Py_ssize_t = capacities.width
    flow: cython.longlong = 0
    trees.width = width + 2
    trees.now = 1
    for y in range(height + 2):
        for x in range(width + 2):
            i = y * trees.width + x
            trees.nodes[i].parent = NOBODY
            trees.nodes[i].tree = 0
            trees.nodes[i].distance = 0
            trees.nodes[i].stamp = 0
            trees.nodes[i].waits = 0
            if y == 0 or x == 0 or y > height or x > width:
                for d in range(4):
                    trees.nodes[i].arcs[d] = 0
                continue
            arcs = cython.address(capacities.arcs[y - 1, x - 1, 0])
            trees.nodes[i].arcs[0] = arcs[0] if x < width else 0
            trees.nodes[i].arcs[1] = arcs[1] if y < height else 0
            trees.nodes[i].arcs[2] = arcs[2] if x > 1 else 0
            trees.nodes[i].arcs[3] = arcs[3] if y > 1 else 0
            source = capacities.source[y - 1, x - 1]
            sink = capacities.sink[y - 1, x - 1]
            flow += min(source, sink)
            trees.nodes[i].terminal = source - sink
            if source != sink:
                trees.nodes[i].tree = SOURCE if source > sink else SINK
                trees.nodes[i].parent = ROOT
                trees.nodes[i].distance = 1
                wake(trees, i)
    return flow


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def minimum_cut(
    capacities: Capacities, trees: Trees, side: cython.uchar[:, ::1], most: cython.longlong
) -> cython.longlong:
    """Fill `side` with 1 for nodes that the source reaches through residual capacities.

    That set is the same for every maximum flow. Returns the flow, which is the value of the cut;
    or, once it is more than `most`, the flow so far, and `side` is left.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.Py_ssize_t, d=cython.int)
    flow: cython.longlong = plant(capacities, trees)
    while True:
        i = take(trees.active)
        if i < 0:
            break
        if flow > most:
            trees.active[trees.active.shape[0] - 1] = 0
            return flow
        trees.nodes[i].waits = 0
        while trees.nodes[i].parent != NOBODY:  # a path was found, and i may lead to more of them
            d = grow(trees, i)
            if d < 0:
                break
            trees.now += 1
            flow += augment(trees, i, d)
            while trees.orphans[trees.orphans.shape[0] - 1] > 0:
                adopt(trees, take(trees.orphans))
    for y in range(capacities.height):
        for x in range(capacities.width):
            i = (y + 1) * trees.width + x + 1
            side[y, x] = trees.nodes[i].parent != NOBODY and trees.nodes[i].tree == SOURCE
    return flow


def cut_grid(capacities: Capacities, trees: Trees, side: cython.uchar[:, ::1]):
    """Call `minimum_cut`, beside other threads."""
    cython.declare(flow=cython.longlong)
    with cython.nogil:
        flow = minimum_cut(capacities, trees, side, LLONG_MAX)
    return flow
