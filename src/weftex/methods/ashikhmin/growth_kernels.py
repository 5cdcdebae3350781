# mypy: ignore-errors
"""The kernels of `ashikhmin`; compiled by Cython, see setup.py.

Places are flat indices into the pixels of the sample's windows.
"""

import cython
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.window_kernels import (
    copy_pixel,
    gather_runs,
    known_runs,
    run_distance,
)
from cython.cimports.weftex.search.zone_kernels import squared

ONE = cython.declare(cython.longlong, 256)  # a weight of 1; distances are integers


@cython.cclass
class Sample:
    """The sample's windows, and its own guide, which may have more channels than the canvas's."""

    pixels: cython.const[cython.uchar][:, :, ::1]
    usable: cython.const[cython.uchar][:, ::1]
    period: cython.const[cython.int][::1]
    guide: cython.const[cython.uchar][:, :, ::1]
    half: cython.Py_ssize_t  # of a window's width

    def __init__(self, windows, guide, half):
        self.pixels, self.usable, self.period = windows.pixels, windows.usable, windows.period
        self.guide, self.half = guide, half


@cython.cclass
class Picture:
    """The picture in the making, and the guide that it follows with a weight in 1/256."""

    pixels: cython.uchar[:, :, ::1]
    done: cython.uchar[:, ::1]
    source: cython.int[:, ::1]
    wrap_y: cython.bint
    wrap_x: cython.bint
    guide: cython.const[cython.uchar][:, :, ::1]
    guide_weight: cython.longlong

    def __init__(self, pixels, done, source, wrap, guide, guide_weight):
        self.pixels, self.done, self.source = pixels, done, source
        self.wrap_y, self.wrap_x = wrap
        self.guide, self.guide_weight = guide, guide_weight


@cython.cclass
class Search:
    """The search for one pixel."""

    jumps: cython.Py_ssize_t
    runs: cython.int[:, ::1]
    query: cython.uchar[::1]
    places: cython.int[::1]
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    wrap_y: cython.bint
    again: cython.bint  # the pixel was chosen before
    run_count: cython.Py_ssize_t

    def __init__(self, jumps, runs, query, places):
        self.jumps, self.runs, self.query, self.places = jumps, runs, query, places


def choose(
    sample: Sample,
    picture: Picture,
    search: Search,
    line: cython.const[cython.int][::1],
    random_places: cython.const[cython.int][:, ::1],
    around: cython.bint,
    again: cython.bint,
):
    """Choose the pixels of a line in its order, each by the window that is most like its own.

    `random_places` has a row for each pixel. `around` lets windows go around the canvas along y;
    `again` is for the passes after the first.
    """
    cython.declare(i=cython.Py_ssize_t, count=cython.Py_ssize_t, width=cython.Py_ssize_t)
    cython.declare(place=cython.Py_ssize_t)
    width = picture.source.shape[1]
    search.wrap_y, search.again = picture.wrap_y or around, again
    with cython.nogil:
        for i in range(line.shape[0]):
            search.y, search.x = line[i] // width, line[i] % width
            search.run_count = known_runs(
                picture.done, search.y, search.x, search.wrap_y, picture.wrap_x,
                sample.half, sample.half, sample.half, sample.half, search.runs,
            )  # fmt: skip
            count = gather_candidates(sample, picture, search, random_places, i)
            place = best_candidate(sample, picture, search, count)
            copy_pixel(sample.pixels, place, picture.pixels, picture.source, search.y, search.x)
            picture.done[search.y, search.x] = 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_candidates(
    sample: Sample,
    picture: Picture,
    search: Search,
    random_places: cython.const[cython.int][:, ::1],
    row: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """List the candidates: the own source, the neighbors' shifted ones and random ones.

    The random ones are `jumps`, or all of the row where a neighbor's source cannot go on and where
    there is no neighbor. Returns the number of candidates.
    """
    cython.declare(count=cython.Py_ssize_t, found=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(tried=cython.Py_ssize_t)
    count = 0
    tried = search.jumps
    if search.again:
        search.places[0] = picture.source[search.y, search.x]
        count = 1
    found = coherent_places(
        picture.source, search.y, search.x, search.runs, search.run_count,
        sample.usable, sample.period, search.places, count,
    )  # fmt: skip
    if found == 0:
        tried = random_places.shape[1]
    for k in range(count, found):
        if search.places[k] < 0:
            tried = random_places.shape[1]
        else:
            search.places[count] = search.places[k]
            count += 1
    for k in range(tried):
        search.places[count] = random_places[row, k]
        count += 1
    return count


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def best_candidate(
    sample: Sample, picture: Picture, search: Search, count: cython.Py_ssize_t
) -> cython.Py_ssize_t:
    """The candidate whose window is most like the pixel's; the first of equal ones."""
    cython.declare(k=cython.Py_ssize_t, best=cython.Py_ssize_t, columns=cython.Py_ssize_t)
    cython.declare(distance=cython.longlong, least=cython.longlong)
    columns = sample.pixels.shape[1]
    best = search.places[0]
    if count == 1:
        return best
    gather_runs(picture.pixels, search.y, search.x, search.runs, search.run_count, search.query)
    least = -1
    for k in range(count):
        distance = 0
        if picture.guide_weight:
            distance = picture.guide_weight * guide_distance(
                sample, picture, search, search.places[k]
            )
        if least < 0 or distance < least:
            distance += ONE * run_distance(
                sample.pixels, search.places[k] // columns, search.places[k] % columns,
                search.runs, search.run_count, search.query,
                (least - distance) // ONE if least >= 0 else -1,
            )  # fmt: skip
            if least < 0 or distance < least:
                least = distance
                best = search.places[k]
    return best


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def guide_distance(
    sample: Sample, picture: Picture, search: Search, place: cython.Py_ssize_t
) -> cython.longlong:
    """Sum of squared differences of the sample's guide around a place to the canvas's guide.

    In the first pass over the pixel itself and the part of its window that is not made yet; in
    later ones over the whole window.
    """
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t, half=cython.Py_ssize_t)
    cython.declare(sy=cython.Py_ssize_t, sx=cython.Py_ssize_t)
    cython.declare(dy=cython.Py_ssize_t, dx=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, total=cython.longlong)
    height, width, half = picture.guide.shape[0], picture.guide.shape[1], sample.half
    sy, sx = place // sample.guide.shape[1], place % sample.guide.shape[1]
    total = 0
    for dy in range(-half, half + 1):
        cy = search.y + dy
        if cy < 0 or cy >= height:
            if not search.wrap_y:
                continue
            cy = (cy % height + height) % height
        for dx in range(-half, half + 1):
            cx = search.x + dx
            if cx < 0 or cx >= width:
                if not picture.wrap_x:
                    continue
                cx = (cx % width + width) % width
            if search.again or not picture.done[cy, cx] or (dy == 0 and dx == 0):
                total += squared(
                    cython.address(sample.guide[sy + dy, sx + dx, 0]),
                    cython.address(picture.guide[cy, cx, 0]),
                    picture.guide.shape[2],
                )
    return total
