# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of graph-cut textures: the graph of a patch, its cut, and the paste (section 3).

A patch is cut in blocks of pixels first, a node for each, then in smaller blocks around that cut.
Every labeling of blocks is one of pixels of the same cost, so no step raises it. Only pairs of
pixels in different blocks, or with a seam between them, have a cost; `runs` skips all others.
Compiled by Cython, see setup.py and the .pxd.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX
from cython.cimports.libc.string import memset
from cython.cimports.weftex.methods.graphcut.cost_kernels import (
    continued,
    difference,
    divided,
    neighbor,
    seam_cost,
    update_runs,
)
from cython.cimports.weftex.seams.maxflow_kernels import Grid, max_flow


class Graph(Grid):
    """The graph of a patch over a box of the canvas, allocated for the largest box."""

    def __init__(self, labeling, choice, side, near, costs, **grid):
        Grid.__init__(self, **grid)
        self.labeling, self.choice, self.side = labeling, choice, side
        self.near, self.costs = near, costs

    def set_box(self, rows, columns, from_rows, from_columns, prices, cell_exponent):
        """Set the rows and columns of the box, on the canvas and in the sample, and its prices."""
        self.rows, self.columns = rows, columns
        self.from_rows, self.from_columns = from_rows, from_columns
        self.prices, self.cell_exponent = prices, cell_exponent


def mark_choices(graph):
    """Fill in what each pixel may be; return the number of missing pixels that become new."""
    run: cython.Py_ssize_t
    missing: cython.Py_ssize_t = 0
    whole, width = graph.labeling.whole, graph.columns.shape[0]
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
            if done and graph.labeling.fixed[p]:
                graph.choice[i, j] = OLD
            elif whole or graph.labeling.usable[in_sample(graph, i, j)]:
                graph.choice[i, j] = EITHER if done else NEW
            else:
                graph.choice[i, j] = OLD if done else NOTHING
            missing += graph.choice[i, j] == NEW
            j += 1
    return missing


def add_pair(graph, i, j, d, exponent):
    """Add the seams, new and old, between a pixel of the box and its neighbor in direction d.

    With p for the pixel and q for the neighbor, the pair costs `old_new` if only q becomes new,
    `new_old` if only p does, `old_old` if both stay old (an old seam, or 0), and 0 if both become
    new; a neighbor outside the box stays old. If both have a choice, the arcs from the source to p
    and q share `old_old`, for the paper's seam node (section 3.1), and the arcs between them have
    the rest. This is exact if old_old <= old_new + new_old, as with metrics. If costs weighed by
    gradients break it, `new_old` is raised; the cheapest labels are still no worse than the old
    ones. If one has a choice, its terminal arcs have the costs; if neither has, they are returned.
    """
    cython.declare(old_new=cython.longlong, new_old=cython.longlong, old_old=cython.longlong)
    cython.declare(p_may=cython.int, q_may=cython.int, q=cython.int, q_new=cython.int)
    cython.declare(inside=cython.bint, together=cython.bint, joined=cython.bint)
    labels = cython.address(graph.labeling.labels[0])
    way = 1 - (d & 2)
    dy, dx = way if d & 1 else 0, 0 if d & 1 else way
    v, u = i + dy, j + dx
    inside = 0 <= v < graph.rows.shape[0] and 0 <= u < graph.columns.shape[0]
    p_may = graph.choice[i, j]
    q_may = graph.choice[v, u] if inside else OLD
    if p_may == NOTHING or q_may == NOTHING or p_may | q_may != EITHER:
        return 0  # both stay old, or both become new
    p = on_canvas(graph, i, j)
    if inside:
        q = on_canvas(graph, v, u)
        q_new = in_sample(graph, v, u)
    else:
        q = neighbor(graph.labeling, p, dy, dx)
        q_new = -1
        if q < 0 or q == p or not graph.labeling.done[q]:
            return 0
    bi, bj = i >> exponent, j >> exponent  # their blocks
    bv, bu = v >> exponent, u >> exponent
    together = p_may == EITHER and q_may == EITHER
    joined = labels[q] >= 0 and continued(graph.labeling, labels[p], d) == labels[q]
    old_new = new_old = old_old = 0
    if not joined and p_may & OLD and q_may & OLD:
        old_old = seam_cost(graph.labeling, p, q, d, labels[p], labels[q])
        graph.before += old_old
    if together and bi == bv and bj == bu:
        graph.from_source[bi, bj] += old_old
        return 0
    p_new = in_sample(graph, i, j)
    if p_may & OLD and q_may & NEW:
        old_new = seam_cost(graph.labeling, p, q, d, labels[p], q_new)
    if joined and together and continued(graph.labeling, p_new, d) == q_new:
        new_old = old_new  # both patches continue
    elif p_may & NEW and q_may & OLD:
        new_old = seam_cost(graph.labeling, p, q, d, p_new, labels[q])
    if together:
        new_old = max(new_old, old_old - old_new)
        share = min(old_new, old_old)  # the part of `old_old` that p takes
        graph.from_source[bi, bj] += share
        graph.from_source[bv, bu] += old_old - share
        graph.arcs[bv, bu, d ^ 2] += old_new - share
        graph.arcs[bi, bj, d] += new_old - (old_old - share)
    elif p_may == EITHER:
        graph.from_source[bi, bj] += old_old + old_new
        graph.to_sink[bi, bj] += new_old
    elif q_may == EITHER:
        graph.from_source[bv, bu] += old_old + new_old
        graph.to_sink[bv, bu] += old_new
    else:
        return old_new + new_old
    return 0


