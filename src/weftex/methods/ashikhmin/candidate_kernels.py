# mypy: ignore-errors
# cython: infer_types=True
"""The kernels of `ashikhmin`; compiled by Cython, see setup.py and the .pxd.

Places are flat indices into the pixels of the sample's windows.
"""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.search.picture_kernels import (
    Picture,
    SampleWindows,
    coherent_places,
    known_runs,
)
from cython.cimports.weftex.search.window_kernels import copy_pixel, gather_runs, run_distance

ONE = cython.declare(cython.longlong, 256)  # a weight of 1; distances are integers


class PixelChoice:
    """The choice of one pixel, and the guides: the canvas's and the sample's for its windows."""

    def __init__(self, half, jumps, query, places, followed, guide, guide_weight):
        self.half, self.jumps, self.query, self.places = half, jumps, query, places
        self.followed, self.guide, self.guide_weight = followed, guide, guide_weight


def choose(
    sample: SampleWindows,
    picture: Picture,
    choice: PixelChoice,
    line: cython.const[cython.int][::1],
    random_places: cython.const[cython.int][:, ::1],
    around: cython.bint,
    again: cython.bint,
):
    """Choose the pixels of a line in turn, each by the candidate with the most similar window.

    `random_places` has a row for each pixel. `around` wraps windows along y, and `again` is for the
    passes after the first.
    """
    width = picture.source.shape[1]
    choice.wrap_y, choice.again = picture.wrap_y or around, again
    with cython.nogil:
        for i in range(line.shape[0]):
            choice.y, choice.x = line[i] // width, line[i] % width
            choice.query.count = known_runs(
                picture.done, choice.y, choice.x, choice.wrap_y, picture.wrap_x, choice.half,
                choice.query.runs,
            )  # fmt: skip
            count = gather_candidates(sample, picture, choice, random_places, i)
            place = best_candidate(sample, picture, choice, count)
            copy_pixel(sample.pixels, place, picture.pixels, picture.source, choice.y, choice.x)
            picture.done[choice.y, choice.x] = 1


def gather_candidates(sample, picture, choice, random_places, row):
    """List the own source, the neighbors' shifted ones and random ones; return the number listed.

    There are `jumps` random ones, or a whole row where a neighbor is missing or its source cannot
    continue.
    """
    count: cython.Py_ssize_t = 0
    tried = choice.jumps
    if choice.again:
        choice.places[0] = picture.source[choice.y, choice.x]
        count = 1
    found = coherent_places(picture, sample, choice.y, choice.x, choice.query, choice.places, count)
    if found == 0:
        tried = random_places.shape[1]
    for k in range(count, found):
        if choice.places[k] < 0:
            tried = random_places.shape[1]
        else:
            choice.places[count] = choice.places[k]
            count += 1
    for k in range(tried):
        choice.places[count] = random_places[row, k]
        count += 1
    return count


def best_candidate(sample, picture, choice, count):
    """The candidate whose window is most like the pixel's; the first of equal ones."""
    cython.declare(distance=cython.longlong, least=cython.longlong)
    columns = sample.pixels.shape[1]
    best = choice.places[0]
    if count == 1:
        return best
    gather_runs(
        picture.pixels, choice.y, choice.x, choice.query.runs, choice.query.count,
        choice.query.values,
    )  # fmt: skip
    least = -1
    for k in range(count):
        distance = 0
        if choice.guide_weight:
            distance = choice.guide_weight * guide_distance(picture, choice, choice.places[k])
        if least < 0 or distance < least:
            distance += ONE * run_distance(
                sample.pixels, choice.places[k] // columns, choice.places[k] % columns,
                choice.query.runs, choice.query.count, choice.query.values,
                (least - distance) // ONE if least >= 0 else -1,
            )  # fmt: skip
            if least < 0 or distance < least:
                least = distance
                best = choice.places[k]
    return best


def guide_distance(picture, choice, place):
    """Return the sum of squared differences between the guides around `place` and the pixel.

    The first pass compares the pixel and the unmade part of its window, later ones the whole
    window.
    """
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t, total=cython.longlong)
    height, width, half = choice.followed.shape[0], choice.followed.shape[1], choice.half
    sy, sx = place // choice.guide.shape[1], place % choice.guide.shape[1]
    total = 0
    for dy in range(-half, half + 1):
        cy = choice.y + dy
        if cy < 0 or cy >= height:
            if not choice.wrap_y:
                continue
            cy = (cy % height + height) % height
        for dx in range(-half, half + 1):
            cx = choice.x + dx
            if cx < 0 or cx >= width:
                if not picture.wrap_x:
                    continue
                cx = (cx % width + width) % width
            if choice.again or not picture.done[cy, cx] or (dy == 0 and dx == 0):
                total += squared(
                    cython.address(choice.guide[sy + dy, sx + dx, 0]),
                    cython.address(choice.followed[cy, cx, 0]),
                    choice.followed.shape[2],
                )
    return total
