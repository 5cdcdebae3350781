# mypy: ignore-errors
"""The kernel that chooses and lays a run of patches; compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.results.paste_kernels import paste
from cython.cimports.weftex.seams.band_kernels import cut_bands
from cython.cimports.weftex.search.zone_kernels import (
    block_means,
    distance,
    gather,
    nearest_by_blocks,
    nearest_by_features,
    project,
)

# Where candidates come from, as `SEARCHES` in patch_analysis.py numbers them.
ALL = cython.declare(cython.int, 0)
BLOCKS = cython.declare(cython.int, 1)
FEATURES = cython.declare(cython.int, 2)
GIVEN = cython.declare(cython.int, 3)

# A patch that repeats nothing may have this times the squared distance of one that does.
VARIETY = cython.declare(cython.double, 1.7)

# Marks of `bar_repeats`.
REPEATS = cython.declare(cython.int, 1)
CONTINUES = cython.declare(cython.int, 2)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def limit_of(
    energy: cython.longlong, best: cython.longlong, tolerance: cython.double, relative: cython.bint
) -> cython.double:
    """The largest squared distance of the set: by the canvas's energy or by the best candidate."""
    if relative:
        return best * (1 + tolerance) * (1 + tolerance)
    return energy * tolerance * tolerance


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    count: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    barred: cython.uchar[::1],
    energy: cython.longlong,
    tolerance: cython.double,
    relative: cython.bint,
    weighted: cython.bint,
    bits: cython.ulonglong,
) -> cython.Py_ssize_t:
    """Draw one of the candidates within the tolerance; the nearest if none is."""
    i: cython.Py_ssize_t
    best: cython.Py_ssize_t = -1
    near: cython.Py_ssize_t = -1
    free: cython.Py_ssize_t = -1
    within: cython.longlong = 0
    limit: cython.double
    total: cython.double = 0
    target: cython.double
    for i in range(count):
        if best < 0 or keys[i] < keys[best]:
            best = i
        if barred[i] < CONTINUES and (near < 0 or keys[i] < keys[near]):
            near = i
        if not barred[i] and (free < 0 or keys[i] < keys[free]):
            free = i
    if near >= 0:
        best = near
    limit = limit_of(energy, keys[best], tolerance, relative)
    if free < 0 or keys[free] > VARIETY * keys[best]:
        for i in range(count):
            barred[i] = 0 if barred[i] < CONTINUES or near < 0 else CONTINUES
    else:
        best = free
        limit = limit_of(energy, keys[best], tolerance, relative)
    for i in range(count):
        if not barred[i] and (keys[i] < limit or (relative and keys[i] <= limit)):
            within += 1
            if weighted and limit > 0:
                total += 1 - sqrt(keys[i] / limit)
    if within == 0:
        return best
    if weighted and total > 0:
        target = total * (bits >> 11) * (1.0 / 9007199254740992.0)
        for i in range(count):
            if not barred[i] and keys[i] < limit:
                target -= 1 - sqrt(keys[i] / limit)
                if target < 0:
                    return i
        return best
    within = cython.cast(cython.longlong, ((bits >> 32) * within) >> 32)
    for i in range(count):
        if not barred[i] and (keys[i] < limit or (relative and keys[i] <= limit)):
            if within == 0:
                return i
            within -= 1
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def bar_repeats(
    count: cython.Py_ssize_t,
    places: cython.int[::1],
    width: cython.Py_ssize_t,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    placed: cython.int[:, ::1],
    around: cython.const[cython.int][:, ::1],
    p: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
    leave: cython.bint,
    barred: cython.uchar[::1],
) -> cython.void:
    """Mark candidates that would show again what a patch around shows.

    One that continues a patch around as in the sample shows nothing twice, but must `leave` it now
    and then, or large pieces of the sample are copied.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    for i in range(count):
        barred[i] = 0
        for k in range(around.shape[1]):
            n = around[p, k]
            if n < 0:
                continue
            dy = places[i] // width - placed[n, 2]
            dx = places[i] % width - placed[n, 3]
            if dy == y - placed[n, 0] and dx == x - placed[n, 1]:
                if leave:
                    barred[i] = CONTINUES
                    break
                continue
            if -reach < dy < reach and -reach < dx < reach:
                barred[i] = REPEATS
                break


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def climb(
    pixels: cython.const[cython.uchar][:, :, ::1],
    turned: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    runs: cython.const[cython.int][:, ::1],
    query: cython.const[cython.uchar][::1],
    stride: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    keys: cython.longlong[::1],
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    """Try the neighbours that a coarse grid of candidates skipped, around the best few."""
    width: cython.Py_ssize_t = usable.shape[1]
    reach: cython.Py_ssize_t = stride // 2
    turn: cython.Py_ssize_t
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    best: cython.Py_ssize_t
    n: cython.Py_ssize_t
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    key: cython.longlong
    place: cython.int
    while reach >= 1:
        n = min(6, count)
        for turn in range(n):  # bring the best few to the front
            best = turn
            for i in range(turn + 1, count):
                if keys[i] < keys[best]:
                    best = i
            key = keys[best]
            place = places[best]
            keys[best] = keys[turn]
            places[best] = places[turn]
            keys[turn] = key
            places[turn] = place
        for turn in range(n):
            place = places[turn]
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    y = place // width + dy * reach
                    x = place % width + dx * reach
                    if y < 0 or x < 0 or y >= usable.shape[0] or x >= width or not usable[y, x]:
                        continue
                    j = 0
                    while j < count and places[j] != y * width + x:
                        j += 1
                    if j == count and count < places.shape[0]:
                        places[count] = cython.cast(cython.int, y * width + x)
                        keys[count] = distance(pixels, turned, y, x, runs, query, -1)
                        count += 1
        reach //= 2
    return count


def sample_patches(
    canvas: cython.uchar[:, :, ::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    turned: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    positions: cython.const[cython.int][::1],
    nodes: cython.const[cython.uchar][:, :, :, :, ::1],
    runs: cython.const[cython.int][:, ::1],
    blocks: cython.const[cython.int][:, ::1],
    side: cython.Py_ssize_t,
    weights: cython.const[cython.ushort][:, :, ::1],
    bands: cython.const[cython.int][::1],
    basis: cython.const[cython.short][:, ::1],
    offset: cython.const[cython.int][::1],
    shift: cython.int,
    features: cython.const[cython.short][:, ::1],
    given: cython.const[cython.int][::1],
    shortlist: cython.int,
    wanted: cython.Py_ssize_t,
    tolerance: cython.double,
    relative: cython.bint,
    weighted: cython.bint,
    bits: cython.const[cython.ulonglong][::1],
    placed: cython.int[:, ::1],
    around: cython.const[cython.int][:, ::1],
    reach: cython.Py_ssize_t,
    placements: cython.int[:, ::1],
    cuts: cython.ushort[:, ::1],
    query: cython.uchar[::1],
    means: cython.int[::1],
    coordinates: cython.short[::1],
    partial: cython.int[::1],
    total: cython.longlong[::1],
    keys: cython.longlong[::1],
    places: cython.int[::1],
    barred: cython.uchar[::1],
    cost: cython.longlong[:, ::1],
):
    """Fill in the source of each placement, in order, and lay its patch on the canvas.

    Every patch of a call has the same zone. `placements` comes with (y, x, -, -, zone) and leaves
    with the source position in the middle; the last nine arrays are scratch.
    `around` names for each patch the earlier ones of `placed` whose content it should not repeat
    within `reach` pixels.
    """
    p: cython.Py_ssize_t
    i: cython.Py_ssize_t
    count: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    sy: cython.Py_ssize_t
    sx: cython.Py_ssize_t
    energy: cython.longlong
    best: cython.longlong
    bound: cython.double
    width: cython.Py_ssize_t = usable.shape[1]
    length: cython.Py_ssize_t = query.shape[0]
    chosen: cython.int
    with cython.nogil:
        for p in range(placements.shape[0]):
            y = placements[p, 0]
            x = placements[p, 1]
            if length == 0 or tolerance > 1e30:
                # Nothing to match, or anything matches: chaos mosaic.
                i = cython.cast(
                    cython.Py_ssize_t,
                    ((bits[p] >> 32) * cython.cast(cython.ulonglong, positions.shape[0])) >> 32,
                )
                chosen = positions[i]
            else:
                energy = gather(canvas, y, x, runs, query)
                if shortlist == ALL:
                    count = positions.shape[0]
                    for i in range(count):
                        places[i] = positions[i]
                        keys[i] = distance(
                            pixels, turned, places[i] // width, places[i] % width, runs, query, -1
                        )
                else:
                    if shortlist == BLOCKS:
                        block_means(canvas, y, x, blocks, side, means)
                        count = nearest_by_blocks(
                            nodes, blocks, means, usable, partial, total, wanted, keys, places
                        )
                    elif shortlist == FEATURES:
                        block_means(canvas, y, x, blocks, side, means)
                        project(basis, offset, shift, means, coordinates)
                        count = nearest_by_features(
                            features, positions, coordinates, wanted, keys, places
                        )
                    else:
                        count = given.shape[0]
                        for i in range(count):
                            places[i] = given[i]
                    bar_repeats(
                        count, places, width, y, x, placed, around, p, reach, bits[p] & 1, barred
                    )
                    best = -1
                    bound = -1
                    for i in range(count):
                        keys[i] = distance(
                            pixels, turned, places[i] // width, places[i] % width, runs, query,
                            cython.cast(cython.longlong, bound),
                        )  # fmt: skip
                        if barred[i] < CONTINUES and (best < 0 or keys[i] < best):
                            best = keys[i]  # the worst that `choose` may take from here on
                            bound = VARIETY * best if reach > 0 else best
                            bound = max(bound, limit_of(energy, best, tolerance, relative))
                            if relative:
                                bound *= (1 + tolerance) * (1 + tolerance)
                            bound += 1
                    if nodes.shape[1] > 1:
                        count = climb(
                            pixels, turned, usable, runs, query, nodes.shape[1], count, keys, places
                        )
                bar_repeats(
                    count, places, width, y, x, placed, around, p, reach, bits[p] & 1, barred
                )
                chosen = places[
                    choose(count, keys, barred, energy, tolerance, relative, weighted, bits[p])
                ]
            sy = chosen // width
            sx = chosen % width
            placements[p, 2] = cython.cast(cython.int, sy)
            placements[p, 3] = cython.cast(cython.int, sx)
            if cuts.shape[0] > 0:
                cut_bands(canvas, pixels, y, x, sy, sx, weights, bands, cost, cuts, p)
            paste(
                canvas, pixels, 0, 0, canvas.shape[0], canvas.shape[1],
                y, x, sy, sx, weights, 0, cuts, p, 1, False,
            )  # fmt: skip
