# mypy: ignore-errors
# cython: infer_types=True
"""Kernels that order the pixels of a layer; compiled by Cython, see setup.py."""

import cython
from cython.cimports.weftex.search.picture_kernels import around, known_runs


def count_known(
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    runs: cython.int[:, ::1],
    done: cython.const[cython.uchar][:, ::1],
    pixels: cython.const[cython.int][::1],
    counts: cython.int[::1],
):
    """Fill `counts` with the number of known pixels in the window around each pixel.

    `runs` is scratch.
    """
    width = done.shape[1]
    with cython.nogil:
        for i in range(pixels.shape[0]):
            counts[i] = 0
            y, x = pixels[i] // width, pixels[i] % width
            for r in range(known_runs(done, y, x, wrap_y, wrap_x, reach, runs)):
                counts[i] += runs[r, 2]


def wave_numbers(
    wrap_y: cython.bint,
    wrap_x: cython.bint,
    reach: cython.Py_ssize_t,
    runs: cython.int[:, ::1],
    pixels: cython.const[cython.int][::1],
    listed: cython.uchar[:, ::1],
    numbers: cython.int[:, ::1],
    waves: cython.int[::1],
):
    """Fill `waves`: one more than the largest wave of earlier pixels in each pixel's window.

    `listed`, all 0 before and after, and `numbers` are scratch of the canvas's size.
    """
    wave: cython.int
    height, width = listed.shape[0], listed.shape[1]
    with cython.nogil:
        for i in range(pixels.shape[0]):
            y, x = pixels[i] // width, pixels[i] % width
            wave = 0
            for r in range(known_runs(listed, y, x, wrap_y, wrap_x, reach, runs)):
                cy, cx = around(y + runs[r, 0], height), around(x + runs[r, 1], width)
                for j in range(runs[r, 2]):
                    wave = max(wave, numbers[cy, cx] + 1)
                    cx = cx + 1 if cx + 1 < width else 0
            waves[i] = numbers[y, x] = wave
            listed[y, x] = 1
        for i in range(pixels.shape[0]):
            listed[pixels[i] // width, pixels[i] % width] = 0
