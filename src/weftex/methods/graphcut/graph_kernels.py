# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch, its cut, and the paste (section 3).

A patch is cut in blocks of pixels first, a node for each, then in smaller blocks around that cut.
Every labeling of blocks is one of pixels of the same cost, so no step raises it. Only pairs of
pixels in different blocks, or with a seam between them, have a cost; `runs` skips all others.
Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX
from cython.cimports.libc.string import memset
from cython.cimports.weftex.methods.graphcut.cost_kernels import (
    Labeling,
    continued,
    difference,
    divided,
    neighbor,
    seam_cost,
    update_runs,
)
from cython.cimports.weftex.seams.maxflow_kernels import Grid, max_flow


@cython.cclass
class Graph(Grid):
    """The graph of a patch over a box of the canvas, allocated for the largest box."""

    def __init__(self, labeling: Labeling, choice, side, near, costs, **grid):
        Grid.__init__(self, **grid)
        self.labeling = labeling
        self.choice = choice
        self.side = side
        self.near = near
        self.costs = costs

    def cover(self, rows, columns, from_rows, from_columns):
        """Set the rows and columns of the box, on the canvas and in the sample."""
        self.rows, self.columns = rows, columns
        self.from_rows, self.from_columns = from_rows, from_columns


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mark_choices(graph: Graph) -> cython.Py_ssize_t:
    """Fill in what each pixel may be; return the number of missing pixels that become new."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, p=cython.int, run=cython.Py_ssize_t)
    cython.declare(done=cython.bint)
    whole: cython.bint = graph.labeling.whole
    width: cython.Py_ssize_t = graph.columns.shape[0]
    missing: cython.Py_ssize_t = 0
    for i in range(graph.rows.shape[0]):
        j = 0
        while j < width:
            p = on_canvas(graph, i, j)
            done = graph.labeling.done[p]
            run = graph.labeling.runs[p] if whole else 0
            if run != 0:
                run = min(run if run > 0 else -run, width - j)
                memset(cython.address(graph.choice[i, j]), EITHER if done else NEW, run)
                missing += 0 if done else run
                j += run
                continue
            if done and graph.labeling.known[p]:
                graph.choice[i, j] = OLD
            elif whole or graph.labeling.usable[in_sample(graph, i, j)]:
                graph.choice[i, j] = EITHER if done else NEW
            else:
                graph.choice[i, j] = OLD if done else NOTHING
            missing += graph.choice[i, j] == NEW
            j += 1
    return missing


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_pair(
    graph: Graph, i: cython.Py_ssize_t, j: cython.Py_ssize_t, d: cython.int, halvings: cython.int
) -> cython.longlong:
    """Add the seams, new and old, between a pixel of the box and its neighbor in direction d.

    The pair costs a if only the neighbor becomes new, b if only the pixel does, c if both stay old
    (an old seam, or 0), and 0 if both become new. Instead of the paper's seam node (section 3.1),
    the arcs from the source to both take alpha + beta = c, and the arcs between them a - alpha and
    b - beta. This is exact if c <= a + b, as with metrics. Where costs weighed by gradients break
    it, b is raised to c - a; the cheapest labels are still no worse than the old ones. A neighbor
    outside the box stays old. Returns the cost of the pair if neither pixel has a choice.
    """
    cython.declare(a=cython.longlong, b=cython.longlong, c=cython.longlong, alpha=cython.longlong)
    cython.declare(p_new=cython.int, q=cython.int, q_new=cython.int, q_may=cython.int)
    cython.declare(joined=cython.bint)
    labels: cython.p_int = cython.address(graph.labeling.labels[0])
    way: cython.int = 1 - (d & 2)
    dy: cython.int = way if d & 1 else 0
    dx: cython.int = 0 if d & 1 else way
    v: cython.Py_ssize_t = i + dy
    u: cython.Py_ssize_t = j + dx
    inside: cython.bint = 0 <= v < graph.rows.shape[0] and 0 <= u < graph.columns.shape[0]
    p_may: cython.int = graph.choice[i, j]
    q_may = graph.choice[v, u] if inside else OLD
    if p_may == NOTHING or q_may == NOTHING or p_may | q_may != EITHER:
        return 0  # both stay old, or both become new
    p: cython.int = on_canvas(graph, i, j)
    if inside:
        q = on_canvas(graph, v, u)
        q_new = in_sample(graph, v, u)
    else:
        q = neighbor(graph.labeling, p, dy, dx)
        q_new = -1
        if q < 0 or q == p or not graph.labeling.done[q]:
            return 0
    bi: cython.Py_ssize_t = i >> halvings
    bj: cython.Py_ssize_t = j >> halvings
    bv: cython.Py_ssize_t = v >> halvings
    bu: cython.Py_ssize_t = u >> halvings
    together: cython.bint = p_may == EITHER and q_may == EITHER
    joined = labels[q] >= 0 and continued(graph.labeling, labels[p], d) == labels[q]
    c = 0
    if not joined and p_may & OLD and q_may & OLD:
        c = seam_cost(graph.labeling, p, q, d, labels[p], labels[q])
        graph.before += c
    if together and bi == bv and bj == bu:
        graph.source[bi, bj] += cython.cast(cython.int, c)
        return 0
    p_new = in_sample(graph, i, j)
    a = 0
    b = 0
    if p_may & OLD and q_may & NEW:
        a = seam_cost(graph.labeling, p, q, d, labels[p], q_new)
    if joined and together and continued(graph.labeling, p_new, d) == q_new:
        b = a  # both patches continue
    elif p_may & NEW and q_may & OLD:
        b = seam_cost(graph.labeling, p, q, d, p_new, labels[q])
    if together:
        b = max(b, c - a)
        alpha = min(a, c)
        graph.source[bi, bj] += cython.cast(cython.int, alpha)
        graph.source[bv, bu] += cython.cast(cython.int, c - alpha)
        graph.arcs[bv, bu, d ^ 2] += cython.cast(cython.int, a - alpha)
        graph.arcs[bi, bj, d] += cython.cast(cython.int, b - c + alpha)
    elif p_may == EITHER:
        graph.source[bi, bj] += cython.cast(cython.int, c + a)
        graph.sink[bi, bj] += cython.cast(cython.int, b)
    elif q_may == EITHER:
        graph.source[bv, bu] += cython.cast(cython.int, c + b)
        graph.sink[bv, bu] += cython.cast(cython.int, a)
    else:
        return a + b
    return 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_within(
    graph: Graph, i: cython.Py_ssize_t, first: cython.Py_ssize_t, count: cython.Py_ssize_t,
    d: cython.int, halvings: cython.int,
) -> cython.void:  # fmt: skip
    """Add pairs of pixels that continue both the old and the new patch: a = b, c = 0.

    The pixels lie in row i of the box from column `first` on, side by side for pairs with lower
    neighbors (d = 1), else a block's width apart; their labels have the same steps.
    """
    cython.declare(k=cython.Py_ssize_t, at=cython.Py_ssize_t, end=cython.Py_ssize_t)
    cython.declare(one=cython.p_const_int, other=cython.p_const_int, total=cython.int)
    step: cython.Py_ssize_t = 1 if d else 1 << halvings
    channels: cython.int = cython.cast(cython.int, graph.labeling.colors.shape[1])
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = first + 1 - d
    at_p: cython.int = on_canvas(graph, i, first)
    new: cython.int = in_sample(graph, i, first)
    p: cython.p_const_uchar = cython.address(graph.labeling.pixels[at_p, 0])
    p_new: cython.p_const_uchar = cython.address(graph.labeling.colors[new, 0])
    q: cython.p_const_uchar = cython.address(graph.labeling.pixels[on_canvas(graph, v, u), 0])
    q_new: cython.p_const_uchar = cython.address(graph.labeling.colors[in_sample(graph, v, u), 0])
    cost: cython.p_int = cython.address(graph.costs[0])
    for k in range(count):
        at = k * step * channels
        cost[k] = difference(p + at, p_new + at, channels)
        cost[k] += difference(q + at, q_new + at, channels)
    if graph.labeling.by_gradients:
        one = cython.address(graph.labeling.gradients[d, graph.labeling.labels[at_p]])
        other = cython.address(graph.labeling.gradients[d, new])
        for k in range(count):
            cost[k] = divided(cost[k], one[k * step] + other[k * step], channels)
    k = 0
    while k < count:
        at = (first + k * step) >> halvings
        end = min(((at + 1) << halvings) - first, count) if d else k + 1
        total = 0
        while k < end:
            total += cost[k]
            k += 1
        graph.arcs[i >> halvings, at, d] += total
        graph.arcs[v >> halvings, at + 1 - d, d + 2] += total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_run(
    graph: Graph, i: cython.Py_ssize_t, first: cython.Py_ssize_t, end: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.longlong:  # fmt: skip
    """Add the pairs of pixels of one old patch side by side, and their right and lower neighbors.

    Returns the cost of pairs without a choice.
    """
    cython.declare(k=cython.Py_ssize_t)
    block: cython.Py_ssize_t = 1 << halvings
    border: cython.Py_ssize_t = first | (block - 1)  # the last pixel of a block
    fixed: cython.longlong = add_pair(graph, i, end - 1, 0, halvings)
    if border < end - 1:
        add_within(graph, i, border, (end - 2 - border) // block + 1, 0, halvings)
    if i + 1 == graph.rows.shape[0]:
        for k in range(first, end):
            fixed += add_pair(graph, i, k, 1, halvings)
    elif (i + 1) & (block - 1) == 0:
        add_within(graph, i, first, end - first, 1, halvings)
    return fixed


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def is_straight(
    graph: Graph, i: cython.Py_ssize_t, first: cython.Py_ssize_t, last: cython.Py_ssize_t
) -> cython.bint:
    """Whether a run of the box wraps neither around the canvas nor around a tileable sample."""
    apart: cython.int = graph.labeling.labels[on_canvas(graph, i, last)]
    apart -= graph.labeling.labels[on_canvas(graph, i, first)]
    return apart == last - first == graph.from_columns[last] - graph.from_columns[first]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build(graph: Graph, halvings: cython.int, by_runs: cython.bint) -> cython.longlong:
    """Fill in the graph whose minimum cut says which blocks of the box the patch replaces.

    What each pixel may be is in `graph.choice`; `by_runs`: as `mark_choices` filled it in. Returns
    the cost of pairs without a choice.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, run=cython.Py_ssize_t)
    cython.declare(may=cython.p_const_uchar, below=cython.p_const_uchar, alike=cython.bint)
    height: cython.Py_ssize_t = graph.rows.shape[0]
    width: cython.Py_ssize_t = graph.columns.shape[0]
    row: cython.size_t
    fixed: cython.longlong = 0
    by_runs = by_runs and graph.labeling.whole
    graph.before = 0
    graph.height = blocks(height, halvings)
    graph.width = blocks(width, halvings)
    row = graph.width * cython.sizeof(cython.int)
    for i in range(graph.height):
        memset(cython.address(graph.source[i, 0]), 0, row)
        memset(cython.address(graph.sink[i, 0]), 0, row)
        memset(cython.address(graph.arcs[i, 0, 0]), 0, 4 * row)
    for i in range(height):
        may = cython.address(graph.choice[i, 0])
        below = may if i + 1 == height else cython.address(graph.choice[i + 1, 0])
        j = 0
        while j < width:
            run = graph.labeling.runs[on_canvas(graph, i, j)] if by_runs else 0
            run = min(run, width - j)
            if run > 0 and is_straight(graph, i, j, j + run - 1):
                fixed += add_run(graph, i, j, j + run, halvings)
                j += run
                continue
            if run < -1 and i + 1 < height:  # missing, as the pixels below may be
                run = min(-run, width - j)
                if graph.labeling.runs[on_canvas(graph, i + 1, j)] <= -run:
                    j += run - 1
            alike = j + 1 < width and may[j] != EITHER and may[j + 1] == may[j] == below[j]
            if not alike or i + 1 == height:
                fixed += add_pair(graph, i, j, 0, halvings)
                fixed += add_pair(graph, i, j, 1, halvings)
            j += 1
        fixed += add_pair(graph, i, 0, 2, halvings)
    for j in range(width):
        fixed += add_pair(graph, 0, j, 3, halvings)
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut(
    graph: Graph, halvings: cython.int, by_runs: cython.bint, most: cython.longlong
) -> cython.longlong:
    """Cut in blocks, see `build`; return the cost of seams after less that before.

    A cut that costs more than `most` is not completed, and costs more than is returned.
    """
    cost: cython.longlong = build(graph, halvings, by_runs) - graph.before
    return cost + max_flow(graph, graph.side, most - cost)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def narrow(graph: Graph, halvings: cython.int) -> cython.void:
    """Leave a choice to pixels near the cut only: in blocks that it passes, and those around them.

    Outside the box all pixels are old.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, may=cython.int)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, near=cython.int)
    cython.declare(inside=cython.bint)
    block: cython.Py_ssize_t = 1 << halvings
    height: cython.Py_ssize_t = blocks(graph.rows.shape[0], halvings)
    width: cython.Py_ssize_t = blocks(graph.columns.shape[0], halvings)
    has: cython.uchar[:, ::1] = graph.near  # OLD and NEW, if a block has such pixels
    for i in range(height):
        memset(cython.address(has[i, 0]), 0, width)
    for i in range(graph.rows.shape[0]):
        for j in range(graph.columns.shape[0]):
            may = graph.choice[i, j]
            if may == EITHER:
                may = NEW if graph.side[i >> halvings, j >> halvings] else OLD
            has[i >> halvings, j >> halvings] |= may
    for i in range(height):
        for j in range(width):
            inside = REACH <= i < height - REACH and REACH <= j < width - REACH
            near = NOTHING if inside else OLD
            for v in range(max(0, i - REACH), min(i + REACH + 1, height)):
                for u in range(max(0, j - REACH), min(j + REACH + 1, width)):
                    near |= has[v, u]
            if near == EITHER:
                continue
            for v in range(i * block, min((i + 1) * block, graph.rows.shape[0])):
                for u in range(j * block, min((j + 1) * block, graph.columns.shape[0])):
                    if graph.choice[v, u] == EITHER:
                        graph.choice[v, u] = near


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def paste(graph: Graph) -> cython.Py_ssize_t:
    """Copy the pixels on the new side of the cut; return how many of them were missing."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.int, label=cython.int, may=cython.int)
    covered: cython.Py_ssize_t = 0
    for i in range(graph.rows.shape[0]):
        for j in range(graph.columns.shape[0]):
            may = graph.choice[i, j]
            if not (may == NEW or (may == EITHER and graph.side[i, j])):
                continue
            p = on_canvas(graph, i, j)
            label = in_sample(graph, i, j)
            covered += not graph.labeling.done[p]
            graph.labeling.done[p] = 1
            graph.labeling.labels[p] = label
            for k in range(graph.labeling.colors.shape[1]):
                graph.labeling.pixels[p, k] = graph.labeling.colors[label, k]
    update_runs(graph.labeling, graph.rows, graph.columns)
    return covered


def cost_in_blocks(graph: Graph, halvings: cython.int, least: cython.double):
    """By how much a cut in blocks raises the cost of seams, and how many pixels it newly covers.

    A cut that costs more than `least` for each of these pixels is not completed.
    """
    cython.declare(cost=cython.longlong, covered=cython.Py_ssize_t, limit=cython.longlong)
    with cython.nogil:  # beside other threads
        covered = mark_choices(graph)
        least *= max(covered, 1)
        limit = LLONG_MAX // 2
        if least < 1e18:
            limit = cython.cast(cython.longlong, least) + 1
        cost = cut(graph, halvings, True, limit)
    return cost, covered


def paste_patch(graph: Graph, halvings: cython.int):
    """Cut in blocks, then in smaller ones around that cut, and paste; see `paste`."""
    mark_choices(graph)
    cut(graph, halvings, True, LLONG_MAX // 2)
    while halvings > 0:
        narrow(graph, halvings)
        halvings = max(0, halvings - STEP)
        cut(graph, halvings, False, LLONG_MAX // 2)
    return paste(graph)
