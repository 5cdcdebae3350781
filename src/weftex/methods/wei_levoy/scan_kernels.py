# mypy: ignore-errors
# cython: infer_types=True
"""The kernel of Wei and Levoy's method; compiled by Cython, see setup.py and the .pxd."""

import cython
from cython.cimports.weftex.methods.wei_levoy.tsvq_kernels import Tree, nearest
from cython.cimports.weftex.search.picture_kernels import Picture
from cython.cimports.weftex.search.window_kernels import copy_pixel


def gather_window(level, y, x, offsets, first, tree):
    """Copy the known pixels of a window to its bytes of the query, from byte `first` on."""
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    height, width, channels = level.pixels.shape[0], level.pixels.shape[1], level.pixels.shape[2]
    n = tree.known
    at = first
    for i in range(offsets.shape[0]):
        cy, cx = y + offsets[i, 0], x + offsets[i, 1]
        if level.wrap_y and (cy < 0 or cy >= height):
            cy = cy % height
            if cy < 0:
                cy += height
        if level.wrap_x and (cx < 0 or cx >= width):
            cx = cx % width
            if cx < 0:
                cx += width
        if 0 <= cy < height and 0 <= cx < width and level.done[cy, cx]:
            for k in range(channels):
                tree.query[at + k] = level.pixels[cy, cx, k]
            if n and tree.spans[n - 1, 0] + tree.spans[n - 1, 1] == at:
                tree.spans[n - 1, 1] += channels
            else:
                tree.spans[n, 0], tree.spans[n, 1] = at, channels
                n += 1
        at += channels
    tree.known = n


def replace_pixels(
    level: Picture,
    coarser: Picture,
    sample: cython.const[cython.uchar][:, :, ::1],
    own: cython.const[cython.int][:, ::1],
    parents: cython.const[cython.int][:, ::1],
    places: cython.const[cython.int][::1],
    tree: Tree,
    leaves: cython.Py_ssize_t,
):
    """Replace the pixels at `places` in turn, each by the sample's pixel with the nearest window.

    A window has the parent's pixels at the offsets `parents` and its own that are done. A pixel
    without any stays.
    """
    first = parents.shape[0] * level.pixels.shape[2]
    with cython.nogil:
        for i in range(places.shape[0]):
            y, x = places[i] // level.pixels.shape[1], places[i] % level.pixels.shape[1]
            tree.known = 0
            if parents.shape[0]:
                gather_window(coarser, y // 2, x // 2, parents, 0, tree)
            gather_window(level, y, x, own, first, tree)
            level.done[y, x] = 1
            if tree.known == 0:
                continue
            place = tree.places[nearest(tree, leaves)]
            copy_pixel(sample, place, level.pixels, level.source, y, x)
