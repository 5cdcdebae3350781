# mypy: ignore-errors
# cython: infer_types=True
"""The kernel that chooses and pastes a run of patches; compiled, see setup.py and the .pxd.

It takes the steps of Liang et al. (2001), section 2.2. Those of Efros and Freeman (2001), section
2.2, differ in the `Tolerance` and in the cut.
"""

import cython
from cython.cimports.libc.math import sqrt
from cython.cimports.weftex.methods.patches.cut_kernels import cut_bands
from cython.cimports.weftex.raster.difference_kernels import squared
from cython.cimports.weftex.results.paste_kernels import Layout, paste
from cython.cimports.weftex.search.approximate_nearest_kernels import (
    nearest_by_coordinates,
    nearest_by_squares,
    project,
    square_means,
)

#: For Python, the constants of the .pxd.
FINDERS = int(ALL), int(SQUARES), int(COMPONENTS), int(TREE)

# The largest m of Liang et al., section 3.2.
MOST_CANDIDATES = cython.declare(cython.Py_ssize_t, 10000)
LARGEST_M = int(MOST_CANDIDATES)  # for Python

# The squared distance that a window without repeats may have, relative to the best with some.
UNREPEATED = cython.declare(cython.double, 1.7)

# Of the best windows, around which those that a stride skipped are compared.
BEST = cython.declare(cython.Py_ssize_t, 6)
SKIPPED = 9 * int(BEST)  # for Python: compared at most each time that the stride is halved

# Marks of windows that are not drawn.
REPEATS = cython.declare(cython.uchar, 1)  # shows what a patch around shows
CONTINUES = cython.declare(cython.uchar, 2)  # continues a patch around verbatim
DIFFERS = cython.declare(cython.uchar, 3)  # more than the tolerance


class Tolerance:
    """Which windows match, and how one of them is drawn.

    Liang et al., section 2.4: those nearer than d_max, `value` (epsilon) times the root mean square
    of the zone. Efros and Freeman, section 2.2: with `of_best`, those at most 1 + `value` times as
    far as the best. Draws are uniform or `by_similarity` (alpha_i of Liang et al., section 2.1).
    """

    def __init__(self, value, of_best, by_similarity):
        self.value, self.of_best, self.by_similarity = value, of_best, by_similarity
        self.accepts_all = value > 1e30

    def limit(self, energy, best):
        """Return the largest squared distance of a match.

        `energy` is the sum of squares of the zone's pixels, `best` the least squared distance.
        """
        if self.of_best:
            return best * (1 + self.value) * (1 + self.value)
        return energy * self.value * self.value

    def matches(self, distance, limit):
        """Whether a window of this squared distance is in Psi_B: Liang et al., eq. (1)."""
        return distance < limit or (self.of_best and distance <= limit)


class Patches:
    """The patches of an output, numbered in their order, and the sample that they come from."""

    def __init__(self, pixels, transposed, placements, cuts, bits, around, keep_apart):
        self.pixels, self.transposed = pixels, transposed
        self.placements, self.cuts = placements, cuts
        self.bits, self.around, self.keep_apart = bits, around, keep_apart


class WindowSearch:
    """The usable windows of a sample, arranged to be searched by one `BoundaryZone`.

    `nodes` are of the quadtree pyramid, `pca` has the components of the windows at `corners`.
    """

    def __init__(self, finder, stride, usable, corners, zone, nodes, pca):
        self.finder, self.stride = finder, stride
        self.usable, self.corners, self.nodes = usable, corners, nodes
        self.area, self.strips, self.squares = zone.area, zone.strips, zone.squares
        self.side, self.bands = zone.side, zone.bands
        self.basis, self.offset = pca.basis, pca.offset
        self.shift, self.coordinates = pca.shift, pca.coordinates


class Shortlist:
    """The candidates for one patch, and memory for its zone and for their search."""

    def __init__(self, wanted, corners, distances, marks, zone, means, coordinates, path):
        self.wanted, self.corners, self.distances = wanted, corners, distances
        self.marks, self.zone, self.means = marks, zone, means
        self.coordinates, self.path = coordinates, path

    def put(self, corners: cython.const[cython.int][::1]):
        """List these windows as the candidates."""
        for i in range(corners.shape[0]):
            self.corners[i] = corners[i]


