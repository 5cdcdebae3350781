# cython: language_level=3
"""The kernel of iterative refinement; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weft.search._coherence_kernels import coherent_places
from cython.cimports.weft.search._window_kernels import (
    gather_runs,
    known_runs,
    run_distance,
    settle,
)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def offer_place(
    place: cython.Py_ssize_t, count: cython.Py_ssize_t, places: cython.int[::1]
) -> cython.Py_ssize_t:
    """Append a place unless there is none or it is there already; return the new number."""
    i: cython.Py_ssize_t
    if place < 0:
        return count
    for i in range(count):
        if places[i] == place:
            return count
    places[count] = cython.cast(cython.int, place)
    return count + 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def refine(
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    order: cython.const[cython.int][::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    pixels: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    reach: cython.Py_ssize_t,
    similar: cython.const[cython.int][:, ::1],
    given: cython.const[cython.int][:, ::1],
    cells: cython.const[cython.int][::1],
    usage: cython.int[::1],
    capacity: cython.const[cython.int][::1],
    weight: cython.longlong,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    width: cython.Py_ssize_t = levels.shape[1]
    columns: cython.Py_ssize_t = pixels.shape[1]
    p: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t
    row: cython.Py_ssize_t
    count: cython.Py_ssize_t
    coherent: cython.Py_ssize_t
    own: cython.Py_ssize_t
    best: cython.Py_ssize_t
    d: cython.longlong
    bound: cython.longlong
    least: cython.longlong
    scale: cython.longlong
    over: cython.longlong
    changed: cython.Py_ssize_t = 0
    for p in range(order.shape[0]):
        y = order[p] // width
        x = order[p] % width
        own = source[y, x]
        n = known_runs(done, y, x, wrap_y, wrap_x, 1, 1, 1, 1, runs)
        places[0] = cython.cast(cython.int, own)
        coherent = coherent_places(source, y, x, runs, n, usable, period, places, 1)
        count = coherent
        for i in range(coherent):
            if places[i] >= 0:
                for k in range(similar.shape[1]):
                    count = offer_place(similar[places[i], k], count, places)
        n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
        gather_runs(levels, y, x, runs, n, query)
        row = p if given.shape[0] > 1 else 0
        best = -1
        least = -1
        for i in range(count + given.shape[1]):
            k = places[i] if i < count else given[row, i - count]
            if k < 0:
                continue
            # cost = d (scale + weight over) / scale, compared without leaving the integers
            scale = 256 * cython.cast(cython.longlong, capacity[cells[k]])
            over = usage[cells[k]] - capacity[cells[k]]
            over = weight * over if over > 0 else 0
            over = over if over < 64 * scale else 64 * scale
            bound = -1 if least < 0 else least * scale // (scale + over)
            d = run_distance(pixels, k // columns, k % columns, runs, n, query, bound)
            if 0 <= bound and bound < d:
                continue
            d += d * over // scale
            if least < 0 or d < least:
                least = d
                best = k
        if best < 0:
            continue
        done[y, x] = 1
        if best == own:
            continue
        changed += 1
        if own >= 0:
            usage[cells[own]] -= 1
        usage[cells[best]] += 1
        source[y, x] = cython.cast(cython.int, best)
        for k in range(levels.shape[2]):
            levels[y, x, k] = pixels[best // columns, best % columns, k]
    return changed


def refine_pixels(
    levels,
    done,
    source,
    order,
    wrap,
    pixels,
    usable,
    period,
    reach,
    similar,
    given,
    cells,
    usage,
    capacity,
    weight,
    runs,
    query,
    places,
):
    """Give each pixel in `order` the best of its candidates; return how many changed.

    Candidates are the coherent places, `similar` ones to those, and the pixel's row of `given`
    (or its only row). The cell of a place that has been used more often than its capacity
    makes its distance count more, by the excess times `weight` / 256.
    """
    lv: cython.uchar[:, :, ::1] = levels
    dn: cython.uchar[:, ::1] = done
    so: cython.int[:, ::1] = source
    od: cython.const[cython.int][::1] = order
    wy: cython.bint = wrap[0]
    wx: cython.bint = wrap[1]
    px: cython.const[cython.uchar][:, :, ::1] = pixels
    us: cython.const[cython.uchar][:, ::1] = usable
    pe: cython.const[cython.int][::1] = period
    re: cython.Py_ssize_t = reach
    si: cython.const[cython.int][:, ::1] = similar
    gi: cython.const[cython.int][:, ::1] = given
    ce: cython.const[cython.int][::1] = cells
    ug: cython.int[::1] = usage
    ca: cython.const[cython.int][::1] = capacity
    we: cython.longlong = weight
    ru: cython.int[:, ::1] = runs
    qu: cython.uchar[::1] = query
    pl: cython.int[::1] = places
    changed: cython.Py_ssize_t
    with cython.nogil:
        changed = refine(
            lv, dn, so, od, wy, wx, px, us, pe, re, si, gi, ce, ug, ca, we, ru, qu, pl
        )
    return changed
