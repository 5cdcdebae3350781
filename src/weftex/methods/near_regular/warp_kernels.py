# mypy: ignore-errors
"""Kernels of near-regular synthesis: how a gap's piece is warped; compiled, see setup.py.

Places are as in `_near_regular_kernels`, warps as in `weftex.results.warp_kernels`.
"""

import cython
from cython.cimports.weftex.methods.near_regular.block_kernels import around

UP = cython.declare(cython.longlong, 1 << 20)  # keeps quotients above 0


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def side_costs(
    pixels: cython.const[cython.uchar][:, :, ::1],
    own: cython.Py_ssize_t,
    other: cython.Py_ssize_t,
    shift_y: cython.Py_ssize_t,
    shift_x: cython.Py_ssize_t,
    upright: cython.bint,
    edge: cython.Py_ssize_t,
    half: cython.Py_ssize_t,
    height: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    lines: cython.longlong[::1],
) -> cython.void:
    """Squared differences across one side of a window and its neighbour, line by line.

    `own` is the place of the window, `other` that of the neighbour's pixel at its corner, and may
    lie outside of the sample.
    """
    n: cython.Py_ssize_t
    t: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    c: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    at: cython.Py_ssize_t
    d: cython.int
    total: cython.longlong
    across: cython.Py_ssize_t = pixels.shape[1]
    flat: cython.p_const_uchar = cython.address(pixels[0, 0, 0])
    channels: cython.Py_ssize_t = pixels.shape[2]
    for n in range(height if upright else width):
        total = 0
        for t in range(edge - half, edge + half):
            v = n if upright else t
            u = t if upright else n
            y = min(max(v + shift_y, 0), height - 1)
            x = min(max(u + shift_x, 0), width - 1)
            at = own + y * across + x
            for c in range(channels):
                d = cython.cast(cython.int, flat[at * channels + c])
                d -= flat[(other + v * across + u) * channels + c]
                total += d * d
        lines[n] = total