def lay_patches(
    canvas: cython.uchar[:, :, ::1], patches: Patches, first: cython.Py_ssize_t,
    last: cython.Py_ssize_t, layout: Layout, search: WindowSearch, tolerance: Tolerance,
    shortlist: Shortlist,
):  # fmt: skip
    """Choose sources for patches `first` to `last` - 1, cut each and paste it on the canvas.

    All have the zone of `search`. `layout` has the weights of this zone alone, as number 0.
    """
    columns = search.usable.shape[1]
    with cython.nogil:
        for p in range(first, last):
            chosen = choose_window(canvas, patches, p, search, tolerance, shortlist)
            patches.placements[p, 2] = chosen // columns
            patches.placements[p, 3] = chosen % columns
            if patches.cuts.shape[0] > 0:
                cut_bands(
                    canvas, patches.pixels, layout, search.bands, p, shortlist.path, patches.cuts
                )
            paste(canvas, patches.pixels, layout, p, 0)


def choose_window(canvas, patches, p, search, tolerance, shortlist):
    """Return the corner of the window that patch `p` shows."""
    bits = patches.bits[p]
    windows = cython.cast(cython.ulonglong, search.corners.shape[0])
    if search.area == 0 or tolerance.accepts_all:
        # Step 1 of Liang et al., section 2.2: any window, as there is nothing to match.
        return search.corners[cython.cast(cython.Py_ssize_t, ((bits >> 32) * windows) >> 32)]
    # Step 2: the windows that may match E_out, with their distances.
    y, x = patches.placements[p, 0], patches.placements[p, 1]
    energy = copy_zone(canvas, y, x, search.strips, shortlist.zone)
    count = find_similar(canvas, patches, p, search, tolerance, energy, shortlist)
    # Not in the papers: windows that repeat are left out, unless all others are much worse.
    best = free_repeats(count, shortlist)
    # Steps 3 and 4: one of those within the tolerance.
    return shortlist.corners[draw_one(best, count, energy, bits, tolerance, shortlist)]


def find_similar(canvas, patches, p, search, tolerance, energy, shortlist):
    """List windows that may match the zone of patch `p`, with their distances; return how many."""
    y, x = patches.placements[p, 0], patches.placements[p, 1]
    count = list_candidates(canvas, y, x, search, shortlist)
    compare(patches, p, search, tolerance, energy, count, shortlist)
    if search.stride > 1:
        count = compare_skipped(patches, p, search, count, shortlist)
    if count < MOST_CANDIDATES or search.finder == ALL or tolerance.of_best:
        return count
    # With a wide epsilon, most of the largest m may match. Then windows all over the sample do.
    matching: cython.Py_ssize_t = 0
    for i in range(count):
        matching += shortlist.distances[i] < tolerance.limit(energy, 0)
    if 2 * matching > count:
        start = cython.cast(cython.Py_ssize_t, patches.bits[p] >> 40)
        everywhere = list_everywhere(search, start, shortlist)
        if everywhere > 0:
            count = everywhere
            compare(patches, p, search, tolerance, energy, count, shortlist)
    return count


def list_candidates(canvas, y, x, search, shortlist):
    """List windows that may match the zone at (y, x) of the canvas; return how many."""
    if search.finder == TREE:  # `PatchCanvas.choose_and_paste` has listed them
        return min(shortlist.wanted, search.corners.shape[0])
    if search.finder == ALL:
        for i in range(search.corners.shape[0]):
            shortlist.corners[i] = search.corners[i]
        return search.corners.shape[0]
    square_means(canvas, y, x, search.squares, search.side, shortlist.means)
    if search.finder == SQUARES:
        return nearest_by_squares(
            search.nodes, search.squares, shortlist.means, search.usable, shortlist.wanted,
            shortlist.distances, shortlist.corners,
        )  # fmt: skip
    project(search.basis, search.offset, search.shift, shortlist.means, shortlist.coordinates)
    return nearest_by_coordinates(
        search.coordinates, search.corners, shortlist.coordinates, shortlist.wanted,
        shortlist.distances, shortlist.corners,
    )  # fmt: skip


