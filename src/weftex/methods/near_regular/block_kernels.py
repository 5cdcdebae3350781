# mypy: ignore-errors
"""Kernels of near-regular synthesis: the source window of each block; compiled, see setup.py.

A source is the flat index of a window's upper left corner in the sample's pixels. `sources` has one
for each block of the layout, -1 where there is none yet. A row of `blocks` describes a block:

    its index in `sources`, its phase y and x, its height and width, the offset to try first, and
    the source that it gets if no window fits;

a row of `near` describes a block beside it: its index or -1, and how far it is away, y and x.
Phases (eq. 3.29) and offsets, sums of multiples of the lattice vectors, are in 1/65536 pixel.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.repeats.overlap_kernels import repeated_pixels
from cython.cimports.weftex.search.zone_kernels import (
    Shortlist,
    ZoneWindows,
    distance,
    gather,
    list_candidates,
    offer,
)

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any mismatch
HALF = cython.declare(cython.longlong, 1 << 15)  # a pixel, in 1/65536
MOST_DRAWN = cython.declare(cython.Py_ssize_t, 256)  # windows that a drawn block tries
KNOWN = cython.declare(cython.int, 5)  # the wedge of pixels that the canvas knows


@cython.cclass
class GapSearch(Shortlist):
    """The sample, the border of gaps of one size, how windows are compared with it, and scratch.

    `wedges` tells from which neighbor each pixel comes, or that `border` has it already; `runs`
    cover the border. `variety` is in 1/256. `windows`, if any, list the candidates.
    """

    pixels: cython.const[cython.uchar][:, :, ::1]
    turned: cython.const[cython.uchar][:, :, ::1]  # with its axes exchanged
    usable: cython.const[cython.uchar][:, ::1]
    period: cython.const[cython.int][::1]
    wedges: cython.const[cython.uchar][:, ::1]
    runs: cython.const[cython.int][:, ::1]
    border: cython.uchar[:, :, ::1]
    tolerance: cython.Py_ssize_t
    most: cython.Py_ssize_t  # windows to compare
    variety: cython.longlong
    by_correlation: cython.bint
    by_zone: cython.bint
    windows: ZoneWindows
    # Of the gap in hand: its size, and the neighbors above, left, below and right.
    height: cython.longlong
    width: cython.longlong
    other: cython.int[4]
    dy: cython.longlong[4]
    dx: cython.longlong[4]

    def __init__(
        self, sample, border, tolerance, most, variety, by_correlation, windows, **shortlist
    ):
        Shortlist.__init__(self, **shortlist)
        self.pixels, self.turned, self.usable, self.period = sample
        self.wedges, self.runs, self.border = border
        self.tolerance, self.most, self.variety = tolerance, most, variety
        self.by_correlation, self.by_zone = by_correlation, windows is not None
        self.windows = windows


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def source_at(
    usable: cython.const[cython.uchar][:, ::1], period: cython.const[cython.int][::1],
    y: cython.longlong, x: cython.longlong,
) -> cython.int:  # fmt: skip
    """The source at (y, x), wrapped where the sample tiles; -1 if no whole window lies there."""
    if period[2]:
        y = y % period[2]
        x = x % period[3]
        y = y + period[2] if y < 0 else y
        x = x + period[3] if x < 0 else x
    if y < 0 or x < 0 or y >= usable.shape[0] or x >= usable.shape[1] or not usable[y, x]:
        return -1
    return cython.cast(cython.int, y * usable.shape[1] + x)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def similar(
    usable: cython.const[cython.uchar][:, ::1], period: cython.const[cython.int][::1],
    offsets: cython.const[cython.longlong][:, ::1], k: cython.Py_ssize_t,
    blocks: cython.const[cython.longlong][:, ::1], n: cython.Py_ssize_t,
) -> cython.int:  # fmt: skip
    """The window that is similar to block n by the k-th offset (eq. 4.3, Fig. 4.7b), or -1."""
    return source_at(
        usable, period,
        (blocks[n, 1] + offsets[k, 0] + HALF) >> 16,
        (blocks[n, 2] + offsets[k, 1] + HALF) >> 16,
    )  # fmt: skip


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def common_pixels(
    here: cython.int, other: cython.int, dy: cython.longlong, dx: cython.longlong,
    height: cython.longlong, width: cython.longlong, columns: cython.Py_ssize_t,
) -> cython.longlong:  # fmt: skip
    """The number of pixels that a block from `here` repeats of one (dy, dx) away."""
    if other < 0:
        return 0
    y: cython.longlong = here // columns - other // columns
    x: cython.longlong = here % columns - other % columns
    return max(0, repeated_pixels(y, x, dy, dx, height, width))  # continuing repeats nothing


def draw_blocks(
    usable: cython.const[cython.uchar][:, ::1], period: cython.const[cython.int][::1],
    offsets: cython.const[cython.longlong][:, ::1],
    stride: cython.Py_ssize_t,
    blocks: cython.const[cython.longlong][:, ::1],
    near: cython.const[cython.longlong][:, :, ::1],
    sources: cython.int[::1],
):  # fmt: skip
    """Draw a source for each block among the windows similar to it (section 4.2.1).

    Every `stride`-th offset is tried until a window repeats at most an eighth of a block of what
    is near; else the window that repeats least is taken.
    """
    cython.declare(n=cython.Py_ssize_t, t=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(m=cython.Py_ssize_t, tried=cython.Py_ssize_t)
    cython.declare(here=cython.int, best=cython.int)
    cython.declare(height=cython.longlong, width=cython.longlong)
    cython.declare(repeated=cython.longlong, least=cython.longlong)
    count: cython.Py_ssize_t = offsets.shape[0]
    with cython.nogil:
        for n in range(blocks.shape[0]):
            height = blocks[n, 3]
            width = blocks[n, 4]
            k = blocks[n, 5]
            best = cython.cast(cython.int, blocks[n, 6])
            least = NEVER
            tried = 0
            for t in range(count):
                here = similar(usable, period, offsets, k, blocks, n)
                k = (k + stride) % count
                if here < 0:
                    continue
                repeated = 0
                for m in range(near.shape[1]):
                    if near[n, m, 0] >= 0:
                        repeated += common_pixels(
                            here, sources[near[n, m, 0]], near[n, m, 1], near[n, m, 2],
                            height, width, usable.shape[1],
                        )  # fmt: skip
                if repeated < least:
                    least = repeated
                    best = here
                tried += 1
                if 8 * least <= height * width or tried >= MOST_DRAWN:
                    break
            sources[blocks[n, 0]] = best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def correlation(gap: GapSearch, y: cython.Py_ssize_t, x: cython.Py_ssize_t) -> cython.longlong:
    """2**40 (1 - gamma) by eq. (3.13) of the border and the window at (y, x)."""
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(at=cython.Py_ssize_t, f=cython.longlong, g=cython.longlong)
    cython.declare(row=cython.p_const_uchar)
    channels: cython.Py_ssize_t = gap.pixels.shape[2]
    n: cython.longlong = 0
    sums = cython.declare(cython.longlong[5])
    above: cython.longlong = 0
    below: cython.double = 0
    for k in range(channels):
        for i in range(5):
            sums[i] = 0
        at = 0
        n = 0
        for r in range(gap.runs.shape[0]):
            if gap.runs[r, 0]:
                row = cython.address(gap.turned[x + gap.runs[r, 2], y + gap.runs[r, 1], 0])
            else:
                row = cython.address(gap.pixels[y + gap.runs[r, 1], x + gap.runs[r, 2], 0])
            for i in range(gap.runs[r, 3]):
                f = row[i * channels + k]
                g = gap.query[at + i * channels + k]
                sums[0] += f
                sums[1] += g
                sums[2] += f * g
                sums[3] += f * f
                sums[4] += g * g
            at += gap.runs[r, 3] * channels
            n += gap.runs[r, 3]
        above += n * sums[2] - sums[0] * sums[1]
        below += sqrt(cython.cast(cython.double, n * sums[3] - sums[0] * sums[0])) * sqrt(
            cython.cast(cython.double, n * sums[4] - sums[1] * sums[1])
        )
    if below <= 0:
        return 1 << 40
    return cython.cast(cython.longlong, (1.0 - above / below) * 1099511627776.0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mismatch(gap: GapSearch, here: cython.int, bound: cython.longlong) -> cython.longlong:
    """How badly a window fits the border: eq. (4.4), or by the GNCC; may stop past `bound` >= 0.

    A window that repeats its neighbors counts as worse, by `variety` where it repeats all.
    """
    cython.declare(n=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(repeated=cython.longlong, found=cython.longlong)
    columns: cython.Py_ssize_t = gap.pixels.shape[1]
    area: cython.longlong = max(gap.height * gap.width, 1)
    factor: cython.longlong = 256
    for n in range(4):
        repeated = common_pixels(
            here, gap.other[n], gap.dy[n], gap.dx[n], gap.height, gap.width, columns
        )
        factor += gap.variety * repeated // area
    y = here // columns
    x = here % columns
    if gap.by_correlation:
        found = correlation(gap, y, x)
    else:
        bound = bound // factor if bound >= 0 else -1
        found = distance(gap.pixels, gap.turned, y, x, gap.runs, gap.query, bound)
    return factor * found


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compose_border(gap: GapSearch) -> cython.void:
    """Copy each wedge of the border from the neighbor that it belongs to (Fig. 4.9)."""
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.Py_ssize_t, wedge=cython.int)
    cython.declare(here=cython.p_uchar, there=cython.p_const_uchar)
    channels: cython.Py_ssize_t = gap.pixels.shape[2]
    for v in range(gap.wedges.shape[0]):
        for u in range(gap.wedges.shape[1]):
            wedge = gap.wedges[v, u]
            if wedge == 0 or wedge == KNOWN:
                continue
            wedge -= 1
            p = gap.other[wedge] + (gap.dy[wedge] + v) * gap.pixels.shape[1]
            here = cython.address(gap.border[v, u, 0])
            there = cython.address(gap.pixels[0, 0, 0]) + (p + gap.dx[wedge] + u) * channels
            for k in range(channels):
                here[k] = there[k]
    gather(gap.border, 0, 0, gap.runs, gap.query)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_by_zone(gap: GapSearch) -> cython.Py_ssize_t:
    """List the windows whose borders `search` finds nearest (section 5.2); return how many."""
    cython.declare(t=cython.Py_ssize_t, y=cython.int, x=cython.int)
    columns: cython.int = cython.cast(cython.int, gap.windows.usable.shape[1])
    count: cython.Py_ssize_t = list_candidates(gap.border, 0, 0, gap.windows, gap)
    for t in range(count):
        y = gap.places[t] // columns
        x = gap.places[t] % columns
        gap.places[t] = y * cython.cast(cython.int, gap.pixels.shape[1]) + x
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_similar(
    gap: GapSearch,
    offsets: cython.const[cython.longlong][:, ::1],
    blocks: cython.const[cython.longlong][:, ::1],
    n: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """List the windows similar to block n that fit its border best; return how many."""
    cython.declare(t=cython.Py_ssize_t, here=cython.int)
    cython.declare(key=cython.longlong, bound=cython.longlong)
    count: cython.Py_ssize_t = 0
    tried: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t = blocks[n, 5]
    for t in range(offsets.shape[0]):
        here = similar(gap.usable, gap.period, offsets, k, blocks, n)
        k = k + 1 if k + 1 < offsets.shape[0] else 0
        if here < 0:
            continue
        bound = gap.keys[0] if count == gap.wanted else -1
        key = mismatch(gap, here, bound)
        count = offer(
            key, here, count, gap.wanted,
            cython.address(gap.keys[0]), cython.address(gap.places[0]),
        )  # fmt: skip
        tried += 1
        if tried == gap.most:
            break
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_within_tolerance(gap: GapSearch, count: cython.Py_ssize_t) -> cython.int:
    """The best window within the tolerance around the candidates (section 4.2.2), or -1."""
    cython.declare(t=cython.Py_ssize_t, y=cython.longlong, x=cython.longlong, v=cython.longlong)
    cython.declare(key=cython.longlong, here=cython.int)
    columns: cython.Py_ssize_t = gap.pixels.shape[1]
    best: cython.int = -1
    least: cython.longlong = NEVER
    if count > 0:  # the best candidate first: the others soon exceed its mismatch
        best = 0
        for t in range(1, count):
            if gap.keys[t] < gap.keys[best]:
                best = cython.cast(cython.int, t)
        best = gap.places[best]
        least = mismatch(gap, best, -1)
    for t in range(count):
        for y in range(-gap.tolerance, gap.tolerance + 1):
            for x in range(-gap.tolerance, gap.tolerance + 1):
                v = gap.places[t] // columns + y
                here = source_at(gap.usable, gap.period, v, gap.places[t] % columns + x)
                if here < 0:
                    continue
                key = mismatch(gap, here, least)
                if key < least or (key == least and here < best):
                    least = key
                    best = here
    return best


def fill_gaps(
    gap: GapSearch,
    offsets: cython.const[cython.longlong][:, ::1],
    blocks: cython.const[cython.longlong][:, ::1],
    near: cython.const[cython.longlong][:, :, ::1],
    sources: cython.int[::1],
):
    """Choose the source of each gap by the borders of its four neighbors (section 4.2.2).

    The best of the similar windows are listed, then the best within the tolerance around them wins.
    """
    cython.declare(n=cython.Py_ssize_t, m=cython.Py_ssize_t, count=cython.Py_ssize_t)
    cython.declare(best=cython.int)
    with cython.nogil:
        for n in range(blocks.shape[0]):
            gap.height = blocks[n, 3]
            gap.width = blocks[n, 4]
            for m in range(4):
                gap.other[m] = sources[near[n, m, 0]] if near[n, m, 0] >= 0 else -1
                gap.dy[m] = near[n, m, 1]
                gap.dx[m] = near[n, m, 2]
            compose_border(gap)
            if gap.by_zone:
                count = best_by_zone(gap)
            else:
                count = best_similar(gap, offsets, blocks, n)
            best = best_within_tolerance(gap, count)
            sources[blocks[n, 0]] = best if best >= 0 else cython.cast(cython.int, blocks[n, 6])
