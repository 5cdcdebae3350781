# mypy: ignore-errors
"""Kernels that compare boundary zones; compiled by Cython, see setup.py and the .pxd.

All distances are sums of squared differences of integers, so every order of summation, vector
width and machine gives the same one.
"""

import cython
from cython.cimports.weftex.raster.difference_kernels import squared

#: For Python, the constants of the .pxd.
SOURCES = int(ALL), int(BLOCKS), int(COMPONENTS), int(TREE)


class ZoneWindows:
    """The usable windows of a sample, arranged to be searched by one `BoundaryZone`.

    `nodes` are of the quadtree pyramid, `pca` has the components of the windows at `positions`.
    """

    def __init__(self, source, usable, positions, zone, nodes, pca):
        self.source, self.usable, self.positions, self.nodes = source, usable, positions, nodes
        self.area, self.runs, self.blocks = zone.area, zone.runs, zone.blocks
        self.side, self.bands = zone.side, zone.bands
        self.basis, self.offset = pca.basis, pca.offset
        self.shift, self.features = pca.shift, pca.features


class Shortlist:
    """The candidates of one patch, and memory for its zone and for the query of the search."""

    def __init__(
        self, wanted, keys, places, query, means, coordinates, partial, total,
        excluded=None, path=None,
    ):  # fmt: skip
        self.wanted, self.keys, self.places, self.query = wanted, keys, places, query
        self.means, self.coordinates = means, coordinates
        self.partial, self.total = partial, total
        self.excluded, self.path = excluded, path


def copy_zone(canvas, y, x, runs, query):
    """Copy the zone's pixels from the canvas, run by run; return the sum of their squares."""
    height: cython.Py_ssize_t = canvas.shape[0]
    width: cython.Py_ssize_t = canvas.shape[1]
    channels: cython.Py_ssize_t = canvas.shape[2]
    at: cython.Py_ssize_t = 0
    energy: cython.longlong = 0
    cython.declare(r=cython.Py_ssize_t, i=cython.Py_ssize_t, k=cython.Py_ssize_t)
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    for r in range(runs.shape[0]):
        cy = (y + runs[r, 1]) % height
        cx = (x + runs[r, 2]) % width
        for i in range(runs[r, 3]):
            for k in range(channels):
                query[at + k] = canvas[cy, cx, k]
                energy += cython.cast(cython.int, canvas[cy, cx, k]) * canvas[cy, cx, k]
            at += channels
            if runs[r, 0]:
                cy = cy + 1 if cy + 1 < height else 0
            else:
                cx = cx + 1 if cx + 1 < width else 0
    return energy


def zone_distance(pixels, transposed, y, x, runs, query, bound):
    """Return A d**2 of eq. (2) for the window at (y, x), or stop past `bound` (negative: never).

    `transposed` is `pixels` transposed, so that upright runs are contiguous too: short rows cost
    their overhead and not their bytes.
    """
    channels: cython.Py_ssize_t = pixels.shape[2]
    at: cython.Py_ssize_t = 0
    total: cython.longlong = 0
    cython.declare(r=cython.Py_ssize_t, n=cython.Py_ssize_t, row=cython.p_const_uchar)
    for r in range(runs.shape[0]):
        n = runs[r, 3] * channels
        if runs[r, 0]:
            row = cython.address(transposed[x + runs[r, 2], y + runs[r, 1], 0])
        else:
            row = cython.address(pixels[y + runs[r, 1], x + runs[r, 2], 0])
        total += squared(row, cython.address(query[at]), n)
        at += n
        if total > bound and bound >= 0:
            break
    return total


