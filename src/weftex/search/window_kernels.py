# mypy: ignore-errors
"""Kernels that compare the windows around two pixels; compiled by Cython, see setup.py.

A window is a list of runs (dy, dx, length): stretches of a row, seen from its center. All
distances are sums of squared differences of bytes, so any order of summation gives the same.
Types are declared in window_kernels.pxd.
"""

import cython
from cython.cimports.libc.string import memcpy
from cython.cimports.weftex.raster.difference_kernels import squared


class Sample:
    """The windows of a sample, see `weftex.search.windows.Windows`."""

    def __init__(self, pixels, usable, period):
        self.pixels, self.usable, self.period = pixels, usable, period


class Picture:
    """The picture while it is made.

    `done` is 1 where a pixel is known or made, `source` its flat index into the sample's pixels or
    -1, `wrap` whether the vertical and the horizontal axis wrap.
    """

    def __init__(self, pixels, done, source, wrap):
        self.pixels, self.done, self.source = pixels, done, source
        self.wrap_y, self.wrap_x = wrap


class Query:
    """Room for the known part of the window around a pixel."""

    def __init__(self, runs, values):
        self.runs, self.values, self.count = runs, values, 0


def causal_runs(y, x, height, width, wrap_x, up, left, right, runs):
    """Write the L-shaped window of a pixel on the canvas in scan order; return the number of runs.

    Where the canvas wraps along x the rows above are whole, and the end of a row includes its
    beginning. No pixel occurs twice.
    """
    cython.declare(n=cython.Py_ssize_t, dy=cython.Py_ssize_t)
    cython.declare(first=cython.Py_ssize_t, last=cython.Py_ssize_t)
    n = 0
    for dy in range(-up if up < y else -y, 1):
        first = -left
        last = right if dy < 0 else -1
        if wrap_x and dy < 0:
            if last - first + 1 > width:
                first = -((width - 1) // 2) if left > (width - 1) // 2 else -left
                last = first + width - 1
        else:
            if first < -x:
                first = -x
            if last > width - 1 - x:
                last = width - 1 - x
        if first <= last:
            runs[n, 0] = cython.cast(cython.int, dy)
            runs[n, 1] = cython.cast(cython.int, first)
            runs[n, 2] = cython.cast(cython.int, last - first + 1)
            n += 1
    if wrap_x:
        first = width - x
        last = width - 1 - (left if left < x else x)
        if last > right:
            last = right
        if x > 0 and first <= last:
            runs[n, 0] = 0
            runs[n, 1] = cython.cast(cython.int, first)
            runs[n, 2] = cython.cast(cython.int, last - first + 1)
            n += 1
    return n


def turn_runs(runs, n):
    """Put the last run first, so that comparisons begin beside the pixel and end sooner."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, swapped=cython.int)
    for i in range(n // 2):
        for k in range(3):
            swapped = runs[i, k]
            runs[i, k] = runs[n - 1 - i, k]
            runs[n - 1 - i, k] = swapped


def known_runs(done, y, x, wrap_y, wrap_x, reach, runs):
    """Write the known part of the square window around a pixel; return the number of runs.

    The pixel itself is left out, and no pixel occurs twice on a wrapped axis shorter than the
    window.
    """
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, n=cython.Py_ssize_t)
    cython.declare(dy=cython.Py_ssize_t, dx=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    cython.declare(running=cython.bint, known=cython.bint)
    cython.declare(up=cython.Py_ssize_t, down=cython.Py_ssize_t)
    cython.declare(left=cython.Py_ssize_t, right=cython.Py_ssize_t)
    height, width = done.shape[0], done.shape[1]
    n = 0
    up = min(reach, (height - 1) // 2 if wrap_y else y)
    down = min(reach, height // 2 if wrap_y else height - 1 - y)
    left = min(reach, (width - 1) // 2 if wrap_x else x)
    right = min(reach, width // 2 if wrap_x else width - 1 - x)
    cy = (y - up + height) % height
    for dy in range(-up, down + 1):
        running = False
        cx = (x - left + width) % width
        for dx in range(-left, right + 1):
            known = done[cy, cx] != 0 and (dy != 0 or dx != 0)
            if known:
                if running:
                    runs[n - 1, 2] += 1
                else:
                    runs[n, 0] = cython.cast(cython.int, dy)
                    runs[n, 1] = cython.cast(cython.int, dx)
                    runs[n, 2] = 1
                    n += 1
            running = known
            cx = cx + 1 if cx + 1 < width else 0
        cy = cy + 1 if cy + 1 < height else 0
    return n


def gather_runs(levels, y, x, runs, n, query):
    """Copy the bytes of a window of the canvas, around its borders; return their number."""
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, channels=cython.Py_ssize_t)
    cython.declare(r=cython.Py_ssize_t, cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    cython.declare(left=cython.Py_ssize_t, part=cython.Py_ssize_t, at=cython.Py_ssize_t)
    height, width, channels = levels.shape[0], levels.shape[1], levels.shape[2]
    at = 0
    for r in range(n):
        cy = y + runs[r, 0]
        if cy < 0:
            cy += height
        elif cy >= height:
            cy -= height
        cx = x + runs[r, 1]
        if cx < 0:
            cx += width
        elif cx >= width:
            cx -= width
        left = runs[r, 2]
        while left > 0:
            part = left if left < width - cx else width - cx
            memcpy(
                cython.address(query[at]),
                cython.address(levels[cy, cx, 0]),
                cython.cast(cython.size_t, part * channels),
            )
            at += part * channels
            left -= part
            cx = 0
    return at


def run_distance(pixels, y, x, runs, n, query, bound):
    """Return the sum of squared differences to the window of the sample at (y, x).

    Stops past `bound` unless that is negative. Rows nearest to the pixel differ most in a causal
    window, so they are compared first.
    """
    cython.declare(channels=cython.Py_ssize_t, r=cython.Py_ssize_t, length=cython.Py_ssize_t)
    cython.declare(at=cython.Py_ssize_t, total=cython.longlong)
    channels = pixels.shape[2]
    at = 0
    total = 0
    for r in range(n):
        at += runs[r, 2] * channels
    for r in range(n - 1, -1, -1):
        length = runs[r, 2] * channels
        at -= length
        total += squared(
            cython.address(pixels[y + runs[r, 0], x + runs[r, 1], 0]),
            cython.address(query[at]),
            length,
        )
        if total > bound and bound >= 0:
            break
    return total


def usable_place(usable, period, y, x):
    """Return the flat index of the window centered at (y, x), or -1 if none is usable there.

    A place outside of a tileable sample wraps around.
    """
    if period[2]:
        y = (y - period[0]) % period[2]
        x = (x - period[1]) % period[3]
        y = y + period[0] if y >= 0 else y + period[0] + period[2]
        x = x + period[1] if x >= 0 else x + period[1] + period[3]
    elif y < 0 or x < 0 or y >= usable.shape[0] or x >= usable.shape[1]:
        return -1
    return y * usable.shape[1] + x if usable[y, x] else -1


def copy_pixel(sample, place, pixels, source, y, x):
    """Copy the sample's pixel at a flat index to the pixel (y, x) of a canvas."""
    cython.declare(k=cython.Py_ssize_t, v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    v, u = place // sample.shape[1], place % sample.shape[1]
    source[y, x] = cython.cast(cython.int, place)
    for k in range(sample.shape[2]):
        pixels[y, x, k] = sample[v, u, k]


def coherent_places(picture, sample, y, x, query, places, count):
    """List the continued sources of (y, x)'s neighbors after `count` places; return the length.

    Neighbors are the pixels of the query's runs, last run first; each place is listed once, and -1
    once for all unusable ones. Runs reach no further along x than windows, so no row is left.
    """
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, across=cython.Py_ssize_t)
    cython.declare(size=cython.Py_ssize_t, may=cython.p_const_uchar, before=cython.Py_ssize_t)
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, dx=cython.Py_ssize_t)
    cython.declare(own=cython.Py_ssize_t, at=cython.Py_ssize_t)
    height, width = picture.source.shape[0], picture.source.shape[1]
    across = sample.usable.shape[1]
    size = sample.usable.shape[0] * across
    may = cython.address(sample.usable[0, 0])
    before = -1 - size
    for r in range(query.count - 1, -1, -1):
        cy = y + query.runs[r, 0]
        if cy < 0:
            cy += height
        elif cy >= height:
            cy -= height
        for i in range(query.runs[r, 2] - 1, -1, -1):
            dx = query.runs[r, 1] + i
            cx = x + dx
            if cx < 0:
                cx += width
            elif cx >= width:
                cx -= width
            own = picture.source[cy, cx]
            at = own - query.runs[r, 0] * across - dx
            if own < 0 or at == before:
                continue
            before = at
            if at < 0 or at >= size or not may[at]:
                at = -1
                if sample.period[2]:
                    at = usable_place(
                        sample.usable,
                        sample.period,
                        own // across - query.runs[r, 0],
                        own % across - dx,
                    )
            k = 0
            while k < count and places[k] != at:
                k += 1
            if k == count:
                places[count] = cython.cast(cython.int, at)
                count += 1
    return count


