# mypy: ignore-errors
# cython: infer_types=True
"""The kernels of texture synthesis (section 4.2); compiled, see setup.py and the .pxd.

"Section" and "figure" are those of Sabha, Peers and Dutré (2007). Places and centers are flat
indices into the pixels of the sample's windows.
"""

import cython
from cython.cimports.weftex.methods.exact_matching.list_kernels import Lists, near_lists
from cython.cimports.weftex.search.picture_kernels import Picture, known_runs, portion, usable_place
from cython.cimports.weftex.search.window_kernels import (
    causal_runs,
    copy_pixel,
    gather_runs,
    run_distance,
    turn_runs,
)

LAST_STAMP = cython.declare(cython.longlong, 2**31 - 1)
ALL_KEYS = cython.declare(cython.longlong, 2**32)
MIXER = cython.declare(cython.uint, 2654435761)  # of a place's bits, for its key


class PixelSearch:
    """The search for one pixel: the windows that are compared, and what is kept between pixels."""

    def __init__(self, windows, coarser, queries, neighbors, colors, last, seen):
        self.causal, self.reach, self.coarse_reach, self.repeat_distance, self.most = windows
        self.coarse, self.coarse_done, self.suggested = coarser
        self.guided = len(self.suggested) > 0
        self.query, self.coarse_query = queries
        self.color, self.goes_on, self.slots = neighbors
        self.colors, self.last, self.seen, self.stamp = colors, last, seen, 0


def match_pixels(
    lists: Lists,
    picture: Picture,
    search: PixelSearch,
    order: cython.const[cython.int][::1],
    bits: cython.const[cython.ulonglong][::1],
):
    """Synthesize the pixels of `order`; return the number of compared windows (section 4.2).

    `bits` has random bits for each pixel.
    """
    width = picture.source.shape[1]
    search.compared = 0
    if search.stamp > LAST_STAMP - 2 * order.shape[0]:  # a pixel takes one or two
        search.seen[:] = 0
        lists.kept[:, :] = -1
        search.stamp = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            search.y, search.x, search.bits = order[p] // width, order[p] % width, bits[p]
            look_around(lists, picture, search)
            search.chosen = -1
            gather_windows(picture, search)
            find_best(lists, picture, search)
            if search.chosen < 0:  # no list has anything: any window
                search.chosen = lists.centers[portion(search.bits, lists.centers.shape[0])]
            copy_chosen(lists, picture, search)
    return search.compared


def look_around(lists, picture, search):
    """Find the direct neighbors' colors, and the pixels that continue their sources (figure 3)."""
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, source=cython.Py_ssize_t)
    height, width = picture.source.shape[0], picture.source.shape[1]
    columns = lists.pixels.shape[1]
    for d in range(lists.offsets.shape[0]):
        search.color[d] = -1
        search.goes_on[d] = -1
        y = search.y + lists.offsets[d, 0]
        x = search.x + lists.offsets[d, 1]
        if picture.wrap_y:
            y = (y + height) % height
        if picture.wrap_x:
            x = (x + width) % width
        if y < 0 or x < 0 or y >= height or x >= width or not picture.done[y, x]:
            continue
        search.color[d] = search.colors[y, x]
        source = picture.source[y, x]
        if source >= 0:
            y = source // columns - lists.offsets[d, 0]
            x = source % columns - lists.offsets[d, 1]
            search.goes_on[d] = usable_place(lists.usable, lists.period, y, x)
    search.goes_on[lists.offsets.shape[0]] = (
        search.suggested[search.y, search.x] if search.guided else -1
    )


def gather_windows(picture, search):
    """Copy the pixel's window, causal or as far as it is done, and that of the coarser level."""
    y, x, reach, coarse_reach = search.y, search.x, search.reach, search.coarse_reach
    if search.causal:
        search.query.count = causal_runs(
            y, x, picture.done.shape[1], picture.wrap_x, reach, reach, reach, search.query.runs,
        )  # fmt: skip
        turn_runs(search.query.runs, search.query.count)
    else:
        search.query.count = known_runs(
            picture.done, y, x, picture.wrap_y, picture.wrap_x,
            reach, search.query.runs,
        )  # fmt: skip
    gather_runs(picture.pixels, y, x, search.query.runs, search.query.count, search.query.values)
    if search.guided:
        search.coarse_query.count = known_runs(
            search.coarse_done, y, x, picture.wrap_y, picture.wrap_x,
            coarse_reach, search.coarse_query.runs,
        )  # fmt: skip
        gather_runs(
            search.coarse, y, x, search.coarse_query.runs, search.coarse_query.count,
            search.coarse_query.values,
        )  # fmt: skip


