# mypy: ignore-errors
"""The kernel that chooses and lays a run of patches; compiled by Cython, see setup.py."""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.methods.patches.sight_kernels import Sight, shown_again
from cython.cimports.weftex.results.paste_kernels import Layout, View, paste
from cython.cimports.weftex.seams.band_kernels import cut_bands
from cython.cimports.weftex.search.zone_kernels import distance, gather
from cython.cimports.weftex.search.zone_search_kernels import (
    ALL,
    Candidates,
    Sample,
    Search,
    Zone,
    climb,
    list_candidates,
)

# A patch that repeats nothing may have this times the squared distance of one that does.
VARIETY = cython.declare(cython.double, 1.7)

# No patch is taken for what it does not show again that has more than this times the best's.
CLOSE = cython.declare(cython.double, 1.25)

# Marks of `bar_repeats` and `weigh`.
REPEATS = cython.declare(cython.int, 1)
CONTINUES = cython.declare(cython.int, 2)
DEARER = cython.declare(cython.int, 3)


@cython.cclass
class Rule:
    """Which candidates may be taken, and how one of them is drawn.

    Parameters
    ----------
    tolerance : float
        The largest distance over the root mean square of the zone on the canvas, which is epsilon
        of section 2.4; or, with `of_best`, how much worse than the best candidate, relatively.
    of_best : bool
        See `tolerance`.
    by_similarity : bool
        Draw by the similarity factors alpha_i of section 2.1, not evenly.
    reach : int
        Sources of patches near each other keep this many pixels apart.
    """

    tolerance: cython.double
    of_best: cython.bint
    by_similarity: cython.bint
    reach: cython.Py_ssize_t

    def __init__(self, tolerance, of_best, by_similarity, reach):
        self.tolerance = tolerance
        self.of_best = of_best
        self.by_similarity = by_similarity
        self.reach = reach


@cython.cclass
class Patches:
    """A run of patches with one zone.

    Parameters
    ----------
    placements : int32 array (n, 5)
        y and x of each patch; y and x of its source are filled in.
    cuts : uint16 array (n, 2 * (rows + columns)) or (0, 0)
        Filled in, see `paste_kernels.Layout`.
    layout : Layout
        Of these placements and cuts, with the weights of the zone alone.
    bits : uint64 array (n,)
        Random.
    all_placements : int32 array (patches, 5)
        Of the whole output.
    around : int32 array (n, neighbors)
        For each patch the earlier ones, rows of `all_placements`, whose content it should not
        repeat; -1 for none.
    given : int32 array (candidates,)
        Windows that a kd-tree found, for a run of one patch.
    sight : Sight
        What of the patches laid before is not to be shown again.
    """

    placements: cython.int[:, ::1]
    cuts: cython.ushort[:, ::1]
    layout: Layout
    bits: cython.const[cython.ulonglong][::1]
    all_placements: cython.const[cython.int][:, ::1]
    around: cython.const[cython.int][:, ::1]
    given: cython.const[cython.int][::1]
    sight: Sight

    def __init__(self, placements, cuts, layout, bits, all_placements, around, given, sight):
        self.placements = placements
        self.cuts = cuts
        self.layout = layout
        self.bits = bits
        self.all_placements = all_placements
        self.around = around
        self.given = given
        self.sight = sight


@cython.cclass
class Scratch(Candidates):
    """Room for one patch at a time: its candidates, their costs, which are barred, and its cuts.

    A candidate costs its squared distance, and more for what it shows again.
    """

    costs: cython.double[::1]
    barred: cython.uchar[::1]
    cost: cython.longlong[:, ::1]

    def __init__(self, costs, barred, cost, **candidates):
        Candidates.__init__(self, **candidates)
        self.costs = costs
        self.barred = barred
        self.cost = cost


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def limit_of(energy: cython.longlong, best: cython.double, rule: Rule) -> cython.double:
    """The largest cost of the set: by the canvas's energy or by the best candidate.

    Both are A d**2: `energy` is the sum of squares whose mean is in d_max of section 2.4.
    """
    if rule.of_best:
        return best * (1 + rule.tolerance) * (1 + rule.tolerance)
    return energy * rule.tolerance * rule.tolerance


