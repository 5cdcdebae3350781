# mypy: ignore-errors
# cython: infer_types=True
"""The minimum cut of a grid, by augmenting paths in two search trees that are kept.

Boykov and Kolmogorov, An experimental comparison of min-cut/max-flow algorithms for energy
minimization in vision (2004), section 3; distances and time stamps as in its section 3.2. The grid
has a border of nodes without capacity, so no neighbor is missing.
Compiled by Cython, see setup.py and the .pxd.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX
from cython.cimports.libc.string import memset

# A direction is right, down, left or up; the opposite of d is d ^ 2. A Node: see the .pxd.


class Grid:
    """Capacities of arcs (right, down, left, up) and of the terminals' arcs, and two search trees.

    `nodes` lie row by row in a grid with a border, and `steps` lead to neighbors; `active` nodes
    and `orphans` are rings that end with their start and length. `now` is the number of
    augmentations.
    """

    def __init__(self, arcs, from_source, to_sink, nodes, active, orphans):
        self.arcs, self.from_source, self.to_sink = arcs, from_source, to_sink
        self.nodes, self.active, self.orphans = nodes, active, orphans
        self.height, self.width = from_source.shape


def beside(grid, node, d):
    """The neighbor of a node in direction d."""
    return node + grid.steps[d]


def put(ring, i):
    """Add a node to a ring."""
    room = ring.shape[0] - 2
    at = cython.cast(cython.Py_ssize_t, ring[room]) + ring[room + 1]
    ring[at if at < room else at - room] = i
    ring[room + 1] += 1


def take(ring):
    """Remove a ring's first node; -1 if there is none."""
    room = ring.shape[0] - 2
    if ring[room + 1] == 0:
        return -1
    i = ring[ring[room]]
    ring[room] += 1
    if ring[room] == room:
        ring[room] = 0
    ring[room + 1] -= 1
    return i


def wake(grid, node):
    """Let a node's tree grow from it."""
    if not node.waits:
        node.waits = 1
        put(grid.active, node - cython.address(grid.nodes[0]))


def lose(grid, node):
    """Make a node an orphan."""
    node.parent = LOST
    put(grid.orphans, node - cython.address(grid.nodes[0]))


def grow(grid, node):
    """Grow a tree from a node; return the direction in which it meets the other tree, or -1."""
    tree = node.tree
    for d in range(4):
        near = beside(grid, node, d)
        left = node.arcs[d] if tree == SOURCE else near.arcs[d ^ 2]
        if left == 0:
            continue
        if near.parent == NOBODY:
            near.tree = tree
            near.parent = d ^ 2
            near.stamp = node.stamp
            near.distance = node.distance + 1
            wake(grid, near)
        elif near.tree != tree:
            return d
        elif near.stamp <= node.stamp and near.distance > node.distance:
            near.parent = d ^ 2  # a shorter way to the root
            near.stamp = node.stamp
            near.distance = node.distance + 1
    return -1


def augment(grid, node, d):
    """Push the largest flow through a node and its neighbor in direction d; full arcs orphan."""
    start = node  # in the tree of the source
    end = beside(grid, node, d)
    if node.tree == SINK:
        start = end
        end = node
        d ^= 2
    flow = start.arcs[d]
    k = start
    while k.parent != ROOT:
        p = k.parent
        k = beside(grid, k, p)
        flow = min(flow, k.arcs[p ^ 2])
    flow = min(flow, k.terminal)
    k = end
    while k.parent != ROOT:
        flow = min(flow, k.arcs[k.parent])
        k = beside(grid, k, k.parent)
    flow = min(flow, -k.terminal)

    start.arcs[d] -= flow
    end.arcs[d ^ 2] += flow
    k = start
    while k.parent != ROOT:
        p = k.parent
        up = beside(grid, k, p)
        up.arcs[p ^ 2] -= flow
        k.arcs[p] += flow
        if up.arcs[p ^ 2] == 0:
            lose(grid, k)
        k = up
    k.terminal -= flow
    if k.terminal == 0:
        lose(grid, k)
    k = end
    while k.parent != ROOT:
        p = k.parent
        up = beside(grid, k, p)
        k.arcs[p] -= flow
        up.arcs[p ^ 2] += flow
        if k.arcs[p] == 0:
            lose(grid, k)
        k = up
    k.terminal += flow
    if k.terminal == 0:
        lose(grid, k)
    return flow


