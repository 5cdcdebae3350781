# mypy: ignore-errors
# cython: infer_types=True
"""The kernels of iterative refinement; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.weftex.methods.refinement.nearest_kernels import NearestWindows, nearest_window
from cython.cimports.weftex.search.picture_kernels import (
    Picture,
    Query,
    SampleWindows,
    coherent_places,
    known_runs,
)
from cython.cimports.weftex.search.window_kernels import copy_pixel, gather_runs, run_distance

_MOST_EXCESS = cython.declare(cython.longlong, 16384)  # in 1/256


class Sources:
    """The pixels of a sample's level, and the cost of taking one.

    A padded index is into the level's picture with its margins, a sample index into the sample.
    """

    def __init__(self, level, margin, usage):
        self.reach, self.similar, self.margin = level.reach, level.similar, margin
        self.sample_index = level.sample_index.ravel()
        self.padded_index = level.padded_index.ravel()
        self.cells, self.used, self.capacity, self.weight = usage


def take(picture, sample, y, x, place):
    """Give a pixel its place in the sample; return whether it changed."""
    picture.done[y, x] = 1
    if picture.source[y, x] == place:
        return False
    copy_pixel(sample.pixels, place, picture.pixels, picture.source, y, x)
    return True


def excess(sources, cell):
    """Factor of a distance, in 1/256: 256 unless the place's cell is used too often."""
    over: cython.longlong = sources.used[cell] - sources.capacity[cell]
    if over <= 0:
        return 256
    over = sources.weight * over // sources.capacity[cell]
    return 256 + min(over, _MOST_EXCESS)


def gather_coherent(picture, sample, query, candidates, y, x, reach):
    """List a pixel's own place, then the coherent ones; return their number, -1 for none usable."""
    beside = 1 if reach > 0 else 0  # see `coherent_places`
    columns, own = sample.pixels.shape[1], picture.source[y, x]
    candidates[0] = -1
    if own >= 0 and sample.usable[own // columns, own % columns]:
        candidates[0] = own
    query.count = known_runs(picture.done, y, x, picture.wrap_y, picture.wrap_x, beside, query.runs)
    return coherent_places(picture, sample, y, x, query, candidates, 1)


def gather_similar(sample, sources, candidates, coherent):
    """List the usable pixels most like the coherent ones after them; return the number of all."""
    place: cython.Py_ssize_t
    columns, count = sample.pixels.shape[1], coherent
    for i in range(coherent):
        if candidates[i] < 0:
            continue
        for k in range(sources.similar.shape[1]):
            place = sources.similar[sources.sample_index[candidates[i]], k]
            if place < 0:
                continue
            place = sources.padded_index[place]
            if sample.usable[place // columns, place % columns]:
                candidates[count] = place
                count += 1
    return count


def look(picture, query, y, x, reach):
    """Gather the known part of the window around a pixel."""
    query.count = known_runs(picture.done, y, x, picture.wrap_y, picture.wrap_x, reach, query.runs)
    gather_runs(picture.pixels, y, x, query.runs, query.count, query.values)


def refine_coherently(
    picture: Picture, sample: SampleWindows, sources: Sources, query: Query,
    candidates: cython.int[::1], order: cython.const[cython.int][::1],
    tried: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` its best candidate; return how many pixels changed.

    Candidates: its own source, the neighbors' continued sources, pixels similar to these, and
    `tried`. The last two cost a factor `sources.margin` / 256, overused cells `excess` / 256.
    """
    cython.declare(least=cython.longlong, factor=cython.longlong)
    best: cython.Py_ssize_t
    changed: cython.Py_ssize_t = 0
    reach, width, columns = sources.reach, picture.pixels.shape[1], sample.pixels.shape[1]
    with cython.nogil:
        for p in range(order.shape[0]):
            y, x = order[p] // width, order[p] % width
            own = picture.source[y, x]
            coherent = gather_coherent(picture, sample, query, candidates, y, x, reach)
            count = gather_similar(sample, sources, candidates, coherent)
            look(picture, query, y, x, reach)
            best = least = -1
            for i in range(count + tried.shape[0]):
                place = candidates[i] if i < count else tried[i - count]
                if place < 0:
                    continue
                v, u = place // columns, place % columns
                factor = excess(sources, sources.cells[sources.sample_index[place]])
                if i >= coherent:
                    factor = factor * sources.margin // 256
                distance = run_distance(
                    sample.pixels, v, u, query.runs, query.count, query.values,
                    least // factor if best >= 0 else -1,
                )  # fmt: skip
                if best < 0 or distance * factor < least:
                    least = distance * factor
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
    picture: Picture, sample: SampleWindows, whole: NearestWindows, above: NearestWindows,
    query: Query, candidates: cython.int[::1], order: cython.const[cython.int][::1],
):  # fmt: skip
    """Give each pixel in `order` the nearest of all windows; return how many changed."""
    width = picture.pixels.shape[1]
    changed: cython.Py_ssize_t = 0
    with cython.nogil:
        for p in range(order.shape[0]):
            y, x = order[p] // width, order[p] % width
            near = gather_coherent(picture, sample, query, candidates, y, x, whole.reach)
            look(picture, query, y, x, whole.reach)
            place = nearest_window(whole, above, query, candidates, near)
            changed += take(picture, sample, y, x, place)
    return changed