def copy_zone(canvas, y, x, strips, zone):
    """Copy the zone's pixels from the canvas, strip by strip; return the sum of their squares."""
    height, width, channels = canvas.shape[0], canvas.shape[1], canvas.shape[2]
    cython.declare(cy=cython.Py_ssize_t, cx=cython.Py_ssize_t)
    at: cython.Py_ssize_t = 0
    energy: cython.longlong = 0
    for s in range(strips.shape[0]):
        cy = (y + strips[s, 1]) % height
        cx = (x + strips[s, 2]) % width
        for _ in range(strips[s, 3]):
            for k in range(channels):
                zone[at + k] = canvas[cy, cx, k]
                energy += cython.cast(cython.int, canvas[cy, cx, k]) * canvas[cy, cx, k]
            at += channels
            if strips[s, 0]:
                cy = cy + 1 if cy + 1 < height else 0
            else:
                cx = cx + 1 if cx + 1 < width else 0
    return energy


def zone_distance(pixels, transposed, y, x, strips, zone, bound):
    """Return the error of the overlap for the window at (y, x): A d**2 in Liang et al., eq. (2).

    Past `bound`, unless that is negative, it is a part of the sum. `transposed` is `pixels`
    transposed, so that upright strips are contiguous too.
    """
    channels = pixels.shape[2]
    at: cython.Py_ssize_t = 0
    total: cython.longlong = 0
    for s in range(strips.shape[0]):
        n = strips[s, 3] * channels
        if strips[s, 0]:
            strip = cython.address(transposed[x + strips[s, 2], y + strips[s, 1], 0])
        else:
            strip = cython.address(pixels[y + strips[s, 1], x + strips[s, 2], 0])
        total += squared(strip, cython.address(zone[at]), n)
        at += n
        if total > bound and bound >= 0:
            break
    return total


def compare(patches, p, search, tolerance, energy, count, shortlist):
    """Compare candidates at the full resolution, each until it is hopeless, and mark repeats."""
    columns = search.usable.shape[1]
    best: cython.longlong = -1
    bound: cython.double = -1
    for i in range(count):
        y, x = shortlist.corners[i] // columns, shortlist.corners[i] % columns
        distance = zone_distance(
            patches.pixels, patches.transposed, y, x, search.strips, shortlist.zone,
            cython.cast(cython.longlong, bound),
        )  # fmt: skip
        shortlist.distances[i] = distance
        shortlist.marks[i] = mark_of(patches, p, y, x)
        if shortlist.marks[i] < CONTINUES and (best < 0 or distance < best):
            best = distance  # the worst that may be drawn from here on
            bound = UNREPEATED * best if patches.keep_apart > 0 else best
            bound = max(bound, tolerance.limit(energy, best))
            if tolerance.of_best:  # the best unmarked one may be as far as that
                bound = tolerance.limit(energy, bound)
            bound += 1


def compare_skipped(patches, p, search, count, shortlist):
    """Compare the neighbors that a stride skipped, around the best few; return the new count."""
    rows, columns = search.usable.shape[0], search.usable.shape[1]
    corners = cython.address(shortlist.corners[0])
    distances = cython.address(shortlist.distances[0])
    marks = cython.address(shortlist.marks[0])
    best: cython.Py_ssize_t
    step = search.stride // 2
    while step >= 1:
        few = min(BEST, count)
        for k in range(few):  # bring the best few to the front
            best = k
            for i in range(k + 1, count):
                if distances[i] < distances[best]:
                    best = i
            corners[k], corners[best] = corners[best], corners[k]
            distances[k], distances[best] = distances[best], distances[k]
            marks[k], marks[best] = marks[best], marks[k]
        for k in range(few):
            for n in range(9):
                y = corners[k] // columns + (n // 3 - 1) * step
                x = corners[k] % columns + (n % 3 - 1) * step
                if y < 0 or x < 0 or y >= rows or x >= columns or not search.usable[y, x]:
                    continue
                i = 0
                while i < count and corners[i] != y * columns + x:
                    i += 1
                if i == count and count < shortlist.corners.shape[0]:
                    corners[count] = y * columns + x
                    marks[count] = mark_of(patches, p, y, x)
                    distances[count] = zone_distance(
                        patches.pixels, patches.transposed, y, x, search.strips, shortlist.zone, -1
                    )
                    count += 1
        step //= 2
    return count


