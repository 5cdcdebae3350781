# mypy: ignore-errors
"""Kernels of repetition penalties; compiled by Cython, see setup.py.

A patch whose corner has the offset (top, left) in the sample repeats what the canvas shows at some
distance for a box of offsets, for each pixel of the canvas. Boxes are summed up as differences at
their corners. `rows` and `columns` are those looked at: their numbers in `source`, and their
distances from the patch.
"""

import cython


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mark(
    marks: cython.int[:, ::1],
    halvings: cython.int,
    top: cython.int,
    bottom: cython.int,
    left: cython.int,
    right: cython.int,
) -> cython.void:
    """Add 1 to the offsets of a box, bottom and right included; `marks` has a line more of both."""
    if bottom < 0 or right < 0 or top > bottom or left > right:
        return
    top = ((max(top, 0) - 1) >> halvings) + 1
    left = ((max(left, 0) - 1) >> halvings) + 1
    bottom = min((bottom >> halvings) + 1, cython.cast(cython.int, marks.shape[0]) - 1)
    right = min((right >> halvings) + 1, cython.cast(cython.int, marks.shape[1]) - 1)
    if top >= bottom or left >= right:
        return
    marks[top, left] += 1
    marks[top, right] -= 1
    marks[bottom, left] -= 1
    marks[bottom, right] += 1


def mark_repeats(
    source: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.int][:, ::1],
    columns: cython.const[cython.int][:, ::1],
    sample: cython.const[cython.int][::1],
    reach: cython.const[cython.int][:, ::1],
    halvings: cython.int,
    marks: cython.int[:, :, ::1],
):
    """Count, for each offset of a patch, the pixels that it would repeat, as differences.

    `sample`: its height and width, and whether it is tileable. `reach`: height and width of the
    patch, distances that count as nearby, and distances that count as in line. `marks` gets what is
    nearby (both distances are) and what is in line (each distance that is).
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, label=cython.int, v=cython.int)
    cython.declare(y=cython.int, x=cython.int, u=cython.int, at_y=cython.int, at_x=cython.int)
    cython.declare(top=cython.int, left=cython.int)
    near: cython.int[:, ::1] = marks[0]
    line: cython.int[:, ::1] = marks[1]
    height: cython.int = sample[0]
    width: cython.int = sample[1]
    around: cython.int = 1 if sample[2] else 0
    near_y: cython.int = reach[1, 0]
    near_x: cython.int = reach[1, 1]
    line_y: cython.int = reach[2, 0]
    line_x: cython.int = reach[2, 1]
    for i in range(rows.shape[1]):
        for j in range(columns.shape[1]):
            label = source[rows[0, i], columns[0, j]]
            if label < 0:
                continue
            for v in range(-around, around + 1):
                for u in range(-around, around + 1):
                    y = label // width + v * height
                    x = label % width + u * width
                    # An offset (top, left) repeats (y, x) this far from where it is shown.
                    top = y - reach[0, 0] + 1
                    left = x - reach[0, 1] + 1
                    at_y = y - rows[1, i]
                    at_x = x - columns[1, j]
                    mark(
                        near,
                        halvings,
                        max(top, at_y - near_y),
                        min(y, at_y + near_y),
                        max(left, at_x - near_x),
                        min(x, at_x + near_x),
                    )
                    mark(line, halvings, max(top, at_y - line_y), min(y, at_y + line_y), left, x)
                    mark(line, halvings, top, y, max(left, at_x - line_x), min(x, at_x + line_x))


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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def weigh_pixel(
    pixel: cython.p_const_int,
    weights: cython.const[cython.int][:, ::1],
    near: cython.const[cython.int][::1],
    copy: cython.const[cython.int][::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    missing: cython.bint,
    sums: cython.p_longlong,
) -> cython.longlong:
    """Add a pixel at a distance that shows the same cell, see `sum_copies`; return its weight."""
    up: cython.Py_ssize_t = weights.shape[0] // 2
    left: cython.Py_ssize_t = weights.shape[1] // 2
    if pixel[3] != copy[1]:
        sums[5] += y * y + x * x <= near[1]
    sums[3] += missing and pixel[2] != copy[0] and y * y + x * x <= near[0]
    if missing and -up <= y <= up and -left <= x <= left:
        return weights[y + up, x + left]
    return 0


def sum_copies(
    cells: cython.const[cython.int][:, ::1],
    where: cython.const[cython.int][:, ::1],
    weights: cython.const[cython.int][:, ::1],
    near: cython.const[cython.int][::1],
    own: cython.const[cython.int][:, ::1],
    copy: cython.const[cython.int][::1],
    missing: cython.const[cython.uchar][:, ::1],
    places: cython.const[cython.uchar][:, ::1],
    sums: cython.longlong[:, :, ::1],
):
    """Add up, for each offset of an oriented copy, what it would repeat where pixels are missing.

    Of cell k of the sample, `cells` has the first of its rows in `where`, the pixels of the canvas
    that show it, and its salience; `where` the distance from the pixel in cells, the copy that is
    shown, and whether it is mirrored. `own` are the cells of the copy, whose number and mirroring
    are in `copy`. `near`: squared distances within which another copy is beside one, and a mirrored
    copy close to one; -1 where none is mirrored. The middle of `missing` is the pixel.
    The sums: salience times weight, salience, pixels, cells beside another copy, cells, and cells
    close to a mirrored copy, these whether missing or not, as a cut may run there.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, new=cython.bint, cell=cython.int)
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, total=cython.p_longlong)
    cython.declare(weight=cython.longlong, k=cython.int, pixel=cython.p_const_int)
    up: cython.Py_ssize_t = missing.shape[0] // 2
    left: cython.Py_ssize_t = missing.shape[1] // 2
    for y in range(places.shape[0]):
        for x in range(places.shape[1]):
            if not places[y, x]:
                continue
            total = cython.address(sums[y, x, 0])
            for i in range(max(0, y - up), min(own.shape[0], y - up + missing.shape[0])):
                for j in range(max(0, x - left), min(own.shape[1], x - left + missing.shape[1])):
                    new = missing[i - y + up, j - x + left]
                    if not new and near[1] < 0:
                        continue
                    cell = own[i, j]
                    weight = 0
                    for k in range(cells[0, cell], cells[0, cell + 1]):
                        pixel = cython.address(where[k, 0])
                        weight += weigh_pixel(
                            pixel, weights, near, copy, pixel[0] - i + y, pixel[1] - j + x,
                            new, total,
                        )  # fmt: skip
                    if new:
                        total[0] += weight * cells[2, cell]
                        total[1] += cells[2, cell]
                        total[2] += cells[1, cell]
                        total[4] += 1
