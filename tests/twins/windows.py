"""Windows of samples and of canvases."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

#: Steps to the neighbors of a pixel: right, down, left and up.
ARCS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def rectangle(pixels, corner, size):
    """Pixels of a rectangle; rows and columns wrap."""
    rows, columns = (np.arange(n) + at for at, n in zip(corner, size, strict=True))
    return pixels[np.ix_(rows % pixels.shape[0], columns % pixels.shape[1])]


def window_centers(mask, half, tileable):
    """Pixels of a sample around which a whole window is usable, in scan order."""
    around = np.pad(mask, half, "wrap" if tileable else "constant")
    windows = sliding_window_view(around, (2 * half + 1, 2 * half + 1))
    return [tuple(at) for at in np.argwhere(windows.all(axis=(2, 3))).tolist()]


def known_steps(done, pixel, reach, wrap):
    """Steps from a pixel to the known ones of its window, (n, 2), sorted; no pixel is there twice.

    `reach` is how far the window goes up, down, left and right, or one number for all.
    """
    lines, reach = [], np.broadcast_to(reach, 4).reshape(2, 2)
    for at, length, wraps, (before, after) in zip(pixel, done.shape, wrap, reach, strict=True):
        if wraps:
            before, after = min(before, (length - 1) // 2), min(after, length // 2)
        steps = np.arange(-before, after + 1)
        lines.append(steps if wraps else steps[(at + steps >= 0) & (at + steps < length)])
    steps = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    y, x = ((pixel + steps) % done.shape).T
    return steps[(done[y, x] > 0) & steps.any(axis=1)]


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
