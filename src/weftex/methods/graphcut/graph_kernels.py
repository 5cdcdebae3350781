# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch (Kwatra et al., 2003, section 3).

A node is a pixel or a block of pixels: every labeling of blocks is one of pixels of the same
cost. Only pairs of pixels in different blocks, or with a seam between them, have a cost; `runs`
skips all others. Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    SCALE,
    SOFT,
    Labeling,
    SeamCost,
    beside,
    continued,
    difference,
    seam_cost,
)
from cython.cimports.weftex.seams.maxflow_kernels import Capacities


@cython.cclass
class Graph:
    """The graph of a patch over a box of the canvas; there is room for the largest box."""

    def __init__(self, arcs, old, new, choice, side, near, scratch, trees):
        self.arcs = arcs
        self.old = old
        self.new = new
        self.choice = choice
        self.side = side
        self.near = near
        self.scratch = scratch
        self.capacities = Capacities(self.arcs, self.old, self.new)
        self.trees = trees

    def cover(self, rows, columns, from_rows, from_columns):
        """Set the rows and columns of the box, on the canvas and in the sample."""
        self.rows, self.columns = rows, columns
        self.from_rows, self.from_columns = from_rows, from_columns


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(labeling: Labeling, sample: SeamCost, graph: Graph) -> cython.Py_ssize_t:
    """Fill in what each pixel may be; return the number of missing pixels that become new."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, p=cython.int, run=cython.Py_ssize_t)
    width: cython.Py_ssize_t = graph.columns.shape[0]
    missing: cython.Py_ssize_t = 0
    for i in range(graph.rows.shape[0]):
        j = 0
        while j < width:
            p = on_canvas(labeling, graph, i, j)
            run = labeling.runs[p] if sample.whole else 0
            if run != 0:
                run = min(run if run > 0 else -run, width - j)
                memset(cython.address(graph.choice[i, j]), EITHER if labeling.done[p] else NEW, run)
                missing += 0 if labeling.done[p] else run
                j += run
                continue
            if labeling.done[p] and labeling.known[p]:
                graph.choice[i, j] = OLD
            elif sample.whole or sample.usable[in_sample(sample, graph, i, j)]:
                graph.choice[i, j] = EITHER if labeling.done[p] else NEW
            else:
                graph.choice[i, j] = OLD if labeling.done[p] else NOTHING
            missing += graph.choice[i, j] == NEW
            j += 1
    return missing


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_outside(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its neighbor outside the box, which stays as it is.

    Returns the cost of the pair if the pixel has no choice.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)
    may: cython.int = graph.choice[i, j]
    p: cython.int = on_canvas(labeling, graph, i, j)
    way: cython.int = 1 - d // 2 * 2
    q: cython.int = beside(labeling, p, d % 2 * way, (1 - d % 2) * way)
    if q < 0 or q == p or not labeling.done[q] or may == OLD or may == NOTHING:
        return 0
    q_old = seam_cost(labeling, sample, p, q, d, in_sample(sample, graph, i, j), labeling.source[q])
    if may == NEW:
        return q_old
    graph.new[i >> halvings, j >> halvings] += cython.cast(cython.int, q_old)
    p_old = seam_cost(labeling, sample, p, q, d, labeling.source[p], labeling.source[q])
    graph.old[i >> halvings, j >> halvings] += cython.cast(cython.int, p_old)
    graph.before += p_old
    return 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_pair(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its right (d = 0) or lower (d = 1) neighbor in the box.

    It costs c if both stay old (an old seam, or 0), a or b if one becomes new, and 0 if both do.
    Instead of the paper's seam node (section 3.1), the arcs from the source to both take
    alpha + beta = c, and the arcs between them a - alpha and b - beta. This is exact if
    c <= a + b, as with metrics. Where costs weighed by gradients break it, b is raised to c - a;
    the cheapest labels are still no worse than the old ones.
    Returns the cost of the pair if neither pixel has a choice.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)  # and the other one new
    cython.declare(alpha=cython.longlong, p_new=cython.int, q_new=cython.int)
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    p_may: cython.int = graph.choice[i, j]
    q_may: cython.int = graph.choice[v, u]
    p: cython.int = on_canvas(labeling, graph, i, j)
    q: cython.int = on_canvas(labeling, graph, v, u)
    label_p: cython.int = labeling.source[p]
    label_q: cython.int = labeling.source[q]
    bi: cython.Py_ssize_t = i >> halvings
    bj: cython.Py_ssize_t = j >> halvings
    bv: cython.Py_ssize_t = v >> halvings
    bu: cython.Py_ssize_t = u >> halvings
    together: cython.bint = p_may == EITHER and q_may == EITHER
    both_old: cython.longlong = 0
    joined: cython.bint = label_q >= 0 and continued(sample, label_p, d) == label_q
    if not joined and p_may & OLD and q_may & OLD:
        both_old = seam_cost(labeling, sample, p, q, d, label_p, label_q)
        graph.before += both_old
    if together and bi == bv and bj == bu:
        graph.old[bi, bj] += cython.cast(cython.int, both_old)
        return 0
    p_new = in_sample(sample, graph, i, j)
    q_new = in_sample(sample, graph, v, u)
    p_old = 0
    q_old = 0
    if p_may & OLD and q_may & NEW:
        p_old = seam_cost(labeling, sample, p, q, d, label_p, q_new)
    if joined and together and continued(sample, p_new, d) == q_new:
        q_old = p_old  # both patches continue
    elif p_may & NEW and q_may & OLD:
        q_old = seam_cost(labeling, sample, p, q, d, p_new, label_q)
    if together:
        q_old = max(q_old, both_old - p_old)
        alpha = min(p_old, both_old)
        graph.old[bi, bj] += cython.cast(cython.int, alpha)
        graph.old[bv, bu] += cython.cast(cython.int, both_old - alpha)
        graph.arcs[bv, bu, d + 2] += cython.cast(cython.int, p_old - alpha)
        graph.arcs[bi, bj, d] += cython.cast(cython.int, q_old - both_old + alpha)
    elif p_may == EITHER:
        graph.old[bi, bj] += cython.cast(cython.int, both_old + p_old)
        graph.new[bi, bj] += cython.cast(cython.int, q_old)
    elif q_may == EITHER:
        graph.old[bv, bu] += cython.cast(cython.int, both_old + q_old)
        graph.new[bv, bu] += cython.cast(cython.int, p_old)
    else:
        return p_old + q_old
    return 0


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def add_neighbor(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its right (d = 0) or lower neighbor, if it has a cost.

    Returns that cost if neither has a choice.
    """
    cython.declare(other=cython.int, p=cython.int, label=cython.int)
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    may: cython.int = graph.choice[i, j]
    if v == graph.rows.shape[0] or u == graph.columns.shape[0]:
        return add_outside(labeling, sample, graph, i, j, d, halvings)
    other = graph.choice[v, u]
    if other == NOTHING or may | other != EITHER:  # both stay old or both become new
        return 0
    if may == other and i >> halvings == v >> halvings and j >> halvings == u >> halvings:
        p = on_canvas(labeling, graph, i, j)
        label = labeling.source[p]
        if (
            label >= 0
            and continued(sample, label, d) == labeling.source[on_canvas(labeling, graph, v, u)]
        ):
            return 0
    return add_pair(labeling, sample, graph, i, j, d, halvings)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_within(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    i: cython.Py_ssize_t,
    first: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
) -> cython.void:
    """Add pairs of pixels that continue both the old and the new patch: a = b, c = 0.

    The pixels lie in row i of the box from column `first` on, side by side for pairs with lower
    neighbors (d = 1), else a block's width apart. Their labels, and those of the patch, are flat
    indices with the same steps.
    """
    cython.declare(k=cython.Py_ssize_t, at=cython.Py_ssize_t, end=cython.Py_ssize_t)
    cython.declare(one=cython.p_const_int, other=cython.p_const_int, total=cython.int)
    step: cython.Py_ssize_t = 1 if d else 1 << halvings
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    v: cython.Py_ssize_t = i + d
    old: cython.int = labeling.source[on_canvas(labeling, graph, i, first)]
    new: cython.int = in_sample(sample, graph, i, first)
    p: cython.p_const_uchar = cython.address(
        labeling.pixels[on_canvas(labeling, graph, i, first), 0]
    )
    p_new: cython.p_const_uchar = cython.address(sample.pixels[new, 0])
    q: cython.p_const_uchar = cython.address(
        labeling.pixels[on_canvas(labeling, graph, v, first + 1 - d), 0]
    )
    q_new: cython.p_const_uchar = cython.address(
        sample.pixels[in_sample(sample, graph, v, first + 1 - d), 0]
    )
    cost: cython.p_int = cython.address(graph.scratch[0, 0])
    gradient: cython.p_int = cython.address(graph.scratch[1, 0])
    softly: cython.int = SOFT * cython.cast(cython.int, channels)
    if d and channels == 3:  # most pictures; the loop for any step and number is slower
        for k in range(count):
            cost[k] = difference(p + 3 * k, p_new + 3 * k, 3)
            cost[k] += difference(q + 3 * k, q_new + 3 * k, 3)
    else:
        for k in range(count):
            at = k * step * channels
            cost[k] = difference(p + at, p_new + at, channels)
            cost[k] += difference(q + at, q_new + at, channels)
    if sample.by_gradients:
        one = cython.address(sample.gradients[d, old])
        other = cython.address(sample.gradients[d, new])
        for k in range(count):
            gradient[k] = one[k * step] + other[k * step] + softly
        for k in range(count):  # exact, and faster than a division of integers
            cost[k] = cython.cast(
                cython.int, cython.cast(cython.double, SCALE * cost[k]) / gradient[k]
            )
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
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    i: cython.Py_ssize_t,
    first: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pairs of pixels of one old patch side by side, and their right and lower neighbors.

    Returns the cost of pairs without a choice.
    """
    cython.declare(k=cython.Py_ssize_t)
    block: cython.Py_ssize_t = 1 << halvings
    fixed: cython.longlong = 0
    last: cython.Py_ssize_t = end - 1
    border: cython.Py_ssize_t = first | (block - 1)  # the last pixel of a block
    lowest: cython.bint = i + 1 == graph.rows.shape[0]
    apart: cython.int = labeling.source[on_canvas(labeling, graph, i, last)]
    apart -= labeling.source[on_canvas(labeling, graph, i, first)]
    straight: cython.bint = apart == last - first
    straight = straight and graph.from_columns[last] - graph.from_columns[first] == last - first
    if straight and border < last:
        add_within(
            labeling, sample, graph, i, border, (last - 1 - border) // block + 1, 0, halvings
        )
    elif not straight:
        while border < last:
            fixed += add_neighbor(labeling, sample, graph, i, border, 0, halvings)
            border += block
    fixed += add_neighbor(labeling, sample, graph, i, last, 0, halvings)
    if (i + 1) & (block - 1) and not lowest:
        return fixed
    if straight and not lowest:
        add_within(labeling, sample, graph, i, first, end - first, 1, halvings)
        return fixed
    for k in range(first, end):
        fixed += add_neighbor(labeling, sample, graph, i, k, 1, halvings)
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    halvings: cython.int,
    by_runs: cython.bint,
) -> cython.longlong:
    """Fill in the graph whose minimum cut says which blocks of the box the patch replaces.

    What each pixel may be is in `graph.choice`; `by_runs`: as `choose` filled it in. Returns the
    cost of pairs without a choice.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, run=cython.Py_ssize_t)
    cython.declare(may=cython.p_const_uchar, below=cython.p_const_uchar, alike=cython.bint)
    height: cython.Py_ssize_t = graph.rows.shape[0]
    width: cython.Py_ssize_t = graph.columns.shape[0]
    row: cython.size_t = blocks(width, halvings) * cython.sizeof(cython.int)
    fixed: cython.longlong = 0
    by_runs = by_runs and sample.whole
    graph.before = 0
    for i in range(blocks(height, halvings)):
        memset(cython.address(graph.old[i, 0]), 0, row)
        memset(cython.address(graph.new[i, 0]), 0, row)
        memset(cython.address(graph.arcs[i, 0, 0]), 0, 4 * row)
    for i in range(height):
        may = cython.address(graph.choice[i, 0])
        below = may if i + 1 == height else cython.address(graph.choice[i + 1, 0])
        j = 0
        while j < width:
            run = labeling.runs[on_canvas(labeling, graph, i, j)] if by_runs else 0
            if run > 0:
                run = min(run, width - j)
                fixed += add_run(labeling, sample, graph, i, j, j + run, halvings)
                j += run
                continue
            if run < -1 and i + 1 < height:  # missing, as the pixels below may be
                run = min(-run, width - j)
                if labeling.runs[on_canvas(labeling, graph, i + 1, j)] <= -run:
                    j += run - 1
            alike = j + 1 < width and may[j] != EITHER and may[j + 1] == may[j] == below[j]
            if may[j] != NOTHING and (not alike or i + 1 == height):
                fixed += add_neighbor(labeling, sample, graph, i, j, 0, halvings)
                fixed += add_neighbor(labeling, sample, graph, i, j, 1, halvings)
            j += 1
        fixed += add_outside(labeling, sample, graph, i, 0, 2, halvings)
    for j in range(width):
        fixed += add_outside(labeling, sample, graph, 0, j, 3, halvings)
    return fixed
