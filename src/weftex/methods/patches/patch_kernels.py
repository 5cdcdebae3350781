# mypy: ignore-errors
"""The kernel that chooses and pastes a run of patches; compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.repeats.overlap_kernels import repeated_pixels
from cython.cimports.weftex.results.paste_kernels import Layout, View, paste
from cython.cimports.weftex.search.zone_kernels import (
    ALL,
    Shortlist,
    ZoneWindows,
    climb,
    distance,
    gather,
    list_candidates,
)

# A patch that repeats nothing may have this times the squared distance of one that does.
UNREPEATED = cython.declare(cython.double, 1.7)

# More than any path of real differences: 2**16 pixels of 2**10 channels.
OUTSIDE = cython.declare(cython.longlong, 1 << 44)

# Marks of `bar_repeats`.
REPEATS = cython.declare(cython.int, 1)
CONTINUES = cython.declare(cython.int, 2)


@cython.cclass
class Tolerance:
    """Which candidates may be taken, and how one of them is drawn.

    The limit is `value` times the zone's root mean square (epsilon of section 2.4), or with
    `of_best` 1 + `value` times the best distance. Draws are uniform or by alpha_i of section 2.1.
    """

    value: cython.double
    of_best: cython.bint
    by_similarity: cython.bint

    def __init__(self, value, of_best, by_similarity):
        self.value = value
        self.of_best = of_best
        self.by_similarity = by_similarity


@cython.cclass
class Patches:
    """The patches of an output, numbered in their order, and the sample that they come from."""

    pixels: cython.const[cython.uchar][:, :, ::1]  # of the sample
    turned: cython.const[cython.uchar][:, :, ::1]  # the same with exchanged axes
    placements: cython.int[:, ::1]  # (n, 5), as in `Layout`; sources are filled in
    cuts: cython.ushort[:, ::1]  # as in `Layout`; filled in
    bits: cython.const[cython.ulonglong][::1]  # (n,), random
    around: cython.const[cython.int][:, ::1]  # (n, k): earlier patches not to repeat; -1 for none
    keep_apart: cython.Py_ssize_t  # pixels between the sources of patches around

    def __init__(self, pixels, turned, placements, cuts, bits, around, keep_apart):
        self.pixels = pixels
        self.turned = turned
        self.placements = placements
        self.cuts = cuts
        self.bits = bits
        self.around = around
        self.keep_apart = keep_apart


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def limit_of(energy: cython.longlong, best: cython.double, tolerance: Tolerance) -> cython.double:
    """Return the set's largest squared distance, from the canvas's energy or the best candidate.

    Both are A d**2: `energy` is the sum of squares whose mean is in d_max of section 2.4.
    """
    if tolerance.of_best:
        return best * (1 + tolerance.value) * (1 + tolerance.value)
    return energy * tolerance.value * tolerance.value


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def in_set(key: cython.double, limit: cython.double, tolerance: Tolerance) -> cython.bint:
    """Whether a candidate is in Psi_B, eq. (1); of the best, itself included, or of d_max."""
    return key < limit or (tolerance.of_best and key <= limit)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def draw_one(
    best: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    energy: cython.longlong,
    bits: cython.ulonglong,
    tolerance: Tolerance,
    found: Shortlist,
) -> cython.Py_ssize_t:
    """Draw one of the candidates within the tolerance that are not barred; `best` if none is."""
    keys: cython.p_longlong = cython.address(found.keys[0])
    barred: cython.p_uchar = cython.address(found.barred[0])
    limit: cython.double = limit_of(energy, cython.cast(cython.double, keys[best]), tolerance)
    within: cython.longlong = 0
    total: cython.double = 0
    cython.declare(i=cython.Py_ssize_t, target=cython.double)
    for i in range(count):
        if not barred[i] and in_set(cython.cast(cython.double, keys[i]), limit, tolerance):
            within += 1
            if tolerance.by_similarity and limit > 0:
                total += 1 - sqrt(keys[i] / limit)
    if within == 0:
        return best
    if tolerance.by_similarity and total > 0:
        target = total * (bits >> 11) * (1.0 / 9007199254740992.0)
        for i in range(count):
            if not barred[i] and keys[i] < limit:
                target -= 1 - sqrt(keys[i] / limit)
                if target < 0:
                    return i
        return best
    within = cython.cast(cython.longlong, ((bits >> 32) * within) >> 32)
    for i in range(count):
        if not barred[i] and in_set(cython.cast(cython.double, keys[i]), limit, tolerance):
            if within == 0:
                return i
            within -= 1
    return best


# What follows up to `best_unrepeated` is in no paper: neighboring patches do not repeat.


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def bar_repeats(
    patches: Patches,
    p: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    found: Shortlist,
) -> cython.void:
    """Mark candidates that would repeat the source of a patch near patch `p`.

    A candidate that continues a neighboring patch repeats nothing, but half of the patches must not
    continue one, or large pieces of the sample are copied.
    """
    leave: cython.bint = patches.bits[p] & 1
    this: cython.p_const_int = cython.address(patches.placements[p, 0])
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, repeated=cython.longlong)
    cython.declare(other=cython.p_const_int, mark=cython.uchar)
    for i in range(count):
        mark = 0
        for k in range(patches.around.shape[1]):
            if patches.around[p, k] < 0:
                continue
            other = cython.address(patches.placements[patches.around[p, k], 0])
            repeated = repeated_pixels(
                found.places[i] // width - other[2], found.places[i] % width - other[3],
                this[0] - other[0], this[1] - other[1], patches.keep_apart, patches.keep_apart,
            )  # fmt: skip
            if repeated > 0:
                mark = REPEATS
                break
            if repeated < 0 and leave:
                mark = CONTINUES
                break
        found.barred[i] = mark


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_unrepeated(count: cython.Py_ssize_t, found: Shortlist) -> cython.Py_ssize_t:
    """Return the best candidate without a repeat, unless it is much worse than the best of all.

    If it is, candidates that continue no patch are freed; if there are none, all are.
    """
    best: cython.Py_ssize_t = -1
    near: cython.Py_ssize_t = -1
    free: cython.Py_ssize_t = -1
    keys: cython.p_longlong = cython.address(found.keys[0])
    barred: cython.p_uchar = cython.address(found.barred[0])
    i: cython.Py_ssize_t
    for i in range(count):
        if best < 0 or keys[i] < keys[best]:
            best = i
        if barred[i] < CONTINUES and (near < 0 or keys[i] < keys[near]):
            near = i
        if not barred[i] and (free < 0 or keys[i] < keys[free]):
            free = i
    if near >= 0:
        best = near
    if free >= 0 and keys[free] <= UNREPEATED * keys[best]:
        return free
    for i in range(count):
        barred[i] = 0 if barred[i] < CONTINUES or near < 0 else CONTINUES
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def measure(
    patches: Patches,
    windows: ZoneWindows,
    tolerance: Tolerance,
    energy: cython.longlong,
    count: cython.Py_ssize_t,
    found: Shortlist,
) -> cython.void:
    """Compare candidates at the full resolution by eq. (2), each until it is hopeless."""
    width: cython.Py_ssize_t = windows.usable.shape[1]
    best: cython.longlong = -1
    bound: cython.double = -1
    place: cython.Py_ssize_t
    key: cython.longlong
    i: cython.Py_ssize_t
    for i in range(count):
        place = found.places[i]
        key = distance(
            patches.pixels, patches.turned, place // width, place % width, windows.runs,
            found.query, cython.cast(cython.longlong, bound),
        )  # fmt: skip
        found.keys[i] = key
        if found.barred[i] < CONTINUES and (best < 0 or key < best):
            best = key  # the worst that may be drawn from here on
            bound = UNREPEATED * best if patches.keep_apart > 0 else best
            bound = max(bound, limit_of(energy, best, tolerance))
            if tolerance.of_best:
                bound *= (1 + tolerance.value) * (1 + tolerance.value)
            bound += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    canvas: cython.const[cython.uchar][:, :, ::1],
    patches: Patches,
    p: cython.Py_ssize_t,
    windows: ZoneWindows,
    tolerance: Tolerance,
    found: Shortlist,
) -> cython.Py_ssize_t:
    """Return the number of the window that patch `p` shows: steps 1 to 4 of section 2.2."""
    y: cython.Py_ssize_t = patches.placements[p, 0]
    x: cython.Py_ssize_t = patches.placements[p, 1]
    width: cython.Py_ssize_t = windows.usable.shape[1]
    energy: cython.longlong
    cython.declare(count=cython.Py_ssize_t, best=cython.Py_ssize_t, windows_there=cython.ulonglong)
    if windows.area == 0 or tolerance.value > 1e30:
        # Step 1: nothing to match. Or anything matches: the chaos mosaic.
        windows_there = cython.cast(cython.ulonglong, windows.positions.shape[0])
        return windows.positions[
            cython.cast(cython.Py_ssize_t, ((patches.bits[p] >> 32) * windows_there) >> 32)
        ]
    energy = gather(canvas, y, x, windows.runs, found.query)  # E_out
    # Step 2: which windows match it.
    count = list_candidates(canvas, y, x, windows, found)
    bar_repeats(patches, p, count, width, found)
    measure(patches, windows, tolerance, energy, count, found)
    if windows.source != ALL and windows.nodes.shape[1] > 1:
        count = climb(patches.pixels, patches.turned, windows, count, found)
        bar_repeats(patches, p, count, width, found)
    # Steps 3 and 4: draw one of Psi_B, or take the closest.
    best = best_unrepeated(count, found)
    return found.places[draw_one(best, count, energy, patches.bits[p], tolerance, found)]


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def cut_bands(
    canvas: cython.const[cython.uchar][:, :, ::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    layout: Layout,
    bands: cython.const[cython.int][::1],
    p: cython.Py_ssize_t,
    cost: cython.longlong[:, ::1],
    cuts: cython.ushort[:, ::1],
) -> cython.void:
    """Find the minimum error boundary cut along each band, by dynamic programming (section 2.1).

    `bands` is depth, the box (top, left, bottom, right) and four flags for left, top, right,
    bottom; row `p` of `cuts` is filled as `paste` reads it. Ties go to the pixel nearest the box's
    border.
    """
    placement: cython.p_const_int = cython.address(layout.placements[p, 0])
    y: cython.Py_ssize_t = placement[0]
    x: cython.Py_ssize_t = placement[1]
    source_y: cython.Py_ssize_t = placement[2]
    source_x: cython.Py_ssize_t = placement[3]
    full_rows: cython.Py_ssize_t = layout.weights.shape[1]
    full_columns: cython.Py_ssize_t = layout.weights.shape[2]
    depth: cython.Py_ssize_t = bands[0]
    top: cython.Py_ssize_t = bands[1]
    left: cython.Py_ssize_t = bands[2]
    bottom: cython.Py_ssize_t = bands[3]
    right: cython.Py_ssize_t = bands[4]
    height: cython.Py_ssize_t = canvas.shape[0]
    width: cython.Py_ssize_t = canvas.shape[1]
    weight: cython.int
    least: cython.longlong
    upright: cython.bint
    cython.declare(side=cython.Py_ssize_t, first=cython.Py_ssize_t, length=cython.Py_ssize_t)
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, v=cython.Py_ssize_t)
    cython.declare(u=cython.Py_ssize_t, j=cython.Py_ssize_t, best=cython.Py_ssize_t)
    for v in range(full_rows):
        cuts[p, v] = 0
        cuts[p, full_rows + v] = cython.cast(cython.ushort, full_columns)
    for u in range(full_columns):
        cuts[p, 2 * full_rows + u] = 0
        cuts[p, 2 * full_rows + full_columns + u] = cython.cast(cython.ushort, full_rows)
    for side in range(4):
        if not bands[5 + side]:
            continue
        upright = side == 0 or side == 2
        first = top if upright else left
        length = bottom - top if upright else right - left
        for i in range(length):
            for k in range(depth):
                if upright:
                    v = top + i
                    u = left + k if side == 0 else right - 1 - k
                else:
                    u = left + i
                    v = top + k if side == 1 else bottom - 1 - k
                cost[i, k] = 0
                weight = layout.weights[0, v, u]
                if weight == 0:
                    cost[i, k] = OUTSIDE
                elif weight < 256:
                    cost[i, k] = squared(
                        cython.address(canvas[(y + v) % height, (x + u) % width, 0]),
                        cython.address(pixels[source_y + v, source_x + u, 0]),
                        canvas.shape[2],
                    )
                if i > 0:
                    least = cost[i - 1, k]
                    if k > 0 and cost[i - 1, k - 1] < least:
                        least = cost[i - 1, k - 1]
                    if k + 1 < depth and cost[i - 1, k + 1] < least:
                        least = cost[i - 1, k + 1]
                    cost[i, k] += least
        best = 0
        for k in range(1, depth):
            if cost[length - 1, k] < cost[length - 1, best]:
                best = k
        for j in range(length):
            i = length - 1 - j
            if j > 0:
                k = best
                if k > 0 and cost[i, k - 1] <= cost[i, best]:
                    best = k - 1
                if k + 1 < depth and cost[i, k + 1] < cost[i, best]:
                    best = k + 1
            if side == 0:
                cuts[p, first + i] = cython.cast(cython.ushort, left + best)
            elif side == 1:
                cuts[p, 2 * full_rows + first + i] = cython.cast(cython.ushort, top + best)
            elif side == 2:
                cuts[p, full_rows + first + i] = cython.cast(cython.ushort, right - best)
            else:
                cuts[p, 2 * full_rows + full_columns + first + i] = cython.cast(
                    cython.ushort, bottom - best
                )


def lay_patches(
    canvas: cython.uchar[:, :, ::1],
    patches: Patches,
    first: cython.Py_ssize_t,
    last: cython.Py_ssize_t,
    layout: Layout,
    windows: ZoneWindows,
    tolerance: Tolerance,
    found: Shortlist,
):
    """Choose sources for patches `first` to `last` - 1, cut each and paste it on the canvas.

    All have the zone of `windows`; `layout` has its weights alone.
    """
    whole: View = View(0, 0, 1, 0)
    width: cython.Py_ssize_t = windows.usable.shape[1]
    cython.declare(p=cython.Py_ssize_t, chosen=cython.Py_ssize_t)
    with cython.nogil:
        for p in range(first, last):
            chosen = choose(canvas, patches, p, windows, tolerance, found)
            patches.placements[p, 2] = cython.cast(cython.int, chosen // width)
            patches.placements[p, 3] = cython.cast(cython.int, chosen % width)
            if patches.cuts.shape[0] > 0:
                cut_bands(
                    canvas, patches.pixels, layout, windows.bands, p, found.path, patches.cuts
                )
            paste(canvas, patches.pixels, layout, p, 0, whole)


def find_cuts(canvas, pixels, layout: Layout, bands, p, cost, cuts):
    """Fill row `p` of `cuts` with the minimum-error paths of one patch."""
    cut_bands(canvas, pixels, layout, bands, p, cost, cuts)
