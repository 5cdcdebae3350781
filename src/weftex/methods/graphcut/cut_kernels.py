# mypy: ignore-errors
"""Kernels of graph-cut textures: cutting and pasting patches; compiled by Cython, see setup.py.

A patch is cut in blocks of pixels first, a node for each, then in smaller ones where the cut went.
All labellings of blocks are labellings of pixels with the same cost, so no step is for the worse.
"""

import cython
from cython.cimports.libc.limits import LLONG_MAX
from cython.cimports.weftex.methods.graphcut.block_kernels import (
    build_from_kinds,
    choose,
    spread,
)
from cython.cimports.weftex.methods.graphcut.graph_kernels import (
    EITHER,
    NEW,
    NOTHING,
    OLD,
    Graph,
    Patch,
    blocks,
    build,
    in_sample,
    on_canvas,
)
from cython.cimports.weftex.methods.graphcut.run_kernels import follow
from cython.cimports.weftex.methods.graphcut.seam_kernels import Picture, Sample
from cython.cimports.weftex.seams.maxflow_kernels import minimum_cut


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    halvings: cython.int,
    by_kinds: cython.bint,
    most: cython.longlong,
) -> cython.longlong:
    """Cut in blocks, whose kinds may be known; return by how much seams are dearer then.

    What is dearer by more than `most` is not cut to its end, and costs more than returned.
    """
    cython.declare(cost=cython.longlong)
    if by_kinds and halvings > 0:
        cost = build_from_kinds(picture, sample, patch, graph, halvings)
    else:
        cost = build(picture, sample, patch, graph, halvings)
    graph.capacities.height = blocks(patch.rows.shape[0], halvings)
    graph.capacities.width = blocks(patch.columns.shape[0], halvings)
    cost -= graph.before
    return cost + minimum_cut(graph.capacities, graph.trees, graph.side, most - cost)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def narrow(patch: Patch, graph: Graph, halvings: cython.int) -> cython.void:
    """Leave a choice to the pixels of blocks that the cut passes, and of those around them.

    Outside the box all is old.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, may=cython.int)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, near=cython.int)
    block: cython.Py_ssize_t = 1 << halvings
    height: cython.Py_ssize_t = blocks(patch.rows.shape[0], halvings)
    width: cython.Py_ssize_t = blocks(patch.columns.shape[0], halvings)
    for i in range(height):
        for j in range(width):
            graph.shown[i, j] = 0
    for i in range(patch.rows.shape[0]):
        for j in range(patch.columns.shape[0]):
            may = graph.choice[i, j]
            if may == EITHER:
                may = NEW if graph.side[i >> halvings, j >> halvings] else OLD
            graph.shown[i >> halvings, j >> halvings] |= may
    for i in range(height):
        for j in range(width):
            near = OLD if j < REACH or j + REACH >= width else NOTHING
            for u in range(max(0, j - REACH), min(j + REACH + 1, width)):
                near |= graph.shown[i, u]
            graph.along[i, j] = near
    for i in range(height):
        for j in range(width):
            near = OLD if i < REACH or i + REACH >= height else NOTHING
            for v in range(max(0, i - REACH), min(i + REACH + 1, height)):
                near |= graph.along[v, j]
            if near == EITHER:
                continue
            for v in range(i * block, min((i + 1) * block, patch.rows.shape[0])):
                for u in range(j * block, min((j + 1) * block, patch.columns.shape[0])):
                    if graph.choice[v, u] == EITHER:
                        graph.choice[v, u] = near


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def is_new(graph: Graph, i: cython.Py_ssize_t, j: cython.Py_ssize_t) -> cython.bint:
    """Whether the cut has a pixel on the new side."""
    return graph.choice[i, j] == NEW or (graph.choice[i, j] == EITHER and graph.side[i, j])


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def paste(picture: Picture, sample: Sample, patch: Patch, graph: Graph) -> cython.Py_ssize_t:
    """Copy the pixels that the cut has on the new side; return how many were missing before.

    `graph.sums` gets the first and the last column of each row that changed, see `follow`.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.int, label=cython.int, last=cython.Py_ssize_t)
    covered: cython.Py_ssize_t = 0
    for i in range(patch.rows.shape[0]):
        graph.sums[0, i] = 0
        last = -1
        for j in range(patch.columns.shape[0]):
            if not is_new(graph, i, j):
                continue
            if last < 0:
                graph.sums[0, i] = cython.cast(cython.int, j)
            last = j
            p = on_canvas(picture, patch, i, j)
            label = in_sample(sample, patch, i, j)
            covered += not picture.done[p]
            picture.done[p] = 1
            picture.source[p] = label
            for k in range(sample.pixels.shape[1]):
                picture.pixels[p, k] = sample.pixels[label, k]
        graph.sums[1, i] = cython.cast(cython.int, last)
    return covered


def cost_in_blocks(
    picture: Picture, sample: Sample, usable, patch: Patch, graph: Graph, halvings, least
):
    """By how much a cut in blocks makes seams dearer, and how many missing pixels become new.

    What costs more than `least` for each of these pixels is not cut to its end.
    """
    cython.declare(cost=cython.longlong, covered=cython.Py_ssize_t, size=cython.int)
    cython.declare(most=cython.double, limit=cython.longlong)
    pixels: cython.const[cython.uchar][::1] = usable
    size = halvings
    most = least
    with cython.nogil:  # beside other threads
        covered = choose(picture, pixels, sample, patch, graph, size)
        if size == 0:
            spread(patch, graph, size)
        most *= max(covered, 1)
        limit = LLONG_MAX // 2
        if most < 1e18:
            limit = cython.cast(cython.longlong, most) + 1
        cost = cut(picture, sample, patch, graph, size, True, limit)
    return cost, covered


def paste_patch(picture: Picture, sample: Sample, usable, patch: Patch, graph: Graph, halvings):
    """Cut in blocks, around that in smaller and smaller ones, and copy; see `paste`."""
    choose(picture, usable, sample, patch, graph, halvings)
    spread(patch, graph, halvings)
    cut(picture, sample, patch, graph, halvings, True, LLONG_MAX // 2)
    while halvings > 0:
        narrow(patch, graph, halvings)
        halvings = max(0, halvings - STEP)
        cut(picture, sample, patch, graph, halvings, False, LLONG_MAX // 2)
    covered: cython.Py_ssize_t = paste(picture, sample, patch, graph)
    follow(picture, sample, patch, graph.sums)
    return covered
