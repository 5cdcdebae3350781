# mypy: ignore-errors
"""Kernels that list the windows of a sample that may match a boundary zone; see the .pxd.

`Search.source` says where candidates come from: ALL windows, the BLOCKS of the low resolution
(section 3.2), its principal components (FEATURES, section 3.3), or they are GIVEN by a kd-tree
(section 3.1).
"""

import cython
from cython.cimports.weftex.search.zone_kernels import (
    Shortlist,
    block_means,
    distance,
    nearest_by_blocks,
    nearest_by_features,
    project,
)


class Sample:
    """The sample as distances are taken on it, upright and with its axes exchanged."""

    def __init__(self, pixels, turned):
        self.pixels = pixels
        self.turned = turned


class Zone:
    """The boundary zone of a run of patches, see `BoundaryZone`."""

    def __init__(self, area, runs, blocks, side, bands):
        self.area = area
        self.runs = runs
        self.blocks = blocks
        self.side = side
        self.bands = bands


class Search:
    """How candidates for one zone are found.

    Parameters
    ----------
    source : int
        ALL, BLOCKS, FEATURES or GIVEN.
    wanted : int
        m of section 3.2.
    usable, positions
        The windows of the sample, as in `ZoneSearch`.
    nodes : uint8 array (channels, stride, stride, rows, columns)
        Of the quadtree pyramid.
    pca : ZonePCA
        Principal components of the windows at `positions`.
    """

    def __init__(self, source, wanted, usable, positions, nodes, pca):
        self.source = source
        self.wanted = wanted
        self.usable = usable
        self.positions = positions
        self.nodes = nodes
        self.basis = pca.basis
        self.offset = pca.offset
        self.shift = pca.shift
        self.features = pca.features


class Candidates(Shortlist):
    """The candidates of one patch, and room for its zone and what the zone is searched by."""

    def __init__(self, query, means, coordinates, **shortlist):
        Shortlist.__init__(self, **shortlist)
        self.query = query
        self.means = means
        self.coordinates = coordinates


def list_candidates(canvas, y, x, zone, search, given, found):
    """List windows that may match the zone at (y, x) of the canvas; return how many."""
    count: cython.Py_ssize_t = 0
    i: cython.Py_ssize_t
    if search.source == ALL:
        count = search.positions.shape[0]
        for i in range(count):
            found.places[i] = search.positions[i]
    elif search.source == GIVEN:
        count = given.shape[0]
        for i in range(count):
            found.places[i] = given[i]
    else:
        block_means(canvas, y, x, zone.blocks, zone.side, found.means)
        if search.source == BLOCKS:
            count = nearest_by_blocks(search.nodes, zone.blocks, found.means, search.usable, found)
        else:
            project(search.basis, search.offset, search.shift, found.means, found.coordinates)
            count = nearest_by_features(
                search.features, search.positions, found.coordinates, search.wanted,
                found.keys, found.places,
            )  # fmt: skip
    return count


def climb(sample, zone, search, count, found):
    """Try the neighbors that a coarse grid of candidates skipped, around the best few."""
    width: cython.Py_ssize_t = search.usable.shape[1]
    reach: cython.Py_ssize_t = search.nodes.shape[1] // 2
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
                    if y < 0 or x < 0 or y >= search.usable.shape[0] or x >= width:
                        continue
                    if not search.usable[y, x]:
                        continue
                    j = 0
                    while j < count and places[j] != y * width + x:
                        j += 1
                    if j == count and count < found.places.shape[0]:
                        places[count] = cython.cast(cython.int, y * width + x)
                        keys[count] = distance(
                            sample.pixels, sample.turned, y, x, zone.runs, found.query, -1
                        )
                        count += 1
        reach //= 2
    return count
