# mypy: ignore-errors
"""Kernels that compare what is known around a pixel with weights; compiled by Cython, see setup.py.

The distance is a sum of w d**2 over known pixels, w from 1 to 127, in integers. What is known lies
in rows as long as the window, with the weight 0 where nothing is known, so that no loop has holes.
Types are in the .pxd.
"""

import cython
from cython.cimports.libc.string import memset
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.window_kernels import known_runs


class Sample:
    """The windows of a sample and the weights of their pixels."""

    def __init__(self, flat, windows, weights, stride):
        self.flat = flat
        self.usable = windows.usable
        self.period = windows.period
        self.weights = weights
        self.stride = stride
        self.width = windows.pixels.shape[1]
        self.channels = windows.pixels.shape[2]
        self.reach = len(weights) // 2


class Picture:
    """The output so far, and where its pixels come from."""

    def __init__(self, pixels, done, source, wrap):
        self.pixels = pixels
        self.done = done
        self.source = source
        self.wrap_y, self.wrap_x = wrap


class Query:
    """Scratch: what is known of the window around a pixel."""

    def __init__(self, runs, values, weights, rows):
        self.runs = runs
        self.values = values
        self.weights = weights
        self.rows = rows


class Found:
    """Scratch: windows that were compared, and their distances."""

    def __init__(self, places, distances):
        self.places = places
        self.distances = distances


class Choices:
    """Pixels to choose, their random bits, and room for what is chosen."""

    def __init__(self, places, bits, tolerance, chosen, distances, weights):
        self.places = places
        self.bits = bits
        self.tolerance = tolerance
        self.chosen = chosen
        self.distances = distances
        self.weights = weights


def look(picture, sample, y, x, query):
    """Copy what is known around a pixel of the picture, with its weights; return their sum."""
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, reach=cython.Py_ssize_t)
    cython.declare(n=cython.Py_ssize_t, r=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(k=cython.Py_ssize_t, cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    cython.declare(row=cython.Py_ssize_t, column=cython.Py_ssize_t, at=cython.Py_ssize_t)
    cython.declare(first=cython.Py_ssize_t, last=cython.Py_ssize_t, count=cython.int)
    cython.declare(total=cython.longlong, weight=cython.short)
    height = picture.done.shape[0]
    width = picture.done.shape[1]
    reach = sample.reach
    n = known_runs(
        picture.done, y, x, picture.wrap_y, picture.wrap_x, reach, reach, reach, reach, query.runs
    )
    total = 0
    memset(
        cython.address(query.weights[0]), 0,
        cython.cast(cython.size_t, query.weights.shape[0]) * 2,
    )  # fmt: skip
    for r in range(n):
        row = query.runs[r, 0] + reach
        column = query.runs[r, 1] + reach
        cy = y + query.runs[r, 0]
        cy = cy + height if cy < 0 else (cy - height if cy >= height else cy)
        cx = x + query.runs[r, 1]
        cx = cx + width if cx < 0 else (cx - width if cx >= width else cx)
        at = row * sample.stride + column * sample.channels
        for i in range(query.runs[r, 2]):
            weight = sample.weights[row, column + i]
            total += weight
            for k in range(sample.channels):
                query.values[at] = picture.pixels[cy, cx, k]
                query.weights[at] = weight
                at += 1
            cx = cx + 1 if cx + 1 < width else 0
    # The runs are sorted by row: take them from the middle outwards.
    count = 0
    last = 0
    while last < n and query.runs[last, 0] < 0:
        last += 1
    first = last - 1
    while first >= 0 or last < n:
        if last < n and (first < 0 or query.runs[last, 0] <= -query.runs[first, 0]):
            r = last
            last += 1
        else:
            r = first
            first -= 1
        row = query.runs[r, 0] + reach
        if count == 0 or query.rows[count] != row:
            count += 1
            query.rows[count] = cython.cast(cython.int, row)
    query.rows[0] = count
    return total


def coherent_windows(picture, sample, y, x, query, found, count):
    """Add the windows where the sources of the 8 neighbors go on; return the number with those."""
    cython.declare(n=cython.Py_ssize_t, near=cython.Py_ssize_t)
    near = 1 if sample.reach > 0 else 0
    n = known_runs(
        picture.done, y, x, picture.wrap_y, picture.wrap_x, near, near, near, near, query.runs
    )
    return coherent_places(
        picture.source, y, x, query.runs, n, sample.usable, sample.period, found.places, count
    )


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def weighted(
    a: cython.p_const_uchar, b: cython.p_const_uchar, w: cython.p_const_short, n: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of w d**2 of two rows of bytes."""
    cython.declare(i=cython.Py_ssize_t, start=cython.Py_ssize_t, stop=cython.Py_ssize_t)
    cython.declare(d=cython.short, e=cython.short, part=cython.int, total=cython.longlong)
    total = 0
    start = 0
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


def window_distance(sample, place, query, bound):
    """Distance to the window at a flat index; stops past `bound` (negative: never)."""
    cython.declare(r=cython.Py_ssize_t, row=cython.Py_ssize_t, total=cython.longlong)
    cython.declare(corner=cython.Py_ssize_t)
    total = 0
    corner = place - sample.reach * sample.width - sample.reach
    for r in range(1, query.rows[0] + 1):
        row = query.rows[r]
        total += weighted(
            cython.address(sample.flat[(corner + row * sample.width) * sample.channels]),
            cython.address(query.values[row * sample.stride]),
            cython.address(query.weights[row * sample.stride]),
            sample.stride,
        )
        if total > bound and bound >= 0:
            break
    return total


def limit_of(best, tolerance):
    """The largest distance within (1 + tolerance) of the best."""
    return cython.cast(cython.longlong, cython.cast(cython.double, best) * (1 + tolerance))


def choose_one(choices, i, found, count, limit):
    """Choose for pixel i one of the windows found within the limit, each as likely."""
    cython.declare(j=cython.Py_ssize_t, kept=cython.Py_ssize_t)
    kept = 0
    for j in range(count):
        if found.distances[j] <= limit:
            found.places[kept] = found.places[j]
            found.distances[kept] = found.distances[j]
            kept += 1
    j = cython.cast(
        cython.Py_ssize_t, ((choices.bits[i] >> 32) * cython.cast(cython.ulonglong, kept)) >> 32
    )
    choices.chosen[i] = found.places[j]
    choices.distances[i] = found.distances[j]
