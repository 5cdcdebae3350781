# mypy: ignore-errors
"""Kernels of near-regular synthesis: which piece a gap takes; compiled, see setup.py.

Places are as in `block_kernels`.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.methods.near_regular.block_kernels import (
    Grid,
    Sample,
    any_place,
    around,
    place_at,
    shown_again,
    similar,
)
from cython.cimports.weftex.search.zone_kernels import Shortlist, distance, gather, offer
from cython.cimports.weftex.search.zone_search_kernels import ZoneWindows, list_candidates

NEVER = cython.declare(cython.longlong, 1 << 60)  # more than any piece differs by
MOST_COMPARED = cython.declare(cython.Py_ssize_t, 512)  # similar places that a gap looks at
KNOWN = cython.declare(cython.int, 5)  # the wedge of pixels that the canvas knows


@cython.cclass
class Rule:
    """How gaps are searched for; `variety` is in 1/256.

    Where any place is similar to any other, all `windows` may be searched by the border of a gap;
    otherwise they are None.
    """

    tolerance: cython.Py_ssize_t
    candidates: cython.Py_ssize_t
    variety: cython.longlong
    by_correlation: cython.bint
    by_zone: cython.bint
    windows: ZoneWindows

    def __init__(self, tolerance, candidates, variety, by_correlation, windows):
        self.tolerance, self.candidates, self.variety = tolerance, candidates, variety
        self.by_correlation, self.by_zone = by_correlation, windows is not None
        self.windows = windows


@cython.cclass
class Gap(Shortlist):
    """A gap in the making, and what a thread works on while it fills gaps of one size.

    `wedges` tells from which neighbor each pixel of its border comes, `runs` covers the border,
    `border` holds its pixels; those that the canvas knows are there already.
    """

    wedges: cython.const[cython.uchar][:, ::1]
    runs: cython.const[cython.int][:, ::1]
    border: cython.uchar[:, :, ::1]
    # The neighbors above, left, below and right, numbered from 1: their places, and where in
    # their windows this one's corner lies. And the gap's own size.
    other: cython.int[5]
    dy: cython.longlong[5]
    dx: cython.longlong[5]
    height: cython.longlong
    width: cython.longlong

    def __init__(self, wedges, runs, border, **candidates):
        Shortlist.__init__(self, **candidates)
        self.wedges, self.runs, self.border = wedges, runs, border


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def correlation(
    sample: Sample,
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    runs: cython.const[cython.int][:, ::1],
    query: cython.const[cython.uchar][::1],
) -> cython.longlong:
    """2**40 (1 - gamma) by eq. (3.13) of the border and the window at (y, x)."""
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(at=cython.Py_ssize_t, f=cython.longlong, g=cython.longlong)
    cython.declare(row=cython.p_const_uchar)
    channels: cython.Py_ssize_t = sample.pixels.shape[2]
    n: cython.longlong = 0
    sums = cython.declare(cython.longlong[5])
    above: cython.longlong = 0
    below: cython.double = 0
    for k in range(channels):
        for i in range(5):
            sums[i] = 0
        at = 0
        n = 0
        for r in range(runs.shape[0]):
            if runs[r, 0]:
                row = cython.address(sample.turned[x + runs[r, 2], y + runs[r, 1], 0])
            else:
                row = cython.address(sample.pixels[y + runs[r, 1], x + runs[r, 2], 0])
            for i in range(runs[r, 3]):
                f = row[i * channels + k]
                g = query[at + i * channels + k]
                sums[0] += f
                sums[1] += g
                sums[2] += f * g
                sums[3] += f * f
                sums[4] += g * g
            at += runs[r, 3] * channels
            n += runs[r, 3]
        above += n * sums[2] - sums[0] * sums[1]
        below += sqrt(cython.cast(cython.double, n * sums[3] - sums[0] * sums[0])) * sqrt(
            cython.cast(cython.double, n * sums[4] - sums[1] * sums[1])
        )
    if below <= 0:
        return 1 << 40
    return cython.cast(cython.longlong, (1.0 - above / below) * 1099511627776.0)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def mismatch(
    sample: Sample, rule: Rule, gap: Gap, here: cython.int, bound: cython.longlong
) -> cython.longlong:
    """How badly the piece at a place fits the border: eq. (4.4), or by the GNCC.

    What it shows again of its neighbors makes it count worse, by `variety` where it is all. It is
    given up past `bound`, if that is not negative.
    """
    cython.declare(n=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(shown=cython.longlong, found=cython.longlong)
    area: cython.longlong = max(gap.height * gap.width, 1)
    factor: cython.longlong = 256
    for n in range(1, 5):
        shown = shown_again(
            sample, here, gap.other[n], gap.dy[n], gap.dx[n],
            gap.height, gap.width,
        )  # fmt: skip
        factor += rule.variety * shown // area
    y = here // sample.usable.shape[1]
    x = here % sample.usable.shape[1]
    if rule.by_correlation:
        found = correlation(sample, y, x, gap.runs, gap.query)
    else:
        bound = bound // factor if bound >= 0 else -1
        found = distance(
            sample.pixels, sample.turned, y, x, gap.runs, gap.query, bound
        )  # fmt: skip
    return factor * found


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look_around(grid: Grid, i: cython.Py_ssize_t, j: cython.Py_ssize_t, gap: Gap) -> cython.void:
    """Find the places of a gap's neighbors, and where in their windows its corner lies."""
    cython.declare(n=cython.Py_ssize_t, p=cython.Py_ssize_t, q=cython.Py_ssize_t)
    gap.height = grid.rows[i + 1] - grid.rows[i]
    gap.width = grid.columns[j + 1] - grid.columns[j]
    for n in range(1, 5):
        p = i if n % 2 == 0 else around(grid, 0, i, n - 2)
        q = j if n % 2 else around(grid, 1, j, n - 3)
        gap.other[n] = grid.place[p, q]
        gap.dy[n] = 0
        gap.dx[n] = 0
        if n == 1:
            gap.dy[n] = grid.rows[p + 1] - grid.rows[p]
        elif n == 2:
            gap.dx[n] = grid.columns[q + 1] - grid.columns[q]
        elif n == 3:
            gap.dy[n] = -gap.height
        else:
            gap.dx[n] = -gap.width


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def compose_border(sample: Sample, gap: Gap) -> cython.void:
    """Copy each wedge of a gap's border from the neighbor that it belongs to (Fig. 4.9)."""
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(p=cython.Py_ssize_t, wedge=cython.int)
    cython.declare(here=cython.p_uchar, there=cython.p_const_uchar)
    channels: cython.Py_ssize_t = sample.pixels.shape[2]
    for v in range(gap.wedges.shape[0]):
        for u in range(gap.wedges.shape[1]):
            wedge = gap.wedges[v, u]
            if wedge == 0 or wedge == KNOWN:
                continue
            p = gap.other[wedge] + (gap.dy[wedge] + v) * sample.pixels.shape[1]
            here = cython.address(gap.border[v, u, 0])
            there = cython.address(sample.pixels[0, 0, 0]) + (p + gap.dx[wedge] + u) * channels
            for k in range(channels):
                here[k] = there[k]
    gather(gap.border, 0, 0, gap.runs, gap.query)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_by_zone(sample: Sample, rule: Rule, gap: Gap) -> cython.Py_ssize_t:
    """List the places whose borders are nearest in few numbers (section 5.2); return how many."""
    cython.declare(t=cython.Py_ssize_t, y=cython.int, x=cython.int)
    columns: cython.int = cython.cast(cython.int, rule.windows.usable.shape[1])
    count: cython.Py_ssize_t = list_candidates(gap.border, 0, 0, rule.windows, gap)
    for t in range(count):
        y = gap.places[t] // columns
        x = gap.places[t] % columns
        gap.places[t] = y * cython.cast(cython.int, sample.usable.shape[1]) + x
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_similar(
    sample: Sample,
    grid: Grid,
    steps: cython.const[cython.longlong][:, ::1],
    rule: Rule,
    gap: Gap,
    i: cython.Py_ssize_t,
    j: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """List the places similar to block (i, j) that fit its border best; return how many."""
    cython.declare(k=cython.Py_ssize_t, t=cython.Py_ssize_t, here=cython.int)
    cython.declare(key=cython.longlong, bound=cython.longlong)
    count: cython.Py_ssize_t = 0
    tried: cython.Py_ssize_t = 0
    every: cython.Py_ssize_t = steps.shape[0] if steps.shape[0] else sample.centers.shape[0]
    k = cython.cast(cython.Py_ssize_t, grid.bits[i, j] % cython.cast(cython.ulonglong, every))
    for t in range(every):
        if steps.shape[0]:
            here = similar(sample, grid, steps, i, j, k)
        else:
            here = sample.centers[k]
        k = k + 1 if k + 1 < every else 0
        if here < 0:
            continue
        bound = gap.keys[0] if count == rule.candidates else -1
        key = mismatch(sample, rule, gap, here, bound)
        count = offer(
            key, here, count, rule.candidates,
            cython.address(gap.keys[0]), cython.address(gap.places[0]),
        )  # fmt: skip
        tried += 1
        if tried == MOST_COMPARED and steps.shape[0]:
            break
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def put_best_first(gap: Gap, count: cython.Py_ssize_t) -> cython.void:
    """Move the best place listed to the front, so that all others are soon given up."""
    cython.declare(k=cython.Py_ssize_t, t=cython.Py_ssize_t, here=cython.int)
    k = 0
    for t in range(1, count):
        if gap.keys[t] < gap.keys[k] or (
            gap.keys[t] == gap.keys[k] and gap.places[t] < gap.places[k]
        ):
            k = t
    if count > 0:
        here = gap.places[0]
        gap.places[0] = gap.places[k]
        gap.places[k] = here


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_within_tolerance(
    sample: Sample, rule: Rule, gap: Gap, count: cython.Py_ssize_t
) -> cython.int:
    """The best place within the tolerance around those listed (section 4.2.2), or -1."""
    cython.declare(t=cython.Py_ssize_t, y=cython.longlong, x=cython.longlong, here=cython.int)
    cython.declare(key=cython.longlong)
    width: cython.Py_ssize_t = sample.usable.shape[1]
    best: cython.int = -1
    least: cython.longlong = NEVER
    if count > 0:  # most others are soon given up past the best one listed
        best = gap.places[0]
        least = mismatch(sample, rule, gap, best, -1)
    for t in range(count):
        for y in range(-rule.tolerance, rule.tolerance + 1):
            for x in range(-rule.tolerance, rule.tolerance + 1):
                here = place_at(sample, gap.places[t] // width + y, gap.places[t] % width + x)
                if here < 0:
                    continue
                key = mismatch(sample, rule, gap, here, least)
                if key < least or (key == least and here < best):
                    least = key
                    best = here
    return best


def fill_gaps(
    sample: Sample,
    grid: Grid,
    steps: cython.const[cython.longlong][:, ::1],
    cells: cython.const[cython.int][:, ::1],
    rule: Rule,
    gap: Gap,
):
    """Choose the piece of each gap of `cells` by its four neighbors' borders (section 4.2.2).

    The best of the similar places are listed, and then the best window within the tolerance around
    them is taken. Where `steps` is empty (the unconstrained mode), all places are similar, and any
    will do where there is no border.
    """
    cython.declare(c=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(count=cython.Py_ssize_t, best=cython.int)
    with cython.nogil:
        for c in range(cells.shape[0]):
            i = cells[c, 0]
            j = cells[c, 1]
            look_around(grid, i, j, gap)
            if steps.shape[0] == 0 and gap.runs.shape[0] == 0:
                grid.place[i, j] = any_place(sample, grid, i, j)
                continue
            compose_border(sample, gap)
            if rule.by_zone:
                count = best_by_zone(sample, rule, gap)
            else:
                count = best_similar(sample, grid, steps, rule, gap, i, j)
            put_best_first(gap, count)
            best = best_within_tolerance(sample, rule, gap, count)
            grid.place[i, j] = best if best >= 0 else any_place(sample, grid, i, j)
