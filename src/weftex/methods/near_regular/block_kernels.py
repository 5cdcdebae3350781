# mypy: ignore-errors
"""Kernels of near-regular synthesis: which blocks are drawn; compiled, see setup.py.

Places are flat indices into the padded sample of a window's upper left corner. A block's window
reaches `margin` pixels beyond the block on every side.
"""

import cython

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than blocks can show again
UNIT = cython.declare(cython.longlong, 1 << 16)  # positions are in 1/65536 pixel
TRIES = cython.declare(cython.Py_ssize_t, 256)  # sources that a block tries for one of its own


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def settled(
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    y: cython.longlong,
    x: cython.longlong,
) -> cython.int:
    """The place at (y, x), which goes around where the sample tiles; -1 if no window lies there."""
    if period[2]:
        y = y % period[2]
        x = x % period[3]
        y = y + period[2] if y < 0 else y
        x = x + period[3] if x < 0 else x
    if y < 0 or x < 0 or y >= usable.shape[0] or x >= usable.shape[1] or not usable[y, x]:
        return -1
    return cython.cast(cython.int, y * usable.shape[1] + x)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def similar(
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    steps: cython.const[cython.longlong][:, ::1],
    y: cython.longlong,
    x: cython.longlong,
    k: cython.Py_ssize_t,
) -> cython.int:
    """The k-th place that a multiple of the vectors leads to from (y, x) (Fig. 4.7b), or -1."""
    return settled(
        usable, period, (y + steps[k, 0] + (UNIT >> 1)) >> 16, (x + steps[k, 1] + (UNIT >> 1)) >> 16
    )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def around(
    i: cython.Py_ssize_t, step: cython.Py_ssize_t, count: cython.Py_ssize_t, wraps: cython.bint
) -> cython.Py_ssize_t:
    """The row or column of blocks that lies `step` on; -1 outside."""
    i += step
    if wraps:
        return ((i % count) + count) % count
    return i if 0 <= i < count else -1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def shown_again(
    place: cython.int,
    other: cython.int,
    width: cython.Py_ssize_t,
    dy: cython.longlong,
    dx: cython.longlong,
    height: cython.longlong,
    breadth: cython.longlong,
) -> cython.longlong:
    """How many pixels of the sample two blocks both show, `dy` and `dx` apart.

    One that goes on where the other ends in the sample shows nothing twice. -1 shows nothing.
    """
    if other < 0:
        return 0
    y: cython.longlong = place // width - other // width
    x: cython.longlong = place % width - other % width
    if y == dy and x == dx:
        return 0
    y = y if y >= 0 else -y
    x = x if x >= 0 else -x
    if y >= height or x >= breadth:
        return 0
    return (height - y) * (breadth - x)


def draw_blocks(
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    steps: cython.const[cython.longlong][:, ::1],
    centres: cython.const[cython.int][::1],
    cells: cython.const[cython.int][:, ::1],
    phase: cython.const[cython.longlong][:, :, ::1],
    bits: cython.const[cython.ulonglong][:, ::1],
    rows: cython.const[cython.longlong][::1],
    columns: cython.const[cython.longlong][::1],
    wrap: cython.const[cython.int][::1],
    place: cython.int[:, ::1],
):
    """Draw a source for each of `cells` among its similar places (section 4.2.1).

    Of the places, in the order that the block's random bits give, the first that shows little of
    what the blocks drawn before show nearby; else the one that shows least. Without `steps` any of
    `centres` will do. `wrap` is (period of rows, of columns), 0 where an axis does not go around.
    """
    c: cython.Py_ssize_t
    t: cython.Py_ssize_t
    k: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    di: cython.Py_ssize_t
    dj: cython.Py_ssize_t
    tried: cython.Py_ssize_t
    here: cython.int
    best: cython.int
    dy: cython.longlong
    dx: cython.longlong
    height: cython.longlong
    breadth: cython.longlong
    repeated: cython.longlong
    least: cython.longlong
    free: cython.bint = steps.shape[0] == 0
    count: cython.Py_ssize_t = centres.shape[0] if free else steps.shape[0]
    width: cython.Py_ssize_t = usable.shape[1]
    with cython.nogil:
        for c in range(cells.shape[0]):
            i = cells[c, 0]
            j = cells[c, 1]
            height = rows[i + 1] - rows[i]
            breadth = columns[j + 1] - columns[j]
            k = cython.cast(cython.Py_ssize_t, bits[i, j] % cython.cast(cython.ulonglong, count))
            best = -1
            least = NEVER
            tried = 0
            for t in range(count):
                if free:
                    here = centres[k]
                    k = (k + 40503) % count
                else:
                    here = similar(usable, period, steps, phase[i, j, 0], phase[i, j, 1], k)
                    k = k + 1 if k + 1 < count else 0
                if here < 0:
                    continue
                repeated = 0
                for di in range(-2, 3):
                    for dj in range(-2, 3):
                        # Diagonal ones, and the next in the same row or column.
                        if (di + dj) % 2 or (di == 0 and dj == 0) or (di * dj) % 2 == 0 and di * dj:
                            continue
                        p = around(i, di, place.shape[0], wrap[0] != 0)
                        q = around(j, dj, place.shape[1], wrap[1] != 0)
                        if p < 0 or q < 0 or place[p, q] < 0 or (p == i and q == j):
                            continue
                        dy = rows[i] - rows[p]
                        dx = columns[j] - columns[q]
                        if p != i + di:
                            dy += wrap[0] if di < 0 else -wrap[0]
                        if q != j + dj:
                            dx += wrap[1] if dj < 0 else -wrap[1]
                        repeated += shown_again(here, place[p, q], width, dy, dx, height, breadth)
                if repeated < least:
                    least = repeated
                    best = here
                tried += 1
                if 8 * least <= height * breadth or tried >= TRIES:
                    break
            k = cython.cast(
                cython.Py_ssize_t, bits[i, j] % cython.cast(cython.ulonglong, centres.shape[0])
            )
            # No window lies where a multiple leads to: any other one.
            place[i, j] = best if best >= 0 else centres[k]
