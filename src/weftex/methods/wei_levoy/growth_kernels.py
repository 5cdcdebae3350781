# mypy: ignore-errors
"""The kernel of Wei and Levoy's method; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.tsvq_kernels import nearest


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather(
    levels: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    offsets: cython.const[cython.int][:, ::1],
    first: cython.Py_ssize_t,
    query: cython.uchar[::1],
    spans: cython.int[:, ::1],
    n: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Copy what is known of a window to its bytes of the query, from byte `first` on.

    Returns the number of spans, `n` of which are there already.
    """
    height: cython.Py_ssize_t = levels.shape[0]
    width: cython.Py_ssize_t = levels.shape[1]
    channels: cython.Py_ssize_t = levels.shape[2]
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    at: cython.Py_ssize_t = first
    for i in range(offsets.shape[0]):
        cy = y + offsets[i, 0]
        cx = x + offsets[i, 1]
        if wrap_y and (cy < 0 or cy >= height):
            cy = cy % height
            if cy < 0:
                cy += height
        if wrap_x and (cx < 0 or cx >= width):
            cx = cx % width
            if cx < 0:
                cx += width
        if 0 <= cy < height and 0 <= cx < width and done[cy, cx]:
            for k in range(channels):
                query[at + k] = levels[cy, cx, k]
            if n and spans[n - 1, 0] + spans[n - 1, 1] == at:
                spans[n - 1, 1] += cython.cast(cython.int, channels)
            else:
                spans[n, 0] = cython.cast(cython.int, at)
                spans[n, 1] = cython.cast(cython.int, channels)
                n += 1
        at += channels
    return n


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    levels: cython.uchar[:, :, ::1],
    source: cython.int[:, ::1],
    done: cython.uchar[:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    parent: cython.const[cython.uchar][:, :, ::1],
    parent_done: cython.const[cython.uchar][:, ::1],
    offsets: cython.const[cython.int][:, ::1],
    parent_offsets: cython.const[cython.int][:, ::1],
    pixels: cython.const[cython.int][::1],
    start: cython.Py_ssize_t,
    stop: cython.Py_ssize_t,
    sample: cython.const[cython.uchar][:, :, ::1],
    rows: cython.const[cython.uchar][:, ::1],
    places: cython.const[cython.int][::1],
    nodes: cython.const[cython.int][:, ::1],
    centroids: cython.const[cython.uchar][:, ::1],
    leaves: cython.Py_ssize_t,
    query: cython.uchar[::1],
    spans: cython.int[:, ::1],
    keys: cython.longlong[::1],
    pending: cython.int[::1],
) -> cython.void:
    width: cython.Py_ssize_t = levels.shape[1]
    channels: cython.Py_ssize_t = levels.shape[2]
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    n: cython.Py_ssize_t
    place: cython.int
    own: cython.Py_ssize_t = parent_offsets.shape[0] * channels
    for i in range(start, stop):
        y = pixels[i] // width
        x = pixels[i] % width
        n = 0
        if parent_offsets.shape[0]:
            n = gather(
                parent, parent_done, y // 2, x // 2, wrap_y, wrap_x, parent_offsets, 0,
                query, spans, 0,
            )  # fmt: skip
        n = gather(levels, done, y, x, wrap_y, wrap_x, offsets, own, query, spans, n)
        done[y, x] = 1
        if n == 0:
            continue
        place = places[nearest(
            rows, places, nodes, centroids, query, spans, n, leaves, keys, pending
        )]  # fmt: skip
        source[y, x] = place
        for k in range(channels):
            levels[y, x, k] = sample[place // sample.shape[1], place % sample.shape[1], k]


def choose_pixels(
    levels, source, done, wrap, parent, parent_done, offsets, parent_offsets, pixels, start, stop,
    sample, rows, places, nodes, centroids, leaves, query, spans, keys, pending,
):  # fmt: skip
    """Replace the pixels from `start` to `stop` of the list `pixels`, one after the other.

    Each becomes a copy of the sample's pixel whose window is nearest: its parent's window and as
    much of its own as is done. Where nothing is, the pixel stays.
    """
    le: cython.uchar[:, :, ::1] = levels
    so: cython.int[:, ::1] = source
    do: cython.uchar[:, ::1] = done
    wrap_y: cython.bint = wrap[0]
    wrap_x: cython.bint = wrap[1]
    pa: cython.const[cython.uchar][:, :, ::1] = parent
    pd: cython.const[cython.uchar][:, ::1] = parent_done
    of: cython.const[cython.int][:, ::1] = offsets
    po: cython.const[cython.int][:, ::1] = parent_offsets
    px: cython.const[cython.int][::1] = pixels
    a: cython.Py_ssize_t = start
    b: cython.Py_ssize_t = stop
    sa: cython.const[cython.uchar][:, :, ::1] = sample
    ro: cython.const[cython.uchar][:, ::1] = rows
    pl: cython.const[cython.int][::1] = places
    no: cython.const[cython.int][:, ::1] = nodes
    ce: cython.const[cython.uchar][:, ::1] = centroids
    lv: cython.Py_ssize_t = leaves
    qu: cython.uchar[::1] = query
    sp: cython.int[:, ::1] = spans
    ke: cython.longlong[::1] = keys
    pe: cython.int[::1] = pending
    with cython.nogil:
        choose(
            le, so, do, wrap_y, wrap_x, pa, pd, of, po, px, a, b, sa, ro, pl, no, ce, lv,
            qu, sp, ke, pe,
        )  # fmt: skip