def runs_of(done, y, x, wrap, reach, runs, causal=False):
    """`causal_runs` or `known_runs`; returns their number."""
    d: cython.const[cython.uchar][:, ::1] = done
    out: cython.int[:, ::1] = runs
    if causal:
        return causal_runs(y, x, d.shape[0], d.shape[1], wrap[1], reach[0], reach[2], reach[3], out)
    return known_runs(d, y, x, wrap[0], wrap[1], reach[0], out)


def compare(levels, y, x, pixels, places, runs, n, query, bound=-1):
    """Distances of the window at (y, x) of the canvas to those at `places` of the sample."""
    a: cython.const[cython.uchar][:, :, ::1] = levels
    b: cython.const[cython.uchar][:, :, ::1] = pixels
    r: cython.const[cython.int][:, ::1] = runs
    q: cython.uchar[::1] = query
    gather_runs(a, y, x, r, n, q)
    return [run_distance(b, v, u, r, n, q, bound) for v, u in places]


def distances(levels, y, x, pixels, centers, runs, n, query, out):
    """Fill `out` with the distances of the window at (y, x) to those at `centers`, without a bound.

    This is the minimum cost of an exhaustive search, against which searches are measured.
    """
    a: cython.const[cython.uchar][:, :, ::1] = levels
    b: cython.const[cython.uchar][:, :, ::1] = pixels
    c: cython.const[cython.int][::1] = centers
    r: cython.const[cython.int][:, ::1] = runs
    q: cython.uchar[::1] = query
    o: cython.longlong[::1] = out
    cython.declare(i=cython.Py_ssize_t, count=cython.Py_ssize_t, width=cython.Py_ssize_t)
    count, width = n, b.shape[1]
    gather_runs(a, y, x, r, n, q)
    with cython.nogil:
        for i in range(c.shape[0]):
            o[i] = run_distance(b, c[i] // width, c[i] % width, r, count, q, -1)


def place_at(usable, period, y, x):
    """`usable_place`."""
    u: cython.const[cython.uchar][:, ::1] = usable
    p: cython.const[cython.int][::1] = period
    return usable_place(u, p, y, x)


def places_at(picture: Picture, sample: Sample, y, x, query: Query, n, places):
    """`coherent_places` for the first `n` runs of a query; returns their number."""
    out: cython.int[::1] = places
    query.count = n
    return coherent_places(picture, sample, y, x, query, out, 0)
