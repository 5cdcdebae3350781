# mypy: ignore-errors
"""The kernels of iterative refinement; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.nearest_kernels import Search, nearest_window
from cython.cimports.weftex.search.window_kernels import gather_runs, known_runs, run_distance
from cython.cimports.weftex.search.zone_kernels import squared

_MOST_EXCESS = cython.declare(cython.longlong, 16384)  # in 1/256


@cython.cclass
class Output:
    """The output at one level while it is refined."""

    pixels: cython.uchar[:, :, ::1]
    done: cython.uchar[:, ::1]
    source: cython.int[:, ::1]
    wrap_y: cython.bint
    wrap_x: cython.bint

    def __init__(self, pixels, done, source, wrap):
        self.pixels, self.done, self.source = pixels, done, source
        self.wrap_y, self.wrap_x = wrap


@cython.cclass
class Sample:
    """The sample at one level, see `Level`."""

    pixels: cython.const[cython.uchar][:, :, ::1]
    usable: cython.const[cython.uchar][:, ::1]
    places: cython.const[cython.int][::1]
    index: cython.const[cython.int][::1]
    centers: cython.const[cython.int][::1]
    period: cython.const[cython.int][::1]
    reach: cython.Py_ssize_t

    def __init__(self, level, period):
        self.pixels, self.usable = level.pixels, level.usable
        self.places, self.index = level.places.ravel(), level.index
        self.centers, self.reach = level.centers, level.reach
        self.period = period


@cython.cclass
class Similar:
    """The places most like each place of the sample, and how much they count."""

    places: cython.const[cython.int][:, ::1]
    margin: cython.longlong

    def __init__(self, places, margin):
        self.places, self.margin = places, margin


@cython.cclass
class Usage:
    """How often each cell of the sample is used, and may be."""

    cells: cython.const[cython.int][::1]
    used: cython.int[::1]
    capacity: cython.const[cython.int][::1]
    weight: cython.longlong

    def __init__(self, cells, used, capacity, weight):
        self.cells, self.used, self.capacity, self.weight = cells, used, capacity, weight


@cython.cclass
class GuidePair:
    """The output's guide and the sample's at one level, see `Guide`."""

    output: cython.const[cython.uchar][:, :, ::1]
    sample: cython.const[cython.uchar][:, :, ::1]
    weight: cython.longlong
    everywhere: cython.const[cython.uchar][:, ::1]
    runs: cython.int[:, ::1]
    query: cython.uchar[::1]
    run_count: cython.Py_ssize_t

    def __init__(self, guide, everywhere, runs, query):
        self.output, self.sample, self.weight = guide.output, guide.sample, guide.weight
        self.everywhere, self.runs, self.query = everywhere, runs, query


@cython.cclass
class Scratch:
    """Room for the window of a pixel, and for its candidates."""

    runs: cython.int[:, ::1]
    query: cython.uchar[::1]
    places: cython.int[::1]

    def __init__(self, runs, query, places):
        self.runs, self.query, self.places = runs, query, places


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def take(
    output: Output, sample: Sample, y: cython.Py_ssize_t, x: cython.Py_ssize_t,
    place: cython.Py_ssize_t,
) -> cython.bint:  # fmt: skip
    """Give a pixel its place in the sample; return whether it changed."""
    cython.declare(k=cython.Py_ssize_t)
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    output.done[y, x] = 1
    if output.source[y, x] == place:
        return False
    output.source[y, x] = cython.cast(cython.int, place)
    for k in range(output.pixels.shape[2]):
        output.pixels[y, x, k] = sample.pixels[place // columns, place % columns, k]
    return True


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def excess(usage: Usage, cell: cython.Py_ssize_t) -> cython.longlong:
    """Factor of a distance, in 1/256: 256 unless the place's cell is used too often."""
    over: cython.longlong = usage.used[cell] - usage.capacity[cell]
    if over <= 0:
        return 256
    over = usage.weight * over // usage.capacity[cell]
    return 256 + (over if over < _MOST_EXCESS else _MOST_EXCESS)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_guide(
    output: Output, sample: Sample, guide: GuidePair, y: cython.Py_ssize_t, x: cython.Py_ssize_t
) -> cython.void:
    """Gather the whole window of the output's guide around a pixel."""
    reach: cython.Py_ssize_t = sample.reach
    guide.run_count = known_runs(
        guide.everywhere, y, x, output.wrap_y, output.wrap_x, reach, reach, reach, reach, guide.runs
    )
    gather_runs(guide.output, y, x, guide.runs, guide.run_count, guide.query)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def guide_distance(
    guide: GuidePair, y: cython.Py_ssize_t, x: cython.Py_ssize_t, v: cython.Py_ssize_t,
    u: cython.Py_ssize_t, bound: cython.longlong,
) -> cython.longlong:  # fmt: skip
    """Weighted distance of the guides around (y, x) and (v, u); any part of it above `bound`."""
    return guide.weight * (
        squared(
            cython.address(guide.sample[v, u, 0]),
            cython.address(guide.output[y, x, 0]),
            guide.output.shape[2],
        )
        + run_distance(
            guide.sample, v, u, guide.runs, guide.run_count, guide.query,
            bound // guide.weight if bound >= 0 else -1,
        )
    )  # fmt: skip


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_coherent(
    output: Output, sample: Sample, scratch: Scratch, y: cython.Py_ssize_t, x: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """List a pixel's own place, then the coherent ones; return their number, -1 for none usable."""
    cython.declare(count=cython.Py_ssize_t)
    beside: cython.Py_ssize_t = 1 if sample.reach > 0 else 0  # see `coherent_places`
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    own: cython.Py_ssize_t = output.source[y, x]
    scratch.places[0] = -1
    if own >= 0 and sample.usable[own // columns, own % columns]:
        scratch.places[0] = cython.cast(cython.int, own)
    count = known_runs(
        output.done, y, x, output.wrap_y, output.wrap_x, beside, beside, beside, beside,
        scratch.runs,
    )  # fmt: skip
    return coherent_places(
        output.source, y, x, scratch.runs, count, sample.usable, sample.period, scratch.places, 1
    )


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_similar(
    sample: Sample, similar: Similar, scratch: Scratch, coherent: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """List the usable places most like the coherent ones after them; return their number in all."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, place=cython.Py_ssize_t)
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    count: cython.Py_ssize_t = coherent
    for i in range(coherent):
        if scratch.places[i] < 0:
            continue
        for k in range(similar.places.shape[1]):
            place = similar.places[sample.places[scratch.places[i]], k]
            if place < 0:
                continue
            place = sample.index[place]
            if sample.usable[place // columns, place % columns]:
                scratch.places[count] = cython.cast(cython.int, place)
                count += 1
    return count


def refine_coherently(
    output: Output, sample: Sample, similar: Similar, usage: Usage, guide: GuidePair,
    scratch: Scratch, order: cython.const[cython.int][::1], tried: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` the best of its candidates; return how many changed.

    Candidates are its own place, where the sources of its eight neighbors go on, the places
    `similar` to these, and those `tried`; of equals the first is best. The distance to one of
    the latter two counts `similar.margin` / 256 times, that to a place in a cell used too often
    counts `excess` / 256 times. To this comes the distance between the two guides, over the whole
    window. A pixel takes the same place within the borders.
    """
    cython.declare(p=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(count=cython.Py_ssize_t, runs=cython.Py_ssize_t, own=cython.Py_ssize_t)
    cython.declare(place=cython.Py_ssize_t, best=cython.Py_ssize_t, least=cython.longlong)
    cython.declare(coherent=cython.Py_ssize_t)
    cython.declare(apart=cython.longlong, factor=cython.longlong, distance=cython.longlong)
    reach: cython.Py_ssize_t = sample.reach
    width: cython.Py_ssize_t = output.pixels.shape[1]
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    changed: cython.Py_ssize_t = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y = order[p] // width
            x = order[p] % width
            own = output.source[y, x]
            coherent = gather_coherent(output, sample, scratch, y, x)
            count = gather_similar(sample, similar, scratch, coherent)
            runs = known_runs(
                output.done, y, x, output.wrap_y, output.wrap_x, reach, reach, reach, reach,
                scratch.runs,
            )  # fmt: skip
            gather_runs(output.pixels, y, x, scratch.runs, runs, scratch.query)
            if guide.weight > 0:
                gather_guide(output, sample, guide, y, x)
            best = -1
            least = -1
            for i in range(count + tried.shape[0]):
                place = scratch.places[i] if i < count else tried[i - count]
                if place < 0:
                    continue
                v = place // columns
                u = place % columns
                apart = 0
                if guide.weight > 0:
                    apart = guide_distance(guide, y, x, v, u, least)
                    if best >= 0 and apart >= least:
                        continue
                factor = excess(usage, usage.cells[sample.places[place]])
                if i >= coherent:
                    factor = factor * similar.margin // 256
                distance = run_distance(
                    sample.pixels, v, u, scratch.runs, runs, scratch.query,
                    (least - apart) // factor if best >= 0 else -1,
                )  # fmt: skip
                if best < 0 or distance * factor + apart < least:
                    least = distance * factor + apart
                    best = place
            if best < 0:
                continue
            if own >= 0:
                usage.used[usage.cells[sample.places[own]]] -= 1
            usage.used[usage.cells[sample.places[best]]] += 1
            best = sample.index[sample.places[best]]
            changed += take(output, sample, y, x, best)
    return changed


def refine_to_nearest(
    output: Output, sample: Sample, search: Search, scratch: Scratch,
    order: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` the nearest of all windows; return how many changed."""
    cython.declare(p=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(near=cython.Py_ssize_t, runs=cython.Py_ssize_t, place=cython.Py_ssize_t)
    reach: cython.Py_ssize_t = sample.reach
    width: cython.Py_ssize_t = output.pixels.shape[1]
    changed: cython.Py_ssize_t = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y = order[p] // width
            x = order[p] % width
            near = gather_coherent(output, sample, scratch, y, x)
            runs = known_runs(
                output.done, y, x, output.wrap_y, output.wrap_x, reach, reach, reach, reach,
                scratch.runs,
            )  # fmt: skip
            gather_runs(output.pixels, y, x, scratch.runs, runs, scratch.query)
            place = nearest_window(search, scratch.runs, runs, scratch.query, scratch.places, near)
            changed += take(output, sample, y, x, place)
    return changed
