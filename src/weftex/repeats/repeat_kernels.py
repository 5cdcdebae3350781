# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of repetition penalties; compiled by Cython, see setup.py and the .pxd.

A patch whose corner has the offset (top, left) in the sample repeats what the canvas shows at some
distance for a box of offsets, for each pixel of the canvas. Boxes are summed up as differences at
their corners. `rows` and `columns` are those looked at: their numbers in `source`, and their
distances from the patch.
"""

import cython
from cython.cimports.libc.string import memset


def mark(marks, level, top, bottom, left, right):
    """Add 1 to the offsets of a box, bottom and right included; `marks` has a line more of both."""
    if bottom < 0 or right < 0 or top > bottom or left > right:
        return
    top = ((max(top, 0) - 1) >> level) + 1
    left = ((max(left, 0) - 1) >> level) + 1
    bottom = min((bottom >> level) + 1, marks.shape[0] - 1)
    right = min((right >> level) + 1, marks.shape[1] - 1)
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
    level: cython.int,
    marks: cython.int[:, :, ::1],
):
    """Count, for each offset of a patch, the pixels that it would repeat, as differences.

    `sample`: its height and width, and whether it is tileable. `reach`: height and width of the
    patch, distances that count as nearby, and distances that count as in line. `marks` gets what is
    nearby (both distances are) and what is in line (each distance that is).
    """
    near, line = marks[0], marks[1]
    height, width, around = sample[0], sample[1], 1 if sample[2] else 0
    near_y, near_x = reach[1, 0], reach[1, 1]
    line_y, line_x = reach[2, 0], reach[2, 1]
    for i in range(rows.shape[1]):
        for j in range(columns.shape[1]):
            label = source[rows[0, i], columns[0, j]]
            if label < 0:
                continue
            for v in range(-around, around + 1):
                for u in range(-around, around + 1):
                    y, x = label // width + v * height, label % width + u * width
                    # An offset (top, left) repeats (y, x) this far from where it is shown.
                    top = y - reach[0, 0] + 1
                    left = x - reach[0, 1] + 1
                    at_y, at_x = y - rows[1, i], x - columns[1, j]
                    mark(
                        near, level, max(top, at_y - near_y), min(y, at_y + near_y),
                        max(left, at_x - near_x), min(x, at_x + near_x),
                    )  # fmt: skip
                    mark(line, level, max(top, at_y - line_y), min(y, at_y + line_y), left, x)
                    mark(line, level, top, y, max(left, at_x - line_x), min(x, at_x + line_x))


def count_squares(
    source: cython.const[cython.int][:, ::1],
    width: cython.int,
    level: cython.int,
    counts: cython.longlong[:, ::1],
):
    """Count the pixels by the square of 2**level a side of the sample that they come from."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            label = source[i, j]
            if label >= 0:
                counts[label // width >> level, label % width >> level] += 1


def weigh_cell(pixels, weights, spans, missing, holes, plane):
    """Fill in what the pixels that show a cell weigh, seen from each missing pixel."""
    down, along = weights.shape[0] // 2, weights.shape[1] // 2
    for v in range(plane.shape[0]):
        to = cython.address(plane[v, 0])
        if holes[v, 0] == holes[v, 1]:
            continue
        memset(to, 0, plane.shape[1] * cython.sizeof(cython.int))
        for k in range(pixels.shape[0]):
            row = down + v + pixels[k, 0]
            if row < 0 or row >= weights.shape[0]:
                continue
            shift = along + pixels[k, 1]
            weight = cython.address(weights[row, 0]) + shift
            begin = max(holes[v, 0], spans[row, 0] - shift)
            for u in range(begin, min(holes[v, 1], spans[row, 1] - shift)):
                to[u] += weight[u]
        for u in range(holes[v, 0], holes[v, 1]):
            to[u] &= missing[v, u]


def count_beside(pixels, near, mirrored, own, missing, sums):
    """Count the offsets at which a cell of one copy lies beside pixels of other copies of it."""
    cython.declare(down=cython.Py_ssize_t, along=cython.Py_ssize_t, reach=cython.Py_ssize_t)
    reach = near[2]
    for k in range(pixels.shape[0]):
        if pixels[k, 2] == own[0]:
            continue
        down = own[1] + pixels[k, 0]
        along = own[2] + pixels[k, 1]
        for y in range(max(0, -reach - down), min(sums.shape[1], reach - down + 1)):
            for x in range(max(0, -reach - along), min(sums.shape[2], reach - along + 1)):
                away = (down + y) * (down + y) + (along + x) * (along + x)
                if away <= near[0]:
                    sums[3, y, x] -= missing[own[1] + y, own[2] + x]
                if away <= near[1]:
                    sums[5, y, x] += mirrored[pixels[k, 2]] != mirrored[own[0]]


def sum_copies(
    cells: cython.const[cython.int][:, ::1],
    where: cython.const[cython.int][:, ::1],
    own: cython.const[cython.int][:, ::1],
    weights: cython.const[cython.int][:, ::1],
    spans: cython.const[cython.int][:, ::1],
    near: cython.const[cython.int][::1],
    mirrored: cython.const[cython.int][::1],
    missing: cython.const[cython.longlong][:, ::1],
    holes: cython.const[cython.int][:, ::1],
    plane: cython.int[:, ::1],
    sums: cython.longlong[:, :, :, ::1],
):
    """Add up what the offsets of each oriented copy would repeat where pixels are missing.

    Of cell k of the sample, `cells` has the first of its rows in `where`, the pixels of the canvas
    that show it, the first of its rows in `own`, how often it is shown, and its salience. `own`: a
    copy, and where it has the cell, from its last row and column on, so that an offset and this
    place add up to a row and a column of `missing`, which is -1 or 0. `where`: distances in cells
    from the first pixel of `missing`, and the copy that is shown. `spans` and `holes` are where
    rows of `weights` and of `missing` begin and end. `near`: squared distances within which another
    copy is beside one, and a mirrored copy close to one; and the root of the first.
    The sums: salience times weight, salience, pixels, cells beside another copy, cells, and cells
    close to a mirrored copy, these whether missing or not, as a cut may run there.
    """
    cython.declare(used=cython.longlong, pixels=cython.const[cython.int][:, ::1])
    area = sums.shape[2] * sums.shape[3]
    with cython.nogil:  # beside other threads
        for cell in range(cells.shape[1] - 1):
            pixels = where[cells[0, cell] : cells[0, cell + 1]]
            used, salience = cells[2, cell], cells[3, cell]
            weigh_cell(pixels, weights, spans, missing, holes, plane)
            for k in range(cells[1, cell], cells[1, cell + 1]):
                count_beside(pixels, near, mirrored, own[k], missing, sums[own[k, 0]])
                for y in range(sums.shape[2]):
                    if holes[own[k, 1] + y, 0] == holes[own[k, 1] + y, 1]:
                        continue
                    weight = cython.address(plane[own[k, 1] + y, own[k, 2]])
                    new = cython.address(missing[own[k, 1] + y, own[k, 2]])
                    total = cython.address(sums[own[k, 0], 0, y, 0])
                    for x in range(sums.shape[3]):
                        total[x] += cython.cast(cython.longlong, weight[x]) * salience
                    for x in range(sums.shape[3]):
                        total[area + x] += new[x] & salience
                        total[2 * area + x] += new[x] & used
                        total[4 * area + x] -= new[x]
