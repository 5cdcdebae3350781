# mypy: ignore-errors
"""Kernels of graph-cut textures: what a patch would show again; compiled by Cython, see setup.py.

A patch whose corner has the place (top, left) of the sample shows there what the canvas shows
already at some distance. Which places those are is a box for every pixel of the canvas; boxes are
summed up as differences at their corners.
"""

import cython
from cython.cimports.libc.math import fabs, rint, sqrt


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


@cython.cclass
class Distances:
    """What a repetition counts at a distance: the nearer, the more, and more in line.

    Cells have `side` pixels, the sample `height` and `width`; all else is in sides of the sample.
    """

    side: cython.int
    height: cython.int
    width: cython.int
    far: cython.double
    line: cython.double
    line_far: cython.double
    lines: cython.double
    unit: cython.double

    def __init__(self, side, shape, far, line, line_far, lines, unit):
        self.side = side
        self.height, self.width = shape
        self.far = far
        self.line = line
        self.line_far = line_far
        self.lines = lines
        self.unit = unit


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def weight_of(how: Distances, down: cython.double, along: cython.double) -> cython.longlong:
    """What a repetition counts at a distance in pixels."""
    cython.declare(weight=cython.double, off=cython.double, line=cython.double)
    down /= how.height
    along /= how.width
    away: cython.double = sqrt(down * down + along * along)
    weight = max(1 - away / how.far, 0.0)
    if how.line > 0:
        off = min(fabs(down), fabs(along))  # the row or the column that is nearer
        line = max(1 - how.lines * off, 0.0) * max(1 - away / how.line_far, 0.0)
        weight += how.line * line
    return cython.cast(cython.longlong, rint(how.unit * weight))


def find_pieces(
    source: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.int][:, ::1],
    columns: cython.const[cython.int][:, ::1],
    width: cython.int,
    shifts: cython.int[:, ::1],
    pieces: cython.int[:, ::1],
):
    """Tell pieces of the sample, `width` pixels wide, by their shifts; return how many there are.

    `rows` and `columns` have the numbers of lines of `source`, and how far away they are; `pieces`
    is filled with which one shows there, -1 for none.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, label=cython.int, k=cython.int)
    cython.declare(down=cython.int, along=cython.int, last=cython.int)
    count: cython.int = 0
    for i in range(rows.shape[1]):
        last = 0
        for j in range(columns.shape[1]):
            label = source[rows[0, i], columns[0, j]]
            if label < 0:
                pieces[i, j] = -1
                continue
            down = rows[1, i] - label // width
            along = columns[1, j] - label % width
            if not (last < count and shifts[last, 0] == down and shifts[last, 1] == along):
                k = count - 1
                while k >= 0 and not (shifts[k, 0] == down and shifts[k, 1] == along):
                    k -= 1
                if k < 0:
                    k = count
                    shifts[k, 0] = down
                    shifts[k, 1] = along
                    count += 1
                last = k
            pieces[i, j] = last
    return count


def show_pieces(
    source: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.int][:, ::1],
    columns: cython.const[cython.int][:, ::1],
    pieces: cython.const[cython.int][:, ::1],
    how: Distances,
    salience: cython.const[cython.int][:, ::1],
    shown: cython.int[:, :, ::1],
    boxes: cython.int[:, ::1],
):
    """Fill in the salience of the cells that each piece shows, and the box that they lie in.

    A box has its first row, one after the last, and likewise columns.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, label=cython.int, k=cython.int)
    cython.declare(y=cython.int, x=cython.int)
    height: cython.int = cython.cast(cython.int, salience.shape[0])
    width: cython.int = cython.cast(cython.int, salience.shape[1])
    for k in range(shown.shape[0]):
        boxes[k, 0] = height
        boxes[k, 1] = 0
        boxes[k, 2] = width
        boxes[k, 3] = 0
    for i in range(rows.shape[1]):
        for j in range(columns.shape[1]):
            k = pieces[i, j]
            if k < 0:
                continue
            label = source[rows[0, i], columns[0, j]]
            y = min(label // how.width // how.side, height - 1)
            x = min(label % how.width // how.side, width - 1)
            shown[k, y, x] = salience[y, x]
            boxes[k, 0] = min(boxes[k, 0], y)
            boxes[k, 1] = max(boxes[k, 1], y + 1)
            boxes[k, 2] = min(boxes[k, 2], x)
            boxes[k, 3] = max(boxes[k, 3], x + 1)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def sum_in_box(
    shown: cython.const[cython.int][:, ::1],
    box: cython.p_const_int,
    missing: cython.const[cython.uchar][:, ::1],
    top: cython.Py_ssize_t,
    left: cython.Py_ssize_t,
) -> cython.longlong:
    """The sum of what is shown in a box where something is missing, its corner on (top, left)."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, total=cython.int)
    cython.declare(one=cython.p_const_int, other=cython.p_const_uchar)
    first: cython.Py_ssize_t = max(box[2], left)
    last: cython.Py_ssize_t = min(box[3], left + missing.shape[1])
    result: cython.longlong = 0
    if first >= last:
        return 0
    for i in range(max(box[0], top), min(box[1], top + missing.shape[0])):
        one = cython.address(shown[i, first])
        other = cython.address(missing[i - top, first - left])
        total = 0
        for j in range(last - first):
            total += one[j] * other[j]
        result += total
    return result


def sum_pieces(
    shown: cython.const[cython.int][:, :, ::1],
    boxes: cython.const[cython.int][:, ::1],
    shifts: cython.const[cython.int][:, ::1],
    missing: cython.const[cython.uchar][:, ::1],
    cells: cython.const[cython.uchar][:, ::1],
    how: Distances,
    sums: cython.longlong[:, ::1],
):
    """Add up, for each of some cells, what comes again of it, by distance.

    The corner of `missing` lies as many cells before a place as there are.
    """
    cython.declare(k=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(weight=cython.longlong)
    for k in range(shifts.shape[0]):
        for y in range(cells.shape[0]):
            for x in range(cells.shape[1]):
                if not cells[y, x]:
                    continue
                weight = weight_of(how, y * how.side + shifts[k, 0], x * how.side + shifts[k, 1])
                if weight:
                    sums[y, x] += weight * sum_in_box(
                        shown[k],
                        cython.address(boxes[k, 0]),
                        missing,
                        y - cells.shape[0],
                        x - cells.shape[1],
                    )
