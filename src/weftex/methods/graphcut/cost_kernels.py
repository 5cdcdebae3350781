# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of graph-cut textures: the cost of a seam (Kwatra et al., 2003, sections 3 and 5).

Pixels of the canvas and of the sample are flat, row by row. The label of a pixel is its source, the
pixel of the sample that it was copied from. A direction is right, down, left or up; the opposite
of d is d ^ 2. Compiled by Cython, see setup.py and the .pxd.
"""

import cython


class Labeling:
    """The canvas and the sample, with old seams wherever labels do not continue.

    A label is -1 for a known pixel that is not from the sample. `done` is 1 for known and pasted
    pixels, `fixed` where a pixel may not be replaced. `runs` is, for each pixel, the number of
    pixels from it on along its row, at most 127, that may be replaced and have no seam to the right
    or below; or, negative, the number that are missing.

    Bit d of `joins` is set where a pixel of the sample has a usable neighbor in direction d, and
    bit 4 + d where that neighbor is across the border of a tileable sample. `gradients`, empty if
    costs are not divided by them, are the differences from the right and the lower neighbor.
    `whole`: all pixels of the sample are usable.
    """

    def __init__(self, canvas, shape, wrap, sample, sample_shape, whole):
        self.pixels, self.labels, self.done, self.fixed, self.runs = canvas
        self.height, self.width = shape
        self.wrap_y, self.wrap_x = wrap
        self.colors, self.usable, self.joins, self.gradients = sample
        self.by_gradients = len(self.gradients) > 0
        self.rows, self.columns = sample_shape
        self.whole = whole


def neighbor(labeling, p, dy, dx):
    """The canvas pixel beside p, or -1 beyond a border that does not wrap around."""
    y, x = p // labeling.width + dy, p % labeling.width + dx
    if y < 0 or y >= labeling.height:
        if not labeling.wrap_y:
            return -1
        y = y - labeling.height if y > 0 else y + labeling.height
    if x < 0 or x >= labeling.width:
        if not labeling.wrap_x:
            return -1
        x = x - labeling.width if x > 0 else x + labeling.width
    return y * labeling.width + x


def seam_cost(labeling, p, q, d, label_p, label_q):
    """M(s, t, A, B) of equation (1): the cost of a seam between p and its neighbor q.

    |A(p) - B(p)| + |A(q) - B(q)|, or M' of section 5, which divides it by the gradients across the
    seam. Where one patch ends at the sample's border, the missing half counts like the other, and
    the seam twice. No patch continues from the label -1.
    """
    cython.declare(at_p=cython.p_const_uchar, at_q=cython.p_const_uchar)
    cython.declare(cost=cython.int, gradient=cython.int)
    a_at_q = continued(labeling, label_p, d)
    if a_at_q >= 0 and a_at_q == label_q:
        return 0
    channels: cython.int = labeling.colors.shape[1]
    b_at_p = continued(labeling, label_q, d ^ 2)
    cost = gradient = 0
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
    cost: cython.int
    for i in range(rows.shape[0]):
        for j in range(columns.shape[0]):
            p = rows[i] * labeling.width + columns[j]
            cost = 0
            for d in range(2):
                q = neighbor(labeling, p, d, 1 - d)
                if q < 0 or q == p or not labeling.done[p] or not labeling.done[q]:
                    continue
                if labeling.fixed[p] and labeling.fixed[q]:
                    continue
                cost += seam_cost(labeling, p, q, d, labeling.labels[p], labeling.labels[q])
            cells[rows[i] // side, columns[j] // side] += cost - costs[rows[i], columns[j]]
            costs[rows[i], columns[j]] = cost


def may_change(labeling, p):
    """Whether a pixel is there and may be replaced."""
    return labeling.done[p] and not labeling.fixed[p]


def is_joined(labeling, p, d, last):
    """Whether the neighbor in direction d continues the patch and may change, or does not exist.

    `last`: the pixel is in the last row or column of the canvas.
    """
    q = p + (labeling.width if d else 1)
    if last:
        q = neighbor(labeling, p, d, 1 - d)
        if q < 0:
            return True
    if continued(labeling, labeling.labels[p], d) != labeling.labels[q]:
        return False
    return may_change(labeling, q)


def update_row(labeling, y, first, last):
    """Update `runs` of a row where something changed from column `first` to `last`."""
    cython.declare(run=cython.int, after=cython.int)
    after = 0
    if last + 1 < labeling.width:
        after = labeling.runs[y * labeling.width + last + 1]
    for x in range(last, -1, -1):
        p = y * labeling.width + x
        if x >= first:
            run = 0
            if not labeling.done[p]:
                run = -1
            elif may_change(labeling, p):
                run = is_joined(labeling, p, 0, x + 1 == labeling.width)
                run = run and is_joined(labeling, p, 1, y + 1 == labeling.height)
        else:
            run = (labeling.runs[p] > 0) - (labeling.runs[p] < 0)
        if run > 0 and after > 0:
            run = min(after + 1, 127)
        elif run < 0 and after < 0:
            run = max(after - 1, -127)
        if x < first and run == labeling.runs[p]:
            break
        labeling.runs[p] = run
        after = run


def update_runs(labeling, rows, columns):
    """Update `runs` after a patch was pasted into a box: there, above it and left of it."""
    first, last = columns[0] - 1, columns[columns.shape[0] - 1]
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
    for y in range(labeling.height):
        update_row(labeling, y, 0, labeling.width - 1)
