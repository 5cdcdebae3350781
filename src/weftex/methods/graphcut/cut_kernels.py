# mypy: ignore-errors
"""Kernels of graph-cut textures: the cost of seams, and pasting; compiled by Cython, see setup.py.

Pixels of the canvas and of the sample are flat, row by row. A pixel's label is its source: the
place in the sample that it was copied from, and so the patch that it belongs to.
"""

import cython

# Costs weighed by gradients: a mean difference of SOFT levels on either side weighs like none.
SCALE = cython.declare(cython.longlong, 256)
SOFT = cython.declare(cython.longlong, 32)

# The choices that a pixel of a box may have.
NOTHING = cython.declare(cython.int, 0)
OLD = cython.declare(cython.int, 1)
NEW = cython.declare(cython.int, 2)
EITHER = cython.declare(cython.int, 3)


@cython.cclass
class Sample:
    """The sample, and how its seams are weighed."""

    pixels: cython.const[cython.uchar][:, ::1]
    usable: cython.const[cython.uchar][::1]
    height: cython.int
    width: cython.int
    tiles: cython.bint
    by_gradients: cython.bint

    def __init__(self, pixels, usable, shape, tiles, by_gradients):
        self.pixels = pixels
        self.usable = usable
        self.height, self.width = shape
        self.tiles = tiles
        self.by_gradients = by_gradients


@cython.cclass
class Picture:
    """The canvas so far."""

    pixels: cython.uchar[:, ::1]
    source: cython.int[::1]  # the labels; -1 for a known pixel that is not in the sample
    done: cython.uchar[::1]  # 1 where a pixel is
    known: cython.const[cython.uchar][::1]  # 1 where it may not be replaced
    height: cython.int
    width: cython.int
    wrap_y: cython.bint
    wrap_x: cython.bint

    def __init__(self, pixels, source, done, known, shape, wrap):
        self.pixels = pixels
        self.source = source
        self.done = done
        self.known = known
        self.height, self.width = shape
        self.wrap_y, self.wrap_x = wrap


@cython.cclass
class Patch:
    """A patch over a box of the canvas: its pixels' places there and in the sample."""

    on_canvas: cython.const[cython.int][:, ::1]
    in_sample: cython.const[cython.int][:, ::1]

    def __init__(self, on_canvas, in_sample):
        self.on_canvas = on_canvas
        self.in_sample = in_sample


