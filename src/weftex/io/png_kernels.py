# mypy: ignore-errors
"""The kernel that undoes a PNG's filters; compiled by Cython, see setup.py."""

import cython


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def nearest(left: cython.int, above: cython.int, corner: cython.int) -> cython.int:
    """Paeth's guess: that of the three which is nearest to left + above - corner."""
    to_left: cython.int = abs(above - corner)
    to_above: cython.int = abs(left - corner)
    to_corner: cython.int = abs(left + above - 2 * corner)
    if to_left <= to_above and to_left <= to_corner:
        return left
    return above if to_above <= to_corner else corner


def unfilter(lines: cython.uchar[:, ::1], step: cython.Py_ssize_t):
    """Undo the filters of all lines, in place.

    Parameters
    ----------
    lines : uint8 array (rows, 1 + bytes)
        Each after the number of its filter, 0 to 4 (PNG specification, section 9.2).
    step : int
        Bytes of a pixel.
    """
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, kind=cython.int)
    cython.declare(left=cython.int, above=cython.int, corner=cython.int, guess=cython.int)
    with cython.nogil:
        for y in range(lines.shape[0]):
            kind = lines[y, 0]
            if kind == 0:
                continue
            for x in range(1, lines.shape[1]):
                left = lines[y, x - step] if x > step else 0
                above = lines[y - 1, x] if y > 0 else 0
                corner = lines[y - 1, x - step] if x > step and y > 0 else 0
                if kind == 1:
                    guess = left
                elif kind == 2:
                    guess = above
                elif kind == 3:
                    guess = (left + above) >> 1
                else:
                    guess = nearest(left, above, corner)
                lines[y, x] = cython.cast(cython.uchar, lines[y, x] + guess)