def block_means(canvas, y, x, blocks, side, means):
    """Mean of each side x side block of the zone, per channel, as `QuadtreePyramid` rounds it."""
    height: cython.Py_ssize_t = canvas.shape[0]
    width: cython.Py_ssize_t = canvas.shape[1]
    channels: cython.Py_ssize_t = canvas.shape[2]
    cython.declare(b=cython.Py_ssize_t, i=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(k=cython.Py_ssize_t, cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    cython.declare(total=cython.int)
    for b in range(blocks.shape[0]):
        for k in range(channels):
            total = 0
            cy = (y + blocks[b, 0]) % height
            for i in range(side):
                cx = (x + blocks[b, 1]) % width
                for j in range(side):
                    total += canvas[cy, cx, k]
                    cx = cx + 1 if cx + 1 < width else 0
                cy = cy + 1 if cy + 1 < height else 0
            means[b * channels + k] = (total + side * side // 2) // (side * side)


# Typed here too, or it cannot be inlined, which costs a search 5 %.
@cython.cfunc
@cython.inline
@cython.nogil
@cython.exceptval(check=False)
def offer(
    key: cython.longlong,
    place: cython.int,
    count: cython.Py_ssize_t,
    wanted: cython.Py_ssize_t,
    keys: cython.p_longlong,
    places: cython.p_int,
) -> cython.Py_ssize_t:
    """Put a candidate into a heap that keeps the `wanted` smallest keys; return its new size."""
    cython.declare(i=cython.Py_ssize_t, child=cython.Py_ssize_t)
    if count < wanted:
        i = count
        while i > 0 and keys[(i - 1) // 2] < key:
            keys[i] = keys[(i - 1) // 2]
            places[i] = places[(i - 1) // 2]
            i = (i - 1) // 2
        keys[i] = key
        places[i] = place
        return count + 1
    if key >= keys[0]:
        return count
    i = 0
    while True:
        child = 2 * i + 1
        if child >= count:
            break
        if child + 1 < count and keys[child + 1] > keys[child]:
            child += 1
        if keys[child] <= key:
            break
        keys[i] = keys[child]
        places[i] = places[child]
        i = child
    keys[i] = key
    places[i] = place
    return count


def nearest_by_blocks(nodes, blocks, query, usable, shortlist):
    """Find the windows whose blocks are nearest to the query's, over one node of the pyramid each.

    `nodes` is (channel, shift y, shift x, row, column): with a stride of s, the window at (s * i, s
    * j) reads the block at (v, u) in node (v % s, u % s) at (i + v // s, j + u // s).
    """
    channels: cython.Py_ssize_t = nodes.shape[0]
    stride: cython.Py_ssize_t = nodes.shape[1]
    rows: cython.Py_ssize_t = (usable.shape[0] + stride - 1) // stride
    columns: cython.Py_ssize_t = (usable.shape[1] + stride - 1) // stride
    keys: cython.p_longlong = cython.address(shortlist.keys[0])
    places: cython.p_int = cython.address(shortlist.places[0])
    partial: cython.p_int = cython.address(shortlist.partial[0])
    total: cython.p_longlong = cython.address(shortlist.total[0])
    wanted: cython.Py_ssize_t = shortlist.wanted
    count: cython.Py_ssize_t = 0
    cython.declare(i=cython.Py_ssize_t, j=cython.Py_ssize_t, b=cython.Py_ssize_t)
    cython.declare(k=cython.Py_ssize_t, v=cython.Py_ssize_t, u=cython.Py_ssize_t)
    cython.declare(pending=cython.int, d=cython.short, q=cython.short, node=cython.p_const_uchar)
    for i in range(rows):
        for j in range(columns):
            total[j] = 0
            partial[j] = 0
        pending = 0
        for b in range(blocks.shape[0]):
            v = blocks[b, 0]
            u = blocks[b, 1]
            for k in range(channels):
                q = cython.cast(cython.short, query[b * channels + k])
                node = cython.address(
                    nodes[k, v % stride, u % stride, i + v // stride, u // stride]
                )
                for j in range(columns):
                    d = cython.cast(cython.short, node[j]) - q
                    partial[j] += cython.cast(cython.int, d) * d
                pending += 1
                if pending == 16384:
                    pending = 0
                    for j in range(columns):
                        total[j] += partial[j]
                        partial[j] = 0
        for j in range(columns):
            total[j] += partial[j]
            if (count < wanted or total[j] < keys[0]) and usable[i * stride, j * stride]:
                count = offer(
                    total[j],
                    cython.cast(cython.int, i * stride * usable.shape[1] + j * stride),
                    count, wanted, keys, places,
                )  # fmt: skip
    return count


def project(basis, offset, shift, means, features):
    """Coordinates of a query in the principal components, rounded as `ZonePCA` rounds them."""
    cython.declare(d=cython.Py_ssize_t, k=cython.Py_ssize_t, total=cython.int)
    for d in range(basis.shape[0]):
        total = -offset[d] + ((1 << shift) >> 1)
        for k in range(basis.shape[1]):
            total += cython.cast(cython.int, basis[d, k]) * means[k]
        total >>= shift
        features[d] = cython.cast(cython.short, min(max(total, -4095), 4095))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def feature_distances(
    features: cython.const[cython.short][:, ::1], query: cython.const[cython.short][::1],
    start: cython.Py_ssize_t, n: cython.Py_ssize_t, total: cython.p_int,
) -> cython.void:  # fmt: skip
    """Squared distances of n windows' coordinates; one component is one row of `features`."""
    cython.declare(d=cython.Py_ssize_t, j=cython.Py_ssize_t)
    cython.declare(q=cython.short, next_q=cython.short, diff=cython.short, next_diff=cython.short)
    cython.declare(row=cython.p_const_short, next_row=cython.p_const_short)
    for j in range(n):
        total[j] = 0
    for d in range(0, features.shape[0] - 1, 2):  # two at a time halve the traffic of sums
        row = cython.address(features[d, start])
        next_row = cython.address(features[d + 1, start])
        q = query[d]
        next_q = query[d + 1]
        for j in range(n):
            diff = row[j] - q
            next_diff = next_row[j] - next_q
            total[j] += (
                cython.cast(cython.int, diff) * diff
                + cython.cast(cython.int, next_diff) * next_diff
            )
    if features.shape[0] % 2:
        row = cython.address(features[features.shape[0] - 1, start])
        q = query[features.shape[0] - 1]
        for j in range(n):
            diff = row[j] - q
            total[j] += cython.cast(cython.int, diff) * diff


def distances_by_features(features, query, out):
    """Squared distances in principal components of all windows."""
    cython.declare(start=cython.Py_ssize_t)
    for start in range(0, out.shape[0], 1024):
        feature_distances(
            features, query, start, min(1024, out.shape[0] - start), cython.address(out[start])
        )


def nearest_by_features(features, at, query, wanted, keys, places):
    """Find the windows nearest in principal components; one component is one row of `features`."""
    total = cython.declare(cython.int[1024])
    count: cython.Py_ssize_t = 0
    worst: cython.longlong = 0
    cython.declare(start=cython.Py_ssize_t, n=cython.Py_ssize_t, j=cython.Py_ssize_t)
    for start in range(0, at.shape[0], 1024):
        n = min(1024, at.shape[0] - start)
        feature_distances(features, query, start, n, cython.address(total[0]))
        for j in range(n):
            if total[j] < worst or count < wanted:
                count = offer(
                    total[j], at[start + j], count, wanted,
                    cython.address(keys[0]), cython.address(places[0]),
                )  # fmt: skip
                worst = keys[0]
    return count


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


def climb(pixels, transposed, windows, count, found):
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
                        keys[count] = zone_distance(
                            pixels, transposed, y, x, windows.runs, found.query, -1
                        )
                        count += 1
        reach //= 2
    return count
