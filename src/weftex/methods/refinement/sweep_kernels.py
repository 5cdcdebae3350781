# mypy: ignore-errors
"""The kernels of iterative refinement; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.methods.refinement.nearest_kernels import NearestWindows, nearest_window
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.search.picture_kernels import (
    Picture,
    Query,
    Sample,
    coherent_places,
    known_runs,
)
from cython.cimports.weftex.search.window_kernels import copy_pixel, gather_runs, run_distance

_MOST_EXCESS = cython.declare(cython.longlong, 16384)  # in 1/256


@cython.cclass
class Sources:
    """The pixels of a sample's level, and the cost of taking one.

    A padded index is into the level's picture with its margins, a sample index into the sample.
    """

    reach: cython.Py_ssize_t  # of a window
    sample_index: cython.const[cython.int][::1]  # of each padded pixel
    padded_index: cython.const[cython.int][::1]  # of each pixel of the sample
    similar: cython.const[cython.int][:, ::1]  # sample indices of the pixels most like each
    margin: cython.longlong  # factor of their distances in 1/256
    cells: cython.const[cython.int][::1]  # of each pixel of the sample
    used: cython.int[::1]  # how often each cell is used
    capacity: cython.const[cython.int][::1]  # and may be
    weight: cython.longlong  # of using one too often

    def __init__(self, level, margin, usage):
        self.reach, self.similar, self.margin = level.reach, level.similar, margin
        self.sample_index = level.sample_index.ravel()
        self.padded_index = level.padded_index.ravel()
        self.cells, self.used, self.capacity, self.weight = usage


@cython.cclass
class GuidePair:
    """The output's guide and the sample's at one level, see `Guide`."""

    output: cython.const[cython.uchar][:, :, ::1]
    sample: cython.const[cython.uchar][:, :, ::1]
    weight: cython.longlong
    everywhere: cython.const[cython.uchar][:, ::1]  # 1
    query: Query

    def __init__(self, guide, everywhere, query):
        self.output, self.sample, self.weight = guide.output, guide.sample, guide.weight
        self.everywhere, self.query = everywhere, query


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def take(
    picture: Picture, sample: Sample, y: cython.Py_ssize_t, x: cython.Py_ssize_t,
    place: cython.Py_ssize_t,
) -> cython.bint:  # fmt: skip
    """Give a pixel its place in the sample; return whether it changed."""
    changed: cython.bint = picture.source[y, x] != place
    picture.done[y, x] = 1
    if changed:
        copy_pixel(sample.pixels, place, picture.pixels, picture.source, y, x)
    return changed


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def excess(sources: Sources, cell: cython.Py_ssize_t) -> cython.longlong:
    """Factor of a distance, in 1/256: 256 unless the place's cell is used too often."""
    over: cython.longlong = sources.used[cell] - sources.capacity[cell]
    if over <= 0:
        return 256
    over = sources.weight * over // sources.capacity[cell]
    return 256 + (over if over < _MOST_EXCESS else _MOST_EXCESS)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_guide(
    picture: Picture, guide: GuidePair, y: cython.Py_ssize_t, x: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
) -> cython.void:  # fmt: skip
    """Gather the whole window of the output's guide around a pixel."""
    guide.query.count = known_runs(
        guide.everywhere, y, x, picture.wrap_y, picture.wrap_x, reach, guide.query.runs
    )
    gather_runs(guide.output, y, x, guide.query.runs, guide.query.count, guide.query.values)


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
            guide.sample, v, u, guide.query.runs, guide.query.count, guide.query.values,
            bound // guide.weight if bound >= 0 else -1,
        )
    )  # fmt: skip


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_coherent(
    picture: Picture, sample: Sample, query: Query, candidates: cython.int[::1],
    y: cython.Py_ssize_t, x: cython.Py_ssize_t, reach: cython.Py_ssize_t,
) -> cython.Py_ssize_t:  # fmt: skip
    """List a pixel's own place, then the coherent ones; return their number, -1 for none usable."""
    beside: cython.Py_ssize_t = 1 if reach > 0 else 0  # see `coherent_places`
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    own: cython.Py_ssize_t = picture.source[y, x]
    candidates[0] = -1
    if own >= 0 and sample.usable[own // columns, own % columns]:
        candidates[0] = cython.cast(cython.int, own)
    query.count = known_runs(picture.done, y, x, picture.wrap_y, picture.wrap_x, beside, query.runs)
    return coherent_places(picture, sample, y, x, query, candidates, 1)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_similar(
    sample: Sample, sources: Sources, candidates: cython.int[::1], coherent: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """List the usable pixels most like the coherent ones after them; return the number of all."""
    cython.declare(i=cython.Py_ssize_t, k=cython.Py_ssize_t, place=cython.Py_ssize_t)
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    count: cython.Py_ssize_t = coherent
    for i in range(coherent):
        if candidates[i] < 0:
            continue
        for k in range(sources.similar.shape[1]):
            place = sources.similar[sources.sample_index[candidates[i]], k]
            if place < 0:
                continue
            place = sources.padded_index[place]
            if sample.usable[place // columns, place % columns]:
                candidates[count] = cython.cast(cython.int, place)
                count += 1
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look(
    picture: Picture, query: Query, y: cython.Py_ssize_t, x: cython.Py_ssize_t,
    reach: cython.Py_ssize_t,
) -> cython.void:  # fmt: skip
    """Gather the known part of the window around a pixel."""
    query.count = known_runs(picture.done, y, x, picture.wrap_y, picture.wrap_x, reach, query.runs)
    gather_runs(picture.pixels, y, x, query.runs, query.count, query.values)


def refine_coherently(
    picture: Picture, sample: Sample, sources: Sources, guide: GuidePair, query: Query,
    candidates: cython.int[::1], order: cython.const[cython.int][::1],
    tried: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` its best candidate; return how many pixels changed.

    Candidates: its own source, the neighbors' continued sources, pixels similar to these, and
    `tried`. The last two cost a factor `sources.margin` / 256, overused cells `excess` / 256.
    """
    cython.declare(p=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(v=cython.Py_ssize_t, u=cython.Py_ssize_t, i=cython.Py_ssize_t)
    cython.declare(count=cython.Py_ssize_t, own=cython.Py_ssize_t)
    cython.declare(place=cython.Py_ssize_t, best=cython.Py_ssize_t, least=cython.longlong)
    cython.declare(coherent=cython.Py_ssize_t)
    cython.declare(apart=cython.longlong, factor=cython.longlong, distance=cython.longlong)
    reach: cython.Py_ssize_t = sources.reach
    width: cython.Py_ssize_t = picture.pixels.shape[1]
    columns: cython.Py_ssize_t = sample.pixels.shape[1]
    changed: cython.Py_ssize_t = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y = order[p] // width
            x = order[p] % width
            own = picture.source[y, x]
            coherent = gather_coherent(picture, sample, query, candidates, y, x, reach)
            count = gather_similar(sample, sources, candidates, coherent)
            look(picture, query, y, x, reach)
            if guide.weight > 0:
                gather_guide(picture, guide, y, x, reach)
            best = -1
            least = -1
            for i in range(count + tried.shape[0]):
                place = candidates[i] if i < count else tried[i - count]
                if place < 0:
                    continue
                v = place // columns
                u = place % columns
                apart = 0
                if guide.weight > 0:
                    apart = guide_distance(guide, y, x, v, u, least)
                    if best >= 0 and apart >= least:
                        continue
                factor = excess(sources, sources.cells[sources.sample_index[place]])
                if i >= coherent:
                    factor = factor * sources.margin // 256
                distance = run_distance(
                    sample.pixels, v, u, query.runs, query.count, query.values,
                    (least - apart) // factor if best >= 0 else -1,
                )  # fmt: skip
                if best < 0 or distance * factor + apart < least:
                    least = distance * factor + apart
                    best = place
            if best < 0:
                continue
            if own >= 0:
                sources.used[sources.cells[sources.sample_index[own]]] -= 1
            sources.used[sources.cells[sources.sample_index[best]]] += 1
            best = sources.padded_index[sources.sample_index[best]]
            changed += take(picture, sample, y, x, best)
    return changed


def refine_to_nearest(
    picture: Picture, sample: Sample, whole: NearestWindows, above: NearestWindows, query: Query,
    candidates: cython.int[::1], order: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` the nearest of all windows; return how many changed."""
    cython.declare(p=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    cython.declare(near=cython.Py_ssize_t, place=cython.Py_ssize_t)
    width: cython.Py_ssize_t = picture.pixels.shape[1]
    changed: cython.Py_ssize_t = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y = order[p] // width
            x = order[p] % width
            near = gather_coherent(picture, sample, query, candidates, y, x, whole.reach)
            look(picture, query, y, x, whole.reach)
            place = nearest_window(whole, above, query, candidates, near)
            changed += take(picture, sample, y, x, place)
    return changed
