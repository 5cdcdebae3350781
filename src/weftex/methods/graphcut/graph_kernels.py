# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch; compiled by Cython, see setup.py.

A node is a pixel, or a block of pixels. All labellings of blocks are labellings of pixels with the
same cost.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    Picture,
    Sample,
    beside,
    continued,
    difference,
    seam_cost,
)
from cython.cimports.weftex.seams.maxflow_kernels import Capacities


@cython.cclass
class Patch:
    """A patch over a box of the canvas: its rows and columns there and in the sample."""

    def __init__(self, rows, columns, from_rows, from_columns):
        self.rows = rows
        self.columns = columns
        self.from_rows = from_rows
        self.from_columns = from_columns


@cython.cclass
class Graph:
    """A node for each block of a box; a cut says which ones stay old and which become new.

    There is room for the largest box, and for what is worked out of its rows.
    """

    def __init__(self, arcs, old, new, apart, choice, side, shown, along, trees, bytes, sums):
        self.arcs = arcs
        self.old = old
        self.new = new
        self.apart = apart
        self.choice = choice
        self.side = side
        self.shown = shown
        self.along = along
        self.capacities = Capacities(arcs, old, new)
        self.trees = trees
        self.bytes = bytes
        self.sums = sums
        self.before = 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_outside(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    may: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its neighbor outside the box, which stays as it is.

    `may` is the pixel's choice. Returns the pair's cost if that is none.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)
    p: cython.int = on_canvas(picture, patch, i, j)
    way: cython.int = 1 - d // 2 * 2
    q: cython.int = beside(picture, p, d % 2 * way, (1 - d % 2) * way)
    if q < 0 or q == p or not picture.done[q] or may == OLD:
        return 0
    q_old = seam_cost(picture, sample, p, q, d, in_sample(sample, patch, i, j), picture.source[q])
    if may == NEW:
        return q_old
    graph.new[i >> halvings, j >> halvings] += cython.cast(cython.int, q_old)
    p_old = seam_cost(picture, sample, p, q, d, picture.source[p], picture.source[q])
    graph.old[i >> halvings, j >> halvings] += cython.cast(cython.int, p_old)
    graph.before += p_old
    return 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_pair(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    p_may: cython.int,
    q_may: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its right (d = 0) or lower (d = 1) neighbor in the box.

    It costs c if both stay old (an old seam, or 0), a or b if one becomes new, and 0 if both do.
    Instead of the paper's seam node (section 3.1), the arcs from the source to both take
    alpha + beta = c, and the arcs between them a - alpha and b - beta. This is exact if
    c <= a + b, as with metrics. Where costs weighed by gradients break it, b is raised to c - a;
    the cheapest labels are still no worse than the old ones.

    `p_may` and `q_may` are their choices. Returns the pair's cost if neither has one.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)  # and the other one new
    cython.declare(alpha=cython.longlong, p_new=cython.int, q_new=cython.int)
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    both_old: cython.longlong = 0
    p: cython.int = on_canvas(picture, patch, i, j)
    q: cython.int = on_canvas(picture, patch, v, u)
    label_p: cython.int = picture.source[p]
    label_q: cython.int = picture.source[q]
    go_on: cython.bint = label_q >= 0 and continued(sample, label_p, d) == label_q
    bi: cython.Py_ssize_t = i >> halvings
    bj: cython.Py_ssize_t = j >> halvings
    bv: cython.Py_ssize_t = v >> halvings
    bu: cython.Py_ssize_t = u >> halvings
    together: cython.bint = p_may == EITHER and q_may == EITHER
    inside: cython.bint = together and bi == bv and bj == bu
    if not go_on and p_may & OLD and q_may & OLD:
        both_old = seam_cost(picture, sample, p, q, d, label_p, label_q)
        graph.before += both_old
    if inside:
        graph.old[bi, bj] += cython.cast(cython.int, both_old)
        return 0
    p_new = in_sample(sample, patch, i, j)
    q_new = in_sample(sample, patch, v, u)
    p_old = 0
    q_old = 0
    if p_may & OLD and q_may & NEW:
        p_old = seam_cost(picture, sample, p, q, d, label_p, q_new)
    if p_may & NEW and q_may & OLD:
        q_old = seam_cost(picture, sample, p, q, d, p_new, label_q)
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
@cython.nogil
@cython.exceptval(check=False)
def clear(patch: Patch, graph: Graph, halvings: cython.int) -> cython.void:
    """A graph without arcs."""
    cython.declare(i=cython.Py_ssize_t)
    row: cython.size_t = blocks(patch.columns.shape[0], halvings) * cython.sizeof(cython.int)
    graph.before = 0
    for i in range(blocks(patch.rows.shape[0], halvings)):
        memset(cython.address(graph.old[i, 0]), 0, row)
        memset(cython.address(graph.new[i, 0]), 0, row)
        memset(cython.address(graph.arcs[i, 0, 0]), 0, 4 * row)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def measure(picture: Picture, sample: Sample, patch: Patch, graph: Graph) -> cython.void:
    """Fill in how far the colors of pixels are apart that may be old or new."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    for i in range(patch.rows.shape[0]):
        for j in range(patch.columns.shape[0]):
            if graph.choice[i, j] == EITHER:
                graph.apart[i, j] = difference(
                    cython.address(picture.pixels[on_canvas(picture, patch, i, j), 0]),
                    cython.address(sample.pixels[in_sample(sample, patch, i, j), 0]),
                    cython.cast(cython.Py_ssize_t, sample.pixels.shape[1]),
                )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build(
    picture: Picture, sample: Sample, patch: Patch, graph: Graph, halvings: cython.int
) -> cython.longlong:
    """Fill in the graph whose minimum cut says which blocks of a box a patch replaces (section 3).

    What each pixel may be is there already. Returns the cost of pairs without a choice.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int, may=cython.p_uchar)
    cython.declare(apart=cython.p_int, both=cython.int)
    cython.declare(other=cython.int, p=cython.int, q=cython.int, label=cython.int)
    cython.declare(row=cython.int, last=cython.bint, inside=cython.bint)
    rows: cython.Py_ssize_t = patch.rows.shape[0]
    width: cython.Py_ssize_t = patch.columns.shape[0]
    side: cython.Py_ssize_t = graph.choice.shape[1]
    columns: cython.p_const_int = cython.address(patch.columns[0])
    source: cython.p_int = cython.address(picture.source[0])
    mask: cython.Py_ssize_t = (1 << halvings) - 1
    fixed: cython.longlong = 0
    clear(patch, graph, halvings)
    measure(picture, sample, patch, graph)
    for i in range(rows):
        apart = cython.address(graph.apart[i, 0])
        may = cython.address(graph.choice[i, 0])
        row = patch.rows[i] * picture.width
        for j in range(width):
            if may[j] == NOTHING:
                continue
            for d in range(2):
                last = i + 1 == rows if d else j + 1 == width
                if last:
                    fixed += add_outside(picture, sample, patch, graph, i, j, d, may[j], halvings)
                    continue
                other = may[j + side] if d else may[j + 1]
                if other == NOTHING or may[j] | other != EITHER:  # both stay or both become new
                    continue
                if may[j] == other:
                    p = row + columns[j]
                    q = patch.rows[i + d] * picture.width + columns[j + 1 - d]
                    label = continued(sample, source[p], d)
                    if label >= 0 and label == source[q]:  # mostly they are of one old patch
                        inside = ((i + 1 if d else j + 1) & mask) != 0
                        both = apart[j] + (apart[j + side] if d else apart[j + 1])
                        if inside or add_within(
                            sample, patch, graph, i, j, d, halvings, source[p], both
                        ):
                            continue
                fixed += add_pair(picture, sample, patch, graph, i, j, d, may[j], other, halvings)
            if j == 0:
                fixed += add_outside(picture, sample, patch, graph, i, j, 2, may[j], halvings)
            if i == 0:
                fixed += add_outside(picture, sample, patch, graph, i, j, 3, may[j], halvings)
    return fixed
