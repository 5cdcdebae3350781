"""Windows of samples and of canvases."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

#: Steps to the neighbors of a pixel: right, down, left and up.
ARCS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def usable(exemplar):
    """The sample's mask, all of it without one."""
    return np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask


def rectangle(pixels, corner, size):
    """Pixels of a rectangle; rows and columns wrap."""
    rows, columns = (np.arange(n) + at for at, n in zip(corner, size, strict=True))
    return pixels[np.ix_(rows % pixels.shape[0], columns % pixels.shape[1])]


def window_centers(mask, reach, tileable):
    """Pixels of a sample around which a whole window is usable, in scan order."""
    up, down, left, right = reach
    mode = "wrap" if tileable else "constant"
    around = np.pad(mask, ((up, down), (left, right)), mode)
    windows = sliding_window_view(around, (up + down + 1, left + right + 1))
    return [tuple(at) for at in np.argwhere(windows.all(axis=(2, 3))).tolist()]


def known_window(done, y, x, wrap, reach):
    """The known pixels around (y, x), as sorted steps from it; none is there twice."""
    steps = [[], []]
    for axis, (at, length) in enumerate(zip((y, x), done.shape, strict=True)):
        before, after = reach[2 * axis], reach[2 * axis + 1]
        if wrap[axis]:
            before, after = min(before, (length - 1) // 2), min(after, length // 2)
        steps[axis] = [
            step for step in range(-before, after + 1) if wrap[axis] or 0 <= at + step < length
        ]
    return [
        (dy, dx)
        for dy, dx in itertools.product(*steps)
        if (dy or dx) and done[(y + dy) % done.shape[0], (x + dx) % done.shape[1]]
    ]


def windows_at(pixels, places, reach):
    """The windows around pixels of a sample, around its borders, as (N, values)."""
    steps = np.arange(-reach, reach + 1)
    y, x = np.array(places, int).reshape(-1, 2, 1).transpose(1, 0, 2) + steps
    windows = pixels[(y % len(pixels))[:, :, None], (x % pixels.shape[1])[:, None]]
    return windows.reshape(len(windows), -1).astype(int)


def steps_away(picture, y, x, steps):
    """The pixels at some steps from one, around all borders."""
    dy, dx = np.array(steps, int).reshape(-1, 2).T
    return picture[(y + dy) % len(picture), (x + dx) % picture.shape[1]].astype(int)


def by_rows(places):
    """The columns of the places in each row, for `nearest_center`."""
    return {row: sorted(x for y, x in places if y == row) for row in sorted({y for y, _ in places})}


def nearest_center(rows, y, x):
    """The center nearest to (y, x) along the nearest row that has any; the first of equals."""
    row = min(rows, key=lambda v: abs(v - y))
    return row, min(rows[row], key=lambda u: abs(u - x))
