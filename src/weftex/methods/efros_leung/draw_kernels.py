# mypy: ignore-errors
"""Kernels that order the pixels of a layer; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.window_kernels import known_runs


def count_known(
    done: cython.const[cython.uchar][:, ::1],
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    places: cython.const[cython.int][::1],
    runs: cython.int[:, ::1],
    counts: cython.int[::1],
):
    """Fill `counts` with the number of known pixels in the window around each place."""
    width: cython.Py_ssize_t = done.shape[1]
    i: cython.Py_ssize_t
    r: cython.Py_ssize_t
    n: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // width
            x = places[i] % width
            n = known_runs(done, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
            counts[i] = 0
            for r in range(n):
                counts[i] += runs[r, 2]


def wave_numbers(
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    places: cython.const[cython.int][::1],
    listed: cython.uchar[:, ::1],
    numbers: cython.int[:, ::1],
    runs: cython.int[:, ::1],
    waves: cython.int[::1],
):
    """Number the waves of a list: one more than the earlier places in a place's window have.

    Places of one wave do not see each other. `listed`, all 0 before and after, and `numbers` are
    scratch of the canvas's size.
    """
    height: cython.Py_ssize_t = listed.shape[0]
    width: cython.Py_ssize_t = listed.shape[1]
    i: cython.Py_ssize_t
    j: cython.Py_ssize_t
    r: cython.Py_ssize_t
    n: cython.Py_ssize_t
    y: cython.Py_ssize_t
    x: cython.Py_ssize_t
    cy: cython.Py_ssize_t
    cx: cython.Py_ssize_t
    wave: cython.int
    with cython.nogil:
        for i in range(places.shape[0]):
            y = places[i] // width
            x = places[i] % width
            n = known_runs(listed, y, x, wrap_y, wrap_x, reach, reach, reach, reach, runs)
            wave = 0
            for r in range(n):
                cy = (y + runs[r, 0] + height) % height
                cx = (x + runs[r, 1] + width) % width
                for j in range(runs[r, 2]):
                    wave = max(wave, numbers[cy, cx] + 1)
                    cx = cx + 1 if cx + 1 < width else 0
            waves[i] = wave
            numbers[y, x] = wave
            listed[y, x] = 1
        for i in range(places.shape[0]):
            listed[places[i] // width, places[i] % width] = 0
