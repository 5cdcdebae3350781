# mypy: ignore-errors
# cython: infer_types=True
"""The picture in the making, and the known pixels around one; compiled, see setup.py, the .pxd.

A window is a list of runs (dy, dx, length): stretches of a row, seen from its center.
"""

import cython


class SampleWindows:
    """The windows of a sample, see `weftex.search.windows.Windows`."""

    def __init__(self, pixels, usable, period):
        self.pixels, self.usable, self.period = pixels, usable, period


class Picture:
    """The picture while it is made.

    `done` is 1 where a pixel is known or made, `source` its flat index into the sample's pixels or
    -1, `wrap` whether the vertical and the horizontal axis wrap.
    """

    def __init__(self, pixels, done, source, wrap):
        self.pixels, self.done, self.source = pixels, done, source
        self.wrap_y, self.wrap_x = wrap


class Query:
    """Memory for the known part of the window around a pixel."""

    def __init__(self, runs, values, count=0):
        self.runs, self.values, self.count = runs, values, count


def known_runs(done, y, x, wrap_y, wrap_x, reach, runs):
    """Write the known part of the square window around a pixel; return the number of runs.

    The pixel itself is left out, and no pixel occurs twice on a wrapped axis shorter than the
    window.
    """
    cython.declare(running=cython.bint, known=cython.bint)
    height, width = done.shape[0], done.shape[1]
    n = 0
    up = min(reach, (height - 1) // 2 if wrap_y else y)
    down = min(reach, height // 2 if wrap_y else height - 1 - y)
    left = min(reach, (width - 1) // 2 if wrap_x else x)
    right = min(reach, width // 2 if wrap_x else width - 1 - x)
    cy = (y - up + height) % height
    for dy in range(-up, down + 1):
        running = False
        cx = (x - left + width) % width
        for dx in range(-left, right + 1):
            known = done[cy, cx] != 0 and (dy != 0 or dx != 0)
            if known and running:
                runs[n - 1, 2] += 1
            elif known:
                runs[n, 0], runs[n, 1], runs[n, 2] = dy, dx, 1
                n += 1
            running = known
            cx = cx + 1 if cx + 1 < width else 0
        cy = cy + 1 if cy + 1 < height else 0
    return n


def usable_place(usable, period, y, x):
    """Return the flat index of the window centered at (y, x), or -1 if none is usable there.

    A place outside of a tileable sample wraps around.
    """
    if period[2]:
        y = (y - period[0]) % period[2]
        x = (x - period[1]) % period[3]
        y = y + period[0] if y >= 0 else y + period[0] + period[2]
        x = x + period[1] if x >= 0 else x + period[1] + period[3]
    elif y < 0 or x < 0 or y >= usable.shape[0] or x >= usable.shape[1]:
        return -1
    return y * usable.shape[1] + x if usable[y, x] else -1


def coherent_places(picture, sample, y, x, query, places, count):
    """List the continued sources of (y, x)'s neighbors after `count` places; return the length.

    Neighbors are the pixels of the query's runs, last run first; each place is listed once, and -1
    once for all unusable ones. Runs reach no further along x than windows, so a step never crosses
    into another row.
    """
    cython.declare(own=cython.Py_ssize_t, at=cython.Py_ssize_t, before=cython.Py_ssize_t)
    height, width = picture.source.shape[0], picture.source.shape[1]
    across = sample.usable.shape[1]
    size = sample.usable.shape[0] * across
    may = cython.address(sample.usable[0, 0])
    before = -1 - size
    for r in range(query.count - 1, -1, -1):
        cy = around(y + query.runs[r, 0], height)
        for i in range(query.runs[r, 2] - 1, -1, -1):
            dx = query.runs[r, 1] + i
            own = picture.source[cy, around(x + dx, width)]
            at = own - query.runs[r, 0] * across - dx
            if own < 0 or at == before:
                continue
            before = at
            if at < 0 or at >= size or not may[at]:
                at = -1
                if sample.period[2]:
                    at = usable_place(
                        sample.usable,
                        sample.period,
                        own // across - query.runs[r, 0],
                        own % across - dx,
                    )
            k = 0
            while k < count and places[k] != at:
                k += 1
            if k == count:
                places[count] = at
                count += 1
    return count
