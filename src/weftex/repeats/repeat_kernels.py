# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of repetition penalties; compiled by Cython, see setup.py and the .pxd.

The sample is looked at in cells, whichever oriented copy is shown; of the canvas, some places are.
"""

import cython
from cython.cimports.libc.string import memset


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


def weigh_places(places, rows, columns, v, u, weights, sizes):
    """What places weigh, seen from a pixel of a patch; half as much within the patch."""
    cython.declare(total=cython.longlong, down=cython.int, along=cython.int, inside=cython.bint)
    total = 0
    for k in range(places.shape[0]):
        down, along = places[k, 0] - rows[0], places[k, 1] - columns[0]
        down += sizes[0] if down < 0 else 0
        along += sizes[1] if along < 0 else 0
        inside = down < rows.shape[0] and along < columns.shape[0]
        down, along = abs(places[k, 0] - rows[v]), abs(places[k, 1] - columns[u])
        down = min(down, sizes[0] - down) >> sizes[3]
        along = min(along, sizes[1] - along) >> sizes[3]
        if down < weights.shape[0] and along < weights.shape[1]:
            total += weights[down, along] << (not inside)
    return total


def sum_changes(
    source: cython.const[cython.int][:, ::1],
    cell_of: cython.const[cython.int][::1],
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
    from_rows: cython.const[cython.int][::1],
    from_columns: cython.const[cython.int][::1],
    shown: cython.const[cython.int][:, ::1],
    where: cython.const[cython.int][:, ::1],
    weights: cython.const[cython.int][:, ::1],
    sizes: cython.const[cython.int][::1],
    sums: cython.longlong[:, :, ::1],
):
    """Add up by how much more each cell of a patch would repeat than the pixels it covers.

    The patch lies in `rows` and `columns`, and is from those of the sample. Of each cell of the
    sample `shown` has the first of its rows in `where`, which are places of the canvas, how many
    there are, and its salience; `cell_of` has the cell of each pixel. `sizes`: height and width of
    the canvas, far larger where it does not wrap, width of the sample, and the exponent of cells.
    The sums: salience times weight, twice, and places.
    """
    cython.declare(label=cython.int, cell=cython.int, sign=cython.int, exponent=cython.int)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, weight=cython.longlong)
    exponent = sizes[3]
    with cython.nogil:  # beside other threads
        for i in range(sums.shape[1]):
            v = min((i << exponent) + (1 << exponent) // 2, rows.shape[0] - 1)
            for j in range(sums.shape[2]):
                u = min((j << exponent) + (1 << exponent) // 2, columns.shape[0] - 1)
                for k in range(2):
                    sign = 1 if k else -1
                    label = from_rows[v] * sizes[2] + from_columns[u]
                    label = label if k else source[rows[v], columns[u]]
                    if label < 0 or cell_of[label] < 0:
                        continue
                    cell = cell_of[label]
                    weight = weigh_places(
                        where[shown[0, cell] : shown[0, cell] + shown[1, cell]],
                        rows, columns, v, u, weights, sizes,
                    )  # fmt: skip
                    sums[0, i, j] += sign * shown[2, cell] * weight
                    sums[1, i, j] += sign * shown[1, cell]
