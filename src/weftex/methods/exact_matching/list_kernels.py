# mypy: ignore-errors
# cython: infer_types=True
"""The kernels of texture analysis (sections 4.1 and 4.4); compiled by Cython, see setup.py.

Shared types are declared in list_kernels.pxd.
"""

import cython
from cython.cimports.weftex.methods.exact_matching.color_kernels import near_colors
from cython.cimports.weftex.search.picture_kernels import Query
from cython.cimports.weftex.search.window_kernels import gather_runs, run_distance


class Lists:
    """The sample and its lists, and a cache of the last lookups, at least one for each neighbor."""

    def __init__(self, lists, kept, intervals):
        windows, index = lists.windows, lists.index
        self.pixels, self.usable, self.period = windows.pixels, windows.usable, windows.period
        self.centers, self.coarse = windows.centers, lists.coarse
        self.tree, self.number, self.radius = index.tree(), index.number, lists.radius
        self.offsets, self.starts = lists.offsets, lists.starts
        self.groups, self.places = lists.groups, lists.places
        self.kept, self.intervals = kept, intervals


def near_lists(lists, colors, stamp, slots):
    """Return the summed length of the lists of the colors near to each neighbor's.

    Writes to `slots` the rows of `intervals` that hold the near colors, -1 for none.
    """
    listed: cython.longlong = 0
    for d in range(lists.offsets.shape[0]):
        slots[d] = slot_of(lists, colors[d], stamp) if colors[d] >= 0 else -1
        for j in range(lists.kept[slots[d], 1] if slots[d] >= 0 else 0):
            listed += lists.starts[d, lists.intervals[slots[d], 2 * j + 1]]
            listed -= lists.starts[d, lists.intervals[slots[d], 2 * j]]
    return listed


def slot_of(lists, color, stamp):
    """Return the row of `intervals` that holds the colors near to `color`.

    The last lookups are cached, as two of a pixel's four neighbors are also the next pixel's
    (section 4.4, figure 5); the least recently used is replaced.
    """
    oldest = 0
    for slot in range(lists.kept.shape[0]):
        if lists.kept[slot, 0] == color:
            lists.kept[slot, 2] = stamp
            return slot
        if lists.kept[slot, 2] < lists.kept[oldest, 2]:
            oldest = slot
    lists.kept[oldest, 0] = color
    lists.kept[oldest, 2] = stamp
    if lists.radius[color] == 0:
        lists.intervals[oldest, 0] = color
        lists.intervals[oldest, 1] = color + 1
        lists.kept[oldest, 1] = 1
    else:
        lists.kept[oldest, 1] = cython.cast(
            cython.int, near_colors(lists.tree, color, lists.radius[color], lists.intervals, oldest)
        )
    return oldest


def group_places(
    pixels: cython.const[cython.uchar][:, :, ::1],
    query: Query,
    places: cython.const[cython.int][::1],
    sums: cython.const[cython.longlong][::1],
    starts: cython.const[cython.int][::1],
    limit: cython.longlong,
    heads: cython.int[::1],
    leader: cython.int[::1],
):
    """Fill `leader` with the first entry of each list whose window is within `limit` of an entry's.

    `places` are the entries of all lists, sorted by the `sums` of their windows' bytes within each.
    `limit` is a squared difference. `query` has the runs of a window, `heads` is scratch.
    """
    with cython.nogil:
        for c in range(starts.shape[0] - 1):
            count = 0
            for i in range(starts[c], starts[c + 1]):
                leader[i] = cython.cast(
                    cython.int, leader_of(pixels, query, places, sums, i, limit, heads, count)
                )
                if leader[i] == i:
                    heads[count] = cython.cast(cython.int, i)
                    count += 1


def leader_of(pixels, query, places, sums, i, limit, heads, count):
    """The last of `count` leaders that entry i is alike to, or i itself.

    By the inequality of Cauchy and Schwarz, sums that are far apart end the search.
    """
    cython.declare(gap=cython.longlong, size=cython.longlong)
    columns, n, size = pixels.shape[1], query.runs.shape[0], query.values.shape[0]
    if count == 0:
        return i
    if sums[i] - sums[heads[count - 1]] <= limit * size:
        gather_runs(pixels, places[i] // columns, places[i] % columns, query.runs, n, query.values)
    for k in range(count - 1, -1, -1):
        j = heads[k]
        gap = sums[i] - sums[j]
        if gap * gap > limit * size:
            return i
        if limit >= run_distance(
            pixels, places[j] // columns, places[j] % columns, query.runs, n, query.values, limit
        ):
            return j
    return i
