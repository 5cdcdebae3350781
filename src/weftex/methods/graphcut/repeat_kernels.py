# mypy: ignore-errors
"""Kernels of graph-cut textures: what a patch would show again; compiled by Cython, see setup.py.

A patch whose corner has the place (top, left) of the sample shows there what the canvas shows
already at some distance. Which places those are is a box for every pixel of the canvas; boxes are
summed up as differences at their corners.
"""

import cython


@cython.cclass
class Showing:
    """What the canvas shows of the sample, and what of it counts as shown again.

    `source` has the pixels that are looked at, a part of all.
    A pixel counts as nearby if both distances, down and across, are up to `near`, and in line for
    each of them that is up to `aligned`.
    """

    source: cython.const[cython.int][:, ::1]
    height: cython.int  # of the sample
    width: cython.int
    tiles: cython.bint
    patch: cython.const[cython.int][::1]  # height and width
    near: cython.const[cython.int][::1]
    aligned: cython.const[cython.int][::1]

    def __init__(self, source, shape, tiles, patch, near, aligned):
        self.source = source
        self.height, self.width = shape
        self.tiles = tiles
        self.patch = patch
        self.near = near
        self.aligned = aligned


@cython.cclass
class Marks:
    """The places of patches, every 2**halvings-th both ways; a row and a column more than those."""

    marks: cython.int[:, ::1]
    halvings: cython.int

    def __init__(self, marks, halvings):
        self.marks = marks
        self.halvings = halvings


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mark(
    places: Marks, top: cython.int, bottom: cython.int, left: cython.int, right: cython.int
) -> cython.void:
    """Add 1 to the places of a box; bottom and right belong to it."""
    rows: cython.int = cython.cast(cython.int, places.marks.shape[0]) - 1
    columns: cython.int = cython.cast(cython.int, places.marks.shape[1]) - 1
    if bottom < 0 or right < 0 or top > bottom or left > right:
        return
    top = ((max(top, 0) - 1) >> places.halvings) + 1
    left = ((max(left, 0) - 1) >> places.halvings) + 1
    bottom = min((bottom >> places.halvings) + 1, rows)
    right = min((right >> places.halvings) + 1, columns)
    if top >= bottom or left >= right:
        return
    places.marks[top, left] += 1
    places.marks[top, right] -= 1
    places.marks[bottom, left] -= 1
    places.marks[bottom, right] += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mark_again(
    showing: Showing,
    nearby: Marks,
    in_line: Marks,
    y: cython.int,
    x: cython.int,
    away_y: cython.int,
    away_x: cython.int,
) -> cython.void:
    """Mark the places of patches that show (y, x) of the sample again.

    It is shown at (away_y, away_x) from the patch's corner, so a patch of the place (top, left)
    shows it again (y - away_y - top) lines below and (x - away_x - left) to the right.
    """
    top: cython.int = y - showing.patch[0] + 1
    left: cython.int = x - showing.patch[1] + 1
    at_y: cython.int = y - away_y
    at_x: cython.int = x - away_x
    near_y: cython.int = showing.near[0]
    near_x: cython.int = showing.near[1]
    mark(
        nearby,
        max(top, at_y - near_y),
        min(y, at_y + near_y),
        max(left, at_x - near_x),
        min(x, at_x + near_x),
    )
    near_y = showing.aligned[0]
    near_x = showing.aligned[1]
    mark(in_line, max(top, at_y - near_y), min(y, at_y + near_y), left, x)
    mark(in_line, top, y, max(left, at_x - near_x), min(x, at_x + near_x))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def count(
    showing: Showing,
    rows: cython.const[cython.int][:, ::1],
    columns: cython.const[cython.int][:, ::1],
    nearby: Marks,
    in_line: Marks,
) -> cython.void:
    """See `count_shown`."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, label=cython.int)
    cython.declare(y=cython.int, x=cython.int, v=cython.int, u=cython.int)
    around: cython.int = 1 if showing.tiles else 0
    for i in range(rows.shape[1]):
        for j in range(columns.shape[1]):
            label = showing.source[rows[0, i], columns[0, j]]
            if label < 0:
                continue
            for v in range(-around, around + 1):
                for u in range(-around, around + 1):
                    y = label // showing.width + v * showing.height
                    x = label % showing.width + u * showing.width
                    mark_again(showing, nearby, in_line, y, x, rows[1, i], columns[1, j])


def count_squares(
    source: cython.const[cython.int][:, ::1],
    width: cython.int,
    halvings: cython.int,
    counts: cython.longlong[:, ::1],
):
    """Count the pixels by the square of 2**halvings a side of the sample that they come from."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, label=cython.int)
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            label = source[i, j]
            if label >= 0:
                counts[label // width >> halvings, label % width >> halvings] += 1


def count_shown(showing: Showing, rows, columns, nearby: Marks, in_line: Marks):
    """Count, for each place of a patch, the pixels that it would show again, as differences.

    `rows` and `columns` have the numbers of lines of `source`, and their distances from the patch's
    corner.
    """
    count(showing, rows, columns, nearby, in_line)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def sum_missing(
    counts: cython.const[cython.int][:, ::1],
    missing: cython.const[cython.uchar][:, ::1],
    top: cython.Py_ssize_t,
    left: cython.Py_ssize_t,
    sums: cython.p_longlong,
) -> cython.void:
    """The sum of counts where something is missing, its corner on (top, left), and how much is."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, total=cython.int, area=cython.int)
    cython.declare(one=cython.p_const_int, other=cython.p_const_uchar)
    first: cython.Py_ssize_t = max(0, -left)
    last: cython.Py_ssize_t = min(missing.shape[1], counts.shape[1] - left)
    sums[0] = 0
    sums[1] = 0
    if first >= last:
        return
    for i in range(max(0, -top), min(missing.shape[0], counts.shape[0] - top)):
        one = cython.address(counts[top + i, left + first])
        other = cython.address(missing[i, first])
        total = 0
        area = 0
        for j in range(last - first):
            total += one[j] * other[j]
            area += other[j]
        sums[0] += total
        sums[1] += area


def sum_over(
    counts: cython.const[cython.int][:, ::1],
    missing: cython.const[cython.uchar][:, ::1],
    allowed: cython.const[cython.uchar][:, ::1],
    offset: cython.const[cython.int][::1],
    sums: cython.longlong[:, :, ::1],
):
    """Fill in `sum_missing` for each place, which has the offset from that corner."""
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    for y in range(allowed.shape[0]):
        for x in range(allowed.shape[1]):
            if allowed[y, x]:
                sum_missing(
                    counts, missing, y - offset[0], x - offset[1], cython.address(sums[y, x, 0])
                )
