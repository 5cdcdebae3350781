# mypy: ignore-errors
"""Kernels of near-regular synthesis: which piece a drawn block shows; compiled, see setup.py.

Places are flat indices into the padded sample of a window's upper left corner. A block's window
reaches a margin beyond the block on every side.
"""

import cython

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than blocks can show again
UNIT = cython.declare(cython.longlong, 1 << 16)  # positions are in 1/65536 pixel
MOST_DRAWN = cython.declare(cython.Py_ssize_t, 256)  # similar places that a drawn block looks at


class Sample:
    """The sample as it is matched; `turned` has its axes exchanged. See `search.windows`."""

    def __init__(self, pixels, turned, usable, period, centers):
        self.pixels, self.turned, self.usable, self.period = pixels, turned, usable, period
        self.centers = centers


class Grid:
    """Blocks of a canvas: edges, the canvas's periods, phases, random bits and places.

    A period is 0 where an axis does not go around. `phase` is eq. (3.29) of a window's corner, in
    1/65536 pixel. A place is -1 where there is none yet.
    """

    def __init__(self, rows, columns, wrap, phase, bits, place):
        self.rows, self.columns, self.wrap, self.phase = rows, columns, wrap, phase
        self.bits, self.place = bits, place


def place_at(sample, y, x):
    """The place at (y, x), which goes around where the sample tiles; -1 if no window lies there."""
    if sample.period[2]:
        y = y % sample.period[2]
        x = x % sample.period[3]
        y = y + sample.period[2] if y < 0 else y
        x = x + sample.period[3] if x < 0 else x
    if y < 0 or x < 0 or y >= sample.usable.shape[0] or x >= sample.usable.shape[1]:
        return -1
    if not sample.usable[y, x]:
        return -1
    return cython.cast(cython.int, y * sample.usable.shape[1] + x)


def similar(sample, grid, steps, i, j, k):
    """The k-th place that is similar to block (i, j) (eq. 4.3, Fig. 4.7b), or -1."""
    return place_at(
        sample,
        (grid.phase[i, j, 0] + steps[k, 0] + (UNIT >> 1)) >> 16,
        (grid.phase[i, j, 1] + steps[k, 1] + (UNIT >> 1)) >> 16,
    )


def around(grid, axis, at, step):
    """The row (`axis` 0) or column of blocks that lies `step` on; -1 outside."""
    count: cython.Py_ssize_t = grid.bits.shape[axis]
    at += step
    if grid.wrap[axis]:
        return ((at % count) + count) % count
    return at if 0 <= at < count else -1


def shown_again(sample, place, other, dy, dx, height, width):
    """How many pixels of the sample two blocks both show, `dy` and `dx` apart.

    One that goes on where the other ends in the sample shows nothing twice. -1 shows nothing.
    """
    if other < 0:
        return 0
    across: cython.Py_ssize_t = sample.usable.shape[1]
    y: cython.longlong = place // across - other // across
    x: cython.longlong = place % across - other % across
    if y == dy and x == dx:
        return 0
    y = y if y >= 0 else -y
    x = x if x >= 0 else -x
    if y >= height or x >= width:
        return 0
    return (height - y) * (width - x)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def shown_near(
    sample: Sample, grid: Grid, i: cython.Py_ssize_t, j: cython.Py_ssize_t, here: cython.int
) -> cython.longlong:
    """How many pixels block (i, j) would show of those that drawn blocks near it show."""
    cython.declare(p=cython.Py_ssize_t, q=cython.Py_ssize_t, di=cython.Py_ssize_t)
    cython.declare(dj=cython.Py_ssize_t, dy=cython.longlong, dx=cython.longlong)
    height: cython.longlong = grid.rows[i + 1] - grid.rows[i]
    width: cython.longlong = grid.columns[j + 1] - grid.columns[j]
    total: cython.longlong = 0
    for di in range(-2, 3):
        for dj in range(-2, 3):
            # Diagonal ones, and the next in the same row or column.
            if (di + dj) % 2 or (di == 0 and dj == 0) or (di * dj) % 2 == 0 and di * dj:
                continue
            p = around(grid, 0, i, di)
            q = around(grid, 1, j, dj)
            if p < 0 or q < 0 or grid.place[p, q] < 0 or (p == i and q == j):
                continue
            dy = grid.rows[i] - grid.rows[p]
            dx = grid.columns[j] - grid.columns[q]
            if p != i + di:
                dy += grid.wrap[0] if di < 0 else -grid.wrap[0]
            if q != j + dj:
                dx += grid.wrap[1] if dj < 0 else -grid.wrap[1]
            total += shown_again(sample, here, grid.place[p, q], dy, dx, height, width)
    return total


def any_place(sample, grid, i, j):
    """A place for a block to which no whole window is similar: any one."""
    count: cython.ulonglong = sample.centers.shape[0]
    return sample.centers[cython.cast(cython.Py_ssize_t, grid.bits[i, j] % count)]


def draw_blocks(
    sample: Sample,
    grid: Grid,
    steps: cython.const[cython.longlong][:, ::1],
    cells: cython.const[cython.int][:, ::1],
):
    """Draw a place for each of `cells` among those similar to it (section 4.2.1).

    Of these, in the order that the block's random bits give, the first that shows little of what
    the blocks drawn before show nearby; else the one that shows least. Without `steps` any place
    is similar.
    """
    cython.declare(c=cython.Py_ssize_t, t=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, tried=cython.Py_ssize_t)
    cython.declare(here=cython.int, best=cython.int)
    cython.declare(area=cython.longlong, repeated=cython.longlong, least=cython.longlong)
    free: cython.bint = steps.shape[0] == 0
    count: cython.Py_ssize_t = sample.centers.shape[0] if free else steps.shape[0]
    with cython.nogil:
        for c in range(cells.shape[0]):
            i = cells[c, 0]
            j = cells[c, 1]
            area = (grid.rows[i + 1] - grid.rows[i]) * (grid.columns[j + 1] - grid.columns[j])
            k = cython.cast(
                cython.Py_ssize_t, grid.bits[i, j] % cython.cast(cython.ulonglong, count)
            )
            best = -1
            least = NEVER
            tried = 0
            for t in range(count):
                if free:
                    here = sample.centers[k]
                    k = (k + 40503) % count
                else:
                    here = similar(sample, grid, steps, i, j, k)
                    k = k + 1 if k + 1 < count else 0
                if here < 0:
                    continue
                repeated = shown_near(sample, grid, i, j, here)
                if repeated < least:
                    least = repeated
                    best = here
                tried += 1
                if 8 * least <= area or tried >= MOST_DRAWN:
                    break
            grid.place[i, j] = best if best >= 0 else any_place(sample, grid, i, j)
