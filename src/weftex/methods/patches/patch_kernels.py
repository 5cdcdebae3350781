# mypy: ignore-errors
"""The kernel that chooses and pastes a run of patches; compiled by Cython, see setup.py.

Sections and equations are those of Liang et al. (2001), unless Efros and Freeman (2001) are named.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.methods.patches.zone_kernels import (
    ALL,
    Shortlist,
    ZoneWindows,
    climb,
    copy_zone,
    list_candidates,
    zone_distance,
)
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.results.paste_kernels import Layout, paste

# The largest m of section 3.2. If most of so many candidates match, others do too, see `spread`.
MOST_CANDIDATES = cython.declare(cython.Py_ssize_t, 10000)
LARGEST_M = int(MOST_CANDIDATES)  # for Python

# The squared distance that a patch without repeats may have, relative to the best with some.
UNREPEATED = cython.declare(cython.double, 1.7)

# Marks of `exclude_nearby`.
REPEATS = cython.declare(cython.uchar, 1)
CONTINUES = cython.declare(cython.uchar, 2)

# More than any path of real differences: 2**16 pixels of 2**10 channels.
OUTSIDE = cython.declare(cython.longlong, 1 << 44)


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
        self.value, self.of_best, self.by_similarity = value, of_best, by_similarity


@cython.cclass
class Patches:
    """The patches of an output, numbered in their order, and the sample that they come from."""

    pixels: cython.const[cython.uchar][:, :, ::1]  # of the sample
    transposed: cython.const[cython.uchar][:, :, ::1]  # the same with exchanged axes
    placements: cython.int[:, ::1]  # (n, 5), as in `Layout`; sources are filled in
    cuts: cython.ushort[:, ::1]  # as in `Layout`; filled in
    bits: cython.const[cython.ulonglong][::1]  # (n,), random
    around: cython.const[cython.int][:, ::1]  # (n, k): earlier patches not to repeat; -1 for none
    keep_apart: cython.Py_ssize_t  # pixels between the sources of patches around

    def __init__(self, pixels, transposed, placements, cuts, bits, around, keep_apart):
        self.pixels, self.transposed = pixels, transposed
        self.placements, self.cuts = placements, cuts
        self.bits, self.around, self.keep_apart = bits, around, keep_apart


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def squared_limit(
    energy: cython.longlong, best: cython.double, tolerance: Tolerance
) -> cython.double:
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
    best: cython.Py_ssize_t, count: cython.Py_ssize_t, energy: cython.longlong,
    bits: cython.ulonglong, tolerance: Tolerance, found: Shortlist,
) -> cython.Py_ssize_t:  # fmt: skip
    """Draw one of the candidates within the tolerance that are not excluded; `best` if none is."""
    keys: cython.p_longlong = cython.address(found.keys[0])
    excluded: cython.p_uchar = cython.address(found.excluded[0])
    limit: cython.double = squared_limit(energy, cython.cast(cython.double, keys[best]), tolerance)
    within: cython.longlong = 0
    total: cython.double = 0
    cython.declare(i=cython.Py_ssize_t, target=cython.double)
    for i in range(count):
        if not excluded[i] and in_set(cython.cast(cython.double, keys[i]), limit, tolerance):
            within += 1
            if tolerance.by_similarity and limit > 0:
                total += 1 - sqrt(keys[i] / limit)
    if within == 0:
        return best
    if tolerance.by_similarity and total > 0:
        target = total * (bits >> 11) * (1.0 / 9007199254740992.0)
        for i in range(count):
            if not excluded[i] and keys[i] < limit:
                target -= 1 - sqrt(keys[i] / limit)
                if target < 0:
                    return i
        return best
    within = cython.cast(cython.longlong, ((bits >> 32) * within) >> 32)
    for i in range(count):
        if not excluded[i] and in_set(cython.cast(cython.double, keys[i]), limit, tolerance):
            if within == 0:
                return i
            within -= 1
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def exclude_nearby(
    patches: Patches, p: cython.Py_ssize_t, width: cython.Py_ssize_t, count: cython.Py_ssize_t,
    found: Shortlist,
) -> cython.void:  # fmt: skip
    """Mark candidates nearer than `keep_apart` to the source of a patch around.

    One that continues that patch repeats nothing. But half of the patches continue none.
    """
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(this=cython.p_const_int, other=cython.p_const_int)
    apart: cython.Py_ssize_t = patches.keep_apart
    this = cython.address(patches.placements[p, 0])
    for i in range(count):
        found.excluded[i] = 0
        for k in range(patches.around.shape[1]):
            if patches.around[p, k] < 0:
                continue
            other = cython.address(patches.placements[patches.around[p, k], 0])
            y = found.places[i] // width - other[2]
            x = found.places[i] % width - other[3]
            if y == this[0] - other[0] and x == this[1] - other[1]:
                if patches.bits[p] & 1:
                    found.excluded[i] = CONTINUES
                    break
            elif -apart < y < apart and -apart < x < apart:
                found.excluded[i] = REPEATS
                break


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_unrepeated(count: cython.Py_ssize_t, found: Shortlist) -> cython.Py_ssize_t:
    """Return the best unmarked candidate, unless its key is above `UNREPEATED` times the least.

    If it is, candidates that continue no patch are freed; if there are none, all are.
    """
    cython.declare(best=cython.Py_ssize_t, near=cython.Py_ssize_t, free=cython.Py_ssize_t)
    cython.declare(i=cython.Py_ssize_t)
    keys: cython.p_longlong = cython.address(found.keys[0])
    best = near = free = -1
    for i in range(count):
        if best < 0 or keys[i] < keys[best]:
            best = i
        if found.excluded[i] < CONTINUES and (near < 0 or keys[i] < keys[near]):
            near = i
        if not found.excluded[i] and (free < 0 or keys[i] < keys[free]):
            free = i
    if near >= 0:
        best = near
    if free >= 0 and keys[free] <= UNREPEATED * keys[best]:
        return free
    for i in range(count):
        found.excluded[i] = 0 if found.excluded[i] < CONTINUES or near < 0 else CONTINUES
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def measure(
    patches: Patches, windows: ZoneWindows, tolerance: Tolerance, energy: cython.longlong,
    count: cython.Py_ssize_t, found: Shortlist,
) -> cython.void:  # fmt: skip
    """Compare candidates at the full resolution by eq. (2), each until it is hopeless."""
    width: cython.Py_ssize_t = windows.usable.shape[1]
    best: cython.longlong = -1
    bound: cython.double = -1
    place: cython.Py_ssize_t
    key: cython.longlong
    i: cython.Py_ssize_t
    for i in range(count):
        place = found.places[i]
        key = zone_distance(
            patches.pixels, patches.transposed, place // width, place % width, windows.runs,
            found.query, cython.cast(cython.longlong, bound),
        )  # fmt: skip
        found.keys[i] = key
        if found.excluded[i] < CONTINUES and (best < 0 or key < best):
            best = key  # the worst that may be drawn from here on
            bound = UNREPEATED * best if patches.keep_apart > 0 else best
            bound = max(bound, squared_limit(energy, best, tolerance))
            if tolerance.of_best:  # the limit of `draw_one` is relative to what is drawn from
                bound *= (1 + tolerance.value) * (1 + tolerance.value)
            bound += 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def spread(
    windows: ZoneWindows, energy: cython.longlong, start: cython.Py_ssize_t,
    tolerance: Tolerance, count: cython.Py_ssize_t, found: Shortlist,
) -> cython.Py_ssize_t:  # fmt: skip
    """If most candidates match, list windows from all over the sample instead; return how many."""
    matching: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    width: cython.Py_ssize_t = windows.usable.shape[1]
    total: cython.Py_ssize_t = windows.usable.shape[0] * width
    step: cython.Py_ssize_t = total // MOST_CANDIDATES + 1
    for i in range(count):
        matching += found.keys[i] < squared_limit(energy, found.keys[i], tolerance)
    if 2 * matching <= count:
        return 0
    count = 0
    i = start % step
    while i < total:
        if windows.usable[i // width, i % width]:
            found.places[count] = cython.cast(cython.int, i)
            count += 1
        i += step
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose_window(
    canvas: cython.const[cython.uchar][:, :, ::1], patches: Patches, p: cython.Py_ssize_t,
    windows: ZoneWindows, tolerance: Tolerance, found: Shortlist,
) -> cython.Py_ssize_t:  # fmt: skip
    """Return the number of the window that patch `p` shows: steps 1 to 4 of section 2.2."""
    y: cython.Py_ssize_t = patches.placements[p, 0]
    x: cython.Py_ssize_t = patches.placements[p, 1]
    width: cython.Py_ssize_t = windows.usable.shape[1]
    energy: cython.longlong
    cython.declare(count=cython.Py_ssize_t, best=cython.Py_ssize_t)
    cython.declare(start=cython.Py_ssize_t, more=cython.Py_ssize_t)
    windows_there: cython.ulonglong
    if windows.area == 0 or tolerance.value > 1e30:
        # Step 1: nothing to match. Or anything matches: the chaos mosaic.
        windows_there = cython.cast(cython.ulonglong, windows.positions.shape[0])
        return windows.positions[
            cython.cast(cython.Py_ssize_t, ((patches.bits[p] >> 32) * windows_there) >> 32)
        ]
    energy = copy_zone(canvas, y, x, windows.runs, found.query)  # E_out
    # Step 2: which windows match it.
    count = list_candidates(canvas, y, x, windows, found)
    exclude_nearby(patches, p, width, count, found)
    measure(patches, windows, tolerance, energy, count, found)
    if windows.source != ALL and windows.nodes.shape[1] > 1:
        count = climb(patches.pixels, patches.transposed, windows, count, found)
        exclude_nearby(patches, p, width, count, found)
    if count >= MOST_CANDIDATES and windows.source != ALL and not tolerance.of_best:
        start = cython.cast(cython.Py_ssize_t, patches.bits[p] >> 40)
        more = spread(windows, energy, start, tolerance, count, found)
        if more > 0:
            count = more
            exclude_nearby(patches, p, width, count, found)
            measure(patches, windows, tolerance, energy, count, found)
    # Steps 3 and 4: draw one of Psi_B, or take the closest.
    best = best_unrepeated(count, found)
    return found.places[draw_one(best, count, energy, patches.bits[p], tolerance, found)]


@cython.ccall
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
    """Find the minimum error boundary cut along each band, by dynamic programming.

    Section 2.1 of Efros and Freeman. `bands` is depth, the box (left, top, right, bottom) and
    whether there is a band at each of these sides; row `p` of `cuts` is filled as `paste` reads it.
    Ties go to the pixel nearest the box's border.
    """
    placement: cython.p_const_int = cython.address(layout.placements[p, 0])
    rows: cython.Py_ssize_t = layout.weights.shape[1]
    columns: cython.Py_ssize_t = layout.weights.shape[2]
    depth: cython.Py_ssize_t = bands[0]
    upright: cython.bint
    cython.declare(side=cython.Py_ssize_t, first=cython.Py_ssize_t, length=cython.Py_ssize_t)
    cython.declare(edge=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, best=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(at=cython.Py_ssize_t, least=cython.longlong)
    for v in range(rows):
        cuts[p, v] = 0
        cuts[p, rows + v] = cython.cast(cython.ushort, columns)
    for u in range(columns):
        cuts[p, 2 * rows + u] = 0
        cuts[p, 2 * rows + columns + u] = cython.cast(cython.ushort, rows)
    for side in range(4):  # left, top, right, bottom
        if not bands[5 + side]:
            continue
        upright = side % 2 == 0
        first = bands[2] if upright else bands[1]
        length = bands[4] - first if upright else bands[3] - first
        edge = bands[1 + side]
        for i in range(length):
            for k in range(depth):
                at = edge + k if side < 2 else edge - 1 - k
                v = first + i if upright else at
                u = at if upright else first + i
                cost[i, k] = 0
                if layout.weights[0, v, u] == 0:  # the canvas stays
                    cost[i, k] = OUTSIDE
                elif layout.weights[0, v, u] < 256:  # in the overlap
                    y = (placement[0] + v) % canvas.shape[0]
                    x = (placement[1] + u) % canvas.shape[1]
                    cost[i, k] = squared(
                        cython.address(canvas[y, x, 0]),
                        cython.address(pixels[placement[2] + v, placement[3] + u, 0]),
                        canvas.shape[2],
                    )
                if i > 0:
                    least = cost[i - 1, k]
                    if k > 0:
                        least = min(least, cost[i - 1, k - 1])
                    if k + 1 < depth:
                        least = min(least, cost[i - 1, k + 1])
                    cost[i, k] += least
        best = 0
        for k in range(1, depth):
            if cost[length - 1, k] < cost[length - 1, best]:
                best = k
        at = side // 2 * rows if upright else 2 * rows + side // 2 * columns  # in the row of `cuts`
        for i in range(length - 1, -1, -1):
            if i < length - 1:
                k = best
                if k > 0 and cost[i, k - 1] <= cost[i, best]:
                    best = k - 1
                if k + 1 < depth and cost[i, k + 1] < cost[i, best]:
                    best = k + 1
            cuts[p, at + first + i] = cython.cast(
                cython.ushort, edge + best if side < 2 else edge - best
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

    All have the zone of `windows`. `layout` has the weights of this zone alone, as number 0.
    """
    width: cython.Py_ssize_t = windows.usable.shape[1]
    cython.declare(p=cython.Py_ssize_t, chosen=cython.Py_ssize_t)
    with cython.nogil:
        for p in range(first, last):
            chosen = choose_window(canvas, patches, p, windows, tolerance, found)
            patches.placements[p, 2] = cython.cast(cython.int, chosen // width)
            patches.placements[p, 3] = cython.cast(cython.int, chosen % width)
            if patches.cuts.shape[0] > 0:
                cut_bands(
                    canvas, patches.pixels, layout, windows.bands, p, found.path, patches.cuts
                )
            paste(canvas, patches.pixels, layout, p, 0)
