# mypy: ignore-errors
"""Kernels of graph-cut textures: runs of pixels of one old patch; compiled by Cython, see setup.py.

See `seam_kernels.Picture`.
"""

import cython
from cython.cimports.weftex.methods.graphcut.graph_kernels import Patch
from cython.cimports.weftex.methods.graphcut.seam_kernels import (
    Picture,
    Sample,
    beside,
    continued,
)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def may_change(picture: Picture, p: cython.int) -> cython.bint:
    return picture.done[p] and not picture.known[p]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def is_joined(
    picture: Picture, sample: Sample, p: cython.int, d: cython.int, last: cython.bint
) -> cython.bint:
    """Whether the neighbor in direction d is of the same patch and may change too, or is none.

    `last`: it is around the border, or beyond it.
    """
    q: cython.int = p + (picture.width if d else 1)
    if last:
        q = beside(picture, p, d, 1 - d)
        if q < 0:
            return True
    return may_change(picture, q) and continued(sample, picture.source[p], d) == picture.source[q]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def follow_row(
    picture: Picture,
    sample: Sample,
    y: cython.int,
    first: cython.int,
    last: cython.int,
) -> cython.void:
    """Bring `runs` of a row up to date where something changed from column `first` to `last`."""
    cython.declare(x=cython.int, p=cython.int, run=cython.int, after=cython.int)
    lowest: cython.bint = y + 1 == picture.height
    after = 0
    if last + 1 < picture.width:
        after = picture.runs[y * picture.width + last + 1]
    for x in range(last, -1, -1):
        p = y * picture.width + x
        if x >= first:
            run = 0
            if not picture.done[p]:
                run = -1
            elif may_change(picture, p):
                run = is_joined(picture, sample, p, 0, x + 1 == picture.width) and is_joined(
                    picture, sample, p, 1, lowest
                )
        else:
            run = (picture.runs[p] > 0) - (picture.runs[p] < 0)
        if run > 0 and after > 0:
            run = min(after + 1, 127)
        elif run < 0 and after < 0:
            run = max(after - 1, -127)
        if x < first and run == picture.runs[p]:
            break
        picture.runs[p] = cython.cast(cython.schar, run)
        after = run


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def follow_part(
    picture: Picture,
    sample: Sample,
    patch: Patch,
    i: cython.Py_ssize_t,
    first: cython.int,
    last: cython.int,
) -> cython.void:
    """Bring `runs` of a row of a box up to date where a patch changed it or what is around it.

    From column `first` of the box to `last`, -1 for what is to its left; row -1 is above it.
    """
    y: cython.int = patch.rows[i] if i >= 0 else patch.rows[0] - 1
    left: cython.int = patch.columns[0]
    if y < 0:
        if not picture.wrap_y:
            return
        y = picture.height - 1
    if patch.columns[patch.columns.shape[0] - 1] - left != patch.columns.shape[0] - 1:
        first = 0  # it goes around
        last = picture.width - 1
    elif left + first < 0:
        first = 0
        last = picture.width - 1 if picture.wrap_x else left + last
    else:
        first += left
        last += left
    follow_row(picture, sample, y, first, last)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def follow(picture: Picture, sample: Sample, patch: Patch, ends: cython.int[:, ::1]) -> cython.void:
    """Bring `runs` up to date after a patch in this box; see `seam_kernels.Picture`.

    `ends` has the first column of the box that changed in each row, and the last one; one before
    where none did.
    """
    cython.declare(i=cython.Py_ssize_t, first=cython.int, last=cython.int)
    rows: cython.Py_ssize_t = patch.rows.shape[0]
    for i in range(-1, rows):
        first = cython.cast(cython.int, patch.columns.shape[0])
        last = -1
        if i >= 0 and ends[0, i] <= ends[1, i]:
            first = ends[0, i] - 1  # its neighbor to the right changed
            last = ends[1, i]
        if i + 1 < rows and ends[0, i + 1] <= ends[1, i + 1]:
            first = min(first, ends[0, i + 1])
            last = max(last, ends[1, i + 1])
        if first <= last:
            follow_part(picture, sample, patch, i, first, last)


def follow_all(picture: Picture, sample: Sample):
    """Fill in `runs`."""
    cython.declare(y=cython.int)
    for y in range(picture.height):
        follow_row(picture, sample, y, 0, picture.width - 1)
