# mypy: ignore-errors
"""Kernels of graph-cut textures: patches are cut and pasted; compiled by Cython, see setup.py.

A patch is cut in blocks of pixels first, a node for each, then in smaller blocks around that cut.
Every labeling of blocks is a labeling of pixels of the same cost, so no step raises it.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX
from cython.cimports.weftex.methods.graphcut.graph_kernels import (
    EITHER,
    NEW,
    NOTHING,
    OLD,
    Graph,
    blocks,
    build,
    choose,
    in_sample,
    on_canvas,
)
from cython.cimports.weftex.methods.graphcut.run_kernels import update_runs
from cython.cimports.weftex.methods.graphcut.seam_kernels import Labeling, SeamCost
from cython.cimports.weftex.seams.maxflow_kernels import minimum_cut


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut(
    labeling: Labeling,
    sample: SeamCost,
    graph: Graph,
    halvings: cython.int,
    by_runs: cython.bint,
    most: cython.longlong,
) -> cython.longlong:
    """Cut in blocks, see `graph_kernels.build`; return the cost of seams after less that before.

    A cut that costs more than `most` is not completed, and costs more than is returned.
    """
    cost: cython.longlong = build(labeling, sample, graph, halvings, by_runs) - graph.before
    graph.capacities.height = blocks(graph.rows.shape[0], halvings)
    graph.capacities.width = blocks(graph.columns.shape[0], halvings)
    return cost + minimum_cut(graph.capacities, graph.trees, graph.side, most - cost)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def narrow(graph: Graph, halvings: cython.int) -> cython.void:
    """Leave a choice to pixels near the cut only: in blocks that it passes, and those around them.

    Outside the box all pixels are old.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, may=cython.int)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, near=cython.int)
    block: cython.Py_ssize_t = 1 << halvings
    height: cython.Py_ssize_t = blocks(graph.rows.shape[0], halvings)
    width: cython.Py_ssize_t = blocks(graph.columns.shape[0], halvings)
    has: cython.uchar[:, ::1] = graph.near[0]  # OLD and NEW, if a block has such pixels
    along: cython.uchar[:, ::1] = graph.near[1]  # likewise it and the blocks beside it
    for i in range(height):
        for j in range(width):
            has[i, j] = 0
    for i in range(graph.rows.shape[0]):
        for j in range(graph.columns.shape[0]):
            may = graph.choice[i, j]
            if may == EITHER:
                may = NEW if graph.side[i >> halvings, j >> halvings] else OLD
            has[i >> halvings, j >> halvings] |= may
    for i in range(height):
        for j in range(width):
            near = OLD if j < REACH or j + REACH >= width else NOTHING
            for u in range(max(0, j - REACH), min(j + REACH + 1, width)):
                near |= has[i, u]
            along[i, j] = near
    for i in range(height):
        for j in range(width):
            near = OLD if i < REACH or i + REACH >= height else NOTHING
            for v in range(max(0, i - REACH), min(i + REACH + 1, height)):
                near |= along[v, j]
            if near == EITHER:
                continue
            for v in range(i * block, min((i + 1) * block, graph.rows.shape[0])):
                for u in range(j * block, min((j + 1) * block, graph.columns.shape[0])):
                    if graph.choice[v, u] == EITHER:
                        graph.choice[v, u] = near


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def paste(labeling: Labeling, sample: SeamCost, graph: Graph) -> cython.Py_ssize_t:
    """Copy the pixels on the new side of the cut; return how many of them were missing.

    The first and the last column that changed in each row are left in `graph.scratch`.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.int, label=cython.int, last=cython.Py_ssize_t, may=cython.int)
    covered: cython.Py_ssize_t = 0
    for i in range(graph.rows.shape[0]):
        graph.scratch[0, i] = 0
        last = -1
        for j in range(graph.columns.shape[0]):
            may = graph.choice[i, j]
            if not (may == NEW or (may == EITHER and graph.side[i, j])):
                continue
            if last < 0:
                graph.scratch[0, i] = cython.cast(cython.int, j)
            last = j
            p = on_canvas(labeling, graph, i, j)
            label = in_sample(sample, graph, i, j)
            covered += not labeling.done[p]
            labeling.done[p] = 1
            labeling.source[p] = label
            for k in range(sample.pixels.shape[1]):
                labeling.pixels[p, k] = sample.pixels[label, k]
        graph.scratch[1, i] = cython.cast(cython.int, last)
    return covered


def cost_in_blocks(labeling: Labeling, sample: SeamCost, graph: Graph, halvings, least):
    """By how much a cut in blocks raises the cost of seams, and how many pixels it newly covers.

    A cut that costs more than `least` for each of these pixels is not completed.
    """
    cython.declare(cost=cython.longlong, covered=cython.Py_ssize_t)
    cython.declare(most=cython.double, limit=cython.longlong)
    size: cython.int = halvings
    most = least
    with cython.nogil:  # beside other threads
        covered = choose(labeling, sample, graph)
        most *= max(covered, 1)
        limit = LLONG_MAX // 2
        if most < 1e18:
            limit = cython.cast(cython.longlong, most) + 1
        cost = cut(labeling, sample, graph, size, True, limit)
    return cost, covered


def paste_patch(labeling: Labeling, sample: SeamCost, graph: Graph, halvings):
    """Cut in blocks, then in smaller ones around that cut, and paste; see `paste`."""
    choose(labeling, sample, graph)
    cut(labeling, sample, graph, halvings, True, LLONG_MAX // 2)
    while halvings > 0:
        narrow(graph, halvings)
        halvings = max(0, halvings - STEP)
        cut(labeling, sample, graph, halvings, False, LLONG_MAX // 2)
    covered: cython.Py_ssize_t = paste(labeling, sample, graph)
    update_runs(labeling, sample, graph.rows, graph.columns, graph.scratch)
    return covered
