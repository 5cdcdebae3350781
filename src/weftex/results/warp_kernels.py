# mypy: ignore-errors
"""Kernels that resample warped patches; compiled by Cython, see setup.py.

A warp is a grid of shifts over a block, in 1/16 pixel and linear in between; beyond the block
those of its sides go on. Nothing outside of the window is ever looked at. All of it is whole
numbers, so that the same bytes come out everywhere.
"""

import cython
from cython.cimports.weftex.results.paste_kernels import (
    ALPHA,
    LABELS,
    VECTORS,
    View,
    length,
    middle_of,
    stretch,
    value,
)

PART = cython.declare(cython.longlong, 16)  # of a pixel
ROUND = cython.declare(cython.longlong, 4096)  # pixels that keep quotients above 0


@cython.cclass
class Warps:
    """Warps of patches: `nodes[k]` are the shifts of patch k, `within[k]` says where they lie.

    That is the patch's first row and column in the block's window, the block's height and width,
    and how far the window reaches beyond it.
    """

    nodes: cython.const[cython.short][:, :, :, ::1]
    within: cython.const[cython.int][:, ::1]

    def __init__(self, nodes, within):
        self.nodes, self.within = nodes, within


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def node(p: cython.longlong, length: cython.longlong, last: cython.longlong) -> cython.longlong:
    """The last node but one, or before, that is not past place `p` of a block's side."""
    a: cython.longlong = p * last // length
    if a > last - 1:
        a = last - 1
    while a + 1 < last and (a + 1) * length // last <= p:
        a += 1
    return a


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def shifted(
    warps: Warps,
    k: cython.Py_ssize_t,
    v: cython.longlong,
    u: cython.longlong,
    shift: cython.pointer(cython.longlong),
) -> cython.void:
    """The shift at pixel (v, u) of a window, along both axes."""
    cython.declare(n=cython.Py_ssize_t, a=cython.Py_ssize_t, b=cython.Py_ssize_t)
    cython.declare(tall=cython.longlong, wide=cython.longlong, total=cython.longlong)
    height: cython.longlong = warps.within[k, 2]
    width: cython.longlong = warps.within[k, 3]
    last: cython.longlong = warps.nodes.shape[1] - 1
    y: cython.longlong = min(max(v - warps.within[k, 4], 0), height)
    x: cython.longlong = min(max(u - warps.within[k, 4], 0), width)
    a = node(y, height, last)
    b = node(x, width, last)
    tall = (a + 1) * height // last - a * height // last
    wide = (b + 1) * width // last - b * width // last
    y -= a * height // last
    x -= b * width // last
    for n in range(2):
        total = (tall - y) * (
            (wide - x) * warps.nodes[k, a, b, n] + x * warps.nodes[k, a, b + 1, n]
        )
        total += y * (
            (wide - x) * warps.nodes[k, a + 1, b, n] + x * warps.nodes[k, a + 1, b + 1, n]
        )
        shift[n] = (2 * total + (2 * ROUND * PART + 1) * tall * wide) // (2 * tall * wide)
        shift[n] -= ROUND * PART


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def taps(
    at: cython.longlong,
    length: cython.longlong,
    origin: cython.longlong,
    whole: cython.longlong,
    weight: cython.pointer(cython.longlong),
    place: cython.pointer(cython.Py_ssize_t),
) -> cython.void:
    """The four pixels around a place of a window, and their weights in 1/8192 (Catmull and Rom).

    `origin` is where the window begins in the sample, whose side is `whole`.
    """
    p: cython.Py_ssize_t
    q: cython.longlong
    f: cython.longlong
    at = min(max(at, 0), PART * (length - 1))
    f = at % PART
    weight[0] = -f * f * f + 32 * f * f - 256 * f
    weight[1] = 3 * f * f * f - 80 * f * f + 8192
    weight[2] = -3 * f * f * f + 64 * f * f + 256 * f
    weight[3] = f * f * f - 16 * f * f
    for p in range(4):
        q = origin + min(max(at // PART + p - 1, 0), length - 1)
        place[p] = cython.cast(cython.Py_ssize_t, (q % whole + whole) % whole)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def resampled(
    source: cython.const[value][:, :, ::1],
    rows: cython.pointer(cython.Py_ssize_t),
    columns: cython.pointer(cython.Py_ssize_t),
    down: cython.pointer(cython.longlong),
    along: cython.pointer(cython.longlong),
    channel: cython.Py_ssize_t,
    alpha: cython.bint,
) -> value:
    """One channel between 4 by 4 pixels, never beyond the nearest four of them.

    With `alpha` pixels count by how opaque they are.
    """
    p: cython.Py_ssize_t
    q: cython.Py_ssize_t
    w: cython.longlong
    opaque: cython.longlong
    above: cython.longlong = 0
    below: cython.longlong = 0
    share: cython.double
    total: cython.double = 0
    parts: cython.double = 0
    pixel: value
    low: value
    high: value
    any_seen: cython.bint = False
    channels: cython.Py_ssize_t = source.shape[2]
    p = 1 if down[1] >= down[2] else 2
    q = 1 if along[1] >= along[2] else 2
    low = source[rows[p], columns[q], channel]
    high = low
    for p in range(4):
        for q in range(4):
            w = down[p] * along[q]
            if w == 0:
                continue
            pixel = source[rows[p], columns[q], channel]
            if value is cython.uchar or value is cython.ushort:
                opaque = source[rows[p], columns[q], channels - 1] if alpha else 1
                if opaque == 0:
                    continue
                above += w * opaque * pixel
                below += w * opaque
            else:
                share = source[rows[p], columns[q], channels - 1] if alpha else 1.0
                if share == 0:
                    continue
                total += w * share * pixel
                parts += w * share
            if 1 <= p <= 2 and 1 <= q <= 2:
                if not any_seen:
                    any_seen = True
                    low = pixel
                    high = pixel
                low = min(low, pixel)
                high = max(high, pixel)
    if not any_seen:
        return low
    if value is cython.uchar or value is cython.ushort:
        if below <= 0:
            return low
        above = (2 * max(above, 0) + below) // (2 * below)
        if above <= low:
            return low
        if above >= high:
            return high
        pixel = above
        return pixel
    else:
        if parts <= 0:
            return low
        total = total / parts
        if total >= high:
            return high
        if total > low:  # a sum of numbers that floats just hold may be none
            pixel = total
            return pixel
        return low


def warp_into(
    piece: value[:, :, ::1],
    source: cython.const[value][:, :, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    columns: cython.Py_ssize_t,
    warps: Warps,
    k: cython.Py_ssize_t,
    view: View,
):
    """Fill the first `columns` of `piece` with the patch whose source is (y, x), warped.

    `source` and `piece` are at the scale of the view, all else is in pixels of the sample.
    """
    scale: cython.Py_ssize_t = view.scale
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, r=cython.Py_ssize_t)
    cython.declare(q=cython.Py_ssize_t, c=cython.Py_ssize_t)
    channels: cython.Py_ssize_t = source.shape[2]
    height: cython.longlong = scale * cython.cast(
        cython.longlong, warps.within[k, 2] + 2 * warps.within[k, 4]
    )
    width: cython.longlong = scale * cython.cast(
        cython.longlong, warps.within[k, 3] + 2 * warps.within[k, 4]
    )
    top: cython.longlong = scale * cython.cast(cython.longlong, y - warps.within[k, 0])
    left: cython.longlong = scale * cython.cast(cython.longlong, x - warps.within[k, 1])
    shift = cython.declare(cython.longlong[2])
    down = cython.declare(cython.longlong[4])
    along = cython.declare(cython.longlong[4])
    at_y = cython.declare(cython.Py_ssize_t[4])
    at_x = cython.declare(cython.Py_ssize_t[4])
    mixed = cython.declare(cython.double[3])
    middle: cython.double
    whole: cython.bint
    nearest: cython.pointer(cython.const[value])
    to: cython.pointer(value)
    with cython.nogil:
        for v in range(piece.shape[0] // scale):
            for u in range(columns):
                shifted(warps, k, warps.within[k, 0] + v, warps.within[k, 1] + u, shift)
                for r in range(scale):
                    taps(
                        PART * (scale * (warps.within[k, 0] + v) + r) + scale * shift[0],
                        height, top, source.shape[0], down, at_y,
                    )  # fmt: skip
                    for q in range(scale):
                        taps(
                            PART * (scale * (warps.within[k, 1] + u) + q) + scale * shift[1],
                            width, left, source.shape[1], along, at_x,
                        )  # fmt: skip
                        nearest = cython.address(
                            source[
                                at_y[1 if down[1] >= down[2] else 2],
                                at_x[1 if along[1] >= along[2] else 2],
                                0,
                            ]
                        )
                        to = cython.address(piece[scale * v + r, scale * u + q, 0])
                        whole = down[1] == 8192 and along[1] == 8192
                        for c in range(channels):
                            if whole or view.mixing == LABELS:
                                to[c] = nearest[c]
                            else:
                                to[c] = resampled(
                                    source, at_y, at_x, down, along, c,
                                    view.mixing == ALPHA and c < channels - 1,
                                )  # fmt: skip
                        if view.mixing == VECTORS and not whole:
                            middle = middle_of(to, view.middle)
                            for c in range(3):
                                mixed[c] = to[c] - middle
                            stretch(mixed, length(nearest, middle), middle, to)


def displace(
    patch: cython.const[cython.int][::1],
    v: cython.longlong[::1],
    u: cython.longlong[::1],
    first: cython.Py_ssize_t,
    warps: Warps,
):
    """Move pixels (v, u) of patches from `first` on to the nearest pixel that they show."""
    cython.declare(n=cython.Py_ssize_t, k=cython.Py_ssize_t, m=cython.longlong)
    shift = cython.declare(cython.longlong[2])
    with cython.nogil:
        for n in range(patch.shape[0]):
            k = patch[n] - first
            if k < 0:
                continue
            shifted(warps, k, warps.within[k, 0] + v[n], warps.within[k, 1] + u[n], shift)
            m = 2 * warps.within[k, 4] - 1
            v[n] = (
                min(
                    max(PART * (warps.within[k, 0] + v[n]) + shift[0], 0),
                    PART * (warps.within[k, 2] + m),
                )
                + PART // 2
            ) // PART - warps.within[k, 0]
            u[n] = (
                min(
                    max(PART * (warps.within[k, 1] + u[n]) + shift[1], 0),
                    PART * (warps.within[k, 3] + m),
                )
                + PART // 2
            ) // PART - warps.within[k, 1]
