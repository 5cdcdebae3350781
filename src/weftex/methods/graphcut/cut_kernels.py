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
from cython.cimports.weftex.methods.graphcut.seam_kernels import update_runs
from cython.cimports.weftex.seams.maxflow_kernels import minimum_cut


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut(
    graph: Graph, halvings: cython.int, by_runs: cython.bint, most: cython.longlong
) -> cython.longlong:
    """Cut in blocks, see `graph_kernels.build`; return the cost of seams after less that before.

    A cut that costs more than `most` is not completed, and costs more than is returned.
    """
    cost: cython.longlong = build(graph, halvings, by_runs) - graph.before
    return cost + minimum_cut(graph, graph.side, most - cost)


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
            graph.labeling.source[p] = label
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
        covered = choose(graph)
        least *= max(covered, 1)
        limit = LLONG_MAX // 2
        if least < 1e18:
            limit = cython.cast(cython.longlong, least) + 1
        cost = cut(graph, halvings, True, limit)
    return cost, covered


def paste_patch(graph: Graph, halvings: cython.int):
    """Cut in blocks, then in smaller ones around that cut, and paste; see `paste`."""
    choose(graph)
    cut(graph, halvings, True, LLONG_MAX // 2)
    while halvings > 0:
        narrow(graph, halvings)
        halvings = max(0, halvings - STEP)
        cut(graph, halvings, False, LLONG_MAX // 2)
    return paste(graph)