def list_everywhere(search, start, shortlist):
    """List windows from all over the sample, evenly spread; return how many."""
    columns = search.usable.shape[1]
    total = search.usable.shape[0] * columns
    step = total // MOST_CANDIDATES + 1
    count: cython.Py_ssize_t = 0
    i = start % step
    while i < total:
        if search.usable[i // columns, i % columns]:
            shortlist.corners[count] = i
            count += 1
        i += step
    return count


def mark_of(patches, p, y, x):
    """Return the mark of the window at (y, x), if patch `p` were to show it; 0 for none.

    A window nearer than `keep_apart` to the source of a patch around repeats it; but one that
    continues it does not. So that not all patches continue others, half of them may not.
    """
    apart = patches.keep_apart
    this = cython.address(patches.placements[p, 0])
    for k in range(patches.around.shape[1]):
        if patches.around[p, k] < 0:
            continue
        other = cython.address(patches.placements[patches.around[p, k], 0])
        dy, dx = y - other[2], x - other[3]
        if dy == this[0] - other[0] and dx == this[1] - other[1]:
            if patches.bits[p] & 1:
                return CONTINUES
        elif -apart < dy < apart and -apart < dx < apart:
            return REPEATS
    return 0


def free_repeats(count, shortlist):
    """Return the best unmarked window; if it is much worse than marked ones, free them first.

    Freed are those that continue no patch, unless there are no others.
    """
    distances, marks = cython.address(shortlist.distances[0]), cython.address(shortlist.marks[0])
    cython.declare(best=cython.Py_ssize_t, apart=cython.Py_ssize_t, free=cython.Py_ssize_t)
    best = apart = free = -1  # the best of all, of those that continue no patch, of the unmarked
    for i in range(count):
        if best < 0 or distances[i] < distances[best]:
            best = i
        if marks[i] < CONTINUES and (apart < 0 or distances[i] < distances[apart]):
            apart = i
        if not marks[i] and (free < 0 or distances[i] < distances[free]):
            free = i
    if apart >= 0:
        best = apart
    if free >= 0 and distances[free] <= UNREPEATED * distances[best]:
        return free
    for i in range(count):
        if marks[i] < CONTINUES or apart < 0:
            marks[i] = 0
    return best


def draw_one(best, count, energy, bits, tolerance, shortlist):
    """Draw one of Psi_B, the unmarked windows within the tolerance; `best` if there are none."""
    distances, marks = cython.address(shortlist.distances[0]), cython.address(shortlist.marks[0])
    limit: cython.double = tolerance.limit(energy, distances[best])
    size: cython.ulonglong = 0  # of Psi_B
    total: cython.double = 0  # of alpha_i
    for i in range(count):
        if marks[i]:
            continue
        if not tolerance.matches(distances[i], limit):
            marks[i] = DIFFERS
            continue
        size += 1
        if tolerance.by_similarity:
            total += 1 - sqrt(distances[i] / limit)
    if size > 0 and total > 0:
        total *= (bits >> 11) * (1.0 / 9007199254740992.0)
        for i in range(count):
            if not marks[i]:
                total -= 1 - sqrt(distances[i] / limit)
                if total < 0:
                    return i
        return best
    size = ((bits >> 32) * size) >> 32
    for i in range(count):
        if not marks[i]:
            if size == 0:
                return i
            size -= 1
    return best
