# mypy: ignore-errors
"""Kernels that compare what is known around a pixel with every window of a sample.

Compiled by Cython, see setup.py.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.weighted_kernels import (
    draw_one,
    limit_of,
    look,
    window_distance,
)
from cython.cimports.weftex.search.window_kernels import known_runs


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def pick_terms(
    order: cython.const[cython.int][:, ::1],
    wanted: cython.Py_ssize_t,
    limit: cython.longlong,
    lead: cython.Py_ssize_t,
    plane: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    channels: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    stride: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    known: cython.const[cython.short][::1],
    at: cython.Py_ssize_t[::1],
    value: cython.short[::1],
    weight: cython.ushort[::1],
    cap: cython.ushort[::1],
) -> cython.longlong:
    """Choose the `wanted` heaviest known bytes for `bounds`; return what weights are scaled by.

    The limit becomes about 2**13, so that 16 bits tell small differences apart.
    """
    o: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = 0
    place: cython.Py_ssize_t
    scale: cython.longlong
    for o in range(order.shape[0]):
        place = (order[o, 0] + reach) * stride + (order[o, 1] + reach) * channels
        if known[place] == 0:
            continue
        for k in range(channels):
            if n < wanted:
                at[n] = k * plane + lead + order[o, 0] * width + order[o, 1]
                value[n] = query[place + k]
                weight[n] = known[place]
                n += 1
        if n >= wanted:
            break
    scale = 1
    if limit >= 0:
        scale = (cython.cast(cython.longlong, 1) << 29) // max(limit, 1)
    scale = max(1, min(511, scale))  # 127 * 511 < 2**16
    for k in range(wanted):
        if k < n:
            weight[k] = cython.cast(cython.ushort, weight[k] * scale)
            cap[k] = cython.cast(cython.ushort, min(65535, (TERM << 16) // weight[k]))
        else:
            at[k] = lead
            value[k] = 0
            weight[k] = 0
            cap[k] = 0
    return scale


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def bounds(
    planes: cython.p_const_uchar,
    at: cython.const[cython.Py_ssize_t][::1],
    value: cython.const[cython.short][::1],
    weight: cython.const[cython.ushort][::1],
    cap: cython.const[cython.ushort][::1],
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    out: cython.p_ushort,
) -> cython.ushort:
    """Add terms to the lower bounds of BLOCK neighbouring windows; return the least of them.

    A bound is the sum of floor(w d**2 / 2**16), in 16 bits, as twice as many as in 32 are done at
    a time. A square is capped, so that no term passes TERM, and a sum stops at MOST.
    """
    t: cython.Py_ssize_t
    j: cython.Py_ssize_t
    a: cython.p_const_uchar
    b: cython.p_const_uchar
    c: cython.p_const_uchar
    e: cython.p_const_uchar
    least: cython.ushort = 65535
    d: cython.short
    s: cython.ushort
    p: cython.ushort
    va: cython.short
    vb: cython.short
    vc: cython.short
    ve: cython.short
    wa: cython.ushort
    ma: cython.ushort
    wb: cython.ushort
    mb: cython.ushort
    wc: cython.ushort
    mc: cython.ushort
    we: cython.ushort
    me: cython.ushort
    for t in range(first, last, 4):
        a = planes + at[t]
        b = planes + at[t + 1]
        c = planes + at[t + 2]
        e = planes + at[t + 3]
        va = value[t]
        vb = value[t + 1]
        vc = value[t + 2]
        ve = value[t + 3]
        wa = weight[t]
        ma = cap[t]
        wb = weight[t + 1]
        mb = cap[t + 1]
        wc = weight[t + 2]
        mc = cap[t + 2]
        we = weight[t + 3]
        me = cap[t + 3]
        for j in range(BLOCK):
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
            out[j] = p if p < MOST else MOST
    for j in range(BLOCK):
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


def search_full(
    levels: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    places: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
    tolerance: cython.double,
    weights: cython.const[cython.short][:, ::1],
    order: cython.const[cython.int][:, ::1],
    flat: cython.const[cython.uchar][::1],
    planes: cython.const[cython.uchar][:, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    allowed: cython.const[cython.uchar][::1],
    period: cython.const[cython.int][::1],
    blocks: cython.const[cython.int][::1],
    stride: cython.Py_ssize_t,
    chosen: cython.int[::1],
    errors: cython.longlong[::1],
    totals: cython.longlong[::1],
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    known: cython.short[::1],
    rows: cython.int[::1],
    at: cython.Py_ssize_t[::1],
    value: cython.short[::1],
    weight: cython.ushort[::1],
    cap: cython.ushort[::1],
    lower: cython.ushort[:, ::1],
    least: cython.ushort[::1],
    found: cython.int[::1],
    distances: cython.longlong[::1],
):
    """For each pixel of the canvas at `places` draw one of the windows that match it best.

    Fills `chosen` (flat index into the sample), `errors` (its distance) and `totals` (the weight
    of what is known). The arrays after those are scratch.
    """
    channels: cython.Py_ssize_t = levels.shape[2]
    width: cython.Py_ssize_t = usable.shape[1]
    reach: cython.Py_ssize_t = weights.shape[0] // 2
    near: cython.Py_ssize_t = 1 if reach > 0 else 0
    lead: cython.Py_ssize_t = reach * width + reach
    step: cython.Py_ssize_t = STEP if STEP < at.shape[0] else at.shape[0]
    n: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    b: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    place: cython.Py_ssize_t
    count: cython.Py_ssize_t
    nearest: cython.Py_ssize_t
    best: cython.longlong
    limit: cython.longlong
    scale: cython.longlong
    cut: cython.longlong
    d: cython.longlong
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // done.shape[1]
            x = places[i] % done.shape[1]
            totals[i] = look(
                levels, done, wrap_y, wrap_x, y, x, weights, stride, runs, query, known, rows
            )
            count = known_runs(done, y, x, wrap_y, wrap_x, near, near, near, near, runs)
            count = coherent_places(source, y, x, runs, count, usable, period, found, 0)
            best = -1
            for j in range(count):
                if found[j] >= 0:
                    d = window_distance(
                        flat, found[j], width, channels, reach, stride, query, known, rows, best
                    )
                    if best < 0 or d < best:
                        best = d
            limit = limit_of(best, tolerance) if best >= 0 else -1
            scale = pick_terms(
                order, at.shape[0], limit, lead, planes.shape[1], width, channels, reach, stride,
                query, known, at, value, weight, cap,
            )  # fmt: skip
            nearest = 0
            for b in range(blocks.shape[0]):
                memset(cython.address(lower[b, 0]), 0, BLOCK * 2)
                least[b] = bounds(
                    cython.address(planes[0, blocks[b]]), at, value, weight, cap, 0, step,
                    cython.address(lower[b, 0]),
                )  # fmt: skip
                if least[b] < least[nearest]:
                    nearest = b
            count = 0
            # The block with the least bound first: what is found there bounds the others.
            for j in range(BLOCK):
                if lower[nearest, j] == least[nearest]:
                    place = blocks[nearest] + j
                    if allowed[place]:
                        d = window_distance(
                            flat, place, width, channels, reach, stride, query, known, rows, limit
                        )
                        if best < 0 or d < best:
                            best = d
                            limit = limit_of(best, tolerance)
                    break
            cut = cut_of(limit, scale)
            for b in range(blocks.shape[0]):
                n = step
                while least[b] <= cut and n < at.shape[0]:
                    least[b] = bounds(
                        cython.address(planes[0, blocks[b]]), at, value, weight, cap, n, n + step,
                        cython.address(lower[b, 0]),
                    )  # fmt: skip
                    n += step
                if least[b] > cut:
                    continue
                for j in range(BLOCK):
                    if lower[b, j] > cut:
                        continue
                    place = blocks[b] + j
                    if not allowed[place]:
                        continue
                    d = window_distance(
                        flat, place, width, channels, reach, stride, query, known, rows, limit
                    )
                    if d > limit and limit >= 0:
                        continue
                    found[count] = cython.cast(cython.int, place)
                    distances[count] = d
                    count += 1
                    if best < 0 or d < best:
                        best = d
                        limit = limit_of(best, tolerance)
                        cut = cut_of(limit, scale)
            j = draw_one(found, distances, count, limit, bits[i])
            chosen[i] = found[j]
            errors[i] = distances[j]