def distance_to_root(grid, node):
    """The number of arcs from a node to its terminal; -1 if an orphan is on the way."""
    k = node
    away: cython.int = 0
    while k.stamp != grid.now:
        if k.parent == LOST:
            return -1
        away += 1
        if k.parent == ROOT:
            k.stamp = grid.now
            k.distance = 1
            break
        k = beside(grid, k, k.parent)
    else:
        away += k.distance
    left = away
    k = node
    while k.stamp != grid.now:
        k.stamp = grid.now
        k.distance = left
        left -= 1
        k = beside(grid, k, k.parent)
    return away


def adopt(grid, node):
    """Find an orphan the parent that is nearest to the terminal, or let it and its children go."""
    tree = node.tree
    best: cython.int = NOBODY
    least: cython.int = 0
    for d in range(4):
        near = beside(grid, node, d)
        if near.tree != tree or near.parent == NOBODY:
            continue
        left = near.arcs[d ^ 2] if tree == SOURCE else node.arcs[d]
        if left == 0:
            continue
        away = distance_to_root(grid, near)
        if away >= 0 and (best == NOBODY or away < least):
            best = d
            least = away
    node.parent = best
    if best != NOBODY:
        node.stamp = grid.now
        node.distance = least + 1
        return
    for d in range(4):
        near = beside(grid, node, d)
        if near.tree != tree or near.parent == NOBODY:
            continue
        left = near.arcs[d ^ 2] if tree == SOURCE else node.arcs[d]
        if left > 0:
            wake(grid, near)
        if near.parent == d ^ 2:
            lose(grid, near)


def plant(grid):
    """Fill in the nodes, those with a terminal as roots; return the flow through single nodes."""
    node = cython.address(grid.nodes[0])
    height, width = grid.height, grid.width
    flow: cython.longlong = 0
    grid.steps[0] = 1
    grid.steps[1] = width + 2
    grid.steps[2] = -1
    grid.steps[3] = -width - 2
    grid.now = 1
    for y in range(height + 2):
        for x in range(width + 2):
            memset(node, 0, cython.sizeof(Node))
            node.parent = NOBODY
            if y > 0 and x > 0 and y <= height and x <= width:
                arcs = cython.address(grid.arcs[y - 1, x - 1, 0])
                node.arcs[0] = arcs[0] if x < width else 0
                node.arcs[1] = arcs[1] if y < height else 0
                node.arcs[2] = arcs[2] if x > 1 else 0
                node.arcs[3] = arcs[3] if y > 1 else 0
                source = grid.from_source[y - 1, x - 1]
                sink = grid.to_sink[y - 1, x - 1]
                flow += min(source, sink)
                node.terminal = source - sink
                if source != sink:
                    node.tree = SOURCE if source > sink else SINK
                    node.parent = ROOT
                    node.distance = 1
                    wake(grid, node)
            node += 1
    return flow


def max_flow(grid, side, most):
    """Mark in `side` the nodes that residual capacities reach from the source; return the flow.

    Once the flow exceeds `most`, stop and leave `side` as it is.
    """
    first = cython.address(grid.nodes[0])
    flow = plant(grid)
    while True:
        i = take(grid.active)
        if i < 0:
            break
        if flow > most:
            grid.active[grid.active.shape[0] - 1] = 0
            return flow
        node = first + i
        node.waits = 0
        while node.parent != NOBODY:  # a path was found, and it may lead to more of them
            d = grow(grid, node)
            if d < 0:
                break
            grid.now += 1
            flow += augment(grid, node, d)
            while grid.orphans[grid.orphans.shape[0] - 1] > 0:
                adopt(grid, first + take(grid.orphans))
    for y in range(grid.height):
        node = beside(grid, first + 1, 1) + y * grid.steps[1]
        for x in range(grid.width):
            side[y, x] = node[x].parent != NOBODY and node[x].tree == SOURCE
    return flow


def cut_grid(grid: Grid, side: cython.uchar[:, ::1]):
    """Call `max_flow`, beside other threads."""
    with cython.nogil:
        flow = max_flow(grid, side, LLONG_MAX)
    return flow