def estimate(
    pixels: cython.const[cython.uchar][:, :, ::1],
    cells: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.longlong][::1],
    columns: cython.const[cython.longlong][::1],
    wrap: cython.const[cython.int][::1],
    place: cython.const[cython.int][:, ::1],
    margin: cython.Py_ssize_t,
    half: cython.Py_ssize_t,
    shifts: cython.const[cython.int][:, ::1],
    limit: cython.longlong,
    lines: cython.longlong[::1],
    costs: cython.longlong[:, :, ::1],
    found: cython.longlong[:, :, ::1],
    sides: cython.longlong[:, :, ::1],
    warps: cython.short[:, :, :, :, ::1],
):
    """Find how each of `cells` is to be warped so that its sides meet its neighbours'.

    At every node of a side the piece is shifted by whole pixels, up to `limit` along both axes;
    `shifts` has all of these, the shortest first. What is within `half` of the node counts, and a
    shift has to pay for its length. A parabola then tells where the least lies between pixels, if
    that is sure. Sides are evened out, their corners are the mean of the two that meet there, and
    what is inside is blended from the four sides (Coons). `lines`, `costs`, `found` and `sides`
    are scratch.
    """
    e: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    n: cython.Py_ssize_t
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    s: cython.Py_ssize_t
    k: cython.Py_ssize_t
    a: cython.Py_ssize_t
    b: cython.Py_ssize_t
    t: cython.Py_ssize_t
    own: cython.Py_ssize_t
    other: cython.Py_ssize_t
    edge: cython.Py_ssize_t
    tall: cython.Py_ssize_t
    wide: cython.Py_ssize_t
    length: cython.Py_ssize_t
    here: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    upright: cython.bint
    total: cython.longlong
    least: cython.longlong
    still: cython.longlong
    key: cython.longlong
    low: cython.longlong
    high: cython.longlong
    bend: cython.longlong
    last: cython.Py_ssize_t = warps.shape[2] - 1
    r: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, limit)
    across: cython.Py_ssize_t = pixels.shape[1]
    with cython.nogil:
        for e in range(cells.shape[0]):
            i = cells[e, 0]
            j = cells[e, 1]
            tall = cython.cast(cython.Py_ssize_t, rows[i + 1] - rows[i])
            wide = cython.cast(cython.Py_ssize_t, columns[j + 1] - columns[j])
            own = place[i, j]
            for n in range(4):  # above, left, below, right
                for k in range(last + 1):
                    found[n, k, 0] = 0
                    found[n, k, 1] = 0
                upright = n % 2 == 1
                p = i if upright else around(i, n - 1, place.shape[0], wrap[0] != 0)
                q = around(j, n - 2, place.shape[1], wrap[1] != 0) if upright else j
                if p < 0 or q < 0 or place[p, q] < 0:
                    continue
                other = place[p, q]
                if n == 0:
                    other += cython.cast(cython.Py_ssize_t, rows[p + 1] - rows[p]) * across
                elif n == 1:
                    other += cython.cast(cython.Py_ssize_t, columns[q + 1] - columns[q])
                elif n == 2:
                    other -= tall * across
                else:
                    other -= wide
                edge = margin + (0 if n < 2 else wide if upright else tall)
                length = tall if upright else wide
                for s in range(shifts.shape[0]):
                    side_costs(
                        pixels, own, other, shifts[s, 0], shifts[s, 1], upright, edge, half,
                        tall + 2 * margin, wide + 2 * margin, lines,
                    )  # fmt: skip
                    for k in range(last + 1):
                        here = margin + k * length // last
                        total = 0
                        for t in range(max(here - half, 0), min(here + half, length + 2 * margin)):
                            total += lines[t]
                        costs[k, shifts[s, 0] + r, shifts[s, 1] + r] = total
                for k in range(last + 1):
                    still = costs[k, r, r]
                    least = 4 * limit * limit * still
                    y = 0
                    x = 0
                    for s in range(shifts.shape[0]):
                        a = shifts[s, 0]
                        b = shifts[s, 1]
                        key = 4 * limit * limit * costs[k, a + r, b + r] + still * (a * a + b * b)
                        if key < least:
                            least = key
                            y = a
                            x = b
                    if 4 * costs[k, y + r, x + r] > 3 * still:
                        y = 0
                        x = 0
                    for t in range(2):
                        if t == 0:
                            found[n, k, 0] = 16 * y
                            if -r < y < r:
                                low = costs[k, y - 1 + r, x + r]
                                high = costs[k, y + 1 + r, x + r]
                            else:
                                continue
                        else:
                            found[n, k, 1] = 16 * x
                            if -r < x < r:
                                low = costs[k, y + r, x - 1 + r]
                                high = costs[k, y + r, x + 1 + r]
                            else:
                                continue
                        bend = low + high - 2 * costs[k, y + r, x + r]
                        # Only where the parabola's least is an eighth of the difference below.
                        if bend <= 0 or (low - high) * (low - high) < still * bend:
                            continue
                        key = (16 * (low - high) + (2 * UP + 1) * bend) // (2 * bend) - UP
                        found[n, k, t] += min(max(key, -8), 8)
            for n in range(4):
                for k in range(last + 1):
                    for t in range(2):
                        sides[n, k, t] = (
                            found[n, max(k - 1, 0), t]
                            + 2 * found[n, k, t]
                            + found[n, min(k + 1, last), t]
                        )
            for t in range(2):  # both sides of a corner, in 1/128 pixel
                for n in range(4):
                    for k in range(last + 1):
                        sides[n, k, t] *= 2
                meet(sides, 0, 0, 1, 0, t)
                meet(sides, 0, last, 3, 0, t)
                meet(sides, 2, 0, 1, last, t)
                meet(sides, 2, last, 3, last, t)
                for a in range(last + 1):
                    for b in range(last + 1):
                        total = last * (
                            (last - a) * sides[0, b, t]
                            + a * sides[2, b, t]
                            + (last - b) * sides[1, a, t]
                            + b * sides[3, a, t]
                        )
                        total -= (last - a) * ((last - b) * sides[0, 0, t] + b * sides[0, last, t])
                        total -= a * ((last - b) * sides[2, 0, t] + b * sides[2, last, t])
                        bend = 8 * last * last
                        total = (2 * total + (2 * UP + 1) * bend) // (2 * bend) - UP
                        total = min(max(total, -16 * limit), 16 * limit)
                        warps[i, j, a, b, t] = cython.cast(cython.short, total)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def meet(
    sides: cython.longlong[:, :, ::1],
    m: cython.Py_ssize_t,
    a: cython.Py_ssize_t,
    n: cython.Py_ssize_t,
    b: cython.Py_ssize_t,
    t: cython.Py_ssize_t,
) -> cython.void:
    """Give two sides one corner; both are even, so the mean is exact."""
    mean: cython.longlong = (sides[m, a, t] + sides[n, b, t]) // 2
    sides[m, a, t] = mean
    sides[n, b, t] = mean
