# mypy: ignore-errors
"""Kernels of near-regular synthesis: where blocks meet; compiled, see setup.py.

Places are as in `_near_regular_kernels`.
"""

import cython
from cython.cimports.weftex.methods.near_regular.block_kernels import around

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any path costs
BESIDE = cython.declare(cython.int, 1)  # the state of a known pixel beside a hole; 0 in the hole
OFF = cython.declare(cython.int, 2)  # the state of any other


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def squared(
    one: cython.const[cython.uchar][:, :, ::1],
    ay: cython.Py_ssize_t,
    ax: cython.Py_ssize_t,
    other: cython.const[cython.uchar][:, :, ::1],
    by: cython.Py_ssize_t,
    bx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels."""
    k: cython.Py_ssize_t
    d: cython.int
    total: cython.longlong = 0
    for k in range(one.shape[2]):
        d = cython.cast(cython.int, one[ay, ax, k]) - other[by, bx, k]
        total += d * d
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def differ(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    ay: cython.Py_ssize_t,
    ax: cython.Py_ssize_t,
    by: cython.Py_ssize_t,
    bx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels of the sample, by how much a step shows at them."""
    shows: cython.longlong = visibility[ay, ax] + visibility[by, bx]
    return shows * squared(pixels, ay, ax, pixels, by, bx)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def state_of(
    state: cython.const[cython.uchar][:, ::1],
    wrap: cython.const[cython.int][::1],
    y: cython.longlong,
    x: cython.longlong,
) -> cython.int:
    """HOLE, BESIDE a hole or OFF, which is also all that is not on the canvas."""
    if wrap[0]:
        y = y % wrap[0]
        y = y + wrap[0] if y < 0 else y
    if wrap[1]:
        x = x % wrap[1]
        x = x + wrap[1] if x < 0 else x
    if y < 0 or x < 0 or y >= state.shape[0] or x >= state.shape[1]:
        return OFF
    return state[y, x]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def leaves(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    known: cython.const[cython.uchar][:, :, ::1],
    v: cython.longlong,
    u: cython.longlong,
) -> cython.longlong:
    """Squared difference, counted twice, of a pixel of the sample and a known one of the canvas."""
    v = v % known.shape[0]
    u = u % known.shape[1]
    v = v + known.shape[0] if v < 0 else v
    u = u + known.shape[1] if u < 0 else u
    shows: cython.longlong = 2 * visibility[y, x]
    return 2 * shows * squared(pixels, y, x, known, v, u)


def meet(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    place: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.longlong][::1],
    columns: cython.const[cython.longlong][::1],
    wrap: cython.const[cython.int][::1],
    parity: cython.Py_ssize_t,
    inset: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    slack: cython.Py_ssize_t,
    box: cython.Py_ssize_t,
    state: cython.const[cython.uchar][:, ::1],
    error: cython.longlong[:, ::1],
    corners: cython.int[:, :, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
):
    """Find where four blocks meet: near their common corner, where the two drawn ones agree.

    Seams stay within `reach` of the grid; that is `inset` inside of the windows.
    `corners` gets (dy, dx) for each vertex of rows `first` to `last`, at most `slack` either way:
    the place whose box of 2 x `box` pixels differs least between the two. Where there is a
    `state`, pixels that do not show do not count. `error` is scratch.
    """
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    left: cython.Py_ssize_t
    right: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    a: cython.int
    b: cython.int
    ay: cython.Py_ssize_t
    ax: cython.Py_ssize_t
    by: cython.Py_ssize_t
    bx: cython.Py_ssize_t
    size_y: cython.longlong
    size_x: cython.longlong
    total: cython.longlong
    least: cython.longlong
    kind: cython.int
    drawn: cython.bint
    width: cython.Py_ssize_t = pixels.shape[1]
    with cython.nogil:
        for i in range(first, last):
            for j in range(corners.shape[1]):
                corners[i, j, 0] = 0
                corners[i, j, 1] = 0
                p = around(i, -1, place.shape[0], wrap[0] != 0)
                q = around(i, 0, place.shape[0], wrap[0] != 0)
                left = around(j, -1, place.shape[1], wrap[1] != 0)
                right = around(j, 0, place.shape[1], wrap[1] != 0)
                if p < 0 or q < 0 or left < 0 or right < 0 or slack == 0:
                    continue
                size_y = rows[p + 1] - rows[p]
                size_x = columns[left + 1] - columns[left]
                drawn = (i + j + parity) % 2 == 0  # the one below and to the right
                a = place[p, left] if drawn else place[p, right]
                b = place[q, right] if drawn else place[q, left]
                if a < 0 or b < 0:
                    continue
                ay = a // width + inset + size_y
                ax = a % width + inset + (size_x if drawn else 0)
                by = b // width + inset
                bx = b % width + inset + (0 if drawn else size_x)
                for v in range(2 * reach):
                    for u in range(2 * reach):
                        error[v, u] = differ(pixels, visibility, ay + v, ax + u, by + v, bx + u)
                        if state.shape[0]:
                            kind = state_of(
                                state, wrap, rows[i] - reach + v, columns[j] - reach + u
                            )
                            if kind == OFF:
                                error[v, u] = 0
                least = -1
                for y in range(-slack, slack + 1):
                    for x in range(-slack, slack + 1):
                        total = 0
                        for v in range(reach + y - box, reach + y + box):
                            for u in range(reach + x - box, reach + x + box):
                                total += error[v, u]
                        # Of equal ones the nearest to the corner.
                        total = total * 1024 + y * y + x * x
                        if least < 0 or total < least:
                            least = total
                            corners[i, j, 0] = cython.cast(cython.int, y)
                            corners[i, j, 1] = cython.cast(cython.int, x)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def least_path(
    error: cython.const[cython.longlong][:, ::1],
    beyond: cython.const[cython.longlong][:, ::1],
    length: cython.Py_ssize_t,
    depth: cython.Py_ssize_t,
    begin: cython.Py_ssize_t,
    end: cython.Py_ssize_t,
    total: cython.longlong[:, ::1],
    came: cython.int[:, ::1],
    path: cython.int[::1],
) -> cython.void:
    """Find the cheapest boundary along a band between two given places.

    Line i of the band belongs to one side up to path[i] and to the other from there on. Both
    pixels beside every piece of the boundary count, also where it runs across from line to line,
    and for each place on a line what is `beyond`, if anything.
    It stays within one step a line of both its ends, so that no two paths of a corner cross.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    low: cython.Py_ssize_t
    high: cython.Py_ssize_t
    left: cython.longlong
    for k in range(depth + 1):
        total[0, k] = NEVER
    total[0, begin] = 0
    came[0, begin] = cython.cast(cython.int, begin)
    for i in range(1, length):
        low = max(1, begin - i, end - (length - 1 - i))
        high = min(depth - 1, begin + i, end + (length - 1 - i))
        for k in range(depth + 1):
            total[i, k] = total[i - 1, k]
            came[i, k] = cython.cast(cython.int, k)
        for k in range(1, depth + 1):  # across to the right, then to the left
            if total[i, k - 1] < NEVER:
                left = total[i, k - 1] + error[i - 1, k - 1] + error[i, k - 1]
                if left < total[i, k]:
                    total[i, k] = left
                    came[i, k] = came[i, k - 1]
        for k in range(depth - 1, -1, -1):
            if total[i, k + 1] < NEVER:
                left = total[i, k + 1] + error[i - 1, k] + error[i, k]
                if left < total[i, k]:
                    total[i, k] = left
                    came[i, k] = came[i, k + 1]
        for k in range(depth + 1):
            if k < low or k > high:
                total[i, k] = NEVER
            elif total[i, k] < NEVER:
                total[i, k] += error[i, k - 1] + error[i, k]
                if beyond.shape[0]:
                    total[i, k] += beyond[i, k]
    k = end
    for i in range(length - 1, -1, -1):
        path[i] = cython.cast(cython.int, k)
        k = came[i, k]


def cut_edges(
    pixels: cython.const[cython.uchar][:, :, ::1],
    visibility: cython.const[cython.ushort][:, ::1],
    place: cython.const[cython.int][:, ::1],
    rows: cython.const[cython.longlong][::1],
    columns: cython.const[cython.longlong][::1],
    wrap: cython.const[cython.int][::1],
    corners: cython.const[cython.int][:, :, ::1],
    inset: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    upright: cython.bint,
    known: cython.const[cython.uchar][:, :, ::1],
    state: cython.const[cython.uchar][:, ::1],
    error: cython.longlong[:, ::1],
    beyond: cython.longlong[:, ::1],
    total: cython.longlong[:, ::1],
    came: cython.int[:, ::1],
    path: cython.int[::1],
    paths: cython.int[:, :, ::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
):
    """Cut along the left edges of blocks (`upright`) or their upper ones, rows `first` to `last`.

    paths[i, j] says for each line of the window of block (i, j) where in it the block begins. The
    five arrays before `paths` are scratch. Where there is a `state`, differences that do not show
    do not count, but those to `known` pixels beside a hole do, as if the block went on there.
    """
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    k: cython.Py_ssize_t
    t: cython.Py_ssize_t
    n: cython.Py_ssize_t
    start: cython.Py_ssize_t
    stop: cython.Py_ssize_t
    begin: cython.Py_ssize_t
    end: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    y: cython.longlong
    x: cython.longlong
    kind: cython.int
    size: cython.longlong
    length: cython.longlong
    a: cython.int
    b: cython.int
    ay: cython.Py_ssize_t
    ax: cython.Py_ssize_t
    by: cython.Py_ssize_t
    bx: cython.Py_ssize_t
    width: cython.Py_ssize_t = pixels.shape[1]
    with cython.nogil:
        for i in range(first, last):
            for j in range(paths.shape[1]):
                for t in range(paths.shape[2]):
                    paths[i, j, t] = cython.cast(cython.int, inset + reach)
                p = around(i, 0 if upright else -1, place.shape[0], wrap[0] != 0)
                q = around(j, -1 if upright else 0, place.shape[1], wrap[1] != 0)
                k = around(i, 0, place.shape[0], wrap[0] != 0)
                t = around(j, 0, place.shape[1], wrap[1] != 0)
                if p < 0 or q < 0 or k < 0 or t < 0 or reach == 0:
                    continue
                a = place[p, q]
                b = place[k, t]
                if a < 0 or b < 0:
                    continue
                if upright:
                    size = columns[q + 1] - columns[q]
                    length = rows[k + 1] - rows[k]
                    begin = corners[i, j, 1]
                    end = corners[i + 1, j, 1]
                    start = corners[i, j, 0]
                    stop = length + corners[i + 1, j, 0]
                else:
                    size = rows[p + 1] - rows[p]
                    length = columns[t + 1] - columns[t]
                    begin = corners[i, j, 0]
                    end = corners[i, j + 1, 0]
                    start = corners[i, j, 1]
                    stop = length + corners[i, j + 1, 1]
                begin += reach
                end += reach
                start += inset + reach
                stop += inset + reach
                if stop <= start:
                    continue
                ay = a // width + (start if upright else inset + size)
                ax = a % width + (inset + size if upright else start)
                by = b // width + (start if upright else inset)
                bx = b % width + (inset if upright else start)
                for n in range(stop - start):
                    for k in range(2 * reach):
                        if upright:
                            error[n, k] = differ(pixels, visibility, ay + n, ax + k, by + n, bx + k)
                        else:
                            error[n, k] = differ(pixels, visibility, ay + k, ax + n, by + k, bx + n)
                for n in range(stop - start):
                    if state.shape[0] == 0:
                        break
                    beyond[n, 0] = 0
                    for k in range(2 * reach):
                        y = rows[i] + (start - inset - reach + n if upright else k - reach)
                        x = columns[j] + (k - reach if upright else start - inset - reach + n)
                        kind = state_of(state, wrap, y, x)
                        beyond[n, k + 1] = beyond[n, k]
                        if kind == OFF:
                            error[n, k] = 0
                        if kind == BESIDE:
                            # A boundary past this pixel leaves it to the block before.
                            v = n if upright else k
                            u = k if upright else n
                            beyond[n, k + 1] += leaves(
                                pixels, visibility, ay + v, ax + u, known, y, x
                            )
                            beyond[n, k + 1] -= leaves(
                                pixels, visibility, by + v, bx + u, known, y, x
                            )
                least_path(error, beyond, stop - start, 2 * reach, begin, end, total, came, path)
                for t in range(paths.shape[2]):
                    if t < start:
                        n = begin
                    elif t >= stop:
                        n = end
                    else:
                        n = path[t - start]
                    paths[i, j, t] = cython.cast(cython.int, inset + n)


def path_through(error, beyond, begin, end, total, came, path):
    """Fill `path` with the cheapest boundary through a whole band."""
    least_path(error, beyond, error.shape[0], error.shape[1], begin, end, total, came, path)
