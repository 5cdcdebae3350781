# mypy: ignore-errors
"""What a patch would show again; no idea of the papers. Compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.math import sqrt

# Nothing is in sight that is so many patches away.
SIGHT = cython.declare(cython.double, 4.5)
# What comes again in line counts so much more.
IN_LINE = cython.declare(cython.double, 0.5)
# Copies are in line if they are up to this part of a patch off.
ALIGNED = cython.declare(cython.Py_ssize_t, 16)
# Patches that are shown again count as so many at most.
MOST = cython.declare(cython.double, 4.0)


class Sight:
    """What each patch of a run may see of the patches laid before.

    Parameters
    ----------
    variety : float
        By what share of its cost a patch is dearer if all of it is shown again, right beside.
    laid : int32 array (patches, 5)
        Placements of the whole output.
    seen : int32 array (n, others)
        For each patch of the run earlier ones, rows of `laid`; -1 for none.
    window : int32 array (2,)
        Height and width of patches.
    canvas, sample : int32 array (2,)
        Height and width of what goes around, 0 where it does not.
    """

    def __init__(self, variety, laid, seen, window, canvas, sample):
        self.variety = variety
        self.laid = laid
        self.seen = seen
        self.window = window
        self.canvas = canvas
        self.sample = sample


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def nearest(away: cython.Py_ssize_t, n: cython.int) -> cython.Py_ssize_t:
    """The shortest way around an axis of length n; 0 does not go around."""
    if n > 0:
        if 2 * away > n:
            return away - n
        if 2 * away < -n:
            return away + n
    return away


def shown_again(sight, p, y, x, source_y, source_x):
    """How much of a patch from (source_y, source_x), laid at (y, x), is shown already: in patches.

    The nearer, the more, and more in the same rows or columns. What it shows at the very place
    where the other does, because it goes on as in the sample, is not shown twice.
    """
    rows: cython.int = sight.window[0]
    columns: cython.int = sight.window[1]
    far: cython.double = SIGHT * max(rows, columns)
    total: cython.double = 0
    cython.declare(k=cython.Py_ssize_t, n=cython.Py_ssize_t, away=cython.double)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, weight=cython.double)
    cython.declare(down=cython.Py_ssize_t, across=cython.Py_ssize_t)
    for k in range(sight.seen.shape[1]):
        n = sight.seen[p, k]
        if n < 0:
            continue
        v = nearest(source_y - sight.laid[n, 2], sight.sample[0])
        u = nearest(source_x - sight.laid[n, 3], sight.sample[1])
        if v >= rows or -v >= rows or u >= columns or -u >= columns:
            continue  # they share no pixel
        down = nearest(y - sight.laid[n, 0] - v, sight.canvas[0])
        across = nearest(x - sight.laid[n, 1] - u, sight.canvas[1])
        if down == 0 and across == 0:
            continue
        away = sqrt(cython.cast(cython.double, down * down + across * across))
        weight = 1 - away / far if away < far else 0.0
        if -rows <= down * ALIGNED <= rows or -columns <= across * ALIGNED <= columns:
            weight += IN_LINE
        total += weight * ((rows - max(v, -v)) * (columns - max(u, -u)))
    total /= rows * columns
    return total if total < MOST else MOST