@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def in_set(cost: cython.double, limit: cython.double, rule: Rule) -> cython.bint:
    """Whether a candidate is in Psi_B, eq. (1); of the best, itself included, or of d_max."""
    return cost < limit or (rule.of_best and cost <= limit)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def weigh(
    p: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    bound: cython.double,
    limit: cython.double,
    patches: Patches,
    scratch: Scratch,
) -> cython.Py_ssize_t:
    """Make candidates dearer by what they show again; bar those past a bound. Return the cheapest.

    Dearer by a share of their squared distance, or of the `limit` where nearer ones match as well.
    So none is taken that is clearly worse.
    """
    y: cython.Py_ssize_t = patches.placements[p, 0]
    x: cython.Py_ssize_t = patches.placements[p, 1]
    best: cython.Py_ssize_t = -1
    costs: cython.p_double = cython.address(scratch.costs[0])
    cython.declare(i=cython.Py_ssize_t, place=cython.Py_ssize_t, more=cython.double)
    for i in range(count):
        if scratch.barred[i]:
            continue
        if costs[i] > bound:
            scratch.barred[i] = DEARER
            continue
        place = scratch.places[i]
        more = shown_again(patches.sight, p, y, x, place // width, place % width)
        costs[i] += patches.sight.variety * more * max(costs[i], limit, 1.0)
        if best < 0 or costs[i] < costs[best]:
            best = i
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def choose(
    p: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    energy: cython.longlong,
    rule: Rule,
    patches: Patches,
    scratch: Scratch,
) -> cython.Py_ssize_t:
    """Draw one of the candidates within the tolerance; the cheapest if none is."""
    best: cython.Py_ssize_t = -1
    near: cython.Py_ssize_t = -1
    free: cython.Py_ssize_t = -1
    within: cython.longlong = 0
    total: cython.double = 0
    bits: cython.ulonglong = patches.bits[p]
    costs: cython.p_double = cython.address(scratch.costs[0])
    barred: cython.p_uchar = cython.address(scratch.barred[0])
    cython.declare(i=cython.Py_ssize_t, limit=cython.double, target=cython.double)
    cython.declare(bound=cython.double)
    for i in range(count):
        costs[i] = cython.cast(cython.double, scratch.keys[i])
        if best < 0 or costs[i] < costs[best]:
            best = i
        if barred[i] < CONTINUES and (near < 0 or costs[i] < costs[near]):
            near = i
        if not barred[i] and (free < 0 or costs[i] < costs[free]):
            free = i
    if near >= 0:
        best = near
    bound = VARIETY * costs[best]
    if free < 0 or costs[free] > bound:
        for i in range(count):
            barred[i] = 0 if barred[i] < CONTINUES or near < 0 else CONTINUES
    else:
        best = free
    limit = limit_of(energy, costs[best], rule)
    if patches.sight.variety > 0:
        bound = max(min(CLOSE * costs[best], bound), limit)
        best = weigh(p, count, width, bound, 0.0 if rule.of_best else limit, patches, scratch)
        limit = limit_of(energy, costs[best], rule)
    for i in range(count):
        if not barred[i] and in_set(costs[i], limit, rule):
            within += 1
            if rule.by_similarity and limit > 0:
                total += 1 - sqrt(costs[i] / limit)
    if within == 0:
        return best
    if rule.by_similarity and total > 0:
        target = total * (bits >> 11) * (1.0 / 9007199254740992.0)
        for i in range(count):
            if not barred[i] and costs[i] < limit:
                target -= 1 - sqrt(costs[i] / limit)
                if target < 0:
                    return i
        return best
    within = cython.cast(cython.longlong, ((bits >> 32) * within) >> 32)
    for i in range(count):
        if not barred[i] and in_set(costs[i], limit, rule):
            if within == 0:
                return i
            within -= 1
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def bar_repeats(
    p: cython.Py_ssize_t,
    count: cython.Py_ssize_t,
    width: cython.Py_ssize_t,
    rule: Rule,
    patches: Patches,
    scratch: Scratch,
) -> cython.void:
    """Mark candidates that would show again what a patch around patch `p` shows.

    One that continues a patch around as in the sample shows nothing twice, but must leave it now
    and then, or large pieces of the sample are copied.
    """
    y: cython.Py_ssize_t = patches.placements[p, 0]
    x: cython.Py_ssize_t = patches.placements[p, 1]
    reach: cython.Py_ssize_t = rule.reach
    leave: cython.bint = patches.bits[p] & 1
    places: cython.p_int = cython.address(scratch.places[0])
    barred: cython.p_uchar = cython.address(scratch.barred[0])
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, n=cython.Py_ssize_t)
    cython.declare(dy=cython.Py_ssize_t, dx=cython.Py_ssize_t, mark=cython.uchar)
    cython.declare(source_y=cython.Py_ssize_t, source_x=cython.Py_ssize_t)
    for i in range(count):
        source_y = places[i] // width
        source_x = places[i] % width
        mark = 0
        for k in range(patches.around.shape[1]):
            n = patches.around[p, k]
            if n < 0:
                continue
            dy = source_y - patches.all_placements[n, 2]
            dx = source_x - patches.all_placements[n, 3]
            if dy == y - patches.all_placements[n, 0] and dx == x - patches.all_placements[n, 1]:
                if leave:
                    mark = CONTINUES
                    break
                continue
            if -reach < dy < reach and -reach < dx < reach:
                mark = REPEATS
                break
        barred[i] = mark


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def measure(
    sample: Sample,
    zone: Zone,
    search: Search,
    rule: Rule,
    energy: cython.longlong,
    count: cython.Py_ssize_t,
    variety: cython.double,
    scratch: Scratch,
) -> cython.void:
    """Compare candidates at the full resolution by eq. (2), each until it is hopeless."""
    width: cython.Py_ssize_t = search.usable.shape[1]
    best: cython.longlong = -1
    bound: cython.double = -1
    place: cython.Py_ssize_t
    key: cython.longlong
    i: cython.Py_ssize_t
    for i in range(count):
        place = scratch.places[i]
        key = distance(
            sample.pixels, sample.turned, place // width, place % width, zone.runs,
            scratch.query, cython.cast(cython.longlong, bound),
        )  # fmt: skip
        scratch.keys[i] = key
        if search.source == ALL:
            continue
        if scratch.barred[i] < CONTINUES and (best < 0 or key < best):
            best = key  # the worst that `choose` may take from here on
            bound = VARIETY * best if rule.reach > 0 or variety > 0 else best
            bound = max(bound, limit_of(energy, best, rule))
            if rule.of_best:
                bound *= (1 + rule.tolerance) * (1 + rule.tolerance)
            bound += 1


