# mypy: ignore-errors
"""The kernels of texture analysis (sections 4.1 and 4.4); compiled by Cython, see setup.py.

Shared types are declared in list_kernels.pxd.
"""

import cython
from cython.cimports.weftex.search.color_kernels import near_colors
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
    cython.declare(d=cython.Py_ssize_t, j=cython.Py_ssize_t, listed=cython.longlong)
    listed = 0
    for d in range(lists.offsets.shape[0]):
        slots[d] = slot_of(lists, colors[d], stamp) if colors[d] >= 0 else -1
        for j in range(lists.kept[slots[d], 1] if slots[d] >= 0 else 0):
            listed += lists.starts[d, lists.intervals[slots[d], 2 * j + 1]]
            listed -= lists.starts[d, lists.intervals[slots[d], 2 * j]]
    return listed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def slot_of(lists: Lists, color: cython.int, stamp: cython.int) -> cython.int:
    """Return the row of `intervals` that holds the colors near to `color`.

    The last lookups are cached, as two of a pixel's four neighbors are also the next pixel's
    (section 4.4, figure 5); the least recently used is replaced.
    """
    cython.declare(slot=cython.int, oldest=cython.int)
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
            cython.int,
            near_colors(lists.tree, color, lists.radius[color], lists.intervals, oldest),
        )
    return oldest


@cython.cclass
class Entries:
    """The places of all lists, sorted by the sums of their windows' bytes within each."""

    pixels: cython.const[cython.uchar][:, :, ::1]
    runs: cython.const[cython.int][:, ::1]
    size: cython.longlong  # bytes of a window
    places: cython.const[cython.int][::1]
    sums: cython.const[cython.longlong][::1]
    query: cython.uchar[::1]  # room for a window
    heads: cython.int[::1]  # room for a list

    def __init__(self, pixels, runs, places, sums, query, heads):
        self.pixels, self.runs, self.places, self.sums = pixels, runs, places, sums
        self.query, self.heads, self.size = query, heads, len(query)


def group_places(
    entries: Entries,
    starts: cython.const[cython.int][::1],
    limit: cython.longlong,
    leader: cython.int[::1],
):
    """Fill `leader` with the first entry of each list whose window is within `limit` of an entry's.

    `limit` is a squared difference. Lists are sorted by the windows' sums, so the inequality of
    Cauchy and Schwarz ends the search early.
    """
    cython.declare(c=cython.Py_ssize_t, i=cython.Py_ssize_t, count=cython.Py_ssize_t)
    with cython.nogil:
        for c in range(starts.shape[0] - 1):
            count = 0
            for i in range(starts[c], starts[c + 1]):
                leader[i] = cython.cast(cython.int, leader_of(entries, i, count, limit))
                if leader[i] == i:
                    entries.heads[count] = cython.cast(cython.int, i)
                    count += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def leader_of(
    entries: Entries, i: cython.Py_ssize_t, count: cython.Py_ssize_t, limit: cython.longlong
) -> cython.Py_ssize_t:
    """The last of `count` leaders that entry i is alike to, or i itself."""
    cython.declare(j=cython.Py_ssize_t, k=cython.Py_ssize_t, n=cython.Py_ssize_t)
    cython.declare(columns=cython.Py_ssize_t, gap=cython.longlong)
    columns, n = entries.pixels.shape[1], entries.runs.shape[0]
    if count == 0:
        return i
    if entries.sums[i] - entries.sums[entries.heads[count - 1]] <= limit * entries.size:
        gather_runs(
            entries.pixels, entries.places[i] // columns, entries.places[i] % columns,
            entries.runs, n, entries.query,
        )  # fmt: skip
    for k in range(count - 1, -1, -1):
        j = entries.heads[k]
        gap = entries.sums[i] - entries.sums[j]
        if gap * gap > limit * entries.size:
            return i
        if limit >= run_distance(
            entries.pixels, entries.places[j] // columns, entries.places[j] % columns,
            entries.runs, n, entries.query, limit,
        ):  # fmt: skip
            return j
    return i
