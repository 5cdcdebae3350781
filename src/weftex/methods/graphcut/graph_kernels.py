# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch; compiled by Cython, see setup.py.

A node is a pixel, or a block of pixels. All labellings of blocks are labellings of pixels with the
same cost.
"""

import cython
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    Picture,
    Sample,
    beside,
    continued,
    cost_within,
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

    There is room for the largest box.
    """

    def __init__(self, arcs, old, new, apart, choice, side, shown, along, trees):
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
        self.before = 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    picture: Picture,
    usable: cython.const[cython.uchar][::1],
    sample: Sample,
    patch: Patch,
    graph: Graph,
) -> cython.Py_ssize_t:
    """Fill in the choice that each pixel of the box has; return how many missing become new."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, p=cython.int, row=cython.int)
    cython.declare(may=cython.p_uchar, new=cython.p_const_uchar, from_row=cython.int)
    cython.declare(label=cython.int, apart=cython.p_int, old=cython.p_const_uchar)
    columns: cython.p_const_int = cython.address(patch.columns[0])
    from_columns: cython.p_const_int = cython.address(patch.from_columns[0])
    done: cython.p_uchar = cython.address(picture.done[0])
    known: cython.p_const_uchar = cython.address(picture.known[0])
    width: cython.Py_ssize_t = patch.columns.shape[0]
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    missing: cython.Py_ssize_t = 0
    new = cython.address(usable[0])
    for i in range(patch.rows.shape[0]):
        may = cython.address(graph.choice[i, 0])
        apart = cython.address(graph.apart[i, 0])
        row = patch.rows[i] * picture.width
        from_row = patch.from_rows[i] * sample.width
        for j in range(width):
            p = row + columns[j]
            label = from_row + from_columns[j]
            if not new[label] or (done[p] and known[p]):
                may[j] = OLD if done[p] else NOTHING
            elif done[p]:
                may[j] = EITHER
                old = cython.address(picture.pixels[p, 0])
                apart[j] = difference(old, cython.address(sample.pixels[label, 0]), channels)
            else:
                may[j] = NEW
                missing += 1
    return missing


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
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its neighbor outside the box, which stays as it is.

    Returns its cost if the pixel has no choice.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)
    may: cython.int = graph.choice[i, j]
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
    halvings: cython.int,
) -> cython.longlong:
    """Add the pair of a pixel and its right (d = 0) or lower (d = 1) neighbor in the box.

    It costs c if both stay old (an old seam, or 0), a or b if one becomes new, and 0 if both do.
    Instead of the paper's seam node (section 3.1), the arcs from the source to both take
    alpha + beta = c, and the arcs between them a - alpha and b - beta. This is exact if
    c <= a + b, as with metrics. Where costs weighed by gradients break it, b is raised to c - a;
    the cheapest labels are still no worse than the old ones.

    Returns its cost if neither has a choice.
    """
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)  # and the other one new
    cython.declare(alpha=cython.longlong, p_new=cython.int, q_new=cython.int)
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    p_may: cython.int = graph.choice[i, j]
    q_may: cython.int = graph.choice[v, u]
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
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def add_within(
    sample: Sample,
    patch: Patch,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
    label: cython.int,
) -> cython.bint:
    """`add_pair` where both pixels are in the old patch, if they are in the new one too.

    Then a and b are the same, and c is 0.
    """
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    new: cython.int = in_sample(sample, patch, i, j)
    cost: cython.int
    if continued(sample, new, d) != in_sample(sample, patch, v, u):
        return False
    cost = cost_within(sample, graph.apart[i, j] + graph.apart[v, u], label, new, d)
    graph.arcs[v >> halvings, u >> halvings, d + 2] += cost
    graph.arcs[i >> halvings, j >> halvings, d] += cost
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build(
    picture: Picture, sample: Sample, patch: Patch, graph: Graph, halvings: cython.int
) -> cython.longlong:
    """Fill in the graph whose minimum cut says which blocks of a box a patch replaces (section 3).

    Returns the cost of pairs without a choice.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int, may=cython.p_uchar)
    cython.declare(other=cython.int, p=cython.int, q=cython.int, label=cython.int)
    cython.declare(row=cython.int, last=cython.bint, inside=cython.bint)
    rows: cython.Py_ssize_t = patch.rows.shape[0]
    width: cython.Py_ssize_t = patch.columns.shape[0]
    side: cython.Py_ssize_t = graph.choice.shape[1]
    columns: cython.p_const_int = cython.address(patch.columns[0])
    source: cython.p_int = cython.address(picture.source[0])
    mask: cython.Py_ssize_t = (1 << halvings) - 1
    fixed: cython.longlong = 0
    graph.before = 0
    for i in range(blocks(rows, halvings)):
        for j in range(blocks(width, halvings)):
            graph.old[i, j] = 0
            graph.new[i, j] = 0
            for d in range(4):
                graph.arcs[i, j, d] = 0
    for i in range(rows):
        may = cython.address(graph.choice[i, 0])
        row = patch.rows[i] * picture.width
        for j in range(width):
            if may[j] == NOTHING:
                continue
            for d in range(2):
                last = i + 1 == rows if d else j + 1 == width
                if last:
                    fixed += add_outside(picture, sample, patch, graph, i, j, d, halvings)
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
                        if inside or add_within(sample, patch, graph, i, j, d, halvings, source[p]):
                            continue
                fixed += add_pair(picture, sample, patch, graph, i, j, d, halvings)
            if j == 0:
                fixed += add_outside(picture, sample, patch, graph, i, j, 2, halvings)
            if i == 0:
                fixed += add_outside(picture, sample, patch, graph, i, j, 3, halvings)
    return fixed
