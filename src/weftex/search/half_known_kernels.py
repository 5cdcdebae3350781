# mypy: ignore-errors
"""Kernels that find half-known windows by principal components; compiled by Cython, see setup.py.

Floating point is plain double arithmetic in a fixed order, so every machine gets the same.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.exhaustive_kernels import BLOCK, bounds
from cython.cimports.weftex.search.weighted_kernels import (
    draw_one,
    limit_of,
    look,
    window_distance,
)
from cython.cimports.weftex.search.window_kernels import known_runs
from cython.cimports.weftex.search.zone_kernels import offer


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def estimate(
    weights: cython.const[cython.short][:, ::1],
    channels: cython.Py_ssize_t,
    stride: cython.Py_ssize_t,
    query: cython.const[cython.uchar][::1],
    known: cython.const[cython.short][::1],
    rows: cython.const[cython.int][::1],
    mean: cython.const[cython.double][::1],
    basis: cython.const[cython.double][:, ::1],
    products: cython.const[cython.double][:, ::1],
    ridge: cython.const[cython.double][::1],
    gram: cython.double[::1],
    z: cython.double[::1],
) -> cython.void:
    """Coordinates of a window by what is known of it: weighted least squares with a ridge.

    The sum over known pixels of w u u^T, its lower half in `gram` row by row, comes from the
    `products` of each pixel; the solution, of a positive definite system, from an LDL^T
    decomposition in place.
    """
    width: cython.Py_ssize_t = weights.shape[0]
    count: cython.Py_ssize_t = basis.shape[1]
    r: cython.Py_ssize_t
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    d: cython.Py_ssize_t
    e: cython.Py_ssize_t
    at: cython.Py_ssize_t
    row: cython.Py_ssize_t
    half: cython.Py_ssize_t = count * (count + 1) // 2
    w: cython.double
    f: cython.double
    for e in range(half):
        gram[e] = 0
    for d in range(count):
        z[d] = 0
    for r in range(1, rows[0] + 1):
        row = rows[r]
        for i in range(width):
            at = row * stride + i * channels
            if known[at] == 0:
                continue
            w = known[at]
            for e in range(half):
                gram[e] += w * products[row * width + i, e]
            for k in range(channels):
                f = w * (query[at + k] - mean[at + k])
                for d in range(count):
                    z[d] += f * basis[at + k, d]
    for d in range(count):
        gram[d * (d + 1) // 2 + d] += ridge[d]
    for d in range(count):  # gram = L D L^T, and z = L^-1 z
        row = d * (d + 1) // 2
        for e in range(d):
            at = e * (e + 1) // 2
            for i in range(e):
                gram[row + e] -= gram[row + i] * gram[at + i]
        for e in range(d):
            f = gram[row + e]
            gram[row + e] = f / gram[e * (e + 1) // 2 + e]
            gram[row + d] -= gram[row + e] * f
            z[d] -= gram[row + e] * z[e]
    for d in range(count):
        z[d] /= gram[d * (d + 1) // 2 + d]
    for d in range(count - 1, -1, -1):  # z = L^-T z
        for e in range(d):
            z[e] -= gram[d * (d + 1) // 2 + e] * z[d]


def search_half_known(
    levels: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    source: cython.const[cython.int][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    places: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
    tolerance: cython.double,
    weights: cython.const[cython.short][:, ::1],
    flat: cython.const[cython.uchar][::1],
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    stride: cython.Py_ssize_t,
    wanted: cython.Py_ssize_t,
    mean: cython.const[cython.double][::1],
    basis: cython.const[cython.double][:, ::1],
    products: cython.const[cython.double][:, ::1],
    ridge: cython.const[cython.double][::1],
    factor: cython.double,
    origin: cython.const[cython.double][::1],
    planes: cython.const[cython.uchar][::1],
    at: cython.const[cython.Py_ssize_t][::1],
    middles: cython.const[cython.uchar][::1],
    at_middles: cython.const[cython.Py_ssize_t][::1],
    leaves: cython.const[cython.int][::1],
    centres: cython.const[cython.int][::1],
    weight: cython.const[cython.ushort][::1],
    cap: cython.const[cython.ushort][::1],
    chosen: cython.int[::1],
    errors: cython.longlong[::1],
    totals: cython.longlong[::1],
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    known: cython.short[::1],
    rows: cython.int[::1],
    gram: cython.double[::1],
    z: cython.double[::1],
    value: cython.short[::1],
    lower: cython.ushort[::1],
    near_leaves: cython.int[::1],
    keys: cython.longlong[::1],
    found: cython.int[::1],
    distances: cython.longlong[::1],
):
    """As `search_full`, among the `wanted` windows with the nearest components and coherent ones.

    The windows are sorted into leaves of up to BLOCK alike ones; only the nearest leaves are
    looked at. The arrays after `totals` are scratch.
    """
    channels: cython.Py_ssize_t = levels.shape[2]
    width: cython.Py_ssize_t = usable.shape[1]
    reach: cython.Py_ssize_t = weights.shape[0] // 2
    near: cython.Py_ssize_t = 1 if reach > 0 else 0
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    k: cython.Py_ssize_t
    b: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    count: cython.Py_ssize_t
    visited: cython.Py_ssize_t
    d: cython.longlong
    best: cython.longlong
    limit: cython.longlong
    worst: cython.longlong
    place: cython.int
    v: cython.double
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // done.shape[1]
            x = places[i] % done.shape[1]
            totals[i] = look(
                levels, done, wrap_y, wrap_x, y, x, weights, stride, runs, query, known, rows
            )
            estimate(
                weights, channels, stride, query, known, rows, mean, basis, products, ridge, gram, z
            )
            for j in range(value.shape[0]):
                v = factor * z[j] + origin[j] if j < z.shape[0] else 0
                value[j] = cython.cast(cython.short, 0 if v < 0 else (255 if v > 255 else v))
            # The leaves whose middles are nearest, and in those the windows that are.
            count = 0
            for k in range((leaves.shape[0] + BLOCK - 1) // BLOCK):
                b = k * BLOCK
                memset(cython.address(lower[0]), 0, BLOCK * 2)
                bounds(
                    cython.address(middles[b]), at_middles, value, weight, cap, 0, at.shape[0],
                    cython.address(lower[0]),
                )  # fmt: skip
                for j in range(min(BLOCK, leaves.shape[0] - b)):
                    count = offer(
                        (cython.cast(cython.longlong, lower[j]) << 32) | (b + j),
                        cython.cast(cython.int, b + j), count, near_leaves.shape[0],
                        cython.address(keys[0]), cython.address(near_leaves[0]),
                    )  # fmt: skip
            visited = count
            count = 0
            worst = 65535
            for k in range(visited):
                b = near_leaves[k]
                memset(cython.address(lower[0]), 0, BLOCK * 2)
                d = bounds(
                    cython.address(planes[b * BLOCK]), at, value, weight, cap, 0, at.shape[0],
                    cython.address(lower[0]),
                )  # fmt: skip
                if d > worst:
                    continue
                for j in range(leaves[b]):
                    if lower[j] <= worst:
                        place = centres[b * BLOCK + j]
                        count = offer(
                            (cython.cast(cython.longlong, lower[j]) << 32) | place, place, count,
                            wanted, cython.address(keys[0]), cython.address(found[0]),
                        )  # fmt: skip
                        if count == wanted:
                            worst = keys[0] >> 32
            b = known_runs(done, y, x, wrap_y, wrap_x, near, near, near, near, runs)
            count = coherent_places(source, y, x, runs, b, usable, period, found, count)
            best = -1
            limit = -1
            b = 0
            for j in range(count - 1, -1, -1):  # the coherent ones first: they bound the others
                if found[j] < 0:
                    continue
                place = found[j]
                d = window_distance(
                    flat, place, width, channels, reach, stride, query, known, rows, limit
                )
                if best < 0 or d < best:
                    best = d
                    limit = limit_of(best, tolerance)
                distances[j] = d
            for j in range(count):  # in scan order, as in a full search
                if found[j] < 0 or distances[j] > limit:
                    continue
                place = found[j]
                d = distances[j]
                k = b
                while k > 0 and found[k - 1] > place:
                    found[k] = found[k - 1]
                    distances[k] = distances[k - 1]
                    k -= 1
                found[k] = place
                distances[k] = d
                b += 1
            j = draw_one(found, distances, b, limit, bits[i])
            chosen[i] = found[j]
            errors[i] = distances[j]


def coordinates(
    weights, channels, stride, query, known, rows, mean, basis, products, ridge, gram, z
):
    """`estimate`."""
    estimate(weights, channels, stride, query, known, rows, mean, basis, products, ridge, gram, z)
