# mypy: ignore-errors
"""Kernels of graph-cut textures: the graph of a patch in blocks; compiled by Cython, see setup.py.

Most blocks of a patch lie where the canvas shows one piece of the sample, or nothing yet. Only the
pairs of pixels on their borders are looked at, which makes the graph five times as fast.
"""

import cython
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
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    Picture,
    Sample,
    beside,
    continued,
    cost_within,
    difference,
)


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
def add_border(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    d: cython.int,
    count: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.bint:
    """Add the pairs along a block's right (d = 0) or lower border, all of them of one old patch.

    From a pixel on, down or to the right. Returns whether all are of the new one too, or adds none.
    """
    cython.declare(k=cython.Py_ssize_t, p=cython.int, new=cython.int, apart=cython.int)
    cython.declare(here=cython.p_const_uchar, there=cython.p_const_uchar)
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    v: cython.Py_ssize_t = i + d
    u: cython.Py_ssize_t = j + 1 - d
    cost: cython.int = 0
    p = on_canvas(picture, patch, i, j)
    new = in_sample(sample, patch, i, j)
    # All rows and columns go on as these do, but for the last ones of what goes around.
    across: cython.int = on_canvas(picture, patch, v, u) - p
    over: cython.int = in_sample(sample, patch, v, u) - new
    if across != (picture.width if d else 1) or over != (sample.width if d else 1):
        return False
    for k in range(count):
        if d:
            p = on_canvas(picture, patch, i, j + k)
            new = in_sample(sample, patch, i, j + k)
        else:
            p = on_canvas(picture, patch, i + k, j)
            new = in_sample(sample, patch, i + k, j)
        here = cython.address(picture.pixels[p, 0])
        there = cython.address(sample.pixels[new, 0])
        apart = difference(here, there, channels)
        apart += difference(here + across * channels, there + over * channels, channels)
        cost += cost_within(sample, apart, picture.source[p], new, d)
    graph.arcs[v >> halvings, u >> halvings, d + 2] += cost
    graph.arcs[i >> halvings, j >> halvings, d] += cost
    return True


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
    cython.declare(joined=cython.bint, inside=cython.bint)
    bottom: cython.Py_ssize_t = min((v + 1) << halvings, patch.rows.shape[0])
    right: cython.Py_ssize_t = min((u + 1) << halvings, patch.columns.shape[0])
    fixed: cython.longlong = 0
    for i in range(v << halvings, bottom):
        for j in range(u << halvings, right):
            may = graph.choice[i, j]
            if may == NOTHING:
                continue
            joined = may == NEW or picture.runs[on_canvas(picture, patch, i, j)] > 0
            for d in range(2):
                inside = i + 1 < bottom if d else j + 1 < right
                if inside and joined and graph.choice[i + d, j + 1 - d] == may:
                    continue
                fixed += add_right_or_lower(picture, sample, patch, graph, i, j, d, may, halvings)
    return fixed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_uniform(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    v: cython.Py_ssize_t,
    u: cython.Py_ssize_t,
    halvings: cython.int,
) -> cython.longlong:
    """Add the pairs along the right and the lower border of a block that is not mixed."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t, d=cython.int)
    cython.declare(count=cython.Py_ssize_t)
    kind: cython.uchar = graph.shown[v, u]
    top: cython.Py_ssize_t = v << halvings
    left: cython.Py_ssize_t = u << halvings
    bottom: cython.Py_ssize_t = min((v + 1) << halvings, patch.rows.shape[0])
    right: cython.Py_ssize_t = min((u + 1) << halvings, patch.columns.shape[0])
    fixed: cython.longlong = 0
    for d in range(2):
        i = bottom - 1 if d else top
        j = left if d else right - 1
        count = right - left if d else bottom - top
        if bottom < patch.rows.shape[0] if d else right < patch.columns.shape[0]:
            if kind == NEW and graph.shown[v + d, u + 1 - d] == NEW:
                continue
            if kind == EITHER and add_border(
                picture, sample, patch, graph, i, j, d, count, halvings
            ):
                continue
        for k in range(count):
            fixed += add_right_or_lower(
                picture,
                sample,
                patch,
                graph,
                i + (1 - d) * k,
                j + d * k,
                d,
                kind,
                halvings,
            )
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
        for j in range(blocks(columns, halvings)):
            if graph.shown[i, j] == MIXED:
                fixed += add_mixed(picture, sample, patch, graph, i, j, halvings)
            else:
                fixed += add_uniform(picture, sample, patch, graph, i, j, halvings)
    for d in range(2, 4):
        for i in range(rows if d == 2 else 1):
            for j in range(columns if d == 3 else 1):
                may = may_be(graph, i, j, halvings)
                if may != NOTHING:
                    fixed += add_outside(picture, sample, patch, graph, i, j, d, may, halvings)
    return fixed


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def may_change(picture: Picture, p: cython.int) -> cython.bint:
    return picture.done[p] and not picture.known[p]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def is_joined(picture: Picture, sample: Sample, p: cython.int, d: cython.int) -> cython.bint:
    """Whether the neighbor in direction d is of the same patch and may change too, or is none."""
    q: cython.int = p + (picture.width if d else 1)
    y: cython.int = p // picture.width
    if (y + 1 == picture.height) if d else (q == (y + 1) * picture.width):
        q = beside(picture, p, d, 1 - d)
        if q < 0:
            return True
    return may_change(picture, q) and continued(sample, picture.source[p], d) == picture.source[q]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def follow_row(
    picture: Picture,
    sample: Sample,
    y: cython.int,
    first: cython.int,
    last: cython.int,
) -> cython.void:
    """Bring `runs` of a row up to date where something changed from column `first` to `last`."""
    cython.declare(x=cython.int, p=cython.int, run=cython.int, after=cython.int)
    after = 0
    if last + 1 < picture.width:
        after = picture.runs[y * picture.width + last + 1]
    for x in range(last, -1, -1):
        p = y * picture.width + x
        if x >= first:
            run = 0
            if not picture.done[p]:
                run = -1
            elif may_change(picture, p):
                run = is_joined(picture, sample, p, 0) and is_joined(picture, sample, p, 1)
        else:
            run = (picture.runs[p] > 0) - (picture.runs[p] < 0)
        if run > 0 and after > 0:
            run = min(after + 1, 127)
        elif run < 0 and after < 0:
            run = max(after - 1, -127)
        if x < first and run == picture.runs[p]:
            break
        picture.runs[p] = cython.cast(cython.schar, run)
        after = run


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def follow(picture: Picture, sample: Sample, patch: Patch) -> cython.void:
    """Bring `runs` up to date after a patch in this box; see `seam_kernels.Picture`."""
    cython.declare(i=cython.Py_ssize_t, y=cython.int, first=cython.int, last=cython.int)
    count: cython.Py_ssize_t = patch.columns.shape[0]
    last = patch.columns[count - 1]
    first = patch.columns[0] - 1  # its neighbor to the right may have changed
    if first < 0 or last - first != count:
        first = 0
        last = picture.width - 1
    for i in range(-1, patch.rows.shape[0]):
        y = patch.rows[i] if i >= 0 else beside(picture, patch.rows[0] * picture.width, -1, 0)
        if i < 0:
            if y < 0:
                continue
            y //= picture.width
        follow_row(picture, sample, y, first, last)


def follow_all(picture: Picture, sample: Sample):
    """Fill in `runs`."""
    cython.declare(y=cython.int)
    for y in range(picture.height):
        follow_row(picture, sample, y, 0, picture.width - 1)
