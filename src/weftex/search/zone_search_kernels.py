# mypy: ignore-errors
"""Kernels that list the windows of a sample that may match a boundary zone; see the .pxd."""

import cython
from cython.cimports.weftex.search.zone_kernels import (
    block_means,
    distance,
    nearest_by_blocks,
    nearest_by_features,
    project,
)

#: For Python, the constants of the .pxd.
SOURCES = int(ALL), int(BLOCKS), int(COMPONENTS), int(TREE)


class ZoneWindows:
    """The usable windows of a sample, arranged to be searched by one `BoundaryZone`.

    `nodes` are of the quadtree pyramid, `pca` has the components of the windows at `positions`.
    """

    def __init__(self, source, usable, positions, zone, nodes, pca):
        self.source = source
        self.usable = usable
        self.positions = positions
        self.area = zone.area
        self.runs = zone.runs
        self.blocks = zone.blocks
        self.side = zone.side
        self.bands = zone.bands
        self.nodes = nodes
        self.basis = pca.basis
        self.offset = pca.offset
        self.shift = pca.shift
        self.features = pca.features


def list_candidates(canvas, y, x, windows, found):
    """List windows that may match the zone at (y, x) of the canvas; return how many."""
    count: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    if windows.source == ALL:
        count = windows.positions.shape[0]
        for i in range(count):
            found.places[i] = windows.positions[i]
    elif windows.source == TREE:
        count = min(found.wanted, windows.positions.shape[0])
    else:
        block_means(canvas, y, x, windows.blocks, windows.side, found.means)
        if windows.source == BLOCKS:
            count = nearest_by_blocks(
                windows.nodes, windows.blocks, found.means, windows.usable, found
            )
        else:
            project(windows.basis, windows.offset, windows.shift, found.means, found.coordinates)
            count = nearest_by_features(
                windows.features, windows.positions, found.coordinates, found.wanted,
                found.keys, found.places,
            )  # fmt: skip
    return count


def climb(pixels, turned, windows, count, found):
    """Add the neighbors that a coarse grid of candidates skipped, around the best few."""
    width: cython.Py_ssize_t = windows.usable.shape[1]
    reach: cython.Py_ssize_t = windows.nodes.shape[1] // 2
    keys: cython.p_longlong = cython.address(found.keys[0])
    places: cython.p_int = cython.address(found.places[0])
    key: cython.longlong
    place: cython.int
    cython.declare(turn=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(best=cython.Py_ssize_t, n=cython.Py_ssize_t, dy=cython.Py_ssize_t)
    cython.declare(dx=cython.Py_ssize_t, y=cython.Py_ssize_t, x=cython.Py_ssize_t)
    while reach >= 1:
        n = min(6, count)
        for turn in range(n):  # bring the best few to the front
            best = turn
            for i in range(turn + 1, count):
                if keys[i] < keys[best]:
                    best = i
            key = keys[best]
            place = places[best]
            keys[best] = keys[turn]
            places[best] = places[turn]
            keys[turn] = key
            places[turn] = place
        for turn in range(n):
            place = places[turn]
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    y = place // width + dy * reach
                    x = place % width + dx * reach
                    if y < 0 or x < 0 or y >= windows.usable.shape[0] or x >= width:
                        continue
                    if not windows.usable[y, x]:
                        continue
                    j = 0
                    while j < count and places[j] != y * width + x:
                        j += 1
                    if j == count and count < found.places.shape[0]:
                        places[count] = cython.cast(cython.int, y * width + x)
                        keys[count] = distance(pixels, turned, y, x, windows.runs, found.query, -1)
                        count += 1
        reach //= 2
    return count
