# cython: language_level=3
"""Kernels that compare the known part of a window with all windows of a sample.

The distance is a sum of w d**2 over known pixels, w from 1 to 127, in integers. What is known lies
in rows as long as the window, with the weight 0 where nothing is known, so that no loop has holes.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weft.search._window_kernels import settle


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def before(
    reach: cython.Py_ssize_t, at: cython.Py_ssize_t, length: cython.Py_ssize_t, wrap: cython.bint
) -> cython.Py_ssize_t:
    """How far a window reaches up or left; on a short wrapped axis it sees nothing twice."""
    room: cython.Py_ssize_t = (length - 1) // 2 if wrap else at
    return reach if reach < room else room


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def after(
    reach: cython.Py_ssize_t, at: cython.Py_ssize_t, length: cython.Py_ssize_t, wrap: cython.bint
) -> cython.Py_ssize_t:
    """How far a window reaches down or right."""
    room: cython.Py_ssize_t = length // 2 if wrap else length - 1 - at
    return reach if reach < room else room


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def around(at: cython.Py_ssize_t, length: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """A coordinate that may have left a wrapped axis by less than its length."""
    return at + length if at < 0 else (at - length if at >= length else at)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look(
    levels: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    weights: cython.const[cython.short][:, ::1],
    stride: cython.Py_ssize_t,
    query: cython.uchar[::1],
    known: cython.short[::1],
    rows: cython.int[::1],
) -> cython.longlong:
    """Copy what is known around a pixel of the canvas, with its weights; return their sum.

    `rows` receives the number of rows with anything known, and which they are, the nearest first.
    On a wrapped axis shorter than the window nothing is seen twice.
    """
    height: cython.Py_ssize_t = done.shape[0]
    width: cython.Py_ssize_t = done.shape[1]
    channels: cython.Py_ssize_t = levels.shape[2]
    reach: cython.Py_ssize_t = weights.shape[0] // 2
    up: cython.Py_ssize_t = before(reach, y, height, wrap_y)
    down: cython.Py_ssize_t = after(reach, y, height, wrap_y)
    left: cython.Py_ssize_t = before(reach, x, width, wrap_x)
    right: cython.Py_ssize_t = after(reach, x, width, wrap_x)
    step: cython.Py_ssize_t
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    k: cython.Py_ssize_t
    at: cython.Py_ssize_t
    n: cython.int = 0
    row: cython.longlong
    total: cython.longlong = 0
    memset(cython.address(known[0]), 0, cython.cast(cython.size_t, known.shape[0]) * 2)
    for step in range(2 * reach + 1):
        dy = -((step + 1) // 2) if step % 2 else step // 2
        if dy < -up or dy > down:
            continue
        cy = around(y + dy, height)
        row = 0
        for dx in range(-left, right + 1):
            cx = around(x + dx, width)
            if done[cy, cx] and (dy != 0 or dx != 0):
                at = (dy + reach) * stride + (dx + reach) * channels
                for k in range(channels):
                    query[at + k] = levels[cy, cx, k]
                    known[at + k] = weights[dy + reach, dx + reach]
                row += weights[dy + reach, dx + reach]
        if row > 0:
            n += 1
            rows[n] = cython.cast(cython.int, dy + reach)
            total += row
    rows[0] = n
    return total


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def weighted(
    a: cython.p_const_uchar, b: cython.p_const_uchar, w: cython.p_const_short, n: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of w d**2 of two rows of bytes."""
    i: cython.Py_ssize_t
    stop: cython.Py_ssize_t
    start: cython.Py_ssize_t = 0
    d: cython.short
    e: cython.short
    part: cython.int
    total: cython.longlong = 0
    while start < n:
        stop = start + 256 if start + 256 < n else n  # 256 * 127 * 255**2 < 2**31
        part = 0
        for i in range(start, stop):
            d = cython.cast(cython.short, a[i]) - cython.cast(cython.short, b[i])
            e = w[i] * d  # 127 * 255 < 2**15
            part += cython.cast(cython.int, e) * d
        total += part
        start = stop
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def window_distance(
    flat: cython.const[cython.uchar][::1],
    place: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    channels: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    stride: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    known: cython.const[cython.short][::1],
    rows: cython.const[cython.int][::1],
    bound: cython.longlong,
) -> cython.longlong:
    """Distance to the window at a flat index; stops past `bound` (negative: never)."""
    r: cython.Py_ssize_t
    row: cython.Py_ssize_t
    total: cython.longlong = 0
    for r in range(1, rows[0] + 1):
        row = rows[r]
        total += weighted(
            cython.address(flat[(place + (row - reach) * width - reach) * channels]),
            cython.address(query[row * stride]),
            cython.address(known[row * stride]),
            stride,
        )
        if total > bound and bound >= 0:
            break
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def pick_terms(
    order: cython.const[cython.int][:, ::1],
    wanted: cython.Py_ssize_t,
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
) -> cython.longlong:
    """Choose the `wanted` heaviest known bytes for `bounds`; return what weights are scaled by.

    So scaled, the sum of all terms, each rounded down to multiples of 2**16, fits 16 bits.
    """
    o: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t = 0
    place: cython.Py_ssize_t
    far: cython.longlong
    most: cython.longlong = 0
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
                far = query[place + k] if query[place + k] > 127 else 255 - query[place + k]
                most += far * far * known[place]
                n += 1
        if n >= wanted:
            break
    scale = 511  # 127 * 511 < 2**16
    if most > 0:
        scale = min(scale, (cython.cast(cython.longlong, 65535) << 16) // most)
    for k in range(wanted):
        if k < n:
            weight[k] = cython.cast(cython.ushort, weight[k] * scale)
        else:
            at[k] = lead
            value[k] = 0
            weight[k] = 0
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
    wanted: cython.Py_ssize_t,
    out: cython.p_ushort,
) -> cython.ushort:
    """Lower bounds of the distances of BLOCK neighbouring windows; return the least of them.

    They are floor(w d**2 / 2**16), summed in 16 bits: twice as many at a time as in 32.
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
    wb: cython.ushort
    wc: cython.ushort
    we: cython.ushort
    for j in range(BLOCK):
        out[j] = 0
    for t in range(0, wanted, 4):
        a = planes + at[t]
        b = planes + at[t + 1]
        c = planes + at[t + 2]
        e = planes + at[t + 3]
        va = value[t]
        vb = value[t + 1]
        vc = value[t + 2]
        ve = value[t + 3]
        wa = weight[t]
        wb = weight[t + 1]
        wc = weight[t + 2]
        we = weight[t + 3]
        for j in range(BLOCK):
            d = cython.cast(cython.short, a[j]) - va
            s = cython.cast(cython.ushort, d * d)
            p = cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wa) >> 16)
            d = cython.cast(cython.short, b[j]) - vb
            s = cython.cast(cython.ushort, d * d)
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wb) >> 16)
            d = cython.cast(cython.short, c[j]) - vc
            s = cython.cast(cython.ushort, d * d)
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * wc) >> 16)
            d = cython.cast(cython.short, e[j]) - ve
            s = cython.cast(cython.ushort, d * d)
            p += cython.cast(cython.ushort, (cython.cast(cython.uint, s) * we) >> 16)
            out[j] += p
    for j in range(BLOCK):
        least = out[j] if out[j] < least else least
    return least


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def limit_of(best: cython.longlong, tolerance: cython.double) -> cython.longlong:
    """The largest distance within (1 + tolerance) of the best."""
    return cython.cast(cython.longlong, cython.cast(cython.double, best) * (1 + tolerance))


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
    query: cython.uchar[::1],
    known: cython.short[::1],
    rows: cython.int[::1],
    at: cython.Py_ssize_t[::1],
    value: cython.short[::1],
    weight: cython.ushort[::1],
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
    lead: cython.Py_ssize_t = reach * width + reach
    wanted: cython.Py_ssize_t = at.shape[0]
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    b: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    place: cython.Py_ssize_t
    count: cython.Py_ssize_t
    kept: cython.Py_ssize_t
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
                levels, done, wrap_y, wrap_x, y, x, weights, stride, query, known, rows
            )
            best = coherent_best(
                flat, width, channels, reach, stride, query, known, rows,
                done, source, wrap_y, wrap_x, y, x, usable, period,
            )  # fmt: skip
            limit = limit_of(best, tolerance) if best >= 0 else -1
            scale = pick_terms(
                order, wanted, lead, planes.shape[1], width, channels, reach, stride, query, known,
                at, value, weight,
            )  # fmt: skip
            nearest = 0
            for b in range(blocks.shape[0]):
                least[b] = bounds(
                    cython.address(planes[0, blocks[b]]),
                    at,
                    value,
                    weight,
                    wanted,
                    cython.address(lower[b, 0]),
                )
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
            kept = 0
            for j in range(count):
                if distances[j] <= limit:
                    found[kept] = found[j]
                    distances[kept] = distances[j]
                    kept += 1
            j = cython.cast(
                cython.Py_ssize_t, ((bits[i] >> 32) * cython.cast(cython.ulonglong, kept)) >> 32
            )
            chosen[i] = found[j]
            errors[i] = distances[j]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def coherent_best(
    flat: cython.const[cython.uchar][::1],
    width: cython.Py_ssize_t,
    channels: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    stride: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    known: cython.const[cython.short][::1],
    rows: cython.const[cython.int][::1],
    done: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
) -> cython.longlong:
    """The least distance of the places where the neighbours' sources go on; -1 without any."""
    height: cython.Py_ssize_t = done.shape[0]
    across: cython.Py_ssize_t = done.shape[1]
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    from_: cython.Py_ssize_t
    place: cython.Py_ssize_t
    last: cython.Py_ssize_t = -1
    d: cython.longlong
    best: cython.longlong = -1
    up: cython.Py_ssize_t = before(1, y, height, wrap_y)
    down: cython.Py_ssize_t = after(1, y, height, wrap_y)
    left: cython.Py_ssize_t = before(1, x, across, wrap_x)
    right: cython.Py_ssize_t = after(1, x, across, wrap_x)
    for dy in range(-up, down + 1):
        cy = around(y + dy, height)
        for dx in range(-left, right + 1):
            cx = around(x + dx, across)
            from_ = source[cy, cx]
            if not done[cy, cx] or from_ < 0:
                continue
            place = settle(usable, period, from_ // width - dy, from_ % width - dx)
            if place < 0 or place == last:
                continue
            last = place
            d = window_distance(
                flat, place, width, channels, reach, stride, query, known, rows, best
            )
            if best < 0 or d < best:
                best = d
    return best


def count_known(
    done: cython.const[cython.uchar][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    places: cython.const[cython.int][::1],
    counts: cython.int[::1],
):
    """Fill `counts` with the number of known pixels in the window around each place."""
    height: cython.Py_ssize_t = done.shape[0]
    width: cython.Py_ssize_t = done.shape[1]
    i: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    n: cython.int
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // width
            x = places[i] % width
            n = 0
            for dy in range(-before(reach, y, height, wrap_y), after(reach, y, height, wrap_y) + 1):
                cy = around(y + dy, height)
                for dx in range(
                    -before(reach, x, width, wrap_x), after(reach, x, width, wrap_x) + 1
                ):
                    n += done[cy, around(x + dx, width)]
            counts[i] = n


def wave_numbers(
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    places: cython.const[cython.int][::1],
    map: cython.int[:, ::1],
    waves: cython.int[::1],
):
    """Number the waves of a list of places: one more than the earlier places in a window have.

    Places of one wave do not see each other. `map` is scratch of the canvas's size, all 0 before
    and after.
    """
    height: cython.Py_ssize_t = map.shape[0]
    width: cython.Py_ssize_t = map.shape[1]
    i: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    most: cython.int
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // width
            x = places[i] % width
            most = 0
            for dy in range(-before(reach, y, height, wrap_y), after(reach, y, height, wrap_y) + 1):
                cy = around(y + dy, height)
                for dx in range(
                    -before(reach, x, width, wrap_x), after(reach, x, width, wrap_x) + 1
                ):
                    most = max(most, map[cy, around(x + dx, width)])
            map[y, x] = most + 1
            waves[i] = most
        for i in range(places.shape[0]):
            map[places[i] // width, places[i] % width] = 0
