# mypy: ignore-errors
"""Kernels of near-regular synthesis: the source window of each block; compiled, see setup.py.

A source is the flat index of a window's upper left corner in the sample's pixels. `sources` has one
for each block of the layout, -1 where there is none yet. Phases (eq. 3.29) and offsets, sums of
multiples of the lattice vectors, are in 1/65536 pixel.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.libc.string import memcpy
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.search.picture_kernels import SampleWindows, usable_place

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any mismatch
HALF = cython.declare(cython.longlong, 1 << 15)  # a pixel, in 1/65536
MOST_DRAWN = cython.declare(cython.Py_ssize_t, 256)  # windows that a drawn block tries
MOST_COMPARED = cython.declare(cython.Py_ssize_t, 512)  # similar windows that a gap compares
ALL_SIMILAR = int(MOST_COMPARED)  # for Python

Block = cython.struct(
    index=cython.longlong,  # in `sources`
    phase_y=cython.longlong,
    phase_x=cython.longlong,
    height=cython.longlong,
    width=cython.longlong,
    first=cython.longlong,  # the offset to try first
    fallback=cython.longlong,  # the source if no similar window is usable
)
#: A block beside another: its index in `sources` or -1, and how far it is away.
Near = cython.struct(index=cython.longlong, dy=cython.longlong, dx=cython.longlong)


@cython.cclass
class Gaps:
    """The border of gaps of one size, and how the sample's windows are compared with it.

    `pieces` cover the wedges of the border (Fig. 4.9), and `runs` all of it: stretches of a row, by
    their first pixel in `border`, in a window of the sample, and their length. A piece is of the
    neighbor above, left, below or right. The best windows are listed in `keys` and `places`.
    """

    sample: SampleWindows
    pieces: cython.const[cython.int][:, ::1]
    runs: cython.const[cython.int][:, ::1]
    tolerance: cython.Py_ssize_t
    by_correlation: cython.bint
    border: cython.uchar[:, ::1]
    keys: cython.longlong[::1]
    places: cython.int[::1]

    def __init__(self, sample: SampleWindows, pieces, runs, tolerance, by_correlation, scratch):
        self.sample, self.pieces, self.runs = sample, pieces, runs
        self.tolerance, self.by_correlation = tolerance, by_correlation
        self.border, self.keys, self.places = scratch


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def similar_window(
    sample: SampleWindows,
    offsets: cython.const[cython.longlong][:, ::1], k: cython.Py_ssize_t,
    blocks: cython.const[Block][::1], n: cython.Py_ssize_t,
) -> cython.Py_ssize_t:  # fmt: skip
    """The window that is similar to block n by the k-th offset (eq. 4.3, Fig. 4.7b), or -1."""
    y: cython.longlong = (blocks[n].phase_y + offsets[k, 0] + HALF) >> 16
    x: cython.longlong = (blocks[n].phase_x + offsets[k, 1] + HALF) >> 16
    return usable_place(sample.usable, sample.period, y, x)


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def common_pixels(
    here: cython.int, other: cython.int, dy: cython.longlong, dx: cython.longlong,
    height: cython.longlong, width: cython.longlong, columns: cython.Py_ssize_t,
) -> cython.longlong:  # fmt: skip
    """The number of pixels that a block from `here` repeats of one (dy, dx) away."""
    y: cython.longlong = here // columns - other // columns
    x: cython.longlong = here % columns - other % columns
    if other < 0 or (y == dy and x == dx):  # continuing repeats nothing
        return 0
    return max(0, height - abs(y)) * max(0, width - abs(x))


def draw_blocks(
    sample: SampleWindows,
    offsets: cython.const[cython.longlong][:, ::1],
    blocks: cython.const[Block][::1],
    near: cython.const[Near][:, ::1],
    sources: cython.int[::1],
):
    """Draw a source for each block among the windows similar to it (section 4.2.1).

    Offsets are tried until a window repeats at most an eighth of a block of what is near; else the
    window that repeats least is taken.
    """
    cython.declare(n=cython.Py_ssize_t, t=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(m=cython.Py_ssize_t, tried=cython.Py_ssize_t)
    cython.declare(here=cython.int, best=cython.int)
    cython.declare(height=cython.longlong, width=cython.longlong)
    cython.declare(repeated=cython.longlong, least=cython.longlong)
    count: cython.Py_ssize_t = offsets.shape[0]
    with cython.nogil:
        for n in range(blocks.shape[0]):
            height = blocks[n].height
            width = blocks[n].width
            k = blocks[n].first
            best = cython.cast(cython.int, blocks[n].fallback)
            least = NEVER
            tried = 0
            for t in range(count):
                here = similar_window(sample, offsets, k, blocks, n)
                k = k + 1 if k + 1 < count else 0
                if here < 0:
                    continue
                repeated = 0
                for m in range(near.shape[1]):
                    if near[n, m].index >= 0:
                        repeated += common_pixels(
                            here, sources[near[n, m].index], near[n, m].dy, near[n, m].dx,
                            height, width, sample.usable.shape[1],
                        )  # fmt: skip
                if repeated < least:
                    least = repeated
                    best = here
                tried += 1
                if 8 * least <= height * width or tried >= MOST_DRAWN:
                    break
            sources[blocks[n].index] = best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compose_border(
    gaps: Gaps, near: cython.const[Near][:, ::1], n: cython.Py_ssize_t,
    sources: cython.const[cython.int][::1],
) -> cython.void:  # fmt: skip
    """Copy each wedge of the border of gap n from the neighbor that it belongs to (Fig. 4.9)."""
    cython.declare(r=cython.Py_ssize_t, m=cython.Py_ssize_t, first=cython.Py_ssize_t)
    pixels: cython.p_const_uchar = cython.address(gaps.sample.pixels[0, 0, 0])
    columns: cython.Py_ssize_t = gaps.sample.pixels.shape[1]
    channels: cython.Py_ssize_t = gaps.sample.pixels.shape[2]
    for r in range(gaps.pieces.shape[0]):
        m = gaps.pieces[r, 3]
        # The gap's window begins here if it continues the neighbor.
        first = sources[near[n, m].index] + near[n, m].dy * columns + near[n, m].dx
        memcpy(
            cython.address(gaps.border[gaps.pieces[r, 0], 0]),
            pixels + (first + gaps.pieces[r, 1]) * channels,
            gaps.pieces[r, 2] * channels,
        )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def correlation(gaps: Gaps, window: cython.p_const_uchar) -> cython.longlong:
    """2**40 (1 - gamma) by eq. (3.13) of the border and a window."""
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(f=cython.longlong, g=cython.longlong, n=cython.longlong)
    cython.declare(here=cython.p_const_uchar, there=cython.p_const_uchar)
    channels: cython.Py_ssize_t = gaps.border.shape[1]
    sums = cython.declare(cython.longlong[5])
    above: cython.longlong = 0
    below: cython.double = 0
    for k in range(channels):
        for i in range(5):
            sums[i] = 0
        n = 0
        for r in range(gaps.runs.shape[0]):
            here = cython.address(gaps.border[gaps.runs[r, 0], k])
            there = window + gaps.runs[r, 1] * channels + k
            for i in range(gaps.runs[r, 2]):
                f = there[i * channels]
                g = here[i * channels]
                sums[0] += f
                sums[1] += g
                sums[2] += f * g
                sums[3] += f * f
                sums[4] += g * g
            n += gaps.runs[r, 2]
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
def border_mismatch(
    gaps: Gaps, place: cython.Py_ssize_t, bound: cython.longlong
) -> cython.longlong:  # fmt: skip
    """How badly a window fits the border: eq. (4.4), or by the GNCC; may stop past `bound`."""
    cython.declare(r=cython.Py_ssize_t, total=cython.longlong)
    channels: cython.Py_ssize_t = gaps.border.shape[1]
    window: cython.p_const_uchar = cython.address(gaps.sample.pixels[0, 0, 0]) + place * channels
    if gaps.by_correlation:
        return correlation(gaps, window)
    total = 0
    for r in range(gaps.runs.shape[0]):
        total += squared(
            window + gaps.runs[r, 1] * channels,
            cython.address(gaps.border[gaps.runs[r, 0], 0]),
            gaps.runs[r, 2] * channels,
        )
        if total > bound:
            break
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_similar(
    gaps: Gaps,
    offsets: cython.const[cython.longlong][:, ::1],
    blocks: cython.const[Block][::1],
    n: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """List the windows similar to block n that fit its border best; return how many."""
    cython.declare(t=cython.Py_ssize_t, here=cython.int, key=cython.longlong, i=cython.Py_ssize_t)
    wanted: cython.Py_ssize_t = gaps.keys.shape[0]
    count: cython.Py_ssize_t = 0
    tried: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t = blocks[n].first
    for t in range(offsets.shape[0]):
        here = similar_window(gaps.sample, offsets, k, blocks, n)
        k = k + 1 if k + 1 < offsets.shape[0] else 0
        if here < 0:
            continue
        key = border_mismatch(gaps, here, gaps.keys[wanted - 1] if count == wanted else NEVER)
        if count < wanted or key < gaps.keys[wanted - 1]:
            i = min(count, wanted - 1)
            while i > 0 and gaps.keys[i - 1] > key:
                gaps.keys[i] = gaps.keys[i - 1]
                gaps.places[i] = gaps.places[i - 1]
                i -= 1
            gaps.keys[i] = key
            gaps.places[i] = here
            count = min(count + 1, wanted)
        tried += 1
        if tried == MOST_COMPARED:
            break
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_within_tolerance(gaps: Gaps, count: cython.Py_ssize_t) -> cython.int:
    """The best window within the tolerance around the listed ones (section 4.2.2), or -1."""
    cython.declare(t=cython.Py_ssize_t, y=cython.longlong, x=cython.longlong, v=cython.longlong)
    cython.declare(u=cython.longlong, key=cython.longlong, here=cython.int)
    columns: cython.Py_ssize_t = gaps.sample.pixels.shape[1]
    if count == 0:
        return -1
    best: cython.int = gaps.places[0]
    least: cython.longlong = border_mismatch(gaps, best, NEVER)
    for t in range(count):
        for y in range(-gaps.tolerance, gaps.tolerance + 1):
            for x in range(-gaps.tolerance, gaps.tolerance + 1):
                v = gaps.places[t] // columns + y
                u = gaps.places[t] % columns + x
                here = usable_place(gaps.sample.usable, gaps.sample.period, v, u)
                if here < 0:
                    continue
                key = border_mismatch(gaps, here, least)
                if key < least or (key == least and here < best):
                    least = key
                    best = here
    return best


def fill_gaps(
    gaps: Gaps,
    offsets: cython.const[cython.longlong][:, ::1],
    blocks: cython.const[Block][::1],
    near: cython.const[Near][:, ::1],
    sources: cython.int[::1],
):
    """Choose the source of each gap by the borders of its four neighbors (section 4.2.2).

    The best of the similar windows are listed, then the best within the tolerance around them wins.
    """
    cython.declare(n=cython.Py_ssize_t, best=cython.int)
    with cython.nogil:
        for n in range(blocks.shape[0]):
            compose_border(gaps, near, n, sources)
            best = best_within_tolerance(gaps, best_similar(gaps, offsets, blocks, n))
            sources[blocks[n].index] = (
                best if best >= 0 else cython.cast(cython.int, blocks[n].fallback)
            )
