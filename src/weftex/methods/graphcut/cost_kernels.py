# mypy: ignore-errors
"""Kernels of graph-cut textures: the cost of a seam (Kwatra et al., 2003, sections 3 and 5).

Pixels of the canvas and of the sample are flat, row by row. The label of a pixel is its source, the
pixel of the sample that it was copied from. A direction is right, down, left or up; the opposite
of d is d ^ 2. Compiled by Cython, see setup.py.
"""

import cython


@cython.cclass
class Labeling:
    """The canvas and the sample, with old seams wherever labels do not continue.

    A label is -1 for a known pixel that is not from the sample. `done` is 1 for known and pasted
    pixels, `known` where a pixel may not be replaced. `runs` is, for each pixel, the number of
    pixels from it on along its row, at most 127, that may be replaced and have no seam to the right
    or below; or, negative, the number that are missing.

    Bit d of `joins` is set where a pixel of the sample has a usable neighbor in direction d, and
    bit 4 + d where that neighbor is across the border of a tileable sample. `gradients`, empty if
    costs are not divided by them, are the differences from the right and the lower neighbor.
    `whole`: all pixels of the sample are usable.
    """

    def __init__(self, canvas, shape, wrap, sample, sample_shape, whole):
        self.pixels, self.labels, self.done, self.known, self.runs = canvas
        self.height, self.width = shape
        self.wrap_y, self.wrap_x = wrap
        self.colors, self.usable, self.joins, self.gradients = sample
        self.by_gradients = len(self.gradients) > 0
        self.rows, self.columns = sample_shape
        self.whole = whole


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def neighbor(labeling: Labeling, p: cython.int, dy: cython.int, dx: cython.int) -> cython.int:
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
    labeling: Labeling, p: cython.int, q: cython.int, d: cython.int,
    label_p: cython.int, label_q: cython.int,
) -> cython.longlong:  # fmt: skip
    """M(s, t, A, B) of equation (1): the cost of a seam between p and its neighbor q.

    |A(p) - B(p)| + |A(q) - B(q)|, or M' of section 5, which divides it by the gradients across the
    seam. Where one patch ends at the sample's border, the missing half counts like the other, and
    the seam twice. No patch continues from the label -1.
    """
    cython.declare(at_p=cython.p_const_uchar, at_q=cython.p_const_uchar)
    cython.declare(other=cython.p_const_uchar, b_at_p=cython.int, cost=cython.int)
    cython.declare(gradient=cython.int, channels=cython.int)
    a_at_q: cython.int = continued(labeling, label_p, d)
    if a_at_q >= 0 and a_at_q == label_q:
        return 0
    channels = cython.cast(cython.int, labeling.colors.shape[1])
    b_at_p = continued(labeling, label_q, d ^ 2)
    cost = 0
    gradient = 0
    if b_at_p < 0 and a_at_q < 0:
        cost = 4 * WHITE * channels
    else:
        at_p = cython.address(labeling.pixels[p, 0])
        if label_p >= 0:
            at_p = cython.address(labeling.colors[label_p, 0])
        at_q = cython.address(labeling.pixels[q, 0])
        if label_q >= 0:
            at_q = cython.address(labeling.colors[label_q, 0])
        if b_at_p >= 0:
            other = cython.address(labeling.colors[b_at_p, 0])
            cost += difference(at_p, other, channels)
            gradient += difference(at_q, other, channels)
        if a_at_q >= 0:
            other = cython.address(labeling.colors[a_at_q, 0])
            cost += difference(at_q, other, channels)
            gradient += difference(at_p, other, channels)
        if b_at_p < 0 or a_at_q < 0:
            cost *= 4
            gradient *= 2
    return divided(cost, gradient, channels) if labeling.by_gradients else cost


def sum_seams(
    labeling: Labeling,
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
                q = neighbor(labeling, p, d, 1 - d)
                if q < 0 or q == p or not labeling.done[p] or not labeling.done[q]:
                    continue
                if labeling.known[p] and labeling.known[q]:
                    continue
                cost += cython.cast(
                    cython.int,
                    seam_cost(labeling, p, q, d, labeling.labels[p], labeling.labels[q]),
                )
            cells[rows[i] // side, columns[j] // side] += cost - costs[rows[i], columns[j]]
            costs[rows[i], columns[j]] = cost


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def may_change(labeling: Labeling, p: cython.int) -> cython.bint:
    return labeling.done[p] and not labeling.known[p]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def is_joined(
    labeling: Labeling, p: cython.int, d: cython.int, last: cython.bint
) -> cython.bint:  # fmt: skip
    """Whether the neighbor in direction d continues the patch and may change, or does not exist.

    `last`: the pixel is in the last row or column of the canvas.
    """
    q: cython.int = p + (labeling.width if d else 1)
    if last:
        q = neighbor(labeling, p, d, 1 - d)
        if q < 0:
            return True
    same: cython.bint = continued(labeling, labeling.labels[p], d) == labeling.labels[q]
    return same and may_change(labeling, q)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def update_row(
    labeling: Labeling, y: cython.int, first: cython.int, last: cython.int
) -> cython.void:
    """Update `runs` of a row where something changed from column `first` to `last`."""
    cython.declare(x=cython.int, p=cython.int, run=cython.int)
    lowest: cython.bint = y + 1 == labeling.height
    after: cython.int = 0
    if last + 1 < labeling.width:
        after = labeling.runs[y * labeling.width + last + 1]
    for x in range(last, -1, -1):
        p = y * labeling.width + x
        if x >= first:
            run = 0
            if not labeling.done[p]:
                run = -1
            elif may_change(labeling, p):
                run = is_joined(labeling, p, 0, x + 1 == labeling.width) and is_joined(
                    labeling, p, 1, lowest
                )
        else:
            run = (labeling.runs[p] > 0) - (labeling.runs[p] < 0)
        if run > 0 and after > 0:
            run = min(after + 1, 127)
        elif run < 0 and after < 0:
            run = max(after - 1, -127)
        if x < first and run == labeling.runs[p]:
            break
        labeling.runs[p] = cython.cast(cython.schar, run)
        after = run


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def update_runs(
    labeling: Labeling,
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
) -> cython.void:
    """Update `runs` after a patch was pasted into a box: there, above it and left of it."""
    cython.declare(i=cython.Py_ssize_t, y=cython.int)
    first: cython.int = columns[0] - 1
    last: cython.int = columns[columns.shape[0] - 1]
    if last - first != columns.shape[0] or (first < 0 and labeling.wrap_x):  # around the border
        first = 0
        last = labeling.width - 1
    for i in range(-1, rows.shape[0]):
        y = rows[i] if i >= 0 else rows[0] - 1
        if y < 0 and labeling.wrap_y:
            y = labeling.height - 1
        if y >= 0:
            update_row(labeling, y, max(first, 0), last)


def find_runs(labeling: Labeling):
    """Fill in `runs` of the whole canvas."""
    cython.declare(y=cython.int)
    for y in range(labeling.height):
        update_row(labeling, y, 0, labeling.width - 1)
