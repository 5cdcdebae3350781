# mypy: ignore-errors
"""Kernels of near-regular synthesis: how a gap's piece is warped; compiled, see setup.py.

Places are as in `block_kernels`, warps as in `weftex.results.warp_kernels`.
"""

import cython
from cython.cimports.weftex.methods.near_regular.block_kernels import Grid, around

UP = cython.declare(cython.longlong, 1 << 20)  # keeps quotients above 0


@cython.cclass
class Warps:
    """How gaps may be warped, and how they are.

    `shifts` has all of up to `limit` pixels along both axes, the shortest first; what is within
    `half` of a node counts. `nodes` are shifts of each block, see `weftex.results.warp_kernels`.
    """

    margin: cython.Py_ssize_t
    half: cython.Py_ssize_t
    limit: cython.longlong
    shifts: cython.const[cython.int][:, ::1]
    nodes: cython.short[:, :, :, :, ::1]

    def __init__(self, margin, half, limit, shifts, nodes):
        self.margin, self.half, self.limit, self.shifts = margin, half, limit, shifts
        self.nodes = nodes


@cython.cclass
class Scratch:
    """What a thread works on: differences on each line, costs by node and shift, found shifts."""

    lines: cython.longlong[::1]
    costs: cython.longlong[:, :, ::1]
    found: cython.longlong[:, :, ::1]
    sides: cython.longlong[:, :, ::1]
    # One side of a gap: the places of its window and of the neighbor's pixel at that window's
    # corner, which may lie outside of the sample; which line of the window the side is; the
    # window's height and width; and how long the side is.
    own: cython.Py_ssize_t
    other: cython.Py_ssize_t
    upright: cython.bint
    edge: cython.Py_ssize_t
    height: cython.Py_ssize_t
    width: cython.Py_ssize_t
    length: cython.Py_ssize_t

    def __init__(self, lines, costs, found, sides):
        self.lines, self.costs, self.found, self.sides = lines, costs, found, sides


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def side_costs(
    pixels: cython.const[cython.uchar][:, :, ::1],
    half: cython.Py_ssize_t,
    shift_y: cython.Py_ssize_t,
    shift_x: cython.Py_ssize_t,
    scratch: Scratch,
) -> cython.void:
    """Squared differences across one side of a window and its neighbor, line by line."""
    cython.declare(n=cython.Py_ssize_t, t=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, c=cython.Py_ssize_t, y=cython.Py_ssize_t)
    cython.declare(x=cython.Py_ssize_t, at=cython.Py_ssize_t, d=cython.int, total=cython.longlong)
    across: cython.Py_ssize_t = pixels.shape[1]
    flat: cython.p_const_uchar = cython.address(pixels[0, 0, 0])
    channels: cython.Py_ssize_t = pixels.shape[2]
    upright: cython.bint = scratch.upright
    edge: cython.Py_ssize_t = scratch.edge
    height: cython.Py_ssize_t = scratch.height
    width: cython.Py_ssize_t = scratch.width
    for n in range(height if upright else width):
        total = 0
        for t in range(edge - half, edge + half):
            v = n if upright else t
            u = t if upright else n
            y = min(max(v + shift_y, 0), height - 1)
            x = min(max(u + shift_x, 0), width - 1)
            at = scratch.own + y * across + x
            for c in range(channels):
                d = cython.cast(cython.int, flat[at * channels + c])
                d -= flat[(scratch.other + v * across + u) * channels + c]
                total += d * d
        scratch.lines[n] = total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def find_side(
    pixels: cython.const[cython.uchar][:, :, ::1],
    grid: Grid,
    warps: Warps,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    scratch: Scratch,
) -> cython.bint:
    """Find side n (above, left, below, right) of block (i, j); False if no neighbor is there."""
    across: cython.Py_ssize_t = pixels.shape[1]
    tall: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, grid.rows[i + 1] - grid.rows[i])
    wide: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, grid.columns[j + 1] - grid.columns[j])
    upright: cython.bint = n % 2 == 1
    p: cython.Py_ssize_t = i if upright else around(grid, 0, i, n - 1)
    q: cython.Py_ssize_t = around(grid, 1, j, n - 2) if upright else j
    if p < 0 or q < 0 or grid.place[p, q] < 0:
        return False
    scratch.own = grid.place[i, j]
    scratch.other = grid.place[p, q]
    if n == 0:
        scratch.other += cython.cast(cython.Py_ssize_t, grid.rows[p + 1] - grid.rows[p]) * across
    elif n == 1:
        scratch.other += cython.cast(cython.Py_ssize_t, grid.columns[q + 1] - grid.columns[q])
    elif n == 2:
        scratch.other -= tall * across
    else:
        scratch.other -= wide
    scratch.upright = upright
    scratch.edge = warps.margin + (0 if n < 2 else wide if upright else tall)
    scratch.height = tall + 2 * warps.margin
    scratch.width = wide + 2 * warps.margin
    scratch.length = tall if upright else wide
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compare_shifts(
    pixels: cython.const[cython.uchar][:, :, ::1],
    warps: Warps,
    last: cython.Py_ssize_t,
    scratch: Scratch,
) -> cython.void:
    """Sum the differences near every node of a side for every shift."""
    cython.declare(s=cython.Py_ssize_t, k=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(here=cython.Py_ssize_t, stop=cython.Py_ssize_t, total=cython.longlong)
    r: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, warps.limit)
    half: cython.Py_ssize_t = warps.half
    for s in range(warps.shifts.shape[0]):
        side_costs(pixels, half, warps.shifts[s, 0], warps.shifts[s, 1], scratch)
        for k in range(last + 1):
            here = warps.margin + k * scratch.length // last
            stop = min(here + half, scratch.length + 2 * warps.margin)
            total = 0
            for t in range(max(here - half, 0), stop):
                total += scratch.lines[t]
            scratch.costs[k, warps.shifts[s, 0] + r, warps.shifts[s, 1] + r] = total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def beyond_whole(
    low: cython.longlong, here: cython.longlong, high: cython.longlong, still: cython.longlong
) -> cython.longlong:
    """How far from the middle of three costs a parabola's least is, in 1/16 pixel; 0 if unsure."""
    bend: cython.longlong = low + high - 2 * here
    # Only where the parabola's least is an eighth of the difference below.
    if bend <= 0 or (low - high) * (low - high) < still * bend:
        return 0
    found: cython.longlong = (16 * (low - high) + (2 * UP + 1) * bend) // (2 * bend) - UP
    return min(max(found, -8), 8)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_shift(
    warps: Warps, n: cython.Py_ssize_t, k: cython.Py_ssize_t, scratch: Scratch
) -> cython.void:
    """Find the shift of node k of side n; a shift has to pay for its length."""
    cython.declare(s=cython.Py_ssize_t, a=cython.Py_ssize_t, b=cython.Py_ssize_t)
    cython.declare(key=cython.longlong, here=cython.longlong)
    limit: cython.longlong = warps.limit
    r: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, limit)
    still: cython.longlong = scratch.costs[k, r, r]
    least: cython.longlong = 4 * limit * limit * still
    y: cython.Py_ssize_t = 0
    x: cython.Py_ssize_t = 0
    for s in range(warps.shifts.shape[0]):
        a = warps.shifts[s, 0]
        b = warps.shifts[s, 1]
        key = 4 * limit * limit * scratch.costs[k, a + r, b + r] + still * (a * a + b * b)
        if key < least:
            least = key
            y = a
            x = b
    if 4 * scratch.costs[k, y + r, x + r] > 3 * still:
        y = 0
        x = 0
    here = scratch.costs[k, y + r, x + r]
    scratch.found[n, k, 0] = 16 * y
    scratch.found[n, k, 1] = 16 * x
    if -r < y < r:
        scratch.found[n, k, 0] += beyond_whole(
            scratch.costs[k, y - 1 + r, x + r], here, scratch.costs[k, y + 1 + r, x + r], still
        )
    if -r < x < r:
        scratch.found[n, k, 1] += beyond_whole(
            scratch.costs[k, y + r, x - 1 + r], here, scratch.costs[k, y + r, x + 1 + r], still
        )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def even_sides(last: cython.Py_ssize_t, scratch: Scratch) -> cython.void:
    """Even out the shifts along each side, in 1/128 pixel; both sides of a corner meet there."""
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(m=cython.Py_ssize_t, mean=cython.longlong)
    for t in range(2):
        for n in range(4):
            for k in range(last + 1):
                scratch.sides[n, k, t] = 2 * (
                    scratch.found[n, max(k - 1, 0), t]
                    + 2 * scratch.found[n, k, t]
                    + scratch.found[n, min(k + 1, last), t]
                )
        for k in range(4):  # give two sides one corner; both are even, so the mean is exact
            m = k // 2 * 2
            n = k % 2 * 2 + 1
            mean = (scratch.sides[m, k % 2 * last, t] + scratch.sides[n, k // 2 * last, t]) // 2
            scratch.sides[m, k % 2 * last, t] = mean
            scratch.sides[n, k // 2 * last, t] = mean


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def blend_inside(
    warps: Warps,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    scratch: Scratch,
) -> cython.void:
    """Blend the shifts inside of block (i, j) from those of its four sides (Coons)."""
    cython.declare(a=cython.Py_ssize_t, b=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(total=cython.longlong)
    limit: cython.longlong = 16 * warps.limit
    whole: cython.longlong = 8 * last * last
    for t in range(2):
        for a in range(last + 1):
            for b in range(last + 1):
                total = last * (
                    (last - a) * scratch.sides[0, b, t]
                    + a * scratch.sides[2, b, t]
                    + (last - b) * scratch.sides[1, a, t]
                    + b * scratch.sides[3, a, t]
                )
                total -= (last - a) * (
                    (last - b) * scratch.sides[0, 0, t] + b * scratch.sides[0, last, t]
                )
                total -= a * ((last - b) * scratch.sides[2, 0, t] + b * scratch.sides[2, last, t])
                total = (2 * total + (2 * UP + 1) * whole) // (2 * whole) - UP
                total = min(max(total, -limit), limit)
                warps.nodes[i, j, a, b, t] = cython.cast(cython.short, total)


def estimate(
    pixels: cython.const[cython.uchar][:, :, ::1],
    grid: Grid,
    cells: cython.const[cython.int][:, ::1],
    warps: Warps,
    scratch: Scratch,
):
    """Find how each of `cells` is to be warped so that its sides meet its neighbors'.

    At every node of a side the piece is shifted by whole pixels, and a parabola then tells where
    the least lies between pixels, if that is sure.
    """
    cython.declare(c=cython.Py_ssize_t, n=cython.Py_ssize_t, k=cython.Py_ssize_t)
    last: cython.Py_ssize_t = warps.nodes.shape[2] - 1
    with cython.nogil:
        for c in range(cells.shape[0]):
            for n in range(4):
                for k in range(last + 1):
                    scratch.found[n, k, 0] = 0
                    scratch.found[n, k, 1] = 0
                if find_side(pixels, grid, warps, cells[c, 0], cells[c, 1], n, scratch):
                    compare_shifts(pixels, warps, last, scratch)
                    for k in range(last + 1):
                        best_shift(warps, n, k, scratch)
            even_sides(last, scratch)
            blend_inside(warps, cells[c, 0], cells[c, 1], last, scratch)
