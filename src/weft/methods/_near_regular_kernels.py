# cython: language_level=3
"""Kernels of near-regular synthesis: which blocks, and where they meet; compiled, see setup.py.

Places are flat indices into the padded sample of a window's upper left corner. A block's window
reaches `margin` pixels beyond the block on every side.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weft.search._kernels import (
    block_means,
    distance,
    gather,
    nearest_by_features,
    offer,
    project,
)

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any path costs
UNIT = cython.declare(cython.longlong, 1 << 16)  # positions are in 1/65536 pixel
TRIES = cython.declare(cython.Py_ssize_t, 256)  # sources that a block tries for one of its own
SUBSET = cython.declare(cython.Py_ssize_t, 512)  # lattice positions that a gap looks at
CHANNELS = cython.declare(cython.Py_ssize_t, 64)  # of a correlation
KNOWN = cython.declare(cython.int, 5)  # the wedge of pixels that are there already
BESIDE = cython.declare(cython.int, 1)  # the state of a known pixel beside a hole; 0 in the hole
OFF = cython.declare(cython.int, 2)  # the state of any other


@cython.cfunc
@cython.inline
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
@cython.inline
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
@cython.inline
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
@cython.inline
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mismatch(
    pixels: cython.const[cython.uchar][:, :, ::1],
    turned: cython.const[cython.uchar][:, :, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    runs: cython.const[cython.int][:, ::1],
    query: cython.const[cython.uchar][::1],
    bound: cython.longlong,
    by_correlation: cython.bint,
) -> cython.longlong:
    """Eq. (4.4), or 2**40 (1 - gamma) by eq. (3.13) of the border and the window at (y, x)."""
    channels: cython.Py_ssize_t = pixels.shape[2]
    r: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.longlong = 0
    at: cython.Py_ssize_t
    f: cython.longlong
    g: cython.longlong
    sums = cython.declare(cython.longlong[5])
    above: cython.longlong = 0
    below: cython.double = 0
    row: cython.p_const_uchar
    if not by_correlation:
        return distance(pixels, turned, y, x, runs, query, bound)
    for k in range(channels):
        for i in range(5):
            sums[i] = 0
        at = 0
        n = 0
        for r in range(runs.shape[0]):
            if runs[r, 0]:
                row = cython.address(turned[x + runs[r, 2], y + runs[r, 1], 0])
            else:
                row = cython.address(pixels[y + runs[r, 1], x + runs[r, 2], 0])
            for i in range(runs[r, 3]):
                f = row[i * channels + k]
                g = query[at + i * channels + k]
                sums[0] += f
                sums[1] += g
                sums[2] += f * g
                sums[3] += f * f
                sums[4] += g * g
            at += runs[r, 3] * channels
            n += runs[r, 3]
        above += n * sums[2] - sums[0] * sums[1]
        below += sqrt(cython.cast(cython.double, n * sums[3] - sums[0] * sums[0])) * sqrt(
            cython.cast(cython.double, n * sums[4] - sums[1] * sums[1])
        )
    if below <= 0:
        return 1 << 40
    return cython.cast(cython.longlong, (1.0 - above / below) * 1099511627776.0)


def fill_gaps(
    pixels: cython.const[cython.uchar][:, :, ::1],
    turned: cython.const[cython.uchar][:, :, ::1],
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
    wedges: cython.const[cython.uchar][:, ::1],
    runs: cython.const[cython.int][:, ::1],
    blocks: cython.const[cython.int][:, ::1],
    side: cython.Py_ssize_t,
    basis: cython.const[cython.short][:, ::1],
    offset: cython.const[cython.int][::1],
    shift: cython.int,
    features: cython.const[cython.short][:, ::1],
    positions: cython.const[cython.int][::1],
    tolerance: cython.Py_ssize_t,
    wanted: cython.Py_ssize_t,
    variety: cython.longlong,
    by_correlation: cython.bint,
    border: cython.uchar[:, :, ::1],
    query: cython.uchar[::1],
    means: cython.int[::1],
    coordinates: cython.short[::1],
    keys: cython.longlong[::1],
    places: cython.int[::1],
    place: cython.int[:, ::1],
):
    """Choose the source of each gap of `cells` by its four neighbours' borders (section 4.2.2).

    Of the similar places the `wanted` best ones are found, and then the best window within the
    tolerance around them. Without `steps` the shortlist is that of the nearest `features`, and
    without `blocks` of all `centres`. The six arrays before `place` are scratch, but `border` has
    what is known already where `wedges` is 5. What a place shows again of its neighbours makes it
    count worse: by `variety` 1/256 where it is all.
    """
    c: cython.Py_ssize_t
    k: cython.Py_ssize_t
    t: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    n: cython.Py_ssize_t
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    y: cython.longlong
    x: cython.longlong
    count: cython.Py_ssize_t
    all_places: cython.Py_ssize_t = steps.shape[0] if steps.shape[0] else centres.shape[0]
    tried: cython.Py_ssize_t
    wedge: cython.int
    here: cython.int
    best: cython.int
    key: cython.longlong
    factor: cython.longlong
    least: cython.longlong
    size_y: cython.longlong
    size_x: cython.longlong
    other = cython.declare(cython.int[5])
    off_y = cython.declare(cython.longlong[5])
    off_x = cython.declare(cython.longlong[5])
    dy = cython.declare(cython.longlong[5])
    dx = cython.declare(cython.longlong[5])
    width: cython.Py_ssize_t = usable.shape[1]
    channels: cython.Py_ssize_t = pixels.shape[2]
    with cython.nogil:
        for c in range(cells.shape[0]):
            i = cells[c, 0]
            j = cells[c, 1]
            size_y = rows[i + 1] - rows[i]
            size_x = columns[j + 1] - columns[j]
            # Top, left, bottom, right: whose window, and where in it this one's corner lies.
            for n in range(1, 5):
                p = i if n % 2 == 0 else around(i, n - 2, place.shape[0], wrap[0] != 0)
                q = j if n % 2 else around(j, n - 3, place.shape[1], wrap[1] != 0)
                other[n] = place[p, q]
                off_y[n] = 0 if n % 2 == 0 else (-size_y if n == 3 else rows[p + 1] - rows[p])
                off_x[n] = 0 if n % 2 else (-size_x if n == 4 else columns[q + 1] - columns[q])
                dy[n] = off_y[n]
                dx[n] = off_x[n]
            for v in range(wedges.shape[0]):
                for u in range(wedges.shape[1]):
                    wedge = wedges[v, u]
                    if wedge == 0 or wedge == KNOWN:
                        continue
                    p = other[wedge] // width + off_y[wedge] + v
                    q = other[wedge] % width + off_x[wedge] + u
                    for k in range(channels):
                        border[v, u, k] = pixels[p, q, k]
            gather(border, 0, 0, runs, query)
            count = 0
            if steps.shape[0] == 0 and blocks.shape[0] > 0:
                block_means(border, 0, 0, blocks, side, means)
                project(basis, offset, shift, means, coordinates)
                count = nearest_by_features(features, positions, coordinates, wanted, keys, places)
            else:
                k = cython.cast(
                    cython.Py_ssize_t,
                    bits[i, j] % cython.cast(cython.ulonglong, all_places),
                )
                tried = 0
                for t in range(all_places):
                    if steps.shape[0]:
                        here = similar(usable, period, steps, phase[i, j, 0], phase[i, j, 1], k)
                    else:
                        here = centres[k]
                    k = k + 1 if k + 1 < all_places else 0
                    if here < 0:
                        continue
                    factor = 256
                    for n in range(1, 5):
                        factor += (
                            variety
                            * shown_again(here, other[n], width, dy[n], dx[n], size_y, size_x)
                            // max(size_y * size_x, 1)
                        )
                    key = factor * mismatch(
                        pixels, turned, here // width, here % width, runs, query,
                        keys[0] // factor if count == wanted else -1, by_correlation,
                    )  # fmt: skip
                    count = offer(
                        key, here, count, wanted,
                        cython.address(keys[0]), cython.address(places[0]),
                    )  # fmt: skip
                    tried += 1
                    if tried == SUBSET and steps.shape[0]:
                        break
            # The best one first, so that all others are soon given up.
            n = 0
            for t in range(1, count):
                if keys[t] < keys[n] or (keys[t] == keys[n] and places[t] < places[n]):
                    n = t
            if count > 0:
                here = places[0]
                places[0] = places[n]
                places[n] = here
            best = -1
            least = NEVER
            for t in range(count):
                for y in range(-tolerance, tolerance + 1):
                    for x in range(-tolerance, tolerance + 1):
                        here = settled(
                            usable, period, places[t] // width + y, places[t] % width + x
                        )
                        if here < 0:
                            continue
                        factor = 256
                        for n in range(1, 5):
                            factor += (
                                variety
                                * shown_again(here, other[n], width, dy[n], dx[n], size_y, size_x)
                                // max(size_y * size_x, 1)
                            )
                        key = factor * mismatch(
                            pixels, turned, here // width, here % width, runs, query,
                            least // factor if least < NEVER else -1, by_correlation,
                        )  # fmt: skip
                        if key < least or (key == least and here < best):
                            least = key
                            best = here
            k = cython.cast(
                cython.Py_ssize_t, bits[i, j] % cython.cast(cython.ulonglong, centres.shape[0])
            )
            # No window lies where a multiple leads to: any other one.
            place[i, j] = best if best >= 0 else centres[k]


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def differ(
    pixels: cython.const[cython.uchar][:, :, ::1],
    ay: cython.Py_ssize_t,
    ax: cython.Py_ssize_t,
    by: cython.Py_ssize_t,
    bx: cython.Py_ssize_t,
) -> cython.longlong:
    """Squared difference of two pixels of the sample."""
    k: cython.Py_ssize_t
    d: cython.int
    total: cython.longlong = 0
    for k in range(pixels.shape[2]):
        d = cython.cast(cython.int, pixels[ay, ax, k]) - pixels[by, bx, k]
        total += d * d
    return total


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
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    known: cython.const[cython.uchar][:, :, ::1],
    v: cython.longlong,
    u: cython.longlong,
) -> cython.longlong:
    """Squared difference, counted twice, of a pixel of the sample and a known one of the canvas."""
    k: cython.Py_ssize_t
    d: cython.int
    total: cython.longlong = 0
    v = v % known.shape[0]
    u = u % known.shape[1]
    v = v + known.shape[0] if v < 0 else v
    u = u + known.shape[1] if u < 0 else u
    for k in range(pixels.shape[2]):
        d = cython.cast(cython.int, pixels[y, x, k]) - known[v, u, k]
        total += d * d
    return 2 * total


def meet(
    pixels: cython.const[cython.uchar][:, :, ::1],
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
                        error[v, u] = differ(pixels, ay + v, ax + u, by + v, bx + u)
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
                            error[n, k] = differ(pixels, ay + n, ax + k, by + n, bx + k)
                        else:
                            error[n, k] = differ(pixels, ay + k, ax + n, by + k, bx + n)
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
                            beyond[n, k + 1] += leaves(pixels, ay + v, ax + u, known, y, x)
                            beyond[n, k + 1] -= leaves(pixels, by + v, bx + u, known, y, x)
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


def compare(pixels, turned, y, x, runs, query, by_correlation):
    """Return how badly a border fits the window at (y, x)."""
    return mismatch(pixels, turned, y, x, runs, query, -1, by_correlation)
