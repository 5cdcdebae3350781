# mypy: ignore-errors
"""Kernels of graph-cut textures: what a seam costs; compiled by Cython, see setup.py.

Pixels of the canvas and of the sample are flat, row by row. A pixel's label is its source: the
place in the sample that it was copied from, and so the patch that it belongs to. A direction is
right, down, left or up; the opposite of d is d ^ 2.
"""

import cython


@cython.cclass
class Sample:
    """The sample, and how its seams are weighed.

    Of a pixel's `joins`, bit d says that it has a usable neighbor in direction d, bit 4 + d that
    this one is around the border of a sample that tiles. `gradients` is filled with the differences
    of each pixel from the right and the lower one, if costs are weighed by them.
    """

    def __init__(self, pixels, joins, shape, whole, by_gradients, gradients):
        self.pixels = pixels
        self.joins = joins
        self.whole = whole
        self.height, self.width = shape
        self.by_gradients = by_gradients
        fill_gradients(self, gradients)
        self.gradients = gradients


@cython.cfunc
@cython.exceptval(check=False)
def fill_gradients(sample: Sample, gradients: cython.int[:, ::1]) -> cython.void:
    """See `Sample`."""
    cython.declare(p=cython.int, d=cython.int, q=cython.int)
    for p in range(gradients.shape[1]):
        for d in range(2):
            q = continued(sample, p, d)
            if q >= 0:
                gradients[d, p] = difference(
                    cython.address(sample.pixels[p, 0]),
                    cython.address(sample.pixels[q, 0]),
                    cython.cast(cython.Py_ssize_t, sample.pixels.shape[1]),
                )


@cython.cclass
class Picture:
    """The canvas so far.

    A label is -1 for a known pixel that is not in the sample; `done` is 1 where a pixel is, `known`
    where it may not be replaced. `runs` tells how many pixels there are, from each on along its
    row, up to 127, that may be replaced and have no seam to the right or below; or, as less
    than 0, how many that are missing. See `run_kernels.follow`.
    """

    def __init__(self, pixels, source, done, known, runs, shape, wrap):
        self.pixels = pixels
        self.source = source
        self.done = done
        self.known = known
        self.runs = runs
        self.height, self.width = shape
        self.wrap_y, self.wrap_x = wrap


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def beside(picture: Picture, p: cython.int, dy: cython.int, dx: cython.int) -> cython.int:
    """The pixel of the canvas beside p, or -1 beyond a border that does not go around."""
    y: cython.int = p // picture.width + dy
    x: cython.int = p % picture.width + dx
    if y < 0 or y >= picture.height:
        if not picture.wrap_y:
            return -1
        y = y - picture.height if y > 0 else y + picture.height
    if x < 0 or x >= picture.width:
        if not picture.wrap_x:
            return -1
        x = x - picture.width if x > 0 else x + picture.width
    return y * picture.width + x


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def seam_cost(
    picture: Picture,
    sample: Sample,
    p: cython.int,
    q: cython.int,
    d: cython.int,
    label_p: cython.int,
    label_q: cython.int,
) -> cython.longlong:
    """M(s, t, A, B) of equation (1): the cost of a seam between p and its neighbor q.

    |A(p) - B(p)| + |A(q) - B(q)|, and with gradients divided by those of A and of B across the
    seam (M' of section 5). Where a patch ends, the other half counts four times, and gradients
    twice: what goes on beyond the sample's border would be cut off. A known pixel that is not in
    the sample has the label -1, and no patch goes on from it.
    """
    cython.declare(at_p=cython.p_const_uchar, at_q=cython.p_const_uchar)
    cython.declare(other=cython.p_const_uchar, b_at_p=cython.int, cost=cython.int)
    cython.declare(gradient=cython.int, channels=cython.int)
    a_at_q: cython.int = continued(sample, label_p, d)
    if a_at_q >= 0 and a_at_q == label_q:
        return 0
    channels = cython.cast(cython.int, sample.pixels.shape[1])
    b_at_p = continued(sample, label_q, d ^ 2)
    cost = 0
    gradient = 0
    if b_at_p < 0 and a_at_q < 0:
        cost = 1020 * channels
    else:
        at_p = cython.address(picture.pixels[p, 0])
        if label_p >= 0:
            at_p = cython.address(sample.pixels[label_p, 0])
        at_q = cython.address(picture.pixels[q, 0])
        if label_q >= 0:
            at_q = cython.address(sample.pixels[label_q, 0])
        if b_at_p >= 0:
            other = cython.address(sample.pixels[b_at_p, 0])
            cost += difference(at_p, other, channels)
            gradient += difference(at_q, other, channels)
        if a_at_q >= 0:
            other = cython.address(sample.pixels[a_at_q, 0])
            cost += difference(at_q, other, channels)
            gradient += difference(at_p, other, channels)
        if b_at_p < 0 or a_at_q < 0:
            cost *= 4
            gradient *= 2
    if sample.by_gradients:
        return SCALE * cost // (gradient + SOFT * channels)
    return cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def price(
    picture: Picture,
    sample: Sample,
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
    costs: cython.int[:, ::1],
    cells: cython.longlong[:, ::1],
    side: cython.int,
) -> cython.void:
    """See `price_seams`."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int)
    cython.declare(p=cython.int, q=cython.int, cost=cython.int)
    for i in range(rows.shape[0]):
        for j in range(columns.shape[0]):
            p = rows[i] * picture.width + columns[j]
            cost = 0
            for d in range(2):
                q = p + (picture.width if d else 1)
                if (rows[i] + 1 == picture.height) if d else (columns[j] + 1 == picture.width):
                    q = beside(picture, p, d, 1 - d)
                if q < 0 or q == p or not picture.done[p] or not picture.done[q]:
                    continue
                if picture.known[p] and picture.known[q]:
                    continue
                cost += cython.cast(
                    cython.int,
                    seam_cost(picture, sample, p, q, d, picture.source[p], picture.source[q]),
                )
            cells[rows[i] // side, columns[j] // side] += cost - costs[rows[i], columns[j]]
            costs[rows[i], columns[j]] = cost


def price_seams(picture: Picture, sample: Sample, rows, columns, costs, cells, side):
    """Fill in the cost of the seams to the right of and below pixels; sum them up by cells.

    `rows` and `columns` are those of a box, `costs` and `cells` of the whole canvas; a cell has
    `side` pixels a side.
    """
    price(picture, sample, rows, columns, costs, cells, side)
