# cython: language_level=3
"""The kernel of exact neighborhood matching; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weft.search._color_kernels import near_colors
from cython.cimports.weft.search._window_kernels import (
    causal_runs,
    gather_runs,
    known_runs,
    run_distance,
    settle,
)

# Looked-up colours that are kept: at least as many as a pixel has direct neighbours.
KEPT = cython.declare(cython.int, 8)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look_up(
    color: cython.int,
    radius: cython.const[cython.longlong][::1],
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    kept: cython.int[:, ::1],
    intervals: cython.int[:, ::1],
) -> cython.Py_ssize_t:
    """Find the colours near to one; return the row of `intervals` that they stand in.

    A scan meets two of the four neighbours of a pixel again at the next one, so the results looked
    up last are kept (section 4.4, fig. 5). `kept` holds their colours, how many intervals they
    have, and in the last row which goes next.
    """
    slot: cython.Py_ssize_t
    for slot in range(KEPT):
        if kept[slot, 0] == color:
            return slot
    slot = kept[KEPT, 0]
    kept[KEPT, 0] = cython.cast(cython.int, (slot + 1) % KEPT)
    kept[slot, 0] = color
    if radius[color] == 0:
        intervals[slot, 0] = color
        intervals[slot, 1] = color + 1
        kept[slot, 1] = 1
    else:
        kept[slot, 1] = cython.cast(
            cython.int,
            near_colors(colors, low, high, depth, color, radius[color], intervals, slot),
        )
    return slot


def match_pixels(
    order: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
    causal: cython.bint,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    color: cython.int[:, ::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    centres: cython.const[cython.int][::1],
    number: cython.const[cython.int][:, ::1],
    offsets: cython.const[cython.int][:, ::1],
    starts: cython.const[cython.int][:, ::1],
    lists: cython.const[cython.int][::1],
    radius: cython.const[cython.longlong][::1],
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    random_ties: cython.bint,
    block_copying: cython.bint,
    parent_levels: cython.const[cython.uchar][:, :, ::1],
    parent_source: cython.const[cython.int][:, ::1],
    parent_pixels: cython.const[cython.uchar][:, :, ::1],
    parent: cython.const[cython.int][:, ::1],
    parent_reach: cython.Py_ssize_t,
    seen: cython.int[:, ::1],
    stamp: cython.int,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    kept: cython.int[:, ::1],
    intervals: cython.int[:, ::1],
):
    """Choose a source for each pixel of `order`, in this order; return how many were tested."""
    height: cython.Py_ssize_t = levels.shape[0]
    width: cython.Py_ssize_t = levels.shape[1]
    columns: cython.Py_ssize_t = pixels.shape[1]
    channels: cython.Py_ssize_t = pixels.shape[2]
    p: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    d: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    ny: cython.Py_ssize_t
    nx: cython.Py_ssize_t
    n: cython.Py_ssize_t
    slot: cython.Py_ssize_t
    place: cython.Py_ssize_t
    chosen: cython.Py_ssize_t
    near: cython.int
    coherent: cython.bint
    key: cython.uint
    best_key: cython.uint
    distance: cython.longlong
    best: cython.longlong
    tested: cython.longlong = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y = order[p] // width
            x = order[p] % width
            stamp += 1
            if causal:
                n = causal_runs(y, x, height, width, wrap_x, reach, reach, reach, runs)
            else:
                n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
            gather_runs(levels, y, x, runs, n, query)
            best = -1
            best_key = 0
            chosen = -1
            coherent = False
            # What the neighbours' sources go on with; of equal ones the first.
            for d in range(offsets.shape[0]):
                ny = y + offsets[d, 0]
                nx = x + offsets[d, 1]
                if wrap_y:
                    ny = (ny + height) % height
                if wrap_x:
                    nx = (nx + width) % width
                if ny < 0 or nx < 0 or ny >= height or nx >= width or not done[ny, nx]:
                    continue
                if source[ny, nx] < 0:
                    continue
                place = settle(
                    usable,
                    period,
                    source[ny, nx] // columns - offsets[d, 0],
                    source[ny, nx] % columns - offsets[d, 1],
                )
                if place < 0 or seen[place // columns, place % columns] == stamp:
                    continue
                seen[place // columns, place % columns] = stamp
                tested += 1
                distance = run_distance(
                    pixels, place // columns, place % columns, runs, n, query, best
                )
                if best < 0 or distance < best:
                    best = distance
                    chosen = place
                    coherent = True
            for d in range(offsets.shape[0]):
                if coherent and best == 0:
                    break
                ny = y + offsets[d, 0]
                nx = x + offsets[d, 1]
                if wrap_y:
                    ny = (ny + height) % height
                if wrap_x:
                    nx = (nx + width) % width
                if ny < 0 or nx < 0 or ny >= height or nx >= width or not done[ny, nx]:
                    continue
                slot = look_up(
                    color[ny, nx], radius, colors, low, high, depth, kept, intervals
                )
                for j in range(kept[slot, 1]):
                    for i in range(
                        starts[d, intervals[slot, 2 * j]], starts[d, intervals[slot, 2 * j + 1]]
                    ):
                        place = lists[i]
                        if seen[place // columns, place % columns] == stamp:
                            continue
                        seen[place // columns, place % columns] = stamp
                        tested += 1
                        distance = run_distance(
                            pixels, place // columns, place % columns, runs, n, query, best
                        )
                        if best >= 0 and (distance > best or (distance == best and coherent)):
                            continue
                        key = (
                            cython.cast(cython.uint, place) ^ cython.cast(cython.uint, bits[p])
                        ) * cython.cast(cython.uint, 2654435761)
                        if best < 0 or distance < best or (random_ties and key < best_key):
                            best = distance
                            best_key = key
                            chosen = place
                            coherent = False
            if chosen < 0:  # no colour beside it is one of the sample's whole windows
                chosen = centres[
                    ((bits[p] >> 32) * cython.cast(cython.ulonglong, centres.shape[0])) >> 32
                ]
            source[y, x] = cython.cast(cython.int, chosen)
            color[y, x] = number[chosen // columns, chosen % columns]
            for i in range(channels):
                levels[y, x, i] = pixels[chosen // columns, chosen % columns, i]
            done[y, x] = 1
    return tested
