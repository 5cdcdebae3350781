# mypy: ignore-errors
"""Kernels of near-regular synthesis: which piece a gap takes; compiled, see setup.py.

Places are as in `_near_regular_kernels`.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.methods.near_regular.block_kernels import (
    around,
    settled,
    shown_again,
    similar,
)
from cython.cimports.weftex.search.zone_kernels import (
    block_means,
    distance,
    gather,
    nearest_by_features,
    offer,
    project,
)

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any piece differs by
SUBSET = cython.declare(cython.Py_ssize_t, 512)  # lattice positions that a gap looks at
KNOWN = cython.declare(cython.int, 5)  # the wedge of pixels that are there already


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
