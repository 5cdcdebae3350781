# mypy: ignore-errors
"""The kernel of `ashikhmin`; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.coherence_kernels import coherent_places
from cython.cimports.weftex.search.window_kernels import gather_runs, known_runs, run_distance
from cython.cimports.weftex.search.zone_kernels import squared


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def guide_distance(
    own_guide: cython.const[cython.uchar][:, :, ::1],
    place: cython.Py_ssize_t,
    guide: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    half: cython.Py_ssize_t,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    whole: cython.bint,
) -> cython.longlong:
    """Sum of squared differences of a window of the sample to the guide.

    Where nothing is made yet, the pixel itself with it, or over the `whole` window. The sample's
    own guide may have more channels, which do not count.
    """
    height: cython.Py_ssize_t = guide.shape[0]
    width: cython.Py_ssize_t = guide.shape[1]
    sy: cython.Py_ssize_t = place // own_guide.shape[1]
    sx: cython.Py_ssize_t = place % own_guide.shape[1]
    dy: cython.Py_ssize_t
    dx: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    total: cython.longlong = 0
    for dy in range(-half, half + 1):
        cy = y + dy
        if cy < 0 or cy >= height:
            if not wrap_y:
                continue
            cy = (cy % height + height) % height
        for dx in range(-half, half + 1):
            cx = x + dx
            if cx < 0 or cx >= width:
                if not wrap_x:
                    continue
                cx = (cx % width + width) % width
            if whole or not done[cy, cx] or (dy == 0 and dx == 0):
                total += squared(
                    cython.address(own_guide[sy + dy, sx + dx, 0]),
                    cython.address(guide[cy, cx, 0]),
                    guide.shape[2],
                )
    return total


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def gather_candidates(
    source: cython.const[cython.int][:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
    runs: cython.const[cython.int][:, ::1],
    n: cython.Py_ssize_t,
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    strangers: cython.const[cython.int][:, ::1],
    row: cython.Py_ssize_t,
    jumps: cython.Py_ssize_t,
    again: cython.bint,
    places: cython.int[::1],
) -> cython.Py_ssize_t:
    """The own source if there is one, where the neighbours' go on, random ones; their number.

    As many random places as there are for a pixel with a neighbour whose source cannot go on, or
    with none at all, else `jumps`.
    """
    count: cython.Py_ssize_t = 0
    k: cython.Py_ssize_t
    found: cython.Py_ssize_t
    tried: cython.Py_ssize_t = jumps
    if again:
        places[0] = source[y, x]
        count = 1
    found = coherent_places(source, y, x, runs, n, usable, period, places, count)
    if found == 0:
        tried = strangers.shape[1]
    for k in range(count, found):
        if places[k] < 0:
            tried = strangers.shape[1]
        else:
            places[count] = places[k]
            count += 1
    for k in range(tried):
        places[count] = strangers[row, k]
        count += 1
    return count


def choose(
    levels: cython.uchar[:, :, ::1],
    done: cython.uchar[:, ::1],
    source: cython.int[:, ::1],
    line: cython.const[cython.int][::1],
    pixels: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    period: cython.const[cython.int][::1],
    half: cython.Py_ssize_t,
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    strangers: cython.const[cython.int][:, ::1],
    jumps: cython.Py_ssize_t,
    own_guide: cython.const[cython.uchar][:, :, ::1],
    guide: cython.const[cython.uchar][:, :, ::1],
    weight: cython.longlong,
    again: cython.bint,
    runs: cython.int[:, ::1],
    query: cython.uchar[::1],
    places: cython.int[::1],
):
    """Choose the pixels of a line in its order, each by the window that is most like its own.

    The first of equals is taken. Distances are in 1/256: `weight` is that of the guide.
    """
    i: cython.Py_ssize_t
    k: cython.Py_ssize_t
    n: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    count: cython.Py_ssize_t
    best: cython.Py_ssize_t
    least: cython.longlong
    d: cython.longlong
    with cython.nogil:
        for i in range(line.shape[0]):
            y = line[i] // source.shape[1]
            x = line[i] % source.shape[1]
            n = known_runs(done, y, x, wrap_y, wrap_x, half, half, half, half, runs)
            count = gather_candidates(
                source, y, x, runs, n, usable, period, strangers, i, jumps, again, places
            )
            best = places[0]
            least = -1
            if count > 1:
                gather_runs(levels, y, x, runs, n, query)
            for k in range(count if count > 1 else 0):
                d = 0
                if weight:
                    d = weight * guide_distance(
                        own_guide, places[k], guide, done, y, x, half, wrap_y, wrap_x, again
                    )
                if least < 0 or d < least:
                    d += 256 * run_distance(
                        pixels,
                        places[k] // pixels.shape[1],
                        places[k] % pixels.shape[1],
                        runs,
                        n,
                        query,
                        (least - d) >> 8 if least >= 0 else -1,
                    )
                    if least < 0 or d < least:
                        least = d
                        best = places[k]
            source[y, x] = cython.cast(cython.int, best)
            done[y, x] = 1
            for k in range(levels.shape[2]):
                levels[y, x, k] = pixels[best // pixels.shape[1], best % pixels.shape[1], k]
