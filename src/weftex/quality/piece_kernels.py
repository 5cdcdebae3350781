# mypy: ignore-errors
"""Kernel that finds connected pieces; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def root(parents: cython.p_int, i: cython.int) -> cython.int:
    """Return the first pixel that a pixel is known to be connected with."""
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def join(parents: cython.p_int, i: cython.int, j: cython.int) -> cython.void:
    i = root(parents, i)
    j = root(parents, j)
    if i < j:
        parents[j] = i
    else:
        parents[i] = j


def number_pieces(
    shift: cython.const[cython.int][:, :, ::1],
    known: cython.const[cython.uchar][:, ::1],
    names: cython.int[:, ::1],
) -> cython.Py_ssize_t:
    """Number the connected areas of one shift in the order of their first pixels.

    A pixel that is not known is an area of its own. Returns how many areas there are.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.int, count=cython.int)
    width: cython.int = cython.cast(cython.int, shift.shape[1])
    size: cython.int = cython.cast(cython.int, shift.shape[0] * shift.shape[1])
    parents: cython.p_int = cython.address(names[0, 0])
    count = 0
    with cython.nogil:
        for i in range(size):
            parents[i] = i
        for y in range(shift.shape[0]):
            for x in range(shift.shape[1]):
                if not known[y, x]:
                    continue
                i = cython.cast(cython.int, y * width + x)
                if (
                    x > 0
                    and known[y, x - 1]
                    and shift[y, x, 0] == shift[y, x - 1, 0]
                    and shift[y, x, 1] == shift[y, x - 1, 1]
                ):
                    join(parents, i - 1, i)
                if (
                    y > 0
                    and known[y - 1, x]
                    and shift[y, x, 0] == shift[y - 1, x, 0]
                    and shift[y, x, 1] == shift[y - 1, x, 1]
                ):
                    join(parents, i - width, i)
        # A pixel's parent is never after it, so it has its number already.
        for i in range(size):
            if parents[i] == i:
                parents[i] = count
                count += 1
            else:
                parents[i] = parents[parents[i]]
    return count
