"""The quadtree pyramid of patch-based sampling (sections 3.2 and 3.3)."""

import numpy as np

from twins.windows import rectangle


def square_mean(pixels, y, x, side):
    """Mean of a block per channel, halves up; rows and columns wrap."""
    total = rectangle(pixels, (y, x), (side, side)).astype(int).sum(axis=(0, 1))
    return (2 * total + side * side) // (2 * side * side)


def square_distances(pixels, squares, side, query, usable, stride):
    """{window: squared distance of its block means to the query's} for every stride-th window."""
    found = {}
    for y, x in np.argwhere(usable):
        if y % stride or x % stride:
            continue
        means = np.concatenate([square_mean(pixels, y + v, x + u, side) for v, u in squares])
        found[int(y), int(x)] = int(((means - query) ** 2).sum())
    return found
