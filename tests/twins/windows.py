"""Windows of samples and of canvases."""

from __future__ import annotations

import itertools

import numpy as np

#: Steps to the neighbors of a pixel: right, down, left and up.
ARCS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def usable(exemplar):
    """The sample's mask, all of it without one."""
    return np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask


def rectangle(pixels, corner, size):
    """Pixels of a rectangle; rows and columns wrap."""
    rows, columns = (np.arange(n) + at for at, n in zip(corner, size, strict=True))
    return pixels[np.ix_(rows % pixels.shape[0], columns % pixels.shape[1])]


def beside(at, step, shape, wrap):
    """The pixel of a canvas a step away, around wrapped borders; None beyond others."""
    y, x = (
        (k + d) % n if wraps else k + d
        for k, d, n, wraps in zip(at, step, shape, wrap, strict=True)
    )
    return (y, x) if 0 <= y < shape[0] and 0 <= x < shape[1] else None


def inwards(known, wrap):
    """Layers of unknown pixels, those next to known ones first; all at once where none is known."""
    left, layers = {tuple(at) for at in np.argwhere(~known).tolist()}, []
    while left:
        layer = [
            at
            for at in sorted(left)
            if any(beside(at, step, known.shape, wrap) not in left | {None} for step in ARCS)
        ]
        layers.append(layer or sorted(left))
        left -= set(layers[-1])
    return layers


def window_centers(mask, reach, tileable):
    """Pixels of a sample around which a whole window is usable, in scan order."""
    up, down, left, right = reach
    height, width = mask.shape
    centers = []
    for y, x in np.ndindex(height, width):
        window = list(
            itertools.product(range(y - up, y + down + 1), range(x - left, x + right + 1))
        )
        if tileable:
            window = [(v % height, u % width) for v, u in window]
        if all(0 <= v < height and 0 <= u < width and mask[v, u] for v, u in window):
            centers.append((y, x))
    return centers


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


def window_at(pixels, y, x, reach):
    """The window around a pixel of a sample, around its borders where it tiles."""
    return rectangle(pixels, (y - reach, x - reach), [2 * reach + 1] * 2).astype(int)


def steps_away(picture, y, x, steps):
    """The pixels at some steps from one, around all borders."""
    dy, dx = np.array(steps, int).reshape(-1, 2).T
    return picture[(y + dy) % len(picture), (x + dx) % picture.shape[1]].astype(int)


def nearest_center(centers, y, x):
    """The center nearest to (y, x) along the nearest row that has any; the first of equals."""
    row = min(sorted({v for v, _ in centers}), key=lambda v: abs(v - y))
    return row, min(sorted(u for v, u in centers if v == row), key=lambda u: abs(u - x))
