# mypy: ignore-errors
"""The kernel of exact neighborhood matching; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.color_kernels import near_colors
from cython.cimports.weftex.search.window_kernels import (
    causal_runs,
    gather_runs,
    known_runs,
    run_distance,
    settle,
    turn_runs,
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
    stamp: cython.int,
    kept: cython.int[:, ::1],
    intervals: cython.int[:, ::1],
) -> cython.Py_ssize_t:
    """Find the colours near to one; return the row of `intervals` that they stand in.

    A scan meets two of the four neighbours of a pixel again at the next one, so the results looked
    up last are kept (section 4.4, fig. 5). `kept` holds their colours, how many intervals they
    have, and the pixel that used them last; what this pixel has used does not go.
    """
    slot: cython.Py_ssize_t
    oldest: cython.Py_ssize_t = 0
    for slot in range(KEPT):
        if kept[slot, 0] == color:
            kept[slot, 2] = stamp
            return slot
        if kept[slot, 2] < kept[oldest, 2]:
            oldest = slot
    slot = oldest
    kept[slot, 0] = color
    kept[slot, 2] = stamp
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


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def repeats(
    last: cython.Py_ssize_t,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    apart: cython.Py_ssize_t,
) -> cython.bint:
    """Whether a place was last copied to another pixel nearer than `apart`."""
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    if last < 0:
        return False
    dy = last // width - y
    dx = last % width - x
    if dy == 0 and dx == 0:
        return False
    return -apart < dy < apart and -apart < dx < apart


def match_pixels(
    order: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
    causal: cython.bint,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    apart: cython.Py_ssize_t,
    block_copying: cython.bint,
    most: cython.longlong,
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
    groups: cython.const[cython.int][::1],
    places: cython.const[cython.int][::1],
    radius: cython.const[cython.longlong][::1],
    colors: cython.const[cython.uchar][:, ::1],
    low: cython.const[cython.uchar][:, ::1],
    high: cython.const[cython.uchar][:, ::1],
    depth: cython.Py_ssize_t,
    guide: cython.const[cython.uchar][:, :, ::1],
    guide_pixels: cython.const[cython.uchar][:, :, ::1],
    guide_known: cython.const[cython.uchar][:, ::1],
    guide_reach: cython.Py_ssize_t,
    suggested: cython.const[cython.int][:, ::1],
    guide_runs: cython.int[:, ::1],
    guide_query: cython.uchar[::1],
    last: cython.int[:, ::1],
    seen: cython.int[:, ::1],
    stamp: cython.int,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    kept: cython.int[:, ::1],
    intervals: cython.int[:, ::1],
):
    """Choose a source for each pixel of `order`, in this order; return how many were tested.

    Of longer lists a random share, about `most` windows in all, is compared.
    Windows on the canvas are causal or as far as `done`. `guide` and `guide_pixels` are the next
    coarser level of the canvas and of the sample at this one's size, `suggested` the places that
    it leads to; empty without. Places that `starts`, `groups` and `places` list are those of
    `Candidates`. The arrays from `last` on are kept from call to call.
    """
    height: cython.Py_ssize_t = levels.shape[0]
    width: cython.Py_ssize_t = levels.shape[1]
    columns: cython.Py_ssize_t = pixels.shape[1]
    channels: cython.Py_ssize_t = pixels.shape[2]
    guided: cython.bint = guide.shape[0] > 0
    neighbor = cython.declare(cython.int[8])  # the colours of the direct neighbours, -1 for none
    lists = cython.declare(cython.Py_ssize_t[8])  # where what was looked up for each is kept
    p: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    d: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    ny: cython.Py_ssize_t
    nx: cython.Py_ssize_t
    n: cython.Py_ssize_t
    m: cython.Py_ssize_t = 0
    slot: cython.Py_ssize_t
    place: cython.Py_ssize_t
    member: cython.Py_ssize_t
    chosen: cython.Py_ssize_t
    limit: cython.Py_ssize_t
    agreeing: cython.Py_ssize_t
    listed: cython.longlong
    share: cython.ulonglong  # of the lists that is compared, of 2**32
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
            best = -1
            best_key = 0
            chosen = -1
            coherent = False
            n = -1  # the window is gathered when it is needed first
            if block_copying:
                agreeing = 0
                for d in range(4):
                    ny = y + offsets[d, 0]
                    nx = x + offsets[d, 1]
                    if ny < 0 or nx < 0 or ny >= height or nx >= width or source[ny, nx] < 0:
                        continue
                    if not done[ny, nx]:
                        continue
                    place = settle(
                        usable,
                        period,
                        source[ny, nx] // columns - offsets[d, 0],
                        source[ny, nx] % columns - offsets[d, 1],
                    )
                    if place < 0 or (agreeing > 0 and place != chosen):
                        break
                    chosen = place
                    agreeing += 1
                if agreeing < 4:
                    chosen = -1
            if chosen < 0:
                if causal:
                    n = causal_runs(y, x, height, width, wrap_x, reach, reach, reach, runs)
                    turn_runs(runs, n)
                else:
                    n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
                gather_runs(levels, y, x, runs, n, query)
                if guided:
                    m = known_runs(
                        guide_known, y, x, wrap_y, wrap_x,
                        guide_reach, guide_reach, guide_reach, guide_reach, guide_runs,
                    )  # fmt: skip
                    gather_runs(guide, y, x, guide_runs, m, guide_query)
                limit = apart
                while True:
                    # What the neighbours' sources go on with; of equal ones the first.
                    for d in range(offsets.shape[0] + guided):
                        if d < offsets.shape[0]:
                            neighbor[d] = -1
                            ny = y + offsets[d, 0]
                            nx = x + offsets[d, 1]
                            if wrap_y:
                                ny = (ny + height) % height
                            if wrap_x:
                                nx = (nx + width) % width
                            if ny < 0 or nx < 0 or ny >= height or nx >= width or not done[ny, nx]:
                                continue
                            neighbor[d] = color[ny, nx]
                            if source[ny, nx] < 0:
                                continue
                            place = settle(
                                usable,
                                period,
                                source[ny, nx] // columns - offsets[d, 0],
                                source[ny, nx] % columns - offsets[d, 1],
                            )
                        else:
                            place = suggested[y, x]
                        if place < 0 or seen[place // columns, place % columns] == stamp:
                            continue
                        seen[place // columns, place % columns] = stamp
                        if repeats(last[place // columns, place % columns], y, x, width, limit):
                            continue
                        tested += 1
                        distance = run_distance(
                            pixels, place // columns, place % columns, runs, n, query, best
                        )
                        if guided and (best < 0 or distance < best):
                            distance += run_distance(
                                guide_pixels, place // columns, place % columns, guide_runs, m,
                                guide_query, -1,
                            )  # fmt: skip
                        if best < 0 or distance < best:
                            best = distance
                            chosen = place
                            coherent = True
                    if coherent and best == 0:
                        break
                    listed = 0
                    for d in range(offsets.shape[0]):
                        lists[d] = -1
                        if neighbor[d] < 0:
                            continue
                        slot = look_up(
                            neighbor[d], radius, colors, low, high, depth, stamp, kept, intervals
                        )
                        lists[d] = slot
                        for j in range(kept[slot, 1]):
                            listed += starts[d, intervals[slot, 2 * j + 1]]
                            listed -= starts[d, intervals[slot, 2 * j]]
                    share = 0x100000000
                    if listed > most:
                        share = share * cython.cast(cython.ulonglong, most)
                        share //= cython.cast(cython.ulonglong, listed)
                    # The union of the lists of their colours, nothing twice (section 4.4).
                    for d in range(offsets.shape[0]):
                        slot = lists[d]
                        if slot < 0:
                            continue
                        for j in range(kept[slot, 1]):
                            for i in range(
                                starts[d, intervals[slot, 2 * j]],
                                starts[d, intervals[slot, 2 * j + 1]],
                            ):
                                place = places[groups[i]]
                                key = cython.cast(cython.uint, place) ^ cython.cast(
                                    cython.uint, bits[p]
                                )
                                key *= cython.cast(cython.uint, 2654435761)
                                if key >= share:
                                    continue
                                if seen[place // columns, place % columns] == stamp:
                                    continue
                                seen[place // columns, place % columns] = stamp
                                tested += 1
                                distance = run_distance(
                                    pixels, place // columns, place % columns, runs, n, query, best
                                )
                                if guided and (best < 0 or distance <= best):
                                    distance += run_distance(
                                        guide_pixels, place // columns, place % columns,
                                        guide_runs, m, guide_query, -1,
                                    )  # fmt: skip
                                if best >= 0 and (
                                    distance > best or (distance == best and coherent)
                                ):
                                    continue
                                member = places[
                                    groups[i]
                                    + (
                                        (bits[p] >> 32)
                                        * cython.cast(cython.ulonglong, groups[i + 1] - groups[i])
                                        >> 32
                                    )
                                ]
                                if repeats(
                                    last[member // columns, member % columns], y, x, width, limit
                                ):
                                    continue
                                if best < 0 or distance < best or key < best_key:
                                    best = distance
                                    best_key = key
                                    chosen = member
                                    coherent = False
                    if chosen >= 0 or limit == 0:
                        break
                    limit = 0  # everything repeats something nearby
                    stamp += 1
                if chosen < 0:  # no list has anything: any window
                    chosen = centres[
                        (bits[p] >> 32) * cython.cast(cython.ulonglong, centres.shape[0]) >> 32
                    ]
            source[y, x] = cython.cast(cython.int, chosen)
            last[chosen // columns, chosen % columns] = order[p]
            color[y, x] = number[chosen // columns, chosen % columns]
            for i in range(channels):
                levels[y, x, i] = pixels[chosen // columns, chosen % columns, i]
            done[y, x] = 1
    return tested


def group_places(
    pixels: cython.const[cython.uchar][:, :, ::1],
    starts: cython.const[cython.int][::1],
    places: cython.const[cython.int][::1],
    sums: cython.const[cython.longlong][::1],
    runs: cython.const[cython.int][:, ::1],
    size: cython.longlong,
    limit: cython.longlong,
    query: cython.uchar[::1],
    heads: cython.int[::1],
    leader: cython.int[::1],
):
    """For each place of a list, the first of it whose window is alike and leads a group.

    Alike is a squared difference of at most `limit`. Lists are sorted by the windows' sums, so a
    leader whose sum is too far off, by the inequality of Cauchy and Schwarz, ends the search.
    """
    columns: cython.Py_ssize_t = pixels.shape[1]
    c: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    k: cython.Py_ssize_t
    count: cython.Py_ssize_t
    gap: cython.longlong
    with cython.nogil:
        for c in range(starts.shape[0] - 1):
            count = 0
            for i in range(starts[c], starts[c + 1]):
                leader[i] = cython.cast(cython.int, i)
                if count > 0 and sums[i] - sums[heads[count - 1]] <= limit * size:
                    gather_runs(
                        pixels,
                        places[i] // columns,
                        places[i] % columns,
                        runs,
                        runs.shape[0],
                        query,
                    )
                for k in range(count - 1, -1, -1):
                    j = heads[k]
                    gap = sums[i] - sums[j]
                    if gap * gap > limit * size:
                        break
                    if limit >= run_distance(
                        pixels, places[j] // columns, places[j] % columns, runs, runs.shape[0],
                        query, limit,
                    ):  # fmt: skip
                        leader[i] = cython.cast(cython.int, j)
                        break
                if leader[i] == i:
                    heads[count] = cython.cast(cython.int, i)
                    count += 1