def add_within(graph, i, first, count, d, exponent):
    """Add pairs of pixels that continue both the old and the new patch, so that seams cost alike.

    The pixels lie in row i of the box from column `first` on, side by side for pairs with lower
    neighbors (d = 1), else a block's width apart; their labels have the same steps.
    """
    cython.declare(k=cython.Py_ssize_t, at=cython.Py_ssize_t, total=cython.int)
    step: cython.Py_ssize_t = 1 if d else 1 << exponent
    channels: cython.int = graph.labeling.colors.shape[1]
    v, u = i + d, first + 1 - d
    at_p, new = on_canvas(graph, i, first), in_sample(graph, i, first)
    p = cython.address(graph.labeling.pixels[at_p, 0])
    p_new = cython.address(graph.labeling.colors[new, 0])
    q = cython.address(graph.labeling.pixels[on_canvas(graph, v, u), 0])
    q_new = cython.address(graph.labeling.colors[in_sample(graph, v, u), 0])
    cost = cython.address(graph.costs[0])
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
        at = (first + k * step) >> exponent
        end = min(((at + 1) << exponent) - first, count) if d else k + 1
        total = 0
        while k < end:
            total += cost[k]
            k += 1
        graph.arcs[i >> exponent, at, d] += total
        graph.arcs[v >> exponent, at + 1 - d, d + 2] += total


