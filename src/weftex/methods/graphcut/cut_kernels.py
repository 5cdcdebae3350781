# mypy: ignore-errors
"""Kernels of graph-cut textures: what seams cost, and pasting; compiled by Cython, see setup.py.

Pixels of the canvas and of the sample are flat, row by row. `shape` is (height, width, wraps
vertically, wraps horizontally) of the canvas, `sample` is (height, width, tiles, weighs by
gradients) of the sample. A pixel's label is its source: where in the sample it was copied from, and
so how the patch it belongs to goes on beside it.
"""

import cython

# Costs weighed by gradients: a mean difference of SOFT levels on either side weighs like none.
SCALE = cython.declare(cython.longlong, 256)
SOFT = cython.declare(cython.longlong, 32)

# What may become of a pixel.
NOTHING = cython.declare(cython.int, 0)
OLD = cython.declare(cython.int, 1)
NEW = cython.declare(cython.int, 2)
EITHER = cython.declare(cython.int, 3)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def moved(
    at: cython.int,
    dy: cython.int,
    dx: cython.int,
    height: cython.int,
    width: cython.int,
    around_y: cython.int,
    around_x: cython.int,
) -> cython.int:
    """The flat place beside `at`, or -1 beyond a border that does not go around."""
    y: cython.int = at // width + dy
    x: cython.int = at % width + dx
    if y < 0 or y >= height:
        if not around_y:
            return -1
        y = y - height if y >= height else y + height
    if x < 0 or x >= width:
        if not around_x:
            return -1
        x = x - width if x >= width else x + width
    return y * width + x


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def goes_on(
    usable: cython.const[cython.uchar][::1],
    sample: cython.const[cython.int][::1],
    source: cython.int,
    dy: cython.int,
    dx: cython.int,
) -> cython.int:
    """What the patch of a pixel from `source` has beside it; -1 for nothing."""
    at: cython.int
    if source < 0:
        return -1
    at = moved(source, dy, dx, sample[0], sample[1], sample[2], sample[2])
    if at >= 0 and not usable[at]:
        return -1
    return at


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def difference(
    a: cython.p_const_uchar, b: cython.p_const_uchar, channels: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of absolute differences of two pixels: a metric, and exact."""
    k: cython.Py_ssize_t
    total: cython.int = 0
    for k in range(channels):
        total += abs(cython.cast(cython.int, a[k]) - cython.cast(cython.int, b[k]))
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def seam(
    levels: cython.const[cython.uchar][:, ::1],
    pixels: cython.const[cython.uchar][:, ::1],
    usable: cython.const[cython.uchar][::1],
    sample: cython.const[cython.int][::1],
    p: cython.int,
    q: cython.int,
    dy: cython.int,
    dx: cython.int,
    from_p: cython.int,
    from_q: cython.int,
) -> cython.longlong:
    """M(s, t, A, B), what it costs that p has one label and q = p + (dy, dx) another.

    |A(p) - B(p)| + |A(q) - B(q)|, and with gradients divided by those of A and of B across the
    seam (Kwatra et al., equations 1 and 6). Where a patch ends, the other half counts twice. A
    known pixel that is not in the sample has -1 for its label and does not go on.
    """
    channels: cython.Py_ssize_t = pixels.shape[1]
    on_p: cython.int = goes_on(usable, sample, from_q, -dy, -dx)  # what q's patch has at p
    on_q: cython.int = goes_on(usable, sample, from_p, dy, dx)
    at_p: cython.p_const_uchar
    at_q: cython.p_const_uchar
    cost: cython.longlong = 0
    steep: cython.longlong = 0
    if on_q >= 0 and on_q == from_q:
        return 0
    at_p = cython.address(pixels[from_p, 0]) if from_p >= 0 else cython.address(levels[p, 0])
    at_q = cython.address(pixels[from_q, 0]) if from_q >= 0 else cython.address(levels[q, 0])
    if on_p < 0 and on_q < 0:
        cost = 510 * channels
    else:
        if on_p >= 0:
            cost += difference(at_p, cython.address(pixels[on_p, 0]), channels)
            if sample[3]:
                steep += difference(at_q, cython.address(pixels[on_p, 0]), channels)
        if on_q >= 0:
            cost += difference(at_q, cython.address(pixels[on_q, 0]), channels)
            if sample[3]:
                steep += difference(at_p, cython.address(pixels[on_q, 0]), channels)
        if on_p < 0 or on_q < 0:
            cost *= 2
            steep *= 2
    if sample[3]:
        return SCALE * cost // (steep + SOFT * channels)
    return cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def capacities(
    levels: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][::1],
    done: cython.const[cython.uchar][::1],
    fixed: cython.const[cython.uchar][::1],
    shape: cython.const[cython.int][::1],
    pixels: cython.const[cython.uchar][:, ::1],
    usable: cython.const[cython.uchar][::1],
    sample: cython.const[cython.int][::1],
    where: cython.const[cython.int][:, ::1],
    what: cython.const[cython.int][:, ::1],
    arcs: cython.int[:, :, ::1],
    old: cython.int[:, ::1],
    new: cython.int[:, ::1],
    state: cython.uchar[:, ::1],
) -> cython.longlong:
    """Fill the graph whose minimum cut says which pixels of a box a patch replaces.

    `where` and `what` are the box on the canvas and the patch in the sample, as flat places. Each
    pair of neighbours has a cost for each way to label it: c for both old (an old seam, or 0), a
    and b for one of them new, 0 for both. So an old seam needs no node of its own: a pair costs
    alpha + beta = c by its terminals, and by its arcs what a and b are above them. This is exact if
    c <= a + b, which metrics are; costs weighed by gradients are raised to it, which keeps an
    expansion from making things worse.

    Returns what pairs without a choice cost. `state` is what may become of each pixel: NOTHING,
    OLD, NEW or EITHER.
    """
    rows: cython.Py_ssize_t = where.shape[0]
    columns: cython.Py_ssize_t = where.shape[1]
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    v: cython.Py_ssize_t
    u: cython.Py_ssize_t
    d: cython.int
    dy: cython.int
    dx: cython.int
    p: cython.int
    q: cython.int
    p_may: cython.int
    q_may: cython.int
    both_old: cython.longlong
    p_old: cython.longlong  # and q new
    q_old: cython.longlong
    alpha: cython.longlong
    fixed_cost: cython.longlong = 0
    for i in range(rows):
        for j in range(columns):
            p = where[i, j]
            if not usable[what[i, j]] or (done[p] and fixed[p]):
                state[i, j] = OLD if done[p] else NOTHING
            else:
                state[i, j] = EITHER if done[p] else NEW
            old[i, j] = 0
            new[i, j] = 0
            for d in range(4):
                arcs[i, j, d] = 0
    for i in range(rows):
        for j in range(columns):
            p = where[i, j]
            p_may = state[i, j]
            if p_may == NOTHING:
                continue
            for d in range(4):
                dy = d % 2 * (1 - d // 2 * 2)
                dx = (1 - d % 2) * (1 - d // 2 * 2)
                v = i + dy
                u = j + dx
                if 0 <= v < rows and 0 <= u < columns:
                    if d > 1:
                        continue  # was met from the other side
                    q = where[v, u]
                    q_may = state[v, u]
                else:
                    q = moved(p, dy, dx, shape[0], shape[1], shape[2], shape[3])
                    if q < 0 or q == p or not done[q]:
                        continue
                    q_may = OLD
                both_old = 0
                p_old = 0
                q_old = 0
                if p_may & OLD and q_may & OLD and p_may | q_may != OLD:
                    both_old = seam(
                        levels, pixels, usable, sample, p, q, dy, dx, source[p], source[q]
                    )
                if p_may & OLD and q_may & NEW:
                    p_old = seam(
                        levels, pixels, usable, sample, p, q, dy, dx, source[p], what[v, u]
                    )
                if p_may & NEW and q_may & OLD:
                    q_old = seam(
                        levels, pixels, usable, sample, p, q, dy, dx, what[i, j], source[q]
                    )
                if p_may == EITHER and q_may == EITHER:
                    q_old = max(q_old, both_old - p_old)
                    alpha = min(p_old, both_old)
                    old[i, j] += cython.cast(cython.int, alpha)
                    old[v, u] += cython.cast(cython.int, both_old - alpha)
                    arcs[v, u, d + 2] = cython.cast(cython.int, p_old - alpha)
                    arcs[i, j, d] = cython.cast(cython.int, q_old - both_old + alpha)
                elif p_may == EITHER:
                    old[i, j] += cython.cast(cython.int, both_old + p_old)
                    new[i, j] += cython.cast(cython.int, q_old)
                elif q_may == EITHER:
                    old[v, u] += cython.cast(cython.int, both_old + q_old)
                    new[v, u] += cython.cast(cython.int, p_old)
                else:
                    fixed_cost += p_old + q_old
    return fixed_cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def paste(
    levels: cython.uchar[:, ::1],
    source: cython.int[::1],
    done: cython.uchar[::1],
    pixels: cython.const[cython.uchar][:, ::1],
    where: cython.const[cython.int][:, ::1],
    what: cython.const[cython.int][:, ::1],
    side: cython.const[cython.uchar][:, ::1],
) -> cython.Py_ssize_t:
    """Copy the pixels of a patch that `side` has; return how many there was nothing at before."""
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    k: cython.Py_ssize_t
    covered: cython.Py_ssize_t = 0
    for i in range(where.shape[0]):
        for j in range(where.shape[1]):
            if side[i, j]:
                covered += not done[where[i, j]]
                done[where[i, j]] = 1
                source[where[i, j]] = what[i, j]
                for k in range(pixels.shape[1]):
                    levels[where[i, j], k] = pixels[what[i, j], k]
    return covered


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def seams(
    levels: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][::1],
    done: cython.const[cython.uchar][::1],
    fixed: cython.const[cython.uchar][::1],
    shape: cython.const[cython.int][::1],
    pixels: cython.const[cython.uchar][:, ::1],
    usable: cython.const[cython.uchar][::1],
    sample: cython.const[cython.int][::1],
    where: cython.const[cython.int][:, ::1],
    cost: cython.int[::1],
) -> cython.void:
    """Fill in what the seams to the right of and below each pixel of a box cost."""
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    d: cython.int
    p: cython.int
    q: cython.int
    for i in range(where.shape[0]):
        for j in range(where.shape[1]):
            p = where[i, j]
            cost[p] = 0
            for d in range(2):
                q = moved(p, d, 1 - d, shape[0], shape[1], shape[2], shape[3])
                if q < 0 or q == p or not done[p] or not done[q] or (fixed[p] and fixed[q]):
                    continue
                cost[p] += cython.cast(
                    cython.int,
                    seam(levels, pixels, usable, sample, p, q, d, 1 - d, source[p], source[q]),
                )


def fill_capacities(
    levels: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][::1],
    done: cython.const[cython.uchar][::1],
    fixed: cython.const[cython.uchar][::1],
    shape: cython.const[cython.int][::1],
    pixels: cython.const[cython.uchar][:, ::1],
    usable: cython.const[cython.uchar][::1],
    sample: cython.const[cython.int][::1],
    where: cython.const[cython.int][:, ::1],
    what: cython.const[cython.int][:, ::1],
    arcs: cython.int[:, :, ::1],
    old: cython.int[:, ::1],
    new: cython.int[:, ::1],
    state: cython.uchar[:, ::1],
):
    """Call `capacities`, beside other threads."""
    cost: cython.longlong
    with cython.nogil:
        cost = capacities(
            levels, source, done, fixed, shape, pixels, usable, sample, where, what, arcs, old,
            new, state,
        )  # fmt: skip
    return cost


def paste_patch(levels, source, done, pixels, where, what, side):
    """Call `paste`."""
    return paste(levels, source, done, pixels, where, what, side)


def fill_seams(levels, source, done, fixed, shape, pixels, usable, sample, where, cost):
    """Call `seams`."""
    seams(levels, source, done, fixed, shape, pixels, usable, sample, where, cost)
