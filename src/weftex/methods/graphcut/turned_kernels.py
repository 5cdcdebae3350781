# mypy: ignore-errors
"""Kernels of graph-cut textures: what a turned copy would show again; compiled, see setup.py."""

import cython


@cython.cclass
class Seen:
    """What the canvas shows in sight of a pixel, by the cells of the sample that it is of.

    Cell k is shown at `where[first[k]:first[k + 1]]`: rows and columns of cells from the pixel on,
    and the number of the copy that is shown there. `counts` says how often all of the canvas shows
    each. `weights` has what a repetition counts at a distance, its middle being none. `near` is the
    square of the distance within which another copy counts as beside it, `close` of that within
    which one does that is `mirrored` where the other is not.
    """

    first: cython.const[cython.int][::1]
    where: cython.const[cython.int][:, ::1]
    counts: cython.const[cython.int][::1]
    salience: cython.const[cython.int][::1]
    weights: cython.const[cython.int][:, ::1]
    mirrored: cython.const[cython.uchar][::1]
    near: cython.int
    close: cython.int
    mirrors: cython.bint  # whether any copy is mirrored

    def __init__(self, first, where, counts, salience, weights, mirrored, near, close):
        self.first = first
        self.where = where
        self.counts = counts
        self.salience = salience
        self.weights = weights
        self.mirrored = mirrored
        self.near = near
        self.close = close
        self.mirrors = any(mirrored)


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
    cython.declare(k=cython.int, y=cython.Py_ssize_t, x=cython.Py_ssize_t, other=cython.int)
    far_y: cython.Py_ssize_t = seen.weights.shape[0] // 2
    far_x: cython.Py_ssize_t = seen.weights.shape[1] // 2
    weight: cython.longlong = 0
    for k in range(seen.first[cell], seen.first[cell + 1]):
        y = seen.where[k, 0] - down
        x = seen.where[k, 1] - along
        other = seen.where[k, 2]
        if seen.mirrored[other] != seen.mirrored[copy]:
            sums[5] += y * y + x * x <= seen.close
        if missing:
            sums[3] += other != copy and y * y + x * x <= seen.near
            if -far_y <= y <= far_y and -far_x <= x <= far_x:
                weight += seen.weights[y + far_y, x + far_x]
    if missing:
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
    show beside it, how many cells would be shown, and what is shown in a mirror close by, missing
    or not, as a cut may run there.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, new=cython.bint)
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    up: cython.Py_ssize_t = missing.shape[0] // 2
    left: cython.Py_ssize_t = missing.shape[1] // 2
    for y in range(places.shape[0]):
        for x in range(places.shape[1]):
            if not places[y, x]:
                continue
            for i in range(max(0, y - up), min(cells.shape[0], y - up + missing.shape[0])):
                for j in range(max(0, x - left), min(cells.shape[1], x - left + missing.shape[1])):
                    new = missing[i - y + up, j - x + left]
                    if new or seen.mirrors:
                        add_cell(
                            seen,
                            cells[i, j],
                            copy,
                            i - y,
                            j - x,
                            new,
                            cython.address(sums[y, x, 0]),
                        )
