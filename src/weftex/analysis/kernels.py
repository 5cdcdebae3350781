# mypy: ignore-errors
"""Kernels of correlations, their peaks and lines; compiled by Cython, see setup.py.

Sums are taken in one order, without fused products, so they are the same on every machine.
"""

import cython
from cython.cimports.libc.math import rint, sqrt


def overlap_sums(
    level: cython.const[cython.double][:, ::1],
    rows: cython.const[cython.longlong][:, ::1],
    columns: cython.const[cython.longlong][:, ::1],
    down: cython.double[:, :, ::1],
    along: cython.double[:, ::1],
    sums: cython.double[:, ::1],
    squares: cython.double[:, ::1],
) -> cython.double:
    """Add up values and their squares over what overlaps at each shift."""
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(j=cython.Py_ssize_t, one=cython.double, first=cython.Py_ssize_t)
    cython.declare(last=cython.Py_ssize_t, most=cython.double)
    width: cython.Py_ssize_t = level.shape[1]
    most = 0
    with cython.nogil:
        for x in range(width):
            down[0, 0, x] = 0
            down[1, 0, x] = 0
        for y in range(level.shape[0]):
            for x in range(width):
                one = level[y, x]
                down[0, y + 1, x] = down[0, y, x] + one
                down[1, y + 1, x] = down[1, y, x] + one * one
        along[0, 0] = 0
        along[1, 0] = 0
        for i in range(rows.shape[0]):
            first = rows[i, 0]
            last = rows[i, 1]
            for x in range(width):
                along[0, x + 1] = along[0, x] + (down[0, last, x] - down[0, first, x])
                along[1, x + 1] = along[1, x] + (down[1, last, x] - down[1, first, x])
            for j in range(columns.shape[0]):
                sums[i, j] = along[0, columns[j, 1]] - along[0, columns[j, 0]]
                squares[i, j] = along[1, columns[j, 1]] - along[1, columns[j, 0]]
                most = max(most, squares[i, j])
    return most


def add_channel(
    sums: cython.const[cython.double][:, ::1],
    squares: cython.double[:, ::1],
    high: cython.const[cython.double][::1],
    wide: cython.const[cython.double][::1],
    least: cython.double,
    above: cython.double[:, ::1],
    below: cython.double[:, ::1],
):
    """Add what a channel has of the numerator, but for its products, and of the denominator."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, count=cython.double)
    cython.declare(one=cython.double)
    rows: cython.Py_ssize_t = sums.shape[0]
    columns: cython.Py_ssize_t = sums.shape[1]
    with cython.nogil:
        for i in range(rows):
            for j in range(columns):
                count = high[i] * wide[j]
                one = count * squares[i, j] - sums[i, j] * sums[i, j]
                squares[i, j] = one if one > least * count else 0
        for i in range(rows):
            for j in range(columns):
                above[i, j] -= sums[i, j] * sums[rows - 1 - i, columns - 1 - j]
                below[i, j] += sqrt(squares[i, j] * squares[rows - 1 - i, columns - 1 - j])


def divide(
    above: cython.double[:, ::1],
    below: cython.const[cython.double][:, ::1],
    high: cython.const[cython.double][::1],
    wide: cython.const[cython.double][::1],
    products: cython.const[cython.double][:, ::1],
):
    """Turn numerators without their products into coefficients from -1 to 1."""
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, y=cython.Py_ssize_t)
    cython.declare(x=cython.Py_ssize_t, one=cython.double)
    middle: cython.Py_ssize_t = above.shape[0] // 2
    center: cython.Py_ssize_t = above.shape[1] // 2
    with cython.nogil:
        for i in range(above.shape[0]):
            y = i - middle if i >= middle else products.shape[0] + i - middle
            for j in range(above.shape[1]):
                x = j - center if j >= center else products.shape[1] + j - center
                one = 0
                if below[i, j] > 0:
                    one = (above[i, j] + high[i] * wide[j] * products[y, x]) / below[i, j]
                above[i, j] = min(max(one, -1), 1)


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
    """Average along lines of some directions, at the given distances from the middle."""
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
