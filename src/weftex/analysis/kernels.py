# mypy: ignore-errors
"""Kernels of peaks of correlations and of sums along lines; compiled by Cython, see setup.py.

Sums are taken in one order, without fused products, so they are the same on every machine.
"""

import cython
from cython.cimports.libc.math import rint


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def offset(before: cython.double, top: cython.double, after: cython.double) -> cython.double:
    """Where a parabola through three values is highest, from -1/2 to 1/2."""
    return min(max(0.5 * (before - after) / min(before - 2 * top + after, -1e-12), -0.5), 0.5)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def inside(at: cython.Py_ssize_t, side: cython.Py_ssize_t) -> cython.Py_ssize_t:
    return min(max(at, 0), side - 1)


def tops(
    correlation: cython.const[cython.double][:, ::1],
    places: cython.const[cython.longlong][:, ::1],
    window: cython.Py_ssize_t,
    found: cython.double[:, ::1],
    heights: cython.double[::1],
):
    """Find the peak within a window around each shift, below a pixel."""
    cython.declare(i=cython.Py_ssize_t, v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, b=cython.Py_ssize_t)
    cython.declare(a=cython.Py_ssize_t, top=cython.double, left=cython.double)
    cython.declare(right=cython.double, above=cython.double, below=cython.double)
    rows: cython.Py_ssize_t = correlation.shape[0]
    columns: cython.Py_ssize_t = correlation.shape[1]
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i, 1] + rows // 2
            x = places[i, 0] + columns // 2
            b = y - window
            a = x - window
            top = correlation[inside(b, rows), inside(a, columns)]
            for v in range(y - window, y + window + 1):
                for u in range(x - window, x + window + 1):
                    if correlation[inside(v, rows), inside(u, columns)] > top:
                        top = correlation[inside(v, rows), inside(u, columns)]
                        b = v
                        a = u
            left = correlation[inside(b, rows), inside(a - 1, columns)]
            right = correlation[inside(b, rows), inside(a + 1, columns)]
            above = correlation[inside(b - 1, rows), inside(a, columns)]
            below = correlation[inside(b + 1, rows), inside(a, columns)]
            found[i, 0] = a - columns // 2 + offset(left, top, right)
            found[i, 1] = b - rows // 2 + offset(above, top, below)
            heights[i] = 0
            if top >= max(left, right) and top >= max(above, below) and top > 0:
                heights[i] = top


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def place(at: cython.double, side: cython.Py_ssize_t) -> cython.Py_ssize_t:
    """The pixel at a distance from the middle of a side, or the last one."""
    return min(max(cython.cast(cython.Py_ssize_t, rint(at)) + side // 2, 0), side - 1)


def means_along(
    values: cython.const[cython.double][:, ::1],
    cosines: cython.const[cython.double][::1],
    sines: cython.const[cython.double][::1],
    far: cython.const[cython.double][::1],
    along: cython.const[cython.double][::1],
    out: cython.double[:, ::1],
):
    """Average along lines of some directions, each so many pixels from the middle."""
    cython.declare(k=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(c=cython.double, s=cython.double, x=cython.double, y=cython.double)
    height: cython.Py_ssize_t = values.shape[0]
    width: cython.Py_ssize_t = values.shape[1]
    number: cython.double = along.shape[0]
    with cython.nogil:
        for k in range(out.shape[0]):
            c = cosines[k]
            s = sines[k]
            for j in range(out.shape[1]):
                out[k, j] = 0
            for i in range(along.shape[0]):
                x = along[i] * far[k] * c
                y = along[i] * far[k] * s
                for j in range(out.shape[1]):
                    out[k, j] += values[place(y + j * c, height), place(x - j * s, width)]
            for j in range(out.shape[1]):
                out[k, j] /= number


def edges_along(
    parts: cython.const[cython.double][:, :, ::1],
    inner: cython.const[cython.uchar][:, ::1],
    direction: cython.const[cython.double][::1],
    down: cython.const[cython.double][:, ::1],
    across: cython.const[cython.double][:, ::1],
    sums: cython.double[:, ::1],
    counts: cython.longlong[:, ::1],
):
    """Add up edges along lines of a direction, apart in strips across them."""
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, line=cython.int, strip=cython.int)
    cython.declare(edge=cython.double)
    with cython.nogil:
        for y in range(inner.shape[0]):
            for x in range(inner.shape[1]):
                line = cython.cast(cython.int, down[0, y] + across[0, x])
                strip = cython.cast(cython.int, (down[1, y] + across[1, x]) * direction[3])
                if (
                    not inner[y, x]
                    or line < 0
                    or strip < 0
                    or line >= sums.shape[1]
                    or strip >= sums.shape[0]
                ):
                    continue
                edge = direction[0] * parts[0, y, x] - direction[1] * parts[1, y, x]
                sums[strip, line] += edge + direction[2] * parts[2, y, x]
                counts[strip, line] += 1


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def between(values: cython.const[cython.double][::1], at: cython.double) -> cython.double:
    """The value at a place from 0 on, in a line between two; beyond the last it is the last."""
    k: cython.Py_ssize_t = cython.cast(cython.Py_ssize_t, at)
    if k >= values.shape[0] - 1:
        return values[values.shape[0] - 1]
    return (values[k + 1] - values[k]) * (at - k) + values[k]


def stand_out(
    profile: cython.const[cython.double][::1],
    distances: cython.const[cython.double][::1],
    phases: cython.const[cython.double][::1],
    reach: cython.double,
    most: cython.Py_ssize_t,
    least: cython.double,
    out: cython.double[::1],
    counts: cython.longlong[::1],
):
    """Say how high multiples of distances are above places between them."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, t=cython.Py_ssize_t)
    cython.declare(total=cython.double, height=cython.double, highest=cython.double)
    cython.declare(weight=cython.double, own=cython.double, d=cython.double)
    size: cython.double = profile.shape[0]
    with cython.nogil:
        for i in range(distances.shape[0]):
            d = distances[i]
            counts[i] = cython.cast(cython.longlong, reach * size / d)
            counts[i] = min(max(counts[i], 1), most)
            total = own = highest = 0
            for t in range(1, counts[i] + 1):
                total += max(1 - t * d / size, least)
            for k in range(phases.shape[0]):
                height = 0
                for t in range(1, counts[i] + 1):
                    weight = max(1 - t * d / size, least) / total
                    height += between(profile, (t - phases[k]) * d) * weight
                if k == 0:
                    own = height
                else:
                    highest = max(highest, height) if k > 1 else height
            out[i] = own - highest