def find_best(lists, picture, search):
    """Choose the best match of the reduced search space (section 4.2).

    Sources of nearby pixels are left out, unless there are no others.
    """
    search.best, search.best_key, search.coherent = -1, 0, False
    search.apart = search.repeat_distance
    while True:
        search.stamp += 1
        compare_coherent(lists, picture, search)
        if not (search.coherent and search.best == 0):
            compare_listed(lists, picture, search)
        if search.chosen >= 0 or search.apart == 0:
            return
        search.apart = 0


def compare_coherent(lists, picture, search):
    """Compare the pixels that continue the neighbors' sources; of equal ones the first is best."""
    for d in range(lists.offsets.shape[0] + 1):
        place = search.goes_on[d]
        if place < 0 or search.seen[place] == search.stamp:
            continue
        search.seen[place] = search.stamp
        if repeats(picture, search, place):
            continue
        distance = window_distance(lists, picture, search, place)
        if search.best < 0 or distance < search.best:
            search.best = distance
            search.chosen = place
            search.coherent = True


def compare_listed(lists, picture, search):
    """Compare the union of the lists of the neighbors' colors, or a sample of about `most` windows.

    Each window has one random key, and those with keys below a bound are compared. A first share
    estimates the size of the union; the second is chosen by it.
    """
    listed = near_lists(lists, search.color, search.stamp, search.slots)
    if search.most == 0 or listed <= search.most:
        compare_share(lists, picture, search, ALL_KEYS)
        return
    share = ALL_KEYS * search.most // listed
    met = compare_share(lists, picture, search, share)
    if 0 < met < search.most:
        compare_share(lists, picture, search, share * search.most // met)


def compare_share(lists, picture, search, share):
    """Compare the listed windows with keys below `share`, each once; return how many were new.

    See section 4.4.
    """
    cython.declare(key=cython.uint, low_bits=cython.uint, met=cython.longlong)
    low_bits, stamp, met = cython.cast(cython.uint, search.bits), search.stamp, 0
    if lists.places.shape[0] == 0:
        return 0  # no color lies beside a window, and nothing has an address
    # Pointers, as most entries of a long list are only looked at and left out.
    places, heads = cython.address(lists.places[0]), cython.address(lists.groups[0])
    seen = cython.address(search.seen[0])
    for d in range(lists.offsets.shape[0]):
        slot = search.slots[d]
        for j in range(lists.kept[slot, 1] if slot >= 0 else 0):
            for i in range(
                lists.starts[d, lists.intervals[slot, 2 * j]],
                lists.starts[d, lists.intervals[slot, 2 * j + 1]],
            ):
                place = places[heads[i]]
                key = (cython.cast(cython.uint, place) ^ low_bits) * MIXER
                if key < share and seen[place] != stamp:
                    seen[place] = stamp
                    met += 1
                    compare_group(lists, picture, search, i, key)
    return met


def compare_group(lists, picture, search, group, key):
    """Compare one entry of a list; a random member stands for a group.

    Of windows at the same distance a coherent one wins, then the one with the smallest random key.
    """
    first = lists.groups[group]
    distance = window_distance(lists, picture, search, lists.places[first])
    if search.best >= 0 and (
        distance > search.best or (distance == search.best and search.coherent)
    ):
        return
    member = lists.places[first + portion(search.bits, lists.groups[group + 1] - first)]
    if repeats(picture, search, member):
        return
    if search.best < 0 or distance < search.best or key < search.best_key:
        search.best = distance
        search.best_key = key
        search.chosen = member
        search.coherent = False


def window_distance(lists, picture, search, place):
    """The L2 difference to the window at a place, and at the coarser level; past `best` any."""
    search.compared += 1
    y, x = place // lists.pixels.shape[1], place % lists.pixels.shape[1]
    distance = run_distance(
        lists.pixels, y, x, search.query.runs, search.query.count, search.query.values, search.best
    )
    if search.guided and (search.best < 0 or distance <= search.best):
        distance += run_distance(
            lists.coarse, y, x, search.coarse_query.runs, search.coarse_query.count,
            search.coarse_query.values, -1,
        )  # fmt: skip
    return distance


def repeats(picture, search, place):
    """Whether a place was last copied to another pixel nearer than `apart`."""
    last = search.last[place]
    if last < 0:
        return False
    dy = last // picture.source.shape[1] - search.y
    dx = last % picture.source.shape[1] - search.x
    if dy == 0 and dx == 0:
        return False
    return -search.apart < dy < search.apart and -search.apart < dx < search.apart


def copy_chosen(lists, picture, search):
    """Copy the center of the chosen window."""
    y, x, columns = search.y, search.x, lists.pixels.shape[1]
    copy_pixel(lists.pixels, search.chosen, picture.pixels, picture.source, y, x)
    search.colors[y, x] = lists.number[search.chosen // columns, search.chosen % columns]
    picture.done[y, x] = 1
    search.last[search.chosen] = cython.cast(cython.int, y * picture.source.shape[1] + x)
