# mypy: ignore-errors
"""Kernels that order the pixels of a layer; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.window_kernels import known_runs


@cython.cclass
class Neighborhood:
    """The square window around a pixel of a canvas, and scratch for what is known of it."""

    reach: cython.Py_ssize_t
    wrap_y: cython.bint
    wrap_x: cython.bint
    runs: cython.int[:, ::1]

    def __init__(self, reach, wrap, runs):
        self.reach = reach
        self.wrap_y, self.wrap_x = wrap
        self.runs = runs


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def look(
    window: Neighborhood,
    marked: cython.const[cython.uchar][:, ::1],
    y: cython.Py_ssize_t,
    x: cython.Py_ssize_t,
) -> cython.Py_ssize_t:
    """Find the runs of marked pixels in the window around a pixel; return their number."""
    return known_runs(
        marked, y, x, window.wrap_y, window.wrap_x, window.reach, window.reach, window.reach,
        window.reach, window.runs,
    )  # fmt: skip


def count_known(
    window: Neighborhood,
    done: cython.const[cython.uchar][:, ::1],
    places: cython.const[cython.int][::1],
    counts: cython.int[::1],
):
    """Fill `counts` with the number of known pixels in the window around each place."""
    cython.declare(i=cython.Py_ssize_t, r=cython.Py_ssize_t, width=cython.Py_ssize_t)
    width = done.shape[1]
    with cython.nogil:
        for i in range(places.shape[0]):
            counts[i] = 0
            for r in range(look(window, done, places[i] // width, places[i] % width)):
                counts[i] += window.runs[r, 2]


def wave_numbers(
    window: Neighborhood,
    places: cython.const[cython.int][::1],
    listed: cython.uchar[:, ::1],
    numbers: cython.int[:, ::1],
    waves: cython.int[::1],
):
    """Number the waves of a list: one more than the earlier places in a place's window have.

    Places of one wave do not see each other. `listed`, all 0 before and after, and `numbers` are
    scratch of the canvas's size.
    """
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, r=cython.Py_ssize_t)
    cython.declare(y=cython.Py_ssize_t, x=cython.Py_ssize_t, wave=cython.int)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    cython.declare(height=cython.Py_ssize_t, width=cython.Py_ssize_t)
    height = listed.shape[0]
    width = listed.shape[1]
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // width
            x = places[i] % width
            wave = 0
            for r in range(look(window, listed, y, x)):
                cy = (y + window.runs[r, 0] + height) % height
                cx = (x + window.runs[r, 1] + width) % width
                for j in range(window.runs[r, 2]):
                    wave = max(wave, numbers[cy, cx] + 1)
                    cx = cx + 1 if cx + 1 < width else 0
            waves[i] = wave
            numbers[y, x] = wave
            listed[y, x] = 1
        for i in range(places.shape[0]):
            listed[places[i] // width, places[i] % width] = 0
