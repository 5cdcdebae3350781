# mypy: ignore-errors
"""Kernels that find half-known windows by principal components; compiled by Cython, see setup.py.

Floating point is plain double arithmetic in a fixed order, so every machine gets the same.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.exhaustive_kernels import BLOCK_WINDOWS, Terms, bounds
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
from cython.cimports.weftex.search.zone_kernels import offer


@cython.cclass
class Components:
    """The components of whole windows, and scratch for a half-known one's coordinates."""

    mean: cython.const[cython.double][::1]  # as long as a query
    basis: cython.const[cython.double][:, ::1]  # a row for each byte of a query
    products: cython.const[cython.double][:, ::1]  # u u^T of each pixel, its lower half
    ridge: cython.const[cython.double][::1]
    factor: cython.double
    origin: cython.const[cython.double][::1]
    gram: cython.double[::1]
    z: cython.double[::1]

    def __init__(self, mean, basis, products, ridge, factor, origin, gram, z):
        self.mean = mean
        self.basis = basis
        self.products = products
        self.ridge = ridge
        self.factor = factor
        self.origin = origin
        self.gram = gram
        self.z = z


@cython.cclass
class Leaves:
    """Leaves of up to BLOCK_WINDOWS windows with like coordinates, and scratch for a search."""

    planes: cython.const[cython.uchar][::1]  # coordinates of windows, component by component
    middles: cython.const[cython.uchar][::1]  # those of the leaves' means
    sizes: cython.const[cython.int][::1]
    places: cython.const[cython.int][::1]  # of the windows, BLOCK_WINDOWS a leaf
    terms: Terms
    middle_terms: Terms
    lower: cython.ushort[::1]
    near: cython.int[::1]  # the leaves to look into
    keys: cython.longlong[::1]

    def __init__(self, planes, middles, sizes, places, terms, middle_terms, lower, near, keys):
        self.planes = planes
        self.middles = middles
        self.sizes = sizes
        self.places = places
        self.terms = terms
        self.middle_terms = middle_terms
        self.lower = lower
        self.near = near
        self.keys = keys


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def estimate(sample: Sample, query: Query, components: Components) -> cython.void:
    """Coordinates of a window by what is known of it: weighted least squares with a ridge.

    The sum over known pixels of w u u^T, its lower half in `gram` row by row, comes from the
    `products` of each pixel; the solution, of a positive definite system, from an LDL^T
    decomposition in place.
    """
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(d=cython.Py_ssize_t, e=cython.Py_ssize_t, at=cython.Py_ssize_t)
    cython.declare(row=cython.Py_ssize_t, half=cython.Py_ssize_t, count=cython.Py_ssize_t)
    cython.declare(width=cython.Py_ssize_t, w=cython.double, f=cython.double)
    cython.declare(gram=cython.p_double, z=cython.p_double)
    gram = cython.address(components.gram[0])
    z = cython.address(components.z[0])
    width = 2 * sample.reach + 1
    count = components.basis.shape[1]
    half = count * (count + 1) // 2
    for e in range(half):
        gram[e] = 0
    for d in range(count):
        z[d] = 0
    for r in range(1, query.rows[0] + 1):
        row = query.rows[r]
        for i in range(width):
            at = row * sample.stride + i * sample.channels
            if query.weights[at] == 0:
                continue
            w = query.weights[at]
            for e in range(half):
                gram[e] += w * components.products[row * width + i, e]
            for k in range(sample.channels):
                f = w * (query.values[at + k] - components.mean[at + k])
                for d in range(count):
                    z[d] += f * components.basis[at + k, d]
    for d in range(count):
        gram[d * (d + 1) // 2 + d] += components.ridge[d]
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


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def as_bytes(components: Components, terms: Terms) -> cython.void:
    """Round the coordinates to the bytes that those of whole windows are."""
    cython.declare(j=cython.Py_ssize_t, v=cython.double)
    for j in range(terms.value.shape[0]):
        v = 0
        if j < components.z.shape[0]:
            v = components.factor * components.z[j] + components.origin[j]
        terms.value[j] = cython.cast(cython.short, 0 if v < 0 else (255 if v > 255 else v))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest_leaves(leaves: Leaves, terms: Terms) -> cython.Py_ssize_t:
    """Fill `leaves.near` with the leaves whose means are nearest; return their number."""
    cython.declare(b=cython.Py_ssize_t, j=cython.Py_ssize_t, count=cython.Py_ssize_t)
    count = 0
    b = 0
    while b < leaves.sizes.shape[0]:
        memset(cython.address(leaves.lower[0]), 0, BLOCK_WINDOWS * 2)
        bounds(
            cython.address(leaves.middles[b]), terms, 0, terms.at.shape[0],
            cython.address(leaves.lower[0]),
        )  # fmt: skip
        for j in range(min(BLOCK_WINDOWS, leaves.sizes.shape[0] - b)):
            count = offer(
                (cython.cast(cython.longlong, leaves.lower[j]) << 32) | (b + j),
                cython.cast(cython.int, b + j), count, leaves.near.shape[0],
                cython.address(leaves.keys[0]), cython.address(leaves.near[0]),
            )  # fmt: skip
        b += BLOCK_WINDOWS
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def nearest_windows(
    leaves: Leaves,
    visited: cython.Py_ssize_t,
    terms: Terms,
    found: Found,
    wanted: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Find the `wanted` windows with the nearest coordinates in those leaves."""
    cython.declare(b=cython.Py_ssize_t, j=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(count=cython.Py_ssize_t, worst=cython.longlong, place=cython.int)
    cython.declare(least=cython.ushort)
    count = 0
    worst = 65535
    for k in range(visited):
        b = leaves.near[k]
        memset(cython.address(leaves.lower[0]), 0, BLOCK_WINDOWS * 2)
        least = bounds(
            cython.address(leaves.planes[b * BLOCK_WINDOWS]), terms, 0, terms.at.shape[0],
            cython.address(leaves.lower[0]),
        )  # fmt: skip
        if least > worst:
            continue
        for j in range(leaves.sizes[b]):
            if leaves.lower[j] <= worst:
                place = leaves.places[b * BLOCK_WINDOWS + j]
                count = offer(
                    (cython.cast(cython.longlong, leaves.lower[j]) << 32) | place, place, count,
                    wanted, cython.address(leaves.keys[0]), cython.address(found.places[0]),
                )  # fmt: skip
                if count == wanted:
                    worst = leaves.keys[0] >> 32
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compare(
    sample: Sample, query: Query, found: Found, count: cython.Py_ssize_t, tolerance: cython.double
) -> cython.longlong:
    """Distances of the windows found, those past the limit not in full; return the limit."""
    cython.declare(j=cython.Py_ssize_t)
    cython.declare(d=cython.longlong, best=cython.longlong, limit=cython.longlong)
    best = -1
    limit = -1
    for j in range(count - 1, -1, -1):  # the coherent ones first: they limit the others
        if found.places[j] < 0:
            continue
        d = window_distance(sample, found.places[j], query, limit)
        if best < 0 or d < best:
            best = d
            limit = limit_of(best, tolerance)
        found.distances[j] = d
    return limit


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def sort_similar(
    found: Found, count: cython.Py_ssize_t, limit: cython.longlong
) -> cython.Py_ssize_t:
    """Keep the windows within the limit, in scan order as in a full search."""
    cython.declare(j=cython.Py_ssize_t, k=cython.Py_ssize_t, kept=cython.Py_ssize_t)
    cython.declare(place=cython.int, d=cython.longlong)
    kept = 0
    for j in range(count):
        if found.places[j] < 0 or found.distances[j] > limit:
            continue
        place = found.places[j]
        d = found.distances[j]
        k = kept
        while k > 0 and found.places[k - 1] > place:
            found.places[k] = found.places[k - 1]
            found.distances[k] = found.distances[k - 1]
            k -= 1
        found.places[k] = place
        found.distances[k] = d
        kept += 1
    return kept


def search_half_known(
    sample: Sample,
    components: Components,
    leaves: Leaves,
    wanted: cython.Py_ssize_t,
    picture: Picture,
    choices: Choices,
    query: Query,
    found: Found,
):
    """As `search_full`, among the `wanted` windows with the nearest coordinates.

    The windows where neighbors' sources go on are compared too.
    """
    cython.declare(i=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(count=cython.Py_ssize_t, limit=cython.longlong)
    cython.declare(terms=Terms, middle_terms=Terms)
    terms = leaves.terms
    middle_terms = leaves.middle_terms
    with cython.nogil:
        for i in range(choices.places.shape[0]):
            y = choices.places[i] // picture.done.shape[1]
            x = choices.places[i] % picture.done.shape[1]
            choices.weights[i] = look(picture, sample, y, x, query)
            estimate(sample, query, components)
            as_bytes(components, terms)
            count = nearest_leaves(leaves, middle_terms)
            count = nearest_windows(leaves, count, terms, found, wanted)
            count = coherent_windows(picture, sample, y, x, query, found, count)
            limit = compare(sample, query, found, count, choices.tolerance)
            count = sort_similar(found, count, limit)
            choose_one(choices, i, found, count, limit)


def coordinates(sample: Sample, query: Query, components: Components):
    """`estimate`."""
    estimate(sample, query, components)