def add_run(graph, i, first, end, exponent):
    """Add the pairs of pixels of one old patch side by side, and their right and lower neighbors.

    Returns the cost of pairs without a choice.
    """
    block: cython.Py_ssize_t = 1 << exponent
    border = first | (block - 1)  # the last pixel of a block
    fixed = add_pair(graph, i, end - 1, 0, exponent)
    if border < end - 1:
        add_within(graph, i, border, (end - 2 - border) // block + 1, 0, exponent)
    if i + 1 == graph.rows.shape[0]:
        for k in range(first, end):
            fixed += add_pair(graph, i, k, 1, exponent)
    elif (i + 1) & (block - 1) == 0:
        add_within(graph, i, first, end - first, 1, exponent)
    return fixed


def is_straight(graph, i, first, last):
    """Whether a run of the box wraps neither around the canvas nor around a tileable sample."""
    apart = graph.labeling.labels[on_canvas(graph, i, last)]
    apart -= graph.labeling.labels[on_canvas(graph, i, first)]
    return apart == last - first == graph.from_columns[last] - graph.from_columns[first]


def add_prices(graph, exponent):
    """Add what pixels cost if they become new; return the cost of those without a choice."""
    cython.declare(price=cython.int, fixed=cython.longlong)
    fixed = 0
    for i in range(graph.rows.shape[0]):
        for j in range(graph.columns.shape[0]):
            price = graph.prices[i >> graph.cell_exponent, j >> graph.cell_exponent]
            if graph.choice[i, j] == EITHER:
                if price >= 0:
                    graph.to_sink[i >> exponent, j >> exponent] += price
                else:
                    graph.from_source[i >> exponent, j >> exponent] -= price
                    fixed += price
            elif graph.choice[i, j] == NEW:
                fixed += price
    return fixed


def build(graph, exponent, by_runs):
    """Fill in the graph whose minimum cut says which blocks of the box the patch replaces.

    What each pixel may be is in `graph.choice`; `by_runs`: as `mark_choices` filled it in. Returns
    the cost of pairs without a choice.
    """
    cython.declare(run=cython.Py_ssize_t, fixed=cython.longlong, alike=cython.bint)
    fixed = 0
    height, width = graph.rows.shape[0], graph.columns.shape[0]
    by_runs = by_runs and graph.labeling.whole
    graph.before = 0
    graph.height = blocks(height, exponent)
    graph.width = blocks(width, exponent)
    row = graph.width * cython.sizeof(cython.int)
    for i in range(graph.height):
        memset(cython.address(graph.from_source[i, 0]), 0, row)
        memset(cython.address(graph.to_sink[i, 0]), 0, row)
        memset(cython.address(graph.arcs[i, 0, 0]), 0, 4 * row)
    for i in range(height):
        may = cython.address(graph.choice[i, 0])
        below = may if i + 1 == height else cython.address(graph.choice[i + 1, 0])
        j = 0
        while j < width:
            run = graph.labeling.runs[on_canvas(graph, i, j)] if by_runs else 0
            run = min(run, width - j)
            if run > 0 and is_straight(graph, i, j, j + run - 1):
                fixed += add_run(graph, i, j, j + run, exponent)
                j += run
                continue
            if run < -1 and i + 1 < height:  # missing, as the pixels below may be
                run = min(-run, width - j)
                if graph.labeling.runs[on_canvas(graph, i + 1, j)] <= -run:
                    j += run - 1
            alike = j + 1 < width and may[j] != EITHER and may[j + 1] == may[j] == below[j]
            if not alike or i + 1 == height:
                fixed += add_pair(graph, i, j, 0, exponent)
                fixed += add_pair(graph, i, j, 1, exponent)
            j += 1
        fixed += add_pair(graph, i, 0, 2, exponent)
    for j in range(width):
        fixed += add_pair(graph, 0, j, 3, exponent)
    if graph.prices.shape[0] > 0:
        fixed += add_prices(graph, exponent)
    return fixed


def cut(graph, exponent, by_runs, most):
    """Cut in blocks, see `build`; return the cost of seams after less that before.

    A cut that costs more than `most` is not completed, and costs more than is returned.
    """
    cost = build(graph, exponent, by_runs) - graph.before
    return cost + max_flow(graph, graph.side, most - cost)


def narrow(graph, exponent):
    """Leave a choice to pixels near the cut only: in blocks that it passes, and those around them.

    Outside the box all pixels are old.
    """
    cython.declare(may=cython.int, near=cython.int, inside=cython.bint)
    block: cython.Py_ssize_t = 1 << exponent
    height, width = blocks(graph.rows.shape[0], exponent), blocks(graph.columns.shape[0], exponent)
    has = graph.near  # OLD and NEW, if a block has such pixels
    for i in range(height):
        memset(cython.address(has[i, 0]), 0, width)
    for i in range(graph.rows.shape[0]):
        for j in range(graph.columns.shape[0]):
            may = graph.choice[i, j]
            if may == EITHER:
                may = NEW if graph.side[i >> exponent, j >> exponent] else OLD
            has[i >> exponent, j >> exponent] |= may
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


def paste(graph):
    """Copy the pixels on the new side of the cut; return how many of them were missing."""
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


def cost_in_blocks(graph: Graph, exponent: cython.int, most: cython.double):
    """By how much a cut in blocks raises the cost of seams, and how many pixels it newly covers.

    A cut that costs more than `most` for each of these pixels is not completed.
    """
    limit: cython.longlong = LLONG_MAX // 2
    with cython.nogil:  # beside other threads
        covered = mark_choices(graph)
        most *= max(covered, 1)
        if most < 1e18:
            limit = cython.cast(cython.longlong, most) + 1
        cost = cut(graph, exponent, True, limit)
    return cost, covered


def paste_patch(graph: Graph, exponent: cython.int):
    """Cut in blocks, then in smaller ones around that cut, and paste; see `paste`."""
    mark_choices(graph)
    cut(graph, exponent, True, LLONG_MAX // 2)
    while exponent > 0:
        narrow(graph, exponent)
        exponent = max(0, exponent - STEP)
        cut(graph, exponent, False, LLONG_MAX // 2)
    return paste(graph)
