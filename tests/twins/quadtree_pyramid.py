"""The quadtree pyramid of patch-based sampling (sections 3.2 and 3.3)."""

from __future__ import annotations

import itertools

import numpy as np

from twins.windows import rectangle


def quadtree_children(image):
    """The four half-resolution children of an image, by shift (figure 9 b), with exact means."""
    image = np.asarray(image, float)
    children = {}
    for dy, dx in itertools.product((0, 1), repeat=2):
        rows, columns = (image.shape[0] - dy) // 2, (image.shape[1] - dx) // 2
        child = np.zeros((rows, columns))
        for i, j in itertools.product(range(rows), range(columns)):
            block = image[2 * i + dy : 2 * i + dy + 2, 2 * j + dx : 2 * j + dx + 2]
            child[i, j] = block.sum() / 4
        children[dy, dx] = child
    return children


def quadtree_level(image, level):
    """Level 1 is the image, 2 its four children, 3 their 16; keys are shifts in the image."""
    nodes = {(0, 0): np.asarray(image, float)}
    for n in range(level - 1):
        nodes = {
            (v + 2**n * dy, u + 2**n * dx): child
            for (v, u), node in nodes.items()
            for (dy, dx), child in quadtree_children(node).items()
        }
    return nodes


def block_mean(pixels, y, x, side):
    """Mean of a block per channel, halves up; rows and columns wrap."""
    total = rectangle(pixels, (y, x), (side, side)).astype(int).sum(axis=(0, 1))
    return (2 * total + side * side) // (2 * side * side)


def block_distances(pixels, blocks, side, query, usable, stride):
    """{window: squared distance of its block means to the query's} for every stride-th window."""
    found = {}
    for y, x in np.argwhere(usable):
        if y % stride or x % stride:
            continue
        means = np.concatenate([block_mean(pixels, y + v, x + u, side) for v, u in blocks])
        found[int(y), int(x)] = int(((means - query) ** 2).sum())
    return found