def lay_patches(
    canvas: cython.uchar[:, :, ::1],
    sample: Sample,
    zone: Zone,
    search: Search,
    rule: Rule,
    patches: Patches,
    scratch: Scratch,
):
    """Choose the source of each patch of a run, in order, and lay the patch on the canvas.

    Steps 1 to 4 of section 2.2 in Liang et al., and the cut of Efros and Freeman.
    """
    layout: Layout = patches.layout
    whole: View = View(0, 0, 1, 0)
    width: cython.Py_ssize_t = search.usable.shape[1]
    chosen: cython.Py_ssize_t
    energy: cython.longlong
    cython.declare(p=cython.Py_ssize_t, i=cython.Py_ssize_t, count=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    with cython.nogil:
        for p in range(patches.placements.shape[0]):
            y = patches.placements[p, 0]
            x = patches.placements[p, 1]
            if zone.area == 0 or rule.tolerance > 1e30:
                # Step 1: nothing to match. Or anything matches: the chaos mosaic.
                i = cython.cast(
                    cython.Py_ssize_t,
                    (
                        (patches.bits[p] >> 32)
                        * cython.cast(cython.ulonglong, search.positions.shape[0])
                    )
                    >> 32,
                )
                chosen = search.positions[i]
            else:
                energy = gather(canvas, y, x, zone.runs, scratch.query)  # E_out
                # Step 2: which windows match it.
                count = list_candidates(canvas, y, x, zone, search, patches.given, scratch)
                if search.source != ALL:
                    bar_repeats(p, count, width, rule, patches, scratch)
                measure(sample, zone, search, rule, energy, count, patches.sight.variety, scratch)
                if search.source != ALL and search.nodes.shape[1] > 1:
                    count = climb(sample, zone, search, count, scratch)
                bar_repeats(p, count, width, rule, patches, scratch)
                # Steps 3 and 4: draw one of Psi_B, or take the closest.
                chosen = scratch.places[choose(p, count, width, energy, rule, patches, scratch)]
            patches.placements[p, 2] = cython.cast(cython.int, chosen // width)
            patches.placements[p, 3] = cython.cast(cython.int, chosen % width)
            if patches.cuts.shape[0] > 0:
                cut_bands(canvas, sample.pixels, layout, zone.bands, p, scratch.cost, patches.cuts)
            paste(canvas, sample.pixels, layout, p, 0, whole)
