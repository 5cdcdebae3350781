# mypy: ignore-errors
"""The kernels of iterative refinement; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.projection_kernels import run_coordinates
from cython.cimports.weftex.search.window_kernels import gather_runs, known_runs, run_distance
from cython.cimports.weftex.search.zone_kernels import nearest_by_features, squared


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def settle_pixel(
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    pixels: cython.const[cython.uchar][:, :, ::1],
    place: cython.Py_ssize_t,
) -> cython.bint:
    """Give a pixel its place in the sample; return whether it changed."""
    k: cython.Py_ssize_t
    if source[y, x] == place:
        done[y, x] = 1
        return False
    source[y, x] = cython.cast(cython.int, place)
    for k in range(levels.shape[2]):
        levels[y, x, k] = pixels[place // pixels.shape[1], place % pixels.shape[1], k]
    done[y, x] = 1
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def excess(
    cell: cython.Py_ssize_t,
    usage: cython.const[cython.int][::1],
    capacity: cython.const[cython.int][::1],
    weight: cython.longlong,
) -> cython.longlong:
    """What a distance is multiplied with, in 1/256: 256 unless a cell is used too often."""
    over: cython.longlong = usage[cell] - capacity[cell]
    if over <= 0:
        return 256
    over = weight * over // capacity[cell]
    return 256 + (over if over < 16384 else 16384)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def coherent(
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    order: cython.const[cython.int][::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    pixels: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    settled: cython.const[cython.int][::1],
    period: cython.const[cython.int][::1],
    reach: cython.Py_ssize_t,
    similar: cython.const[cython.int][:, ::1],
    margin: cython.longlong,
    tried: cython.const[cython.int][::1],
    cells: cython.const[cython.int][::1],
    usage: cython.int[::1],
    capacity: cython.const[cython.int][::1],
    weight: cython.longlong,
    guide: cython.const[cython.uchar][:, :, ::1],
    own_guide: cython.const[cython.uchar][:, :, ::1],
    guide_weight: cython.longlong,
    all_known: cython.const[cython.uchar][:, ::1],
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    guide_runs: cython.int[:, ::1],
    guide_query: cython.uchar[::1],
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    width: cython.Py_ssize_t = levels.shape[1]
    columns: cython.Py_ssize_t = pixels.shape[1]
    beside: cython.Py_ssize_t = 1 if reach > 0 else 0  # see `coherent_places`
    p: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t
    near: cython.Py_ssize_t
    count: cython.Py_ssize_t
    own: cython.Py_ssize_t
    place: cython.Py_ssize_t
    best: cython.Py_ssize_t
    guide_n: cython.Py_ssize_t = 0
    d: cython.longlong
    g: cython.longlong
    factor: cython.longlong
    least: cython.longlong
    changed: cython.Py_ssize_t = 0
    for p in range(order.shape[0]):
        y = order[p] // width
        x = order[p] % width
        own = source[y, x]
        places[0] = -1
        if own >= 0 and usable[own // columns, own % columns]:
            places[0] = cython.cast(cython.int, own)
        n = known_runs(done, y, x, wrap_y, wrap_x, beside, beside, beside, beside, runs)
        near = coherent_places(source, y, x, runs, n, usable, period, places, 1)
        count = near
        for i in range(near):
            if places[i] >= 0:
                for k in range(similar.shape[1]):
                    places[count] = similar[places[i], k]
                    count += 1
        n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
        gather_runs(levels, y, x, runs, n, query)
        if guide_weight > 0:
            guide_n = known_runs(
                all_known, y, x, wrap_y, wrap_x, reach, reach, reach, reach, guide_runs
            )
            gather_runs(guide, y, x, guide_runs, guide_n, guide_query)
        best = -1
        least = -1
        for i in range(count + tried.shape[0]):
            place = places[i] if i < count else tried[i - count]
            if place < 0:
                continue
            g = 0
            if guide_weight > 0:
                g = guide_weight * (
                    squared(
                        cython.address(own_guide[place // columns, place % columns, 0]),
                        cython.address(guide[y, x, 0]),
                        guide.shape[2],
                    )
                    + run_distance(
                        own_guide, place // columns, place % columns, guide_runs, guide_n,
                        guide_query, least // guide_weight if best >= 0 else -1,
                    )
                )  # fmt: skip
                if best >= 0 and g >= least:
                    continue
            factor = excess(cells[place], usage, capacity, weight)
            if i >= near:
                factor = factor * margin // 256
            d = run_distance(
                pixels, place // columns, place % columns, runs, n, query,
                (least - g) // factor if best >= 0 else -1,
            )  # fmt: skip
            if best < 0 or d * factor + g < least:
                least = d * factor + g
                best = place
        if best < 0:
            continue
        best = settled[best]
        if own >= 0:
            usage[cells[own]] -= 1
        usage[cells[best]] += 1
        changed += settle_pixel(levels, done, source, y, x, pixels, best)
    return changed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest(
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    order: cython.const[cython.int][::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    pixels: cython.const[cython.uchar][:, :, ::1],
    centres: cython.const[cython.int][::1],
    reach: cython.Py_ssize_t,
    mean: cython.const[cython.uchar][::1],
    basis: cython.const[cython.short][:, :, ::1],
    level: cython.const[cython.longlong][::1],
    offset: cython.const[cython.int][::1],
    shift: cython.int,
    features: cython.const[cython.short][:, ::1],
    least_known: cython.Py_ssize_t,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    difference: cython.short[::1],
    totals: cython.longlong[::1],
    coordinates: cython.short[::1],
    keys: cython.longlong[::1],
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    width: cython.Py_ssize_t = levels.shape[1]
    columns: cython.Py_ssize_t = pixels.shape[1]
    p: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    i: cython.Py_ssize_t
    n: cython.Py_ssize_t
    known: cython.Py_ssize_t
    count: cython.Py_ssize_t
    place: cython.Py_ssize_t
    best: cython.Py_ssize_t
    d: cython.longlong
    least: cython.longlong
    changed: cython.Py_ssize_t = 0
    for p in range(order.shape[0]):
        y = order[p] // width
        x = order[p] % width
        n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
        known = gather_runs(levels, y, x, runs, n, query)
        count = 0
        if known >= least_known:
            run_coordinates(
                runs, n, query, mean, basis, level, offset, shift, difference, totals, coordinates
            )
            count = nearest_by_features(
                features, centres, coordinates, places.shape[0], keys, places
            )
        best = -1
        least = -1
        for i in range(count if count else centres.shape[0]):
            place = places[i] if count else centres[i]
            d = run_distance(pixels, place // columns, place % columns, runs, n, query, least)
            if best < 0 or d < least or (d == least and place < best):
                least = d
                best = place
        changed += settle_pixel(levels, done, source, y, x, pixels, best)
    return changed


def refine_coherently(
    levels, done, source, order, wrap, pixels, usable, settled, period, reach, similar, margin,
    tried, cells, usage, capacity, weight, guide, own_guide, guide_weight, all_known, runs, query,
    guide_runs, guide_query, places,
):  # fmt: skip
    """Give each pixel in `order` the best of its candidates; return how many changed.

    Candidates are its own place, where the sources of its eight neighbours go on, the places
    `similar` to these, and those `tried`; of equals the first is best. The distance to one of
    the latter two counts `margin` / 256 times. That to a place in a cell that has been used more
    often than its capacity counts more, by the share of the excess times `weight` / 256. To this
    comes the distance between the two guides, over the whole window, times `guide_weight` / 256.
    What a pixel takes is `settled`: the same place, but not beyond a border.
    """
    lv: cython.uchar[:, :, ::1] = levels
    dn: cython.uchar[:, ::1] = done
    so: cython.int[:, ::1] = source
    od: cython.const[cython.int][::1] = order
    wy: cython.bint = wrap[0]
    wx: cython.bint = wrap[1]
    px: cython.const[cython.uchar][:, :, ::1] = pixels
    us: cython.const[cython.uchar][:, ::1] = usable
    se: cython.const[cython.int][::1] = settled
    pe: cython.const[cython.int][::1] = period
    re: cython.Py_ssize_t = reach
    si: cython.const[cython.int][:, ::1] = similar
    ma: cython.longlong = margin
    tr: cython.const[cython.int][::1] = tried
    ce: cython.const[cython.int][::1] = cells
    ug: cython.int[::1] = usage
    ca: cython.const[cython.int][::1] = capacity
    we: cython.longlong = weight
    gu: cython.const[cython.uchar][:, :, ::1] = guide
    og: cython.const[cython.uchar][:, :, ::1] = own_guide
    gw: cython.longlong = guide_weight
    ak: cython.const[cython.uchar][:, ::1] = all_known
    ru: cython.int[:, ::1] = runs
    qu: cython.uchar[::1] = query
    gr: cython.int[:, ::1] = guide_runs
    gq: cython.uchar[::1] = guide_query
    pl: cython.int[::1] = places
    changed: cython.Py_ssize_t
    with cython.nogil:
        changed = coherent(
            lv, dn, so, od, wy, wx, px, us, se, pe, re, si, ma, tr, ce, ug, ca, we, gu, og, gw, ak,
            ru, qu, gr, gq, pl,
        )  # fmt: skip
    return changed


def refine_by_components(
    levels, done, source, order, wrap, pixels, centres, reach, mean, basis, level, offset, shift,
    features, least_known, runs, query, difference, totals, coordinates, keys, places,
):  # fmt: skip
    """Give each pixel in `order` the nearest of the windows; return how many changed.

    Only as many windows as `places` has room for, the nearest by their coordinates, are compared;
    all of them where fewer than `least_known` bytes of the window are known.
    """
    lv: cython.uchar[:, :, ::1] = levels
    dn: cython.uchar[:, ::1] = done
    so: cython.int[:, ::1] = source
    od: cython.const[cython.int][::1] = order
    wy: cython.bint = wrap[0]
    wx: cython.bint = wrap[1]
    px: cython.const[cython.uchar][:, :, ::1] = pixels
    ct: cython.const[cython.int][::1] = centres
    re: cython.Py_ssize_t = reach
    me: cython.const[cython.uchar][::1] = mean
    ba: cython.const[cython.short][:, :, ::1] = basis
    le: cython.const[cython.longlong][::1] = level
    of: cython.const[cython.int][::1] = offset
    sh: cython.int = shift
    fe: cython.const[cython.short][:, ::1] = features
    lk: cython.Py_ssize_t = least_known
    ru: cython.int[:, ::1] = runs
    qu: cython.uchar[::1] = query
    di: cython.short[::1] = difference
    to: cython.longlong[::1] = totals
    co: cython.short[::1] = coordinates
    ke: cython.longlong[::1] = keys
    pl: cython.int[::1] = places
    changed: cython.Py_ssize_t
    with cython.nogil:
        changed = nearest(
            lv, dn, so, od, wy, wx, px, ct, re, me, ba, le, of, sh, fe, lk, ru, qu, di, to, co,
            ke, pl,
        )  # fmt: skip
    return changed
