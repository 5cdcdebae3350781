# mypy: ignore-errors
"""Kernels of graph-cut textures: the cost of a seam (Kwatra et al., 2003, sections 3 and 5).

Pixels of the canvas and of the sample are flat, row by row. The label of a pixel is its source, the
pixel of the sample that it was copied from. A direction is right, down, left or up; the opposite
of d is d ^ 2. Compiled by Cython, see setup.py.
"""

import cython


@cython.cclass
class SeamCost:
    """The sample, and what the cost of its seams needs.

    Bit d of `joins` is set where a pixel has a usable neighbor in direction d, and bit 4 + d where
    that neighbor is across the border of a tileable sample. `gradients` is filled with the
    differences from the right and the lower neighbor, if costs are divided by them. `whole`: all
    pixels of the sample are usable.
    """

    def __init__(self, pixels, usable, joins, shape, whole, gradients):
        self.pixels = pixels
        self.usable = usable
        self.joins = joins
        self.whole = whole
        self.height, self.width = shape
        self.by_gradients = gradients is not None
        if self.by_gradients:
            fill_gradients(self, gradients)
            self.gradients = gradients


@cython.cfunc
@cython.exceptval(check=False)
def fill_gradients(sample: SeamCost, gradients: cython.int[:, ::1]) -> cython.void:
    """Fill in the differences of all pixels from their right and lower neighbors."""
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
class Labeling:
    """The canvas: pixels and their labels, with old seams wherever labels do not continue.

    The label is -1 for a known pixel that is not from the sample. `done` is 1 for known and pasted
    pixels, `known` where a pixel may not be replaced. `runs`: see `run_kernels`.
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
def beside(labeling: Labeling, p: cython.int, dy: cython.int, dx: cython.int) -> cython.int:
    """The canvas pixel beside p, or -1 beyond a border that does not wrap around."""
    y: cython.int = p // labeling.width + dy
    x: cython.int = p % labeling.width + dx
    if y < 0 or y >= labeling.height:
        if not labeling.wrap_y:
            return -1
        y = y - labeling.height if y > 0 else y + labeling.height
    if x < 0 or x >= labeling.width:
        if not labeling.wrap_x:
            return -1
        x = x - labeling.width if x > 0 else x + labeling.width
    return y * labeling.width + x


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def seam_cost(
    labeling: Labeling,
    sample: SeamCost,
    p: cython.int,
    q: cython.int,
    d: cython.int,
    label_p: cython.int,
    label_q: cython.int,
) -> cython.longlong:
    """M(s, t, A, B) of equation (1): the cost of a seam between p and its neighbor q.

    |A(p) - B(p)| + |A(q) - B(q)|, or M' of section 5, which divides it by the gradients across the
    seam. Where one patch ends at the sample's border, the other's half counts four times, and its
    gradient twice. No patch continues from the label -1.
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
        at_p = cython.address(labeling.pixels[p, 0])
        if label_p >= 0:
            at_p = cython.address(sample.pixels[label_p, 0])
        at_q = cython.address(labeling.pixels[q, 0])
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


def sum_seams(
    labeling: Labeling,
    sample: SeamCost,
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
    costs: cython.int[:, ::1],
    cells: cython.longlong[:, ::1],
    side: cython.int,
):
    """Update the costs of the seams right of and below the pixels of a box of the canvas.

    `cells` are the sums of all `costs` over squares of `side` pixels.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, d=cython.int)
    cython.declare(p=cython.int, q=cython.int, cost=cython.int)
    for i in range(rows.shape[0]):
        for j in range(columns.shape[0]):
            p = rows[i] * labeling.width + columns[j]
            cost = 0
            for d in range(2):
                q = p + (labeling.width if d else 1)
                if (rows[i] + 1 == labeling.height) if d else (columns[j] + 1 == labeling.width):
                    q = beside(labeling, p, d, 1 - d)
                if q < 0 or q == p or not labeling.done[p] or not labeling.done[q]:
                    continue
                if labeling.known[p] and labeling.known[q]:
                    continue
                cost += cython.cast(
                    cython.int,
                    seam_cost(labeling, sample, p, q, d, labeling.source[p], labeling.source[q]),
                )
            cells[rows[i] // side, columns[j] // side] += cost - costs[rows[i], columns[j]]
            costs[rows[i], columns[j]] = cost