@cython.cclass
class Graph:
    """A node for each pixel of a box; a cut says which ones stay old and which become new."""

    arcs: cython.int[:, :, ::1]  # to the right, lower, left and upper neighbor
    old: cython.int[:, ::1]  # from the source: the price of a pixel that stays old
    new: cython.int[:, ::1]  # to the sink: the price of one that becomes new
    choice: cython.uchar[:, ::1]  # NOTHING, OLD, NEW or EITHER

    def __init__(self, arcs, old, new, choice):
        self.arcs = arcs
        self.old = old
        self.new = new
        self.choice = choice


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def neighbor(
    place: cython.int,
    dy: cython.int,
    dx: cython.int,
    height: cython.int,
    width: cython.int,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
) -> cython.int:
    """The flat place beside `place`, or -1 beyond a border that does not go around."""
    y: cython.int = place // width + dy
    x: cython.int = place % width + dx
    if y < 0 or y >= height:
        if not wrap_y:
            return -1
        y = y - height if y >= height else y + height
    if x < 0 or x >= width:
        if not wrap_x:
            return -1
        x = x - width if x >= width else x + width
    return y * width + x


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def beside(picture: Picture, p: cython.int, dy: cython.int, dx: cython.int) -> cython.int:
    """The pixel of the canvas beside p; -1 for none."""
    height: cython.int = picture.height
    return neighbor(p, dy, dx, height, picture.width, picture.wrap_y, picture.wrap_x)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def continued(sample: Sample, label: cython.int, dy: cython.int, dx: cython.int) -> cython.int:
    """The place in the sample that a pixel's patch has beside it; -1 for none."""
    cython.declare(place=cython.int)
    if label < 0:
        return -1
    place = neighbor(label, dy, dx, sample.height, sample.width, sample.tiles, sample.tiles)
    if place >= 0 and not sample.usable[place]:
        return -1
    return place


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def difference(
    a: cython.p_const_uchar, b: cython.p_const_uchar, channels: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of absolute differences of two pixels: a metric, and exact."""
    cython.declare(k=cython.Py_ssize_t)
    total: cython.int = 0
    for k in range(channels):
        total += abs(cython.cast(cython.int, a[k]) - cython.cast(cython.int, b[k]))
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def seam_cost(
    picture: Picture,
    sample: Sample,
    p: cython.int,
    q: cython.int,
    dy: cython.int,
    dx: cython.int,
    label_p: cython.int,
    label_q: cython.int,
) -> cython.longlong:
    """M(s, t, A, B) of equation (1): the cost of a seam between p and q = p + (dy, dx).

    |A(p) - B(p)| + |A(q) - B(q)|, and with gradients divided by those of A and of B across the
    seam (M' of section 5). Where a patch ends, the other half counts twice. A known pixel that is
    not in the sample has the label -1, and no patch goes on from it.
    """
    cython.declare(at_p=cython.p_const_uchar, at_q=cython.p_const_uchar)
    channels: cython.Py_ssize_t = sample.pixels.shape[1]
    b_at_p: cython.int = continued(sample, label_q, -dy, -dx)
    a_at_q: cython.int = continued(sample, label_p, dy, dx)
    cost: cython.longlong = 0
    gradient: cython.longlong = 0
    if a_at_q >= 0 and a_at_q == label_q:
        return 0
    at_p = cython.address(picture.pixels[p, 0])
    if label_p >= 0:
        at_p = cython.address(sample.pixels[label_p, 0])
    at_q = cython.address(picture.pixels[q, 0])
    if label_q >= 0:
        at_q = cython.address(sample.pixels[label_q, 0])
    if b_at_p < 0 and a_at_q < 0:
        cost = 510 * channels
    else:
        if b_at_p >= 0:
            cost += difference(at_p, cython.address(sample.pixels[b_at_p, 0]), channels)
            if sample.by_gradients:
                gradient += difference(at_q, cython.address(sample.pixels[b_at_p, 0]), channels)
        if a_at_q >= 0:
            cost += difference(at_q, cython.address(sample.pixels[a_at_q, 0]), channels)
            if sample.by_gradients:
                gradient += difference(at_p, cython.address(sample.pixels[a_at_q, 0]), channels)
        if b_at_p < 0 or a_at_q < 0:
            cost *= 2
            gradient *= 2
    if sample.by_gradients:
        return SCALE * cost // (gradient + SOFT * channels)
    return cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def start_graph(picture: Picture, sample: Sample, patch: Patch, graph: Graph) -> cython.void:
    """Fill in the choice that each pixel of the box has, and zeros."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int, p=cython.int)
    for i in range(patch.on_canvas.shape[0]):
        for j in range(patch.on_canvas.shape[1]):
            p = patch.on_canvas[i, j]
            if not sample.usable[patch.in_sample[i, j]] or (picture.done[p] and picture.known[p]):
                graph.choice[i, j] = OLD if picture.done[p] else NOTHING
            else:
                graph.choice[i, j] = EITHER if picture.done[p] else NEW
            graph.old[i, j] = 0
            graph.new[i, j] = 0
            for d in range(4):
                graph.arcs[i, j, d] = 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def build_graph(picture: Picture, sample: Sample, patch: Patch, graph: Graph) -> cython.longlong:
    """Fill in the graph whose minimum cut says which pixels of a box a patch replaces (section 3).

    A pair of neighbors costs c if both stay old (an old seam, or 0), a or b if one becomes new, and
    0 if both do. Instead of the paper's seam node (section 3.1), the arcs from the source to both
    take alpha + beta = c, and the arcs between them a - alpha and b - beta. This is exact if
    c <= a + b, as with metrics. Where costs weighed by gradients break it, b is raised to c - a;
    the cheapest labels are still no worse than the old ones.

    Returns the cost of pairs without a choice.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, d=cython.int, dy=cython.int, dx=cython.int)
    cython.declare(p=cython.int, q=cython.int, p_may=cython.int, q_may=cython.int)
    cython.declare(both_old=cython.longlong, alpha=cython.longlong)
    cython.declare(p_old=cython.longlong, q_old=cython.longlong)  # and the other one new
    rows: cython.Py_ssize_t = patch.on_canvas.shape[0]
    columns: cython.Py_ssize_t = patch.on_canvas.shape[1]
    fixed_cost: cython.longlong = 0
    start_graph(picture, sample, patch, graph)
    for i in range(rows):
        for j in range(columns):
            p = patch.on_canvas[i, j]
            p_may = graph.choice[i, j]
            if p_may == NOTHING:
                continue
            for d in range(4):
                dy = d % 2 * (1 - d // 2 * 2)
                dx = (1 - d % 2) * (1 - d // 2 * 2)
                v = i + dy
                u = j + dx
                if 0 <= v < rows and 0 <= u < columns:
                    if d > 1:
                        continue  # was met from the other side
                    q = patch.on_canvas[v, u]
                    q_may = graph.choice[v, u]
                else:
                    q = beside(picture, p, dy, dx)
                    if q < 0 or q == p or not picture.done[q]:
                        continue
                    q_may = OLD
                both_old = 0
                p_old = 0
                q_old = 0
                if p_may & OLD and q_may & OLD and p_may | q_may != OLD:
                    both_old = seam_cost(
                        picture, sample, p, q, dy, dx, picture.source[p], picture.source[q]
                    )
                if p_may & OLD and q_may & NEW:
                    p_old = seam_cost(
                        picture, sample, p, q, dy, dx, picture.source[p], patch.in_sample[v, u]
                    )
                if p_may & NEW and q_may & OLD:
                    q_old = seam_cost(
                        picture, sample, p, q, dy, dx, patch.in_sample[i, j], picture.source[q]
                    )
                if p_may == EITHER and q_may == EITHER:
                    q_old = max(q_old, both_old - p_old)
                    alpha = min(p_old, both_old)
                    graph.old[i, j] += cython.cast(cython.int, alpha)
                    graph.old[v, u] += cython.cast(cython.int, both_old - alpha)
                    graph.arcs[v, u, d + 2] = cython.cast(cython.int, p_old - alpha)
                    graph.arcs[i, j, d] = cython.cast(cython.int, q_old - both_old + alpha)
                elif p_may == EITHER:
                    graph.old[i, j] += cython.cast(cython.int, both_old + p_old)
                    graph.new[i, j] += cython.cast(cython.int, q_old)
                elif q_may == EITHER:
                    graph.old[v, u] += cython.cast(cython.int, both_old + q_old)
                    graph.new[v, u] += cython.cast(cython.int, p_old)
                else:
                    fixed_cost += p_old + q_old
    return fixed_cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def paste(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    graph: Graph,
    side: cython.const[cython.uchar][:, ::1],
) -> cython.Py_ssize_t:
    """Copy the pixels that the cut has on the new side; return how many were missing before."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.int, label=cython.int)
    covered: cython.Py_ssize_t = 0
    for i in range(patch.on_canvas.shape[0]):
        for j in range(patch.on_canvas.shape[1]):
            if side[i, j] or graph.choice[i, j] == NEW:
                p = patch.on_canvas[i, j]
                label = patch.in_sample[i, j]
                covered += not picture.done[p]
                picture.done[p] = 1
                picture.source[p] = label
                for k in range(sample.pixels.shape[1]):
                    picture.pixels[p, k] = sample.pixels[label, k]
    return covered


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def price_seams(
    picture: Picture,
    sample: Sample,
    places: cython.const[cython.int][:, ::1],
    costs: cython.int[::1],
) -> cython.void:
    """Fill in the cost of the seams to the right of and below each of these pixels."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int)
    cython.declare(p=cython.int, q=cython.int, cost=cython.longlong)
    for i in range(places.shape[0]):
        for j in range(places.shape[1]):
            p = places[i, j]
            costs[p] = 0
            for d in range(2):
                q = beside(picture, p, d, 1 - d)
                if q < 0 or q == p or not picture.done[p] or not picture.done[q]:
                    continue
                if picture.known[p] and picture.known[q]:
                    continue
                cost = seam_cost(
                    picture, sample, p, q, d, 1 - d, picture.source[p], picture.source[q]
                )
                costs[p] += cython.cast(cython.int, cost)


def graph_of_patch(picture: Picture, sample: Sample, patch: Patch, graph: Graph):
    """Call `build_graph`, beside other threads."""
    cython.declare(cost=cython.longlong)
    with cython.nogil:
        cost = build_graph(picture, sample, patch, graph)
    return cost


def paste_patch(picture: Picture, sample: Sample, patch: Patch, graph: Graph, side):
    """Call `paste`."""
    return paste(picture, sample, patch, graph, side)


def costs_of_seams(picture: Picture, sample: Sample, places, costs):
    """Call `price_seams`."""
    price_seams(picture, sample, places, costs)
