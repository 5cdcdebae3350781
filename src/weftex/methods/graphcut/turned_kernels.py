# mypy: ignore-errors
"""Kernels of graph-cut textures: what a turned copy would show again; compiled, see setup.py."""

import cython


@cython.cclass
class Seen:
    """What the canvas shows in sight of a pixel, by the cells of the sample that it is of.

    Cell k is shown at `where[first[k]:first[k + 1]]`: rows and columns of cells from the pixel on,
    and the number of the copy that is shown there. `counts` says how often all of the canvas shows
    each. `weights` has what a repetition counts at a distance, its middle being none; `near`
    is the square of the distance within which another copy counts as beside it.
    """

    first: cython.const[cython.int][::1]
    where: cython.const[cython.int][:, ::1]
    counts: cython.const[cython.int][::1]
    salience: cython.const[cython.int][::1]
    weights: cython.const[cython.int][:, ::1]
    near: cython.int

    def __init__(self, first, where, counts, salience, weights, near):
        self.first = first
        self.where = where
        self.counts = counts
        self.salience = salience
        self.weights = weights
        self.near = near


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def add_cell(
    seen: Seen,
    cell: cython.int,
    copy: cython.int,
    down: cython.Py_ssize_t,
    along: cython.Py_ssize_t,
    missing: cython.bint,
    sums: cython.p_longlong,
) -> cython.void:
    """Add what a cell of the sample, shown by a copy so many cells from the pixel, shows again."""
    cython.declare(k=cython.int, y=cython.Py_ssize_t, x=cython.Py_ssize_t, each=cython.int)
    far_y: cython.Py_ssize_t = seen.weights.shape[0] // 2
    far_x: cython.Py_ssize_t = seen.weights.shape[1] // 2
    weight: cython.longlong = 0
    for k in range(seen.first[cell], seen.first[cell + 1]):
        y = seen.where[k, 0] - down
        x = seen.where[k, 1] - along
        each = 0
        if -far_y <= y <= far_y and -far_x <= x <= far_x:
            each = seen.weights[y + far_y, x + far_x]
        if seen.where[k, 2] != copy:
            each //= 2  # what is turned is seen less
            sums[3] += y * y + x * x <= seen.near
        weight += each
    if not missing:
        return
    sums[0] += weight * seen.salience[cell]
    sums[1] += seen.salience[cell]
    sums[2] += seen.counts[cell]
    sums[4] += 1


def sum_seen(
    seen: Seen,
    cells: cython.const[cython.int][:, ::1],
    copy: cython.int,
    missing: cython.const[cython.uchar][:, ::1],
    places: cython.const[cython.uchar][:, ::1],
    sums: cython.longlong[:, :, ::1],
):
    """Add up, for each place of a copy, what it would show again where something is missing.

    `cells` has the cells of the sample that the copy shows. The middle of `missing` is the pixel.
    The sums are those of saliences times weights, of saliences, of counts, of what other copies
    show beside it, missing or not, as a cut may run there, and how many cells would be shown.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    up: cython.Py_ssize_t = missing.shape[0] // 2
    left: cython.Py_ssize_t = missing.shape[1] // 2
    for y in range(places.shape[0]):
        for x in range(places.shape[1]):
            if not places[y, x]:
                continue
            for i in range(max(0, y - up), min(cells.shape[0], y - up + missing.shape[0])):
                for j in range(max(0, x - left), min(cells.shape[1], x - left + missing.shape[1])):
                    add_cell(
                        seen,
                        cells[i, j],
                        copy,
                        i - y,
                        j - x,
                        missing[i - y + up, j - x + left],
                        cython.address(sums[y, x, 0]),
                    )
