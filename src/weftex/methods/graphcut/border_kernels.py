# mypy: ignore-errors
"""Kernels of graph-cut textures: borders of blocks that lie in one old patch, a row at a time.

Where both the old and the new patch go on, what a seam costs needs no labels but the first one, and
many pixels are looked at by one instruction. Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.weftex.methods.graphcut.graph_kernels import (
    EITHER,
    Graph,
    Patch,
    blocks,
    in_sample,
    on_canvas,
)
from cython.cimports.weftex.methods.graphcut.seam_kernels import SCALE, SOFT, Picture, Sample


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def go_on(patch: Patch, j: cython.Py_ssize_t, last: cython.Py_ssize_t) -> cython.bint:
    """Whether all columns of a box up to the last one are side by side, here and in the sample."""
    return (
        patch.columns[last] - patch.columns[j] == last - j
        and patch.from_columns[last] - patch.from_columns[j] == last - j
    )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def run_end(
    picture: Picture,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    u: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.Py_ssize_t:
    """One after the last block, from one on, whose pixels are all side by side in one old patch.

    The block itself if its own are not.
    """
    cython.declare(last=cython.Py_ssize_t, p=cython.int, q=cython.int)
    columns: cython.Py_ssize_t = patch.columns.shape[0]
    first: cython.Py_ssize_t = u << halvings
    top: cython.Py_ssize_t = v << halvings
    p = on_canvas(picture, patch, top, first)
    while u < blocks(columns, halvings) and graph.shown[v, u] == EITHER:
        last = min((u + 1) << halvings, columns) - 1
        q = on_canvas(picture, patch, top, last)
        if not go_on(patch, first, last) or picture.source[q] - picture.source[p] != q - p:
            break
        u += 1
    return u


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def set_apart(
    one: cython.p_const_uchar,
    other: cython.p_const_uchar,
    apart: cython.p_uchar,
    count: cython.Py_ssize_t,
) -> cython.void:
    """How far so many bytes are apart."""
    cython.declare(k=cython.Py_ssize_t, most=cython.uchar, least=cython.uchar)
    for k in range(count):
        most = one[k] if one[k] > other[k] else other[k]
        least = other[k] if one[k] > other[k] else one[k]
        apart[k] = most - least


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def set_costs(
    sample: Sample, apart: cython.p_int, gradients: cython.p_int, count: cython.Py_ssize_t
) -> cython.void:
    """`cost_within` of so many pairs, in the place of how far they are apart."""
    cython.declare(k=cython.Py_ssize_t, softly=cython.int)
    if sample.by_gradients:
        softly = SOFT * cython.cast(cython.int, sample.pixels.shape[1])
        for k in range(count):  # exact, and quicker than by whole numbers
            apart[k] = cython.cast(
                cython.int, cython.cast(cython.double, SCALE * apart[k]) / (gradients[k] + softly)
            )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cost_across(
    sample: Sample,
    graph: Graph,
    old: cython.Py_ssize_t,
    new: cython.Py_ssize_t,
    halvings: cython.int,
    count: cython.Py_ssize_t,
) -> cython.void:
    """Add a row's share of the costs of so many blocks' right borders to `graph.sums`."""
    cython.declare(u=cython.Py_ssize_t, k=cython.Py_ssize_t, c=cython.Py_ssize_t, far=cython.int)
    cython.declare(here=cython.p_uchar)
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    apart: cython.p_int = cython.address(graph.sums[1, 0])
    gradients: cython.p_int = cython.address(graph.sums[2, 0])
    for u in range(count):
        k = ((u + 1) << halvings) - 1
        here = cython.address(graph.bytes[0, k * channels])
        far = 0
        if channels == 3:
            far = here[0] + here[1] + here[2] + here[3] + here[4] + here[5]
        else:
            for c in range(2 * channels):
                far += here[c]
        apart[u] = far
        if sample.by_gradients:
            gradients[u] = sample.gradients[0, old + k] + sample.gradients[0, new + k]
    set_costs(sample, apart, gradients, count)
    for u in range(count):
        graph.sums[0, u] += apart[u]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cost_below(
    sample: Sample,
    graph: Graph,
    old: cython.Py_ssize_t,
    new: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
) -> cython.void:
    """Fill `graph.sums` with the costs of seams below so many pixels."""
    cython.declare(k=cython.Py_ssize_t, c=cython.Py_ssize_t)
    cython.declare(one=cython.p_const_int, other=cython.p_const_int)
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    upper: cython.p_uchar = cython.address(graph.bytes[0, 0])
    lower: cython.p_uchar = cython.address(graph.bytes[1, 0])
    apart: cython.p_int = cython.address(graph.sums[1, 0])
    gradients: cython.p_int = cython.address(graph.sums[2, 0])
    if channels == 3:  # most pictures; the loop for any number is slower
        for k in range(count):
            apart[k] = upper[3 * k] + upper[3 * k + 1] + upper[3 * k + 2]
            apart[k] += lower[3 * k] + lower[3 * k + 1] + lower[3 * k + 2]
    else:
        for k in range(count):
            apart[k] = 0
            for c in range(k * channels, (k + 1) * channels):
                apart[k] += upper[c] + lower[c]
    if sample.by_gradients:
        one = cython.address(sample.gradients[1, old])
        other = cython.address(sample.gradients[1, new])
        for k in range(count):
            gradients[k] = one[k] + other[k]
    set_costs(sample, apart, gradients, count)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_run(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    first: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.bint:
    """Add the pairs along the right and lower borders of a run of blocks, if not of the box.

    Returns whether that of the last block's right border is among them.
    """
    cython.declare(i=cython.Py_ssize_t, u=cython.Py_ssize_t, k=cython.Py_ssize_t, p=cython.int)
    cython.declare(new=cython.int, cost=cython.int, turn=cython.int)
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    top: cython.Py_ssize_t = v << halvings
    left: cython.Py_ssize_t = first << halvings
    bottom: cython.Py_ssize_t = min((v + 1) << halvings, patch.rows.shape[0])
    right: cython.Py_ssize_t = min(end << halvings, patch.columns.shape[0])
    beyond: cython.bint = right < patch.columns.shape[0] and go_on(patch, left, right)
    across: cython.Py_ssize_t = end - first if beyond else end - first - 1
    for u in range(across):
        graph.sums[0, u] = 0
    for i in range(top, min(bottom + 1, patch.rows.shape[0])):
        p = on_canvas(picture, patch, i, left)
        new = in_sample(sample, patch, i, left)
        turn = 1 if i == bottom else 0
        set_apart(
            cython.address(picture.pixels[p, 0]),
            cython.address(sample.pixels[new, 0]),
            cython.address(graph.bytes[turn, 0]),
            (right - left + (1 if beyond else 0)) * channels,
        )
        if i < bottom:
            cost_across(sample, graph, picture.source[p], new, halvings, across)
    for u in range(across):
        graph.arcs[v, first + u + 1, 2] += graph.sums[0, u]
        graph.arcs[v, first + u, 0] += graph.sums[0, u]
    if bottom == patch.rows.shape[0]:
        return beyond
    p = on_canvas(picture, patch, bottom - 1, left)
    new = in_sample(sample, patch, bottom - 1, left)
    cost_below(sample, graph, picture.source[p], new, right - left)
    for u in range(first, end):
        cost = 0
        for k in range((u << halvings) - left, min((u + 1) << halvings, right) - left):
            cost += graph.sums[1, k]
        graph.arcs[v + 1, u, 3] += cost
        graph.arcs[v, u, 1] += cost
    return beyond
