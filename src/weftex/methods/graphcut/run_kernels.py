# mypy: ignore-errors
"""Kernels of graph-cut textures: runs of pixels of one patch in the rows of the canvas.

`Labeling.runs` is, for each pixel, the number of pixels from it on along its row, at most 127, that
may be replaced and have no seam to the right or below; or, negative, the number that are missing.
Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    Labeling,
    SeamCost,
    beside,
    continued,
)


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
    labeling: Labeling, sample: SeamCost, p: cython.int, d: cython.int, last: cython.bint
) -> cython.bint:
    """Whether the neighbor in direction d continues the patch and may change, or does not exist.

    `last`: the pixel is in the last row or column of the canvas.
    """
    q: cython.int = p + (labeling.width if d else 1)
    if last:
        q = beside(labeling, p, d, 1 - d)
        if q < 0:
            return True
    same: cython.bint = continued(sample, labeling.source[p], d) == labeling.source[q]
    return same and may_change(labeling, q)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def update_row(
    labeling: Labeling, sample: SeamCost, y: cython.int, first: cython.int, last: cython.int
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
                run = is_joined(labeling, sample, p, 0, x + 1 == labeling.width) and is_joined(
                    labeling, sample, p, 1, lowest
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
def update_part(
    labeling: Labeling,
    sample: SeamCost,
    columns: cython.const[cython.int][::1],
    y: cython.int,
    first: cython.int,
    last: cython.int,
) -> cython.void:
    """Update `runs` of a row where a patch changed it from column `first` of its box to `last`.

    -1 is the column left of the box.
    """
    left: cython.int = columns[0]
    if columns[columns.shape[0] - 1] - left != columns.shape[0] - 1:  # it wraps around
        first = 0
        last = labeling.width - 1
    elif left + first < 0:
        first = 0
        last = labeling.width - 1 if labeling.wrap_x else left + last
    else:
        first += left
        last += left
    update_row(labeling, sample, y, first, last)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def update_runs(
    labeling: Labeling,
    sample: SeamCost,
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
    ends: cython.const[cython.int][:, ::1],
) -> cython.void:
    """Update `runs` after a patch was pasted into a box of the canvas.

    `ends` has the first and the last column of the box that changed in each row; the last is less
    than the first where none did.
    """
    cython.declare(i=cython.Py_ssize_t, first=cython.int, last=cython.int, y=cython.int)
    for i in range(-1, rows.shape[0]):
        first = cython.cast(cython.int, columns.shape[0])
        last = -1
        if i >= 0 and ends[0, i] <= ends[1, i]:
            first = ends[0, i] - 1  # its neighbor to the right changed
            last = ends[1, i]
        if i + 1 < rows.shape[0] and ends[0, i + 1] <= ends[1, i + 1]:
            first = min(first, ends[0, i + 1])
            last = max(last, ends[1, i + 1])
        y = rows[i] if i >= 0 else rows[0] - 1
        if y < 0 and labeling.wrap_y:
            y = labeling.height - 1
        if first <= last and y >= 0:
            update_part(labeling, sample, columns, y, first, last)


def find_runs(labeling: Labeling, sample: SeamCost):
    """Fill in `runs` of the whole canvas."""
    cython.declare(y=cython.int)
    for y in range(labeling.height):
        update_row(labeling, sample, y, 0, labeling.width - 1)
