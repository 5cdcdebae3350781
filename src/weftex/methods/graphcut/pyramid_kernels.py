# mypy: ignore-errors
# cython: infer_types=True
"""Kernels of graph-cut textures: matches on the levels of a pyramid; compiled, see the .pxd.

A level is the pixels of a picture, and a mask of those that count.
"""

import cython
from cython.cimports.libc.math import INFINITY
from cython.cimports.libc.string import memchr, memcpy, memset
from cython.cimports.weftex.raster.difference_kernels import squared


def halve(
    whole: cython.const[cython.uchar][:, :, ::1],
    counting: cython.const[cython.uchar][:, ::1],
    pixels: cython.uchar[:, :, ::1],
    mask: cython.uchar[:, ::1],
):
    """Fill in means of squares of four pixels, rounded; those count all of whose pixels do."""
    cython.declare(upper=cython.p_const_uchar, lower=cython.p_const_uchar, half=cython.p_uchar)
    channels = pixels.shape[2]
    for i in range(pixels.shape[0]):
        upper = cython.address(counting[2 * i, 0])
        lower = cython.address(counting[2 * i + 1, 0])
        half = cython.address(mask[i, 0])
        for j in range(pixels.shape[1]):
            half[j] = upper[2 * j] & upper[2 * j + 1] & lower[2 * j] & lower[2 * j + 1]
        upper = cython.address(whole[2 * i, 0, 0])
        lower = cython.address(whole[2 * i + 1, 0, 0])
        half = cython.address(pixels[i, 0, 0])
        for j in range(pixels.shape[1]):
            for k in range(channels):
                total = 2 + upper[k] + upper[channels + k] + lower[k] + lower[channels + k]
                half[k] = total >> 2
            upper += 2 * channels
            lower += 2 * channels
            half += channels


def copy_box(
    canvas: cython.const[cython.uchar][:, :, ::1],
    done: cython.const[cython.uchar][:, ::1],
    rows: cython.const[cython.int][::1],
    columns: cython.const[cython.int][::1],
    pixels: cython.uchar[:, :, ::1],
    mask: cython.uchar[:, ::1],
):
    """Copy a box of a canvas; nothing counts in rows and columns below 0."""
    channels, width = pixels.shape[2], columns.shape[0]
    j = 0
    while j < width:  # runs of columns
        end = j + 1
        while end < width and (
            columns[end] - columns[j] == end - j if columns[j] >= 0 else columns[end] < 0
        ):
            end += 1
        for i in range(rows.shape[0]):
            if rows[i] < 0 or columns[j] < 0:
                memset(cython.address(mask[i, j]), 0, end - j)
                memset(cython.address(pixels[i, j, 0]), 0, (end - j) * channels)
                continue
            memcpy(cython.address(mask[i, j]), cython.address(done[rows[i], columns[j]]), end - j)
            memcpy(
                cython.address(pixels[i, j, 0]),
                cython.address(canvas[rows[i], columns[j], 0]),
                (end - j) * channels,
            )
        j = end


def run_of(marks, at, end, mark):
    """The first place from `at` on that has this mark, 0 or 1, or the end."""
    found: cython.p_void = memchr(marks + at, mark, end - at)
    if found == cython.NULL:
        return end
    return cython.cast(cython.p_const_uchar, found) - marks


def box_mismatch(box, known, sample, usable, top, left, whole, most):
    """Mean squared difference where both count, the box's corner on (top, left) of the sample.

    Infinite where nothing counts in both, or once the sum is `most` or more. `whole`: all pixels
    of the sample count.
    """
    channels = box.shape[2]
    first, last = max(0, -left), min(box.shape[1], sample.shape[1] - left)
    upper, lower = max(0, -top), min(box.shape[0], sample.shape[0] - top)
    total: cython.longlong = 0
    area: cython.longlong = 0
    if first >= last:
        return INFINITY
    for turn in range(8):  # every eighth row first, so that bad places end early
        for i in range(upper + turn, lower, 8):
            here = cython.address(known[i, 0])
            there = cython.address(usable[top + i, left + first]) - first
            j = run_of(here, first, last, 1)
            while j < last:
                if not (whole or there[j]):
                    j = run_of(here, run_of(there, j + 1, last, 1), last, 1)
                    continue
                end = run_of(here, j + 1, last, 0)
                if not whole:
                    end = run_of(there, j + 1, end, 0)
                total += squared(
                    cython.address(box[i, j, 0]),
                    cython.address(sample[top + i, left + j, 0]),
                    (end - j) * channels,
                )
                area += end - j
                j = run_of(here, end, last, 1)
        if total >= most:
            return INFINITY
    if area == 0:
        return INFINITY
    return cython.cast(cython.double, total) / area


def nudge(
    box: cython.const[cython.uchar][:, :, ::1],
    known: cython.const[cython.uchar][:, ::1],
    sample: cython.const[cython.uchar][:, :, ::1],
    usable: cython.const[cython.uchar][:, ::1],
    allowed: cython.const[cython.uchar][:, ::1],
    offset: cython.const[cython.int][::1],
    whole: cython.bint,
    places: cython.int[:, ::1],
):
    """Move each place to the best match among itself and its eight neighbors, the first of them.

    The box's corner lies on (place - offset) of the sample. Other threads may run.
    """
    cython.declare(best=cython.double, found=cython.bint)
    # A mean over no more pixels than this is no better once its sum is that of the best.
    area: cython.double = min(box.shape[0] * box.shape[1], sample.shape[0] * sample.shape[1])
    area *= 1 + 1e-12
    with cython.nogil:
        for k in range(places.shape[0]):
            middle_y, middle_x = places[k, 0], places[k, 1]
            best = INFINITY
            found = False
            for n in range(-1, 9):  # the place itself, which need not be allowed, then all nine
                y = middle_y + (n // 3 - 1 if n >= 0 else 0)
                x = middle_x + (n % 3 - 1 if n >= 0 else 0)
                if n == 4 or not (0 <= y < allowed.shape[0] and 0 <= x < allowed.shape[1]):
                    continue
                if not allowed[y, x]:
                    continue
                cost = box_mismatch(
                    box, known, sample, usable, y - offset[0], x - offset[1], whole, best * area
                )
                if cost < best or not found:
                    found = True
                    best = cost
                    places[k, 0], places[k, 1] = y, x
