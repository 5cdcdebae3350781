# mypy: ignore-errors
"""Kernels that compare what is known around a pixel with every window of a sample.

Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.weighted_kernels import (
    Choices,
    Found,
    Picture,
    Query,
    Sample,
    choose_one,
    coherent_windows,
    limit_of,
    look,
    window_distance,
)

#: For Python, the constants of the .pxd.
block_windows = int(BLOCK_WINDOWS)
step_terms = int(STEP_TERMS)
largest_term = int(LARGEST_TERM)


class Terms:
    """Scratch: the bytes of a query that lower bounds are made of."""

    def __init__(self, at, value, weight, cap):
        self.at = at
        self.value = value
        self.weight = weight
        self.cap = cap


@cython.cclass
class Blocks:
    """Stretches of BLOCK_WINDOWS flat indices that hold all windows, and their lower bounds."""

    planes: cython.const[cython.uchar][:, ::1]  # of one channel each, with a margin
    starts: cython.const[cython.int][::1]
    allowed: cython.const[cython.uchar][::1]  # `usable` row by row, and a block more
    order: cython.const[cython.int][:, ::1]  # places in a window, the heaviest first
    lower: cython.ushort[:, ::1]
    least: cython.ushort[::1]  # of a block

    def __init__(self, planes, starts, allowed, order, lower, least):
        self.planes = planes
        self.starts = starts
        self.allowed = allowed
        self.order = order
        self.lower = lower
        self.least = least


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def pick_terms(
    sample: Sample, blocks: Blocks, query: Query, limit: cython.longlong, terms: Terms
) -> cython.longlong:
    """Choose the heaviest known bytes for `bounds`; return the scale of their weights.

    The limit becomes about 2**13, so that 16 bits tell small differences apart.
    """
    cython.declare(o=cython.Py_ssize_t, k=cython.Py_ssize_t, n=cython.Py_ssize_t)
    cython.declare(dy=cython.Py_ssize_t, dx=cython.Py_ssize_t, place=cython.Py_ssize_t)
    cython.declare(lead=cython.Py_ssize_t, wanted=cython.Py_ssize_t, scale=cython.longlong)
    lead = sample.reach * sample.width + sample.reach
    wanted = terms.at.shape[0]
    n = 0
    for o in range(blocks.order.shape[0]):
        dy = blocks.order[o, 0]
        dx = blocks.order[o, 1]
        place = (dy + sample.reach) * sample.stride + (dx + sample.reach) * sample.channels
        if query.weights[place] == 0:
            continue
        for k in range(sample.channels):
            if n < wanted:
                terms.at[n] = k * blocks.planes.shape[1] + lead + dy * sample.width + dx
                terms.value[n] = query.values[place + k]
                terms.weight[n] = query.weights[place]
                n += 1
        if n >= wanted:
            break
    scale = 1
    if limit >= 0:
        scale = (cython.cast(cython.longlong, 1) << 29) // max(limit, 1)
    scale = max(1, min(511, scale))  # 127 * 511 < 2**16
    for k in range(wanted):
        if k < n:
            terms.weight[k] = cython.cast(cython.ushort, terms.weight[k] * scale)
            terms.cap[k] = cython.cast(
                cython.ushort, min(65535, (LARGEST_TERM << 16) // terms.weight[k])
            )
        else:
            terms.at[k] = lead
            terms.value[k] = 0
            terms.weight[k] = 0
            terms.cap[k] = 0
    return scale


def bounds(planes, terms, first, last, out):
    """Add terms to the lower bounds of a block of neighboring windows; return the least of them.

    A bound is the sum of floor(w d**2 / 2**16), in 16 bits, as twice as many as in 32 are done at
    a time. A square is capped, so that no term passes LARGEST_TERM, and a sum stops at
    LARGEST_BOUND. Four terms are added in one pass over the block.
    """
    cython.declare(t=cython.Py_ssize_t, j=cython.Py_ssize_t, least=cython.ushort)
    cython.declare(a=cython.p_const_uchar, va=cython.short, wa=cython.ushort, ma=cython.ushort)
    cython.declare(b=cython.p_const_uchar, vb=cython.short, wb=cython.ushort, mb=cython.ushort)
    cython.declare(c=cython.p_const_uchar, vc=cython.short, wc=cython.ushort, mc=cython.ushort)
    cython.declare(e=cython.p_const_uchar, ve=cython.short, we=cython.ushort, me=cython.ushort)
    cython.declare(d=cython.short, s=cython.ushort, p=cython.ushort)
    for t in range(first, last, 4):
        a = planes + terms.at[t]
        b = planes + terms.at[t + 1]
        c = planes + terms.at[t + 2]
        e = planes + terms.at[t + 3]
        va = terms.value[t]
        vb = terms.value[t + 1]
        vc = terms.value[t + 2]
        ve = terms.value[t + 3]
        wa = terms.weight[t]
        wb = terms.weight[t + 1]
        wc = terms.weight[t + 2]
        we = terms.weight[t + 3]
        ma = terms.cap[t]
        mb = terms.cap[t + 1]
        mc = terms.cap[t + 2]
        me = terms.cap[t + 3]
        for j in range(BLOCK_WINDOWS):
            d = cython.cast(cython.short, a[j]) - va
            s = cython.cast(cython.ushort, d * d)
            s = s if s < ma else ma
            p = cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wa) >> 16)
            d = cython.cast(cython.short, b[j]) - vb
            s = cython.cast(cython.ushort, d * d)
            s = s if s < mb else mb
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wb) >> 16)
            d = cython.cast(cython.short, c[j]) - vc
            s = cython.cast(cython.ushort, d * d)
            s = s if s < mc else mc
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wc) >> 16)
            d = cython.cast(cython.short, e[j]) - ve
            s = cython.cast(cython.ushort, d * d)
            s = s if s < me else me
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * we) >> 16)
            p += out[j]
            out[j] = p if p < LARGEST_BOUND else LARGEST_BOUND
    least = 65535
    for j in range(BLOCK_WINDOWS):
        least = out[j] if out[j] < least else least
    return least


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def cut_of(limit: cython.longlong, scale: cython.longlong) -> cython.longlong:
    """The lower bound that a distance of `limit` may have; without a limit, any."""
    if limit < 0 or limit >= cython.cast(cython.longlong, 1) << 40:
        return 65535
    return (limit * scale) >> 16


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def first_bounds(blocks: Blocks, terms: Terms, step: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """Bound all windows by the first terms; return the block with the least bound."""
    cython.declare(b=cython.Py_ssize_t, nearest=cython.Py_ssize_t)
    nearest = 0
    for b in range(blocks.starts.shape[0]):
        memset(cython.address(blocks.lower[b, 0]), 0, BLOCK_WINDOWS * 2)
        blocks.least[b] = bounds(
            cython.address(blocks.planes[0, blocks.starts[b]]), terms, 0, step,
            cython.address(blocks.lower[b, 0]),
        )  # fmt: skip
        if blocks.least[b] < blocks.least[nearest]:
            nearest = b
    return nearest


def search_full(
    sample: Sample,
    blocks: Blocks,
    picture: Picture,
    choices: Choices,
    query: Query,
    terms: Terms,
    found: Found,
):
    """Choose for each pixel one of the windows that match what is known around it best."""
    cython.declare(n=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(b=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(place=cython.Py_ssize_t, count=cython.Py_ssize_t, nearest=cython.Py_ssize_t)
    cython.declare(best=cython.longlong, limit=cython.longlong, scale=cython.longlong)
    cython.declare(cut=cython.longlong, d=cython.longlong, size=cython.Py_ssize_t)
    cython.declare(step=cython.Py_ssize_t)
    size = terms.at.shape[0]
    step = min(STEP_TERMS, size)
    with cython.nogil:
        for i in range(choices.places.shape[0]):
            y = choices.places[i] // picture.done.shape[1]
            x = choices.places[i] % picture.done.shape[1]
            choices.weights[i] = look(picture, sample, y, x, query)
            # The distance of coherent windows limits that of the others.
            best = -1
            for j in range(coherent_windows(picture, sample, y, x, query, found, 0)):
                if found.places[j] >= 0:
                    d = window_distance(sample, found.places[j], query, best)
                    if best < 0 or d < best:
                        best = d
            limit = limit_of(best, choices.tolerance) if best >= 0 else -1
            scale = pick_terms(sample, blocks, query, limit, terms)
            nearest = first_bounds(blocks, terms, step)
            # The distance of the window with the least bound limits it further.
            for j in range(BLOCK_WINDOWS):
                if blocks.lower[nearest, j] == blocks.least[nearest]:
                    place = blocks.starts[nearest] + j
                    if blocks.allowed[place]:
                        d = window_distance(sample, place, query, limit)
                        if best < 0 or d < best:
                            best = d
                            limit = limit_of(best, choices.tolerance)
                    break
            cut = cut_of(limit, scale)
            count = 0
            for b in range(blocks.starts.shape[0]):
                n = step
                while blocks.least[b] <= cut and n < size:
                    blocks.least[b] = bounds(
                        cython.address(blocks.planes[0, blocks.starts[b]]), terms, n, n + step,
                        cython.address(blocks.lower[b, 0]),
                    )  # fmt: skip
                    n += step
                if blocks.least[b] > cut:
                    continue
                for j in range(BLOCK_WINDOWS):
                    if blocks.lower[b, j] > cut:
                        continue
                    place = blocks.starts[b] + j
                    if not blocks.allowed[place]:
                        continue
                    d = window_distance(sample, place, query, limit)
                    if d > limit and limit >= 0:
                        continue
                    found.places[count] = cython.cast(cython.int, place)
                    found.distances[count] = d
                    count += 1
                    if best < 0 or d < best:
                        best = d
                        limit = limit_of(best, choices.tolerance)
                        cut = cut_of(limit, scale)
            choose_one(choices, i, found, count, limit)
