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
                    picture, sample, p, 1, y + 1 == picture.height
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
def follow(picture: Picture, sample: Sample, patch: Patch) -> cython.void:
    """Bring `runs` up to date after a patch in this box; see `seam_kernels.Picture`."""
    cython.declare(i=cython.Py_ssize_t, y=cython.int, first=cython.int, last=cython.int)
    count: cython.Py_ssize_t = patch.columns.shape[0]
    last = patch.columns[count - 1]
    first = patch.columns[0] - 1  # its neighbor to the right may have changed
    if first < 0 or last - first != count:
        first = 0
        last = picture.width - 1
    for i in range(-1, patch.rows.shape[0]):
        y = patch.rows[i] if i >= 0 else beside(picture, patch.rows[0] * picture.width, -1, 0)
        if i < 0:
            if y < 0:
                continue
            y //= picture.width
        follow_row(picture, sample, y, first, last)


def follow_all(picture: Picture, sample: Sample):
    """Fill in `runs`."""
    cython.declare(y=cython.int)
    for y in range(picture.height):
        follow_row(picture, sample, y, 0, picture.width - 1)
