# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch in blocks; compiled by Cython, see setup.py.

Most blocks of a patch lie where the canvas shows one piece of the sample, or nothing yet. Only the
pairs of pixels on their borders are looked at, which makes the graph five times as fast.
"""

import cython
from cython.cimports.weftex.methods.graphcut.border_kernels import add_run, run_end
from cython.cimports.weftex.methods.graphcut.graph_kernels import (
    EITHER,
    MIXED,
    NEW,
    NOTHING,
    Graph,
    Patch,
    add_outside,
    add_pair,
    add_within,
    blocks,
    choice_of,
    clear,
    in_sample,
    on_canvas,
)
from cython.cimports.weftex.methods.graphcut.seam_kernels import Picture, Sample, difference


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def kind_of(
    picture: Picture,
    patch: Patch,
    top: cython.Py_ssize_t,
    bottom: cython.Py_ssize_t,
    left: cython.Py_ssize_t,
    right: cython.Py_ssize_t,
) -> cython.uchar:
    """The kind of a block of a box: its rows and columns there, and one after the last."""
    cython.declare(i=cython.Py_ssize_t, run=cython.int)
    width: cython.int = cython.cast(cython.int, right - left)
    first: cython.int = patch.columns[left]
    joined: cython.int = 1
    missing: cython.int = 1
    if patch.columns[right - 1] - first != width - 1:  # it goes around
        return MIXED
    for i in range(top, bottom):
        run = picture.runs[patch.rows[i] * picture.width + first]
        joined &= run >= width
        missing &= run <= -width
    return EITHER if joined else NEW if missing else MIXED


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    picture: Picture,
    usable: cython.const[cython.uchar][::1],
    sample: Sample,
    patch: Patch,
    graph: Graph,
    halvings: cython.int,
) -> cython.Py_ssize_t:
    """Fill in the kinds of blocks, and the choices of pixels in those that are mixed.

    Returns how many missing pixels become new.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, kind=cython.uchar)
    cython.declare(top=cython.Py_ssize_t, left=cython.Py_ssize_t)
    cython.declare(bottom=cython.Py_ssize_t, right=cython.Py_ssize_t)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    rows: cython.Py_ssize_t = patch.rows.shape[0]
    columns: cython.Py_ssize_t = patch.columns.shape[0]
    block: cython.Py_ssize_t = 1 << halvings
    missing: cython.Py_ssize_t = 0
    for v in range(blocks(rows, halvings)):
        top = v << halvings
        bottom = min(top + block, rows)
        for u in range(blocks(columns, halvings)):
            left = u << halvings
            right = min(left + block, columns)
            kind = MIXED
            if sample.whole:
                kind = kind_of(picture, patch, top, bottom, left, right)
            graph.shown[v, u] = kind
            if kind == NEW:
                missing += (bottom - top) * (right - left)
            if kind != MIXED:
                continue
            for i in range(top, bottom):
                for j in range(left, right):
                    graph.choice[i, j] = choice_of(
                        picture,
                        sample,
                        usable,
                        on_canvas(picture, patch, i, j),
                        in_sample(sample, patch, i, j),
                    )
                    missing += graph.choice[i, j] == NEW
    return missing


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def spread(patch: Patch, graph: Graph, halvings: cython.int) -> cython.void:
    """Fill in the choices of pixels in blocks that are not mixed."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, kind=cython.uchar)
    for i in range(patch.rows.shape[0]):
        for j in range(patch.columns.shape[0]):
            kind = graph.shown[i >> halvings, j >> halvings]
            if kind != MIXED:
                graph.choice[i, j] = kind


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def may_be(
    graph: Graph, i: cython.Py_ssize_t, j: cython.Py_ssize_t, halvings: cython.int
) -> cython.int:
    """The choice of a pixel."""
    kind: cython.uchar = graph.shown[i >> halvings, j >> halvings]
    return graph.choice[i, j] if kind == MIXED else kind


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_right_or_lower(
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
    """Add the pair of a pixel, of a known choice, and its right (d = 0) or lower neighbor.

    Returns its cost if there is no choice.
    """
    cython.declare(p=cython.int, q=cython.int, other=cython.int)
    cython.declare(apart=cython.int, channels=cython.Py_ssize_t)
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    if v == patch.rows.shape[0] or u == patch.columns.shape[0]:
        return add_outside(picture, sample, patch, graph, i, j, d, may, halvings)
    other = may_be(graph, v, u, halvings)
    if other == NOTHING or may | other != EITHER:  # both stay or both become new
        return 0
    p = on_canvas(picture, patch, i, j)
    if may == other and picture.runs[p] > 0:  # they are of one old patch
        if i >> halvings == v >> halvings and j >> halvings == u >> halvings:
            return 0
        q = on_canvas(picture, patch, v, u)
        channels = sample.pixels.shape[1]
        apart = difference(
            cython.address(picture.pixels[p, 0]),
            cython.address(sample.pixels[in_sample(sample, patch, i, j), 0]),
            channels,
        ) + difference(
            cython.address(picture.pixels[q, 0]),
            cython.address(sample.pixels[in_sample(sample, patch, v, u), 0]),
            channels,
        )
        if add_within(sample, patch, graph, i, j, d, halvings, picture.source[p], apart):
            return 0
    return add_pair(picture, sample, patch, graph, i, j, d, may, other, halvings)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_mixed(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    u: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pairs of a mixed block's pixels and their right and lower neighbors."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int, may=cython.int)
    cython.declare(joined=cython.bint, inside=cython.bint, run=cython.int)
    bottom: cython.Py_ssize_t = min((v + 1) << halvings, patch.rows.shape[0])
    right: cython.Py_ssize_t = min((u + 1) << halvings, patch.columns.shape[0])
    left: cython.Py_ssize_t = u << halvings
    # What goes on is of one choice, too, if the patch may replace all of it.
    leap: cython.bint = sample.whole and (
        patch.columns[right - 1] - patch.columns[left] == right - 1 - left
    )
    fixed: cython.longlong = 0
    for i in range(v << halvings, bottom):
        j = left - 1
        while j + 1 < right:
            j += 1
            may = graph.choice[i, j]
            if may == NOTHING:
                continue
            run = picture.runs[on_canvas(picture, patch, i, j)]
            if leap and run > 1 and may == EITHER and i + 1 < bottom and j + 1 < right:
                j = min(j + run, right - 1) - 1
                continue
            joined = may == NEW or run > 0
            for d in range(2):
                inside = i + 1 < bottom if d else j + 1 < right
                if inside and joined and graph.choice[i + d, j + 1 - d] == may:
                    continue
                fixed += add_right_or_lower(picture, sample, patch, graph, i, j, d, may, halvings)
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_side(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    u: cython.Py_ssize_t,
    d: cython.int,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pairs along the right (d = 0) or the lower border of a block that is not mixed."""
    cython.declare(k=cython.Py_ssize_t)
    kind: cython.uchar = graph.shown[v, u]
    top: cython.Py_ssize_t = v << halvings
    left: cython.Py_ssize_t = u << halvings
    bottom: cython.Py_ssize_t = min((v + 1) << halvings, patch.rows.shape[0])
    right: cython.Py_ssize_t = min((u + 1) << halvings, patch.columns.shape[0])
    fixed: cython.longlong = 0
    if bottom < patch.rows.shape[0] if d else right < patch.columns.shape[0]:
        if kind == NEW and graph.shown[v + d, u + 1 - d] == NEW:
            return 0
    for k in range(right - left if d else bottom - top):
        fixed += add_right_or_lower(
            picture,
            sample,
            patch,
            graph,
            bottom - 1 if d else top + k,
            left + k if d else right - 1,
            d,
            kind,
            halvings,
        )
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_row(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pairs of a row of blocks, and those to the right and below."""
    cython.declare(end=cython.Py_ssize_t, beyond=cython.bint, d=cython.int)
    count: cython.Py_ssize_t = blocks(patch.columns.shape[0], halvings)
    last: cython.bint = (v + 1) << halvings >= patch.rows.shape[0]
    u: cython.Py_ssize_t = 0
    fixed: cython.longlong = 0
    while u < count:
        if graph.shown[v, u] == MIXED:
            fixed += add_mixed(picture, sample, patch, graph, v, u, halvings)
            u += 1
            continue
        end = run_end(picture, patch, graph, v, u, halvings)
        if end == u:
            for d in range(2):
                fixed += add_side(picture, sample, patch, graph, v, u, d, halvings)
            u += 1
            continue
        beyond = add_run(picture, sample, patch, graph, v, u, end, halvings)
        if not beyond:
            fixed += add_side(picture, sample, patch, graph, v, end - 1, 0, halvings)
        while u < end:
            if last:
                fixed += add_side(picture, sample, patch, graph, v, u, 1, halvings)
            u += 1
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build_from_kinds(
    picture: Picture, sample: Sample, patch: Patch, graph: Graph, halvings: cython.int
) -> cython.longlong:
    """`graph_kernels.build`, of blocks whose kinds are known."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int, may=cython.int)
    rows: cython.Py_ssize_t = patch.rows.shape[0]
    columns: cython.Py_ssize_t = patch.columns.shape[0]
    fixed: cython.longlong = 0
    clear(patch, graph, halvings)
    for i in range(blocks(rows, halvings)):
        fixed += add_row(picture, sample, patch, graph, i, halvings)
    for d in range(2, 4):
        for i in range(rows if d == 2 else 1):
            for j in range(columns if d == 3 else 1):
                may = may_be(graph, i, j, halvings)
                if may != NOTHING:
                    fixed += add_outside(picture, sample, patch, graph, i, j, d, may, halvings)
    return fixed
