"""Slow, obvious twins of weftex's kernels and orderings, written from the definitions.

"Section", "equation" and "figure" are those of Liang, Liu, Xu, Guo and Shum (2001), Real-time
texture synthesis by patch-based sampling. Nothing here is clever, nothing is shared with the
package but the random bits (`weftex.random.draw`), the bytes that matching looks at
(`Exemplar.matching`, which has tests of its own) and the nouns.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np

from weftex.random import draw

#: A source that repeats nothing may have this times the squared distance of one that does.
VARIETY = 1.7

#: Patches of a hole that one more should not repeat: so many, the latest laid.
NEARBY = 11
#: What a step of a path costs where the patch cannot show: more than any path where it can.
HALF = Fraction(1, 2)
OUTSIDE = 2**44

# Random bits


def splitmix(state):
    """SplitMix64's step on Python's own integers (Steele, Lea and Flood, 2014)."""
    mask = 2**64 - 1
    state = (state + 0x9E3779B97F4A7C15) & mask
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
    return state ^ (state >> 31)


def random_bits(seed, purpose, *place):
    """The 64 bits of one place: seed, the purpose's bytes, 0xff and coordinates, mixed in turn."""
    state = splitmix(seed)
    for word in (*purpose.encode(), 0xFF, *place):
        state = splitmix(state ^ (word & (2**64 - 1)))  # negative ones in two's complement
    return state


# Boundary zones (sections 2.1 and 2.2)


def distance_to_unknown(known):
    """Chebyshev distance of every pixel of a window to the nearest unknown one; inf without."""
    unknown = np.argwhere(~known)
    if not len(unknown):
        return np.full(known.shape, np.inf)
    away = np.abs(np.argwhere(np.ones_like(known))[:, None] - unknown[None])
    return away.max(axis=2).min(axis=1).reshape(known.shape)


def zone_of(known, width):
    """The band of width w_E along the border: known, and that near something unknown."""
    return known & (distance_to_unknown(known) <= width)


def zone_weights(known, width, frozen=None, paste=False):
    """Weights in 1/256: all for the new pixel outside the zone, falling evenly through it."""
    zone, distance = zone_of(known, width), distance_to_unknown(known)
    weights = np.zeros(known.shape, int)
    for v, u in itertools.product(*map(range, known.shape)):
        if not known[v, u]:
            weights[v, u] = 256
        elif zone[v, u]:
            share = (width + 1 - distance[v, u]) / (width + 1)
            weights[v, u] = 256 if paste else max(1, math.floor(256 * share + 1e-9))
        if frozen is not None and frozen[v, u]:
            weights[v, u] = 0
    return weights


def zone_distance(a, b):
    """Equation (2): a and b are (A, channels), the zone's pixels on either side."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return math.sqrt(((a - b) ** 2).sum() / len(a))


def largest_distance(canvas, epsilon):
    """d_max of section 2.4 for the zone's pixels on the canvas, (A, channels)."""
    canvas = np.asarray(canvas, float)
    return epsilon * math.sqrt((canvas**2).sum() / len(canvas))


# The random choice (equation (1), steps 2 to 4 of section 2.2)


def pick(bits, count):
    """One of `count` with even chances, by the upper half of the 64 random bits."""
    return (int(bits) >> 32) * count >> 32


def psi_b(distances, d_max):
    """Equation (1), and step 3: the nearest where it is empty. Indices, in order."""
    matching = [i for i, d in enumerate(distances) if d < d_max]
    return matching or [int(np.argmin(distances))]


def similarity_weights(distances, d_max):
    """The normalised similarity factors alpha_i of section 2.1."""
    alpha = np.array([1 - d / d_max for d in distances])
    return alpha / alpha.sum()


def choose(keys, marks, energy, bits, *, epsilon=None, tolerance=None, similarity=False):
    """Index of the candidate drawn.

    Parameters
    ----------
    keys : list of int
        A d**2 of each candidate: whole numbers, so that nothing hangs on rounding.
    marks : list of str
        "" for a candidate as any other, "repeats" and "continues" as `mark_repeats` says.
    energy : int
        A d_max**2 / epsilon**2.
    epsilon, tolerance : float
        One of the two: the rule of patch-based sampling or that of image quilting.
    """

    def limit(best):
        if epsilon is not None:
            return energy * epsilon * epsilon
        return best * (1 + tolerance) * (1 + tolerance)

    def within(i, bound):
        return keys[i] < bound if epsilon is not None else keys[i] <= bound

    def nearest(of):
        return min(of, key=lambda i: (keys[i], i))

    everything = list(range(len(keys)))
    eligible = [i for i in everything if marks[i] != "continues"] or everything
    fresh = [i for i in everything if not marks[i]]
    best = nearest(eligible)
    bound = limit(keys[best])
    if fresh and keys[nearest(fresh)] <= VARIETY * keys[best]:
        eligible, best = fresh, nearest(fresh)
        bound = limit(keys[best])
    matching = [i for i in eligible if within(i, bound)]
    if not matching:
        return best
    if similarity and bound > 0:
        alpha = [1 - math.sqrt(keys[i] / bound) for i in matching]
        total = 0.0
        for a in alpha:
            total += a
        if total > 0:
            left = total * (int(bits) >> 11) * 2.0**-53
            for i, a in zip(matching, alpha, strict=True):
                left -= a
                if left < 0:
                    return i
            return best
    return matching[pick(bits, len(matching))]


def mark_repeats(corner, places, around, reach, leave):
    """Which candidates would show again what a patch laid nearby shows.

    `around` lists (y, x, source y, source x) of earlier patches. A source within `reach` of one of
    theirs repeats it, unless it goes on exactly as the sample does, which `leave` forbids too.
    """
    marks = []
    for sy, sx in places:
        mark = ""
        for y, x, oy, ox in around:
            if (sy - oy, sx - ox) == (corner[0] - y, corner[1] - x):
                if leave:
                    mark = "continues"
                    break
            elif max(abs(sy - oy), abs(sx - ox)) < reach:
                mark = "repeats"
                break
        marks.append(mark)
    return marks


# Low resolution (sections 3.2 and 3.3)


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
    height, width = pixels.shape[:2]
    rows, columns = [(y + k) % height for k in range(side)], [(x + k) % width for k in range(side)]
    total = pixels[np.ix_(rows, columns)].astype(int).sum(axis=(0, 1))
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


def feature_distances(features, query):
    """Squared distance of each column of `features` to the query."""
    return [sum((int(f) - int(q)) ** 2 for f, q in zip(c, query, strict=True)) for c in features.T]


# Seams


def path_by_exhaustion(cost):
    """The cheapest path from the first row to the last, one step aside a row at most.

    Of equally cheap ones, the one that, read backwards, stays nearest to the first column.
    """
    rows, columns = cost.shape
    best = None
    for path in itertools.product(range(columns), repeat=rows):
        if any(abs(a - b) > 1 for a, b in itertools.pairwise(path)):
            continue
        key = (sum(int(cost[i, k]) for i, k in enumerate(path)), path[::-1])
        if best is None or key < best:
            best = key
    return list(best[1][::-1])


def path_by_programming(cost):
    """The same path by dynamic programming."""
    rows, columns = cost.shape
    table = [[int(c) for c in cost[0]]]
    for i in range(1, rows):
        table.append(
            [
                int(cost[i, k]) + min(table[-1][max(k - 1, 0) : min(k + 2, columns)])
                for k in range(columns)
            ]
        )
    path = [min(range(columns), key=lambda k: (table[-1][k], k))]
    for i in range(rows - 2, -1, -1):
        near = range(max(path[0] - 1, 0), min(path[0] + 2, columns))
        path.insert(0, min(near, key=lambda k: (table[i][k], k)))
    return path


def box_of(weights):
    """(top, left, bottom, right) of where a patch can show; all of the window if it cannot."""
    shown = np.argwhere(weights > 0)
    if not len(shown):
        return (0, 0, *weights.shape)
    return (*shown.min(axis=0).tolist(), *(shown.max(axis=0) + 1).tolist())


def band_depth(weights, width, hole=False):
    """How far bands reach into the box: the zone's width, or in a hole half of the shorter side."""
    top, left, bottom, right = box_of(weights)
    shorter = min(bottom - top, right - left)
    return max(min(width, shorter), shorter // 2) if hole else min(width, shorter)


def cut_sides(canvas_window, new_window, weights, zone, width, hole=False):
    """{side: {line: position}}: for each row or column of the box where the older pixels end.

    A side of the box has a band if the zone is there. A step of its path costs the squared
    difference where pixels are blended, nothing where none was known, and as good as never goes
    where the canvas stays.
    """
    top, left, bottom, right = box_of(weights)
    depth = band_depth(weights, width, hole)
    cost = ((canvas_window.astype(int) - new_window.astype(int)) ** 2).sum(axis=2)
    cost[weights == 0] = OUTSIDE
    cost[weights == 256] = 0
    cost, there = cost[top:bottom, left:right], zone[top:bottom, left:right]
    turned = {  # so that each border lies to the left
        "left": (cost, there, top, lambda k: left + k),
        "top": (cost.T, there.T, left, lambda k: top + k),
        "right": (cost[:, ::-1], there[:, ::-1], top, lambda k: right - k),
        "bottom": (cost[::-1].T, there[::-1].T, left, lambda k: bottom - k),
    }
    return {
        side: {first + i: at(k) for i, k in enumerate(path_by_programming(c[:, :depth]))}
        for side, (c, z, first, at) in turned.items()
        if z[:, :depth].any()
    }


def cut_row(paths, rows, columns):
    """The paths as `Synthesis.cuts` stores them: first and past-the-last own columns and rows."""
    lines = {
        "left": [0] * rows,
        "right": [columns] * rows,
        "top": [0] * columns,
        "bottom": [rows] * columns,
    }
    for side, path in paths.items():
        for i, k in path.items():
            lines[side][i] = k
    return np.concatenate([*lines.values()]).astype(np.uint16)


def cut_weights(weights, cut):
    """The weights in force: in the zone all or nothing, on either side of the paths."""
    rows, columns = weights.shape
    first_column, last_column, first_row, last_row = np.split(
        cut.astype(int), np.cumsum([rows, rows, columns])
    )
    result = weights.copy()
    for v, u in itertools.product(range(rows), range(columns)):
        if 0 < weights[v, u] < 256:
            own = first_column[v] <= u < last_column[v] and first_row[u] <= v < last_row[u]
            result[v, u] = 256 if own else 0
    return result


# Compositing


def blend_pixel(old, new, weight, alpha=False):
    """Mix two pixels, (channels,), of one dtype; whole numbers round halves up."""
    if weight == 0:
        return old.copy()
    if weight == 256:
        return new.copy()
    result = old.copy()
    whole = old.dtype.kind == "u"
    colours = len(old) - 1 if alpha else len(old)
    if whole:
        o, n = [int(k) for k in old], [int(k) for k in new]
        for k in range(len(old)):
            result[k] = (o[k] * (256 - weight) + n[k] * weight + 128) // 256
        if alpha:
            a, b = (256 - weight) * o[-1], weight * n[-1]
            for k in range(colours):
                result[k] = (2 * (a * o[k] + b * n[k]) + a + b) // (2 * (a + b)) if a + b else n[k]
        return result
    for k in range(len(old)):
        result[k] = float(old[k]) + float(new[k] - old[k]) * (weight / 256)
    if alpha:
        a, b = (256 - weight) * float(old[-1]), weight * float(new[-1])
        share = b / (a + b) if a + b else 1.0
        for k in range(colours):
            result[k] = float(old[k]) + float(new[k] - old[k]) * share
    return result


def paste_all(out, source, top, left, shape, placements, weights, cuts, scale=1, alpha=False):
    """Replay placements over `out`, (rows, columns, channels), in place."""
    height, width = shape
    sample_height, sample_width = source.shape[0] // scale, source.shape[1] // scale
    for p, (y, x, sy, sx, zone) in enumerate(placements.tolist()):
        mask = weights[zone].astype(int)
        if len(cuts):
            mask = cut_weights(mask, cuts[p])
        for v, u in itertools.product(*map(range, mask.shape)):
            cy, cx = (y + v) % height - top, (x + u) % width - left
            fy, fx = (sy + v) % sample_height, (sx + u) % sample_width
            for r, q in itertools.product(range(scale), repeat=2):
                row, column = cy * scale + r, cx * scale + q
                if 0 <= row < out.shape[0] and 0 <= column < out.shape[1]:
                    new = source[fy * scale + r, fx * scale + q]
                    out[row, column] = blend_pixel(out[row, column], new, int(mask[v, u]), alpha)


def layers(window, shape, placements, weights, cuts, most=4):
    """{(row, column): [(patch, share), …]}, heaviest first, of what shows in a window."""
    top, left, rows, columns = window
    found = {(i, j): [] for i in range(rows) for j in range(columns)}
    for p, (y, x, _, _, zone) in enumerate(placements.tolist()):
        mask = weights[zone].astype(int)
        if len(cuts):
            mask = cut_weights(mask, cuts[p])
        for v, u in itertools.product(*map(range, mask.shape)):
            at = ((y + v) % shape[0] - top, (x + u) % shape[1] - left)
            if at not in found or mask[v, u] == 0:
                continue
            new = np.float32(mask[v, u]) / np.float32(256)
            older = [(k, np.float32(s * (np.float32(1) - new))) for k, s in found[at]]
            older = older[: most - 1]
            ahead = [entry for entry in older if entry[1] >= new]
            found[at] = ahead + [(p, new)] + older[len(ahead) :]
    return {at: [e for e in entries if e[1] > 0] for at, entries in found.items()}


# Orders


def patch_starts(length, size, overlap, wrap):
    """As few patches as cover an axis with at least the overlap, spread evenly."""
    if not wrap and length <= size:
        return [0]
    span = length if wrap else length - size
    count = 2 if wrap else 1
    while True:
        ends = [j * span // count for j in range(count + 1)]  # a wrapped axis ends where it starts
        if max(b - a for a, b in itertools.pairwise(ends)) <= size - overlap:
            return ends[:-1] if wrap else ends
        count += 1


# Patch-based sampling as a whole

#: Earlier patches of the grid that lie around one, as (rows, columns) away, in the order they ask.
AROUND = [(0, -2), (0, -1), *((-1, k) for k in range(-2, 2)), *((-2, k) for k in range(-2, 3))]


def sample_exhaustive(exemplar, method, canvas, seed, *, corners=None, finish=True):
    """Steps 1 to 6 of section 2.2, by looking at every window of the sample for every patch.

    Parameters
    ----------
    method : PatchSampling or Quilting
        With patch_size and boundary_width given.
    corners : list of (int, int), optional
        Where windows go, in order; needed for a canvas with holes.
    finish : bool
        Also make the picture (step 6).

    Returns
    -------
    placements : list of (y, x, source y, source x)
    picture : array or None
    """
    size, width = method.patch_size, method.boundary_width
    pixelwise = size == 1
    window = [2 * width + 1] * 2 if pixelwise else [min(size, n) for n in canvas.shape]
    centre = (width, width)
    if not pixelwise:
        width = zone_width(method, canvas)
    sample = exemplar.matching(method.edge_weight).astype(int)
    places = _windows_of(exemplar, window)
    stack = np.array([_at(sample, place, window) for place in places])
    buffer = np.zeros((*canvas.shape, sample.shape[2]), int)
    laid = np.zeros(canvas.shape, bool)
    holes = canvas.hole is not None
    if holes:
        buffer[:] = exemplar.as_matching(canvas.known, method.edge_weight)
        laid = ~canvas.hole
    frozen = laid.copy()
    rule = (
        {"tolerance": method.tolerance}
        if method.slug == "quilting"
        else {"epsilon": method.epsilon, "similarity": method.choice == "similarity"}
    )
    placements, records = [], []
    for number, (step, corner, known) in enumerate(_steps(method, canvas, window, corners, laid)):
        rows = [(corner[0] + v) % canvas.shape[0] for v in range(window[0])]
        columns = [(corner[1] + u) % canvas.shape[1] for u in range(window[1])]
        here = np.ix_(rows, columns)
        inside = _inside(canvas, corner, window)
        if known is None:
            known = laid[here] & inside
        zone = zone_of(known, width)
        if holes:
            bits = draw(seed, "patch", number)
        else:
            bits = draw(seed, "patch", *step)
        wanted = buffer[here][zone]
        if not zone.any() or math.inf in rule.values():
            chosen = pick(bits, len(places))
        else:
            keys = ((stack[:, zone] - wanted) ** 2).sum(axis=(1, 2)).tolist()
            marks = [""] * len(places)
            if method.repeat_distance > 0 and not pixelwise:
                if holes:
                    around = laid_nearby(corner, placements, window)
                else:
                    steps = _grid_steps(method, canvas)
                    grid = dict(zip(steps, placements, strict=False))
                    asked = [(step[0] + a, step[1] + b) for a, b in AROUND]
                    around = [grid[k] for k in asked if k in grid]
                marks = mark_repeats(
                    corner,
                    places,
                    around,
                    round(method.repeat_distance * size),
                    int(bits) & 1,
                )
            chosen = choose(keys, marks, int((wanted**2).sum()), bits, **rule)
        source = places[chosen]
        weights = zone_weights(
            known, width, frozen[here] & inside if holes else None, method.blend == "none"
        )
        if pixelwise:
            weights[:] = 0
            weights[centre] = 256
        final = weights
        if method.blend == "cut" and not pixelwise:
            paths = cut_sides(buffer[here], stack[chosen], weights, zone, width, holes)
            final = cut_weights(weights, cut_row(paths, *weights.shape))
        now = np.where(weights > 0, 256, 0) if method.blend == "feather-at-end" else final
        for v, u in itertools.product(*map(range, now.shape)):
            if now[v, u]:
                at = rows[v], columns[u]
                old = buffer[at].astype(np.uint8)
                new = stack[chosen, v, u].astype(np.uint8)
                buffer[at] = blend_pixel(old, new, int(now[v, u]))
                laid[at] = True
        placements.append((*corner, *source))
        records.append((corner, source, final))
    if pixelwise:
        placements = [
            ((y + width) % canvas.shape[0], (x + width) % canvas.shape[1], a + width, b + width)
            for y, x, a, b in placements
        ]
    placements = [(y, x, a % exemplar.shape[0], b % exemplar.shape[1]) for y, x, a, b in placements]
    return placements, _finish(exemplar, canvas, records) if finish else None


def laid_nearby(corner, placements, window):
    """In a hole: the latest few patches whose corners are within two windows along both axes."""
    near = [
        p
        for p in placements
        if abs(p[0] - corner[0]) < 2 * window[0] and abs(p[1] - corner[1]) < 2 * window[1]
    ]
    return near[-NEARBY:]


def zone_width(method, canvas):
    """w_E of a run: at most a quarter of the window along an axis that wraps.

    The last patch of a wrapped row has a zone at either end, and room must be left between them.
    """
    width = method.boundary_width
    for n, wrap in zip(canvas.shape, canvas.wrap, strict=True):
        if wrap:
            width = min(width, min(method.patch_size, n) // 4)
    return max(width, 1)


def _finish(exemplar, canvas, records):
    """Step 6: blending, with the sample's own pixels."""
    pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
    picture = np.zeros((*canvas.shape, pixels.shape[2]), pixels.dtype)
    if canvas.known is not None:
        picture[:] = canvas.known.reshape(picture.shape)
    for (y, x), (sy, sx), weights in records:
        for v, u in itertools.product(*map(range, weights.shape)):
            if weights[v, u]:
                at = (y + v) % canvas.shape[0], (x + u) % canvas.shape[1]
                new = pixels[(sy + v) % exemplar.shape[0], (sx + u) % exemplar.shape[1]]
                picture[at] = blend_pixel(picture[at], new, int(weights[v, u]), exemplar.alpha)
    return picture.reshape(*canvas.shape, *exemplar.pixels.shape[2:])


def _windows_of(exemplar, window):
    """Upper left corners of the sample's windows (edge handling of section 2.4)."""
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    found = []
    for y, x in itertools.product(*map(range, exemplar.shape)):
        fits = y + window[0] <= exemplar.shape[0] and x + window[1] <= exemplar.shape[1]
        if (fits or exemplar.tileable) and _at(usable, (y, x), window).all():
            found.append((y, x))
    return found


def _at(pixels, corner, window):
    rows = [(corner[0] + v) % pixels.shape[0] for v in range(window[0])]
    columns = [(corner[1] + u) % pixels.shape[1] for u in range(window[1])]
    return pixels[np.ix_(rows, columns)]


def _inside(canvas, corner, window):
    """Which pixels of a window are on the canvas: all of them along axes that wrap."""
    inside = np.ones(window, bool)
    for axis in (0, 1):
        if not canvas.wrap[axis]:
            at = corner[axis] + np.arange(window[axis])
            inside &= np.expand_dims((at >= 0) & (at < canvas.shape[axis]), 1 - axis)
    return inside


def _grid_starts(method, canvas):
    width = zone_width(method, canvas)
    return [
        patch_starts(n, min(method.patch_size, n), min(width, n - 1, method.patch_size - 1), wrap)
        if n > 1
        else ([0, 0] if wrap else [0])
        for n, wrap in zip(canvas.shape, canvas.wrap, strict=True)
    ]


def _grid_steps(method, canvas):
    rows, columns = (len(starts) for starts in _grid_starts(method, canvas))
    return list(itertools.product(range(rows), range(columns)))


def _steps(method, canvas, window, corners, laid):
    """(numbers for the random bits, corner, what is known or None for what was laid)."""
    width = method.boundary_width
    if method.patch_size > 1:
        width = zone_width(method, canvas)
    if corners is not None:
        for corner in corners:
            yield None, corner, None
    elif method.patch_size == 1:
        for y, x in itertools.product(*map(range, canvas.shape)):
            yield (y, x), (y - width, x - width), None
    else:
        starts = _grid_starts(method, canvas)
        for i, j in _grid_steps(method, canvas):
            y, x = starts[0][i], starts[1][j]
            known = np.zeros(window, bool)  # figures 3 and 5
            if i > 0:
                known[:width] = True
            if j > 0:
                known[:, :width] = True
            if canvas.wrap[0] and i > 0 and y + window[0] > canvas.shape[0]:
                known[canvas.shape[0] - y :] = True
            if canvas.wrap[1] and j > 0 and x + window[1] > canvas.shape[1]:
                known[:, canvas.shape[1] - x :] = True
            yield (i, j), (y, x), known


# Windows around single pixels (what the pixel methods share)


def window_centres(mask, reach, tileable):
    """Pixels of a sample around which a whole window is usable, in scan order."""
    up, down, left, right = reach
    height, width = mask.shape
    centres = []
    for y, x in np.ndindex(height, width):
        window = list(
            itertools.product(range(y - up, y + down + 1), range(x - left, x + right + 1))
        )
        if tileable:
            window = [(v % height, u % width) for v, u in window]
        if all(0 <= v < height and 0 <= u < width and mask[v, u] for v, u in window):
            centres.append((y, x))
    return centres


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


# Graph cuts


#: The neighbours that the arcs of a grid lead to: right, down, left and up.
ARCS = ((0, 1), (1, 0), (0, -1), (-1, 0))


def cut_value(side, arcs, source, sink):
    """Capacity of what leads from the source's side to the sink's."""
    height, width = side.shape
    value = source[~side].sum() + sink[side].sum()
    for y, x in np.argwhere(side):
        for d, (dy, dx) in enumerate(ARCS):
            if 0 <= y + dy < height and 0 <= x + dx < width and not side[y + dy, x + dx]:
                value += arcs[y, x, d]
    return int(value)


def cut_by_exhaustion(arcs, source, sink):
    """Of all labellings of a tiny grid the cheapest, and of those the one that holds the fewest.

    The source's sides of minimum cuts are closed under intersection, so there is one such.
    """
    cells = [(False, True)] * source.size
    sides = [np.reshape(labels, source.shape) for labels in itertools.product(*cells)]
    values = [cut_value(side, arcs, source, sink) for side in sides]
    best = min(values)
    least = np.logical_and.reduce([s for s, v in zip(sides, values, strict=True) if v == best])
    return least, best


# Non-parametric sampling (Efros and Leung, 1999)


def bell_weights(width):
    """A Gaussian with a sigma of width / 6.4, in whole numbers from 1 to 127."""
    sigma, middle = width / 6.4, width // 2
    return [
        [
            max(1, round(127 * math.exp(-((v - middle) ** 2 + (u - middle) ** 2) / 2 / sigma**2)))
            for u in range(width)
        ]
        for v in range(width)
    ]


def weighted_distances(levels, y, x, known, exemplar, centres, weights):
    """Sum of w d**2 over the known steps, to the window around each of the sample's centres."""
    pixels, middle = exemplar.matching().astype(int), len(weights) // 2
    totals = np.zeros(len(centres), int)
    centres = np.array(centres)
    for dy, dx in known:
        here = levels[(y + dy) % len(levels), (x + dx) % levels.shape[1]].astype(int)
        rows, columns = (centres[:, 0] + dy) % len(pixels), (centres[:, 1] + dx) % pixels.shape[1]
        difference = pixels[rows, columns] - here
        totals += weights[dy + middle][dx + middle] * (difference**2).sum(axis=1)
    return [int(total) for total in totals]


def efros_leung(method, exemplar, canvas, seed):
    """Grow a canvas one pixel after the other; (H, W, 2) sources, -1 for known pixels.

    `method` has the window's width and the seed's size settled.
    """
    pixels, wrap = exemplar.matching(), canvas.wrap
    levels = np.zeros((*canvas.shape, pixels.shape[2]), np.uint8)
    done, source = np.zeros(canvas.shape, bool), np.full((*canvas.shape, 2), -1)
    reach = [method.window_width // 2] * 4
    mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    centres = window_centres(mask, reach, exemplar.tileable)
    weights = bell_weights(method.window_width)

    def lay(y, x, v, u):
        v, u = v % exemplar.shape[0], u % exemplar.shape[1]
        levels[y, x], done[y, x], source[y, x] = pixels[v, u], True, (v, u)

    if canvas.hole is not None and not canvas.hole.all():
        levels[~canvas.hole] = exemplar.as_matching(canvas.known)[~canvas.hole]
        done[~canvas.hole] = True
    else:
        v, u = centres[pick(random_bits(seed, "efros-leung seed"), len(centres))]
        side = [min(method.seed_size, n) for n in canvas.shape]
        top, left = ((n - s) // 2 for n, s in zip(canvas.shape, side, strict=True))
        for i, j in np.ndindex(*side):
            half = method.seed_size // 2
            lay(top + i, left + j, v + i - half, u + j - half)

    def has_filled_neighbour(y, x):
        for v, u in itertools.product((y - 1, y, y + 1), (x - 1, x, x + 1)):
            inside = [w or 0 <= k < n for k, n, w in zip((v, u), canvas.shape, wrap, strict=True)]
            if all(inside) and done[v % canvas.height, u % canvas.width]:
                return True
        return False

    threshold = method.threshold
    while not done.all():
        layer = [p for p in np.ndindex(*canvas.shape) if not done[p] and has_filled_neighbour(*p)]
        layer.sort(
            key=lambda p: (
                -len(known_window(done, *p, wrap, reach)),
                random_bits(seed, "efros-leung order", *p),
            )
        )
        progress = False
        for y, x in layer:
            known = known_window(done, y, x, wrap, reach)
            distances = weighted_distances(levels, y, x, known, exemplar, centres, weights)
            limit = min(distances) * (1 + method.tolerance)
            similar = [i for i, d in enumerate(distances) if d <= limit]
            drawn = similar[pick(random_bits(seed, "efros-leung", y, x), len(similar))]
            total = sum(weights[dy + reach[0]][dx + reach[0]] for dy, dx in known)
            if distances[drawn] / (255**2 * pixels.shape[2] * max(total, 1)) <= threshold:
                lay(y, x, *centres[drawn])
                progress = True
        if not progress:
            threshold *= 1.1
    return source


# Wei and Levoy (2000): pyramids, trees of vectors, causal windows


def coarser(levels, wrap, start=(0, 0)):
    """Every second pixel of the 1 4 6 4 1 mean, rounded; beyond a border the last pixel goes on."""
    height, width = levels.shape[:2]
    shape = (height + 1 - start[0]) // 2, (width + 1 - start[1]) // 2
    result = np.zeros((*shape, levels.shape[2]), np.uint8)
    for y, x in np.ndindex(result.shape[:2]):
        total = np.full(levels.shape[2], 128)
        for v, u in itertools.product(range(-2, 3), repeat=2):
            weight = (1, 4, 6, 4, 1)[v + 2] * (1, 4, 6, 4, 1)[u + 2]
            at = 2 * y + start[0] + v, 2 * x + start[1] + u
            at = _tap(at[0], height, wrap[0]), _tap(at[1], width, wrap[1])
            total += weight * levels[at].astype(int)
        result[y, x] = total // 256
    return result


def coarser_mask(mask, wrap, start=(0, 0)):
    """Whether all pixels that count for a coarser one are in the mask."""
    height, width = mask.shape
    result = np.ones(((height + 1 - start[0]) // 2, (width + 1 - start[1]) // 2), bool)
    for y, x in np.ndindex(result.shape):
        for v, u in itertools.product(range(-2, 3), repeat=2):
            at = 2 * y + start[0] + v, 2 * x + start[1] + u
            result[y, x] &= mask[_tap(at[0], height, wrap[0]), _tap(at[1], width, wrap[1])]
    return result


def stacked(levels, number, wrap, halve=coarser):
    """A coarser level, which is every 2**number-th pixel, for each pixel to be the first."""
    if not number:
        return levels
    result = np.empty_like(levels)
    for y, x in itertools.product((0, 1), repeat=2):
        result[y::2, x::2] = stacked(halve(levels, wrap, (y, x)), number - 1, wrap, halve)
    return result


def _tap(at, length, wraps):
    return at % length if wraps else min(max(at, 0), length - 1)


def _centroid(vectors):
    return (vectors.sum(axis=0) + len(vectors) // 2) // len(vectors)


def _spread(vectors):
    return int(((vectors - _centroid(vectors)) ** 2).sum())


def halves(vectors, rounds=8):
    """Which vectors are in the second of two clusters, by Lloyd's algorithm."""
    mean = vectors.sum(axis=0) // len(vectors)
    byte = int(np.argmax(((vectors - mean) ** 2).sum(axis=0)))
    second = vectors[:, byte] > mean[byte]
    for _ in range(rounds):
        centroids = [_centroid(vectors[second == k]) for k in (False, True)]
        first, other = (((vectors - c) ** 2).sum(axis=1) for c in centroids)
        now = other < first
        if (now == second).all() or now.all() or not now.any():
            break
        second = now
    return second


def vector_tree(vectors, tree_size=None, leaf=32):
    """Nodes as dicts: members, centroid and, if split, children; always the worst leaf is split."""
    vectors = vectors.astype(np.int64)
    nodes = [{"members": np.arange(len(vectors))}]
    while True:
        open_leaves = [
            (-_spread(vectors[node["members"]]) if number else 0, number)
            for number, node in enumerate(nodes)
            if "children" not in node
            and _spread(vectors[node["members"]])
            and (tree_size is not None or len(node["members"]) > leaf)
        ]
        leaves = sum("children" not in node for node in nodes)
        if not open_leaves or leaves == tree_size:
            return nodes
        node = nodes[min(open_leaves)[1]]
        second = halves(vectors[node["members"]])
        node["children"] = (len(nodes), len(nodes) + 1)
        for members in (node["members"][~second], node["members"][second]):
            nodes.append({"members": members, "centroid": _centroid(vectors[members])})


def nearest_in_tree(nodes, vectors, query, counts, leaves):
    """The member nearest in the bytes that count, among those of the leaves that are looked at."""

    def distance(vector):
        return int(((vector[counts].astype(np.int64) - query[counts]) ** 2).sum())

    waiting, found = [(0, 0)], []
    while waiting and leaves:
        number = min(waiting)[1]
        waiting.remove(min(waiting))
        while "children" in nodes[number]:
            near, far = sorted(
                (distance(nodes[c]["centroid"]), c) for c in nodes[number]["children"]
            )
            waiting.append(far)
            number = near[1]
        found += [(distance(vectors[m]), m) for m in nodes[number]["members"]]
        leaves -= 1
    return min(found)[1]


def wei_levoy(exemplar, method, canvas, seed):
    """Source index of every pixel; `method` with settled levels and widths."""
    count, width = method.levels, method.window_width
    parent_width = method.parent_width if count > 1 else 0
    tiles = (exemplar.tileable, exemplar.tileable)
    mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    samples, masks = [exemplar.matching()], [mask]
    for _ in range(count - 1):
        samples.append(coarser(samples[-1], tiles))
        masks.append(coarser_mask(masks[-1], tiles))
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    holed = not hole.all()
    wrap = canvas.wrap if holed else (True, True)

    def noise(level, shape):
        usable = np.flatnonzero(masks[level])
        share = sorted(usable, key=lambda p: (draw(seed, "wei-levoy share", level, p), p))
        total = shape[0] * shape[1]
        pixels = [share[k % len(share)] for k in range(total)]
        place = sorted(range(total), key=lambda k: (draw(seed, "wei-levoy noise", level, k), k))
        return np.array([pixels[k] for k in place]).reshape(shape)

    source = noise(0, canvas.shape)
    channels = samples[0].shape[2]
    picture = samples[0].reshape(-1, channels)[source]
    if holed:
        picture[~hole] = exemplar.as_matching(canvas.known)[~hole]
    pictures, knowns = [picture], [~hole]
    for _ in range(count - 1):
        pictures.append(coarser(pictures[-1], wrap))
        knowns.append(coarser_mask(knowns[-1], wrap))
    above = None
    for level in range(count - 1, -1, -1):
        above = _wei_levoy_level(
            method, canvas, seed, level, samples, masks, tiles, pictures, knowns[level], source,
            above, wrap, holed, noise, width, parent_width if level + 1 < count else 0,
        )  # fmt: skip
    return np.where(hole, above, -1)


def _wei_levoy_level(
    method, canvas, seed, level, samples, masks, tiles, pictures, known, source, above, wrap, holed,
    noise, width, parent_width,
):  # fmt: skip
    """The source map of one level; `above` is that of the coarser one."""
    sample, picture = samples[level], pictures[level]
    flat = sample.reshape(-1, sample.shape[2])
    shape, many = picture.shape[:2], len(samples) > 1
    source = source.copy() if level == 0 else np.full(shape, -1)
    if method.start == "parent" and many:
        fresh = noise(level, shape)
        if above is not None:
            for y, x in np.ndindex(shape):
                v, u = divmod(int(above[y // 2, x // 2]), samples[level + 1].shape[1])
                v = min(2 * v + y % 2, sample.shape[0] - 1)
                u = min(2 * u + x % 2, sample.shape[1] - 1)
                fresh[y, x] = v * sample.shape[1] + u
        source = np.where(known, source, fresh)
        picture[~known] = flat[source[~known]]
    if width == 1:
        return source
    reach, parent_reach = width // 2, parent_width // 2
    around = [o for o in itertools.product(range(-reach, reach + 1), repeat=2) if o != (0, 0)]
    parents = list(itertools.product(range(-parent_reach, parent_reach + 1), repeat=2))
    parents = parents if parent_width else []

    def windows(causal):
        """Vectors and places of all pixels whose windows are whole."""
        own = around[: len(around) // 2] if causal else around
        box = [
            (v, u)
            for v in range(-reach, 1 if causal else reach + 1)
            for u in range(-reach, reach + 1)
        ]
        vectors, places = [], []
        for y, x in np.ndindex(sample.shape[:2]):
            if not all(_usable(masks[level], y + v, x + u, tiles) for v, u in box):
                continue
            if not all(
                _usable(masks[level + 1], y // 2 + v, x // 2 + u, tiles) for v, u in parents
            ):
                continue
            vectors.append(
                [
                    samples[level + 1][_around(samples[level + 1], y // 2 + v, x // 2 + u)]
                    for v, u in parents
                ]
                + [sample[_around(sample, y + v, x + u)] for v, u in own]
            )
            places.append(y * sample.shape[1] + x)
        return np.array(vectors, np.uint8).reshape(len(places), -1), places, own

    size = 1 if method.search == "full" else method.tree_size
    done = known.copy() if holed else np.ones(shape, bool)

    def run(pixels, causal, leaves):
        vectors, places, own = windows(causal)
        tree = vector_tree(vectors, size)
        for y, x in pixels:
            query, counts = [], []
            cells = [(pictures[level + 1], None, y // 2 + v, x // 2 + u) for v, u in parents]
            cells += [(picture, done, y + v, x + u) for v, u in own]
            for values, made, v, u in cells:
                inside = all(
                    w or 0 <= at < length
                    for w, at, length in zip(wrap, (v, u), values.shape, strict=False)
                )
                v, u = _around(values, v, u)
                counts += [inside and (made is None or bool(made[v, u]))] * values.shape[2]
                query += list(values[v, u])
            done[y, x] = True
            if any(counts):
                found = nearest_in_tree(tree, vectors, np.array(query), np.array(counts), leaves)
                source[y, x] = places[found]
                picture[y, x] = flat[places[found]]

    every = list(np.ndindex(shape))
    if holed:
        inwards = _wei_levoy_inwards(known, wrap, seed)
        run(inwards, False, 8 * method.leaves)
        for _ in range(4 + method.passes):
            run(inwards, False, method.leaves)
        return source
    run(every, True, method.leaves)
    for _ in range(method.passes):
        run(every, False, method.leaves)

    def near(at, length):
        return at < reach or at >= length - reach

    border = [
        (y, x) for y, x in every
        if (canvas.wrap[0] and near(y, shape[0])) or (canvas.wrap[1] and near(x, shape[1]))
    ]  # fmt: skip
    for _ in range(2 if border else 0):
        run(border, False, method.leaves)
    return source


def _around(values, y, x):
    return y % values.shape[0], x % values.shape[1]


def _usable(mask, y, x, tiles):
    inside = 0 <= y < mask.shape[0] and 0 <= x < mask.shape[1]
    return (inside or tiles[0]) and bool(mask[_around(mask, y, x)])


def _wei_levoy_inwards(known, wrap, seed):
    """Unknown pixels, those next to known ones first; each layer by lines from a random corner."""
    known, order, number = known.copy(), [], 0
    height, width = known.shape
    while not known.all():
        number += 1
        layer = []
        for y, x in np.argwhere(~known).tolist():
            for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                inside = (wrap[0] or 0 <= v < height) and (wrap[1] or 0 <= u < width)
                if inside and known[v % height, u % width]:
                    layer.append((y, x))
                    break
        layer = layer or np.argwhere(~known).tolist()
        bits = int(draw(seed, "wei-levoy order", number))
        down, right = 1 - 2 * (bits & 1), 1 - (bits & 2)
        if bits & 4:  # by rows, else by columns
            layer.sort(key=lambda p: (down * p[0], right * p[1]))
        else:
            layer.sort(key=lambda p: (right * p[1], down * p[0]))
        order += [tuple(p) for p in layer]
        for p in layer:
            known[tuple(p)] = True
    return order


# Coherent candidates (Ashikhmin, 2001)


def path_around(cost, closed):
    """The cheapest path; a closed one starts where the cheapest twice around crosses."""
    if not closed:
        return path_by_programming(cost)
    start = path_by_programming(np.concatenate([cost, cost]))[len(cost)]
    held = np.concatenate([cost, cost[:1]])
    for row in (0, -1):
        held[row] = [cost[0][k] if k == start else 10**15 for k in range(cost.shape[1])]
    return path_by_programming(held)[:-1]


def guides(exemplar, canvas):
    """The canvas's guide and the sample's, (H, W, G) numbers to compare; None without one."""
    if canvas.guide is None:
        return None, None
    if exemplar.guide is None:
        levels = exemplar.as_matching(canvas.guide).astype(int)
        return levels, exemplar.matching()[..., : levels.shape[2]].astype(int)
    given, own = (p.reshape(*p.shape[:2], -1).astype(float) for p in (canvas.guide, exemplar.guide))
    labels = sorted({tuple(colour) for colour in own.reshape(-1, own.shape[2])})
    if len(labels) > 32:
        assert canvas.guide.dtype == np.uint8  # all that the tests compare
        return given.astype(int), own.astype(int)
    labels = labels[-1:] if len(labels) <= 2 else labels
    return tuple(
        255 * np.stack([(p == label).all(axis=2) for label in labels], axis=2).astype(int)
        for p in (given, own)
    )


def coherent_places(source, y, x, steps, exemplar, centres):
    """Where the sources of the neighbours go on, the last neighbour first; None out of place."""
    places = []
    for dy, dx in reversed(steps):
        v, u = source[(y + dy) % len(source)][(x + dx) % len(source[0])] or (None, None)
        if v is None:
            continue
        place = v - dy, u - dx
        if exemplar.tileable:
            place = place[0] % exemplar.shape[0], place[1] % exemplar.shape[1]
        place = place if place in centres else None
        if place not in places:
            places.append(place)
    return places


def ashikhmin(method, exemplar, canvas, seed):
    """Choose all pixels, `passes` times; (H, W, 2) sources, -1 for known pixels from elsewhere.

    `method` has the window's width settled.
    """
    pixels, (height, width) = exemplar.matching().astype(int), canvas.shape
    half = method.window_width // 2
    reach = [half] * 4
    mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    centres = window_centres(mask, reach, exemplar.tileable)
    allowed = set(centres)
    levels = np.zeros((height, width, pixels.shape[2]), int)
    done = np.zeros(canvas.shape, bool)
    source = [[None] * width for _ in range(height)]
    guide, own_guide = guides(exemplar, canvas)
    weight = round(256 * method.guide_weight)
    jumps = method.jumps if method.jumps is not None else int(guide is not None)

    def random_place(*words):
        return centres[pick(random_bits(seed, *words), len(centres))]

    def lay(y, x, place):
        source[y][x], levels[y, x] = place, pixels[place]

    def around(y, x, v, u):
        """The pixel at (v, u) steps, around wrapped borders; None beyond others."""
        at = [y + v, x + u]
        for axis in (0, 1):
            if canvas.wrap[axis]:
                at[axis] %= canvas.shape[axis]
            elif not 0 <= at[axis] < canvas.shape[axis]:
                return None
        return tuple(at)

    lines = [[(y, x) for x in range(width)] for y in range(height)]
    holes = canvas.hole is not None and not canvas.hole.all()
    if holes:
        done = ~canvas.hole
        levels[done] = exemplar.as_matching(canvas.known)[done]
        for y, x in np.argwhere(done).tolist():
            if canvas.known_from is not None:
                source[y][x] = (y + canvas.known_from[0], x + canvas.known_from[1])
        lines, left = [], {(y, x) for y, x in np.argwhere(canvas.hole).tolist()}
        while left:
            beside = [
                (y, x)
                for y, x in sorted(left)
                if any(
                    around(y, x, *step) not in left | {None}
                    for step in ((-1, 0), (1, 0), (0, -1), (0, 1))
                )
            ]
            lines.append(beside)
            left -= set(beside)
    elif half:
        for y, x in itertools.product(range(max(0, height - half), height), range(width)):
            lay(y, x, random_place("ashikhmin start", y * width + x))

    def choose(line, seen, start, number):
        for y, x in line:
            wrap = (canvas.wrap[0] or start, canvas.wrap[1])
            steps = known_window(seen, y, x, wrap, reach)
            found = coherent_places(source, y, x, steps, exemplar, allowed)
            if number > 0:
                found = [source[y][x]] + [place for place in found if place != source[y][x]]
            tries = max(jumps, 8) if None in found or not found else jumps
            found = [place for place in found if place is not None] + [
                random_place("ashikhmin", number, y * width + x, k) for k in range(tries)
            ]

            def distance(place, y=y, x=x, steps=steps, wrap=wrap):
                total = 0
                for dy, dx in steps:
                    made = levels[(y + dy) % height, (x + dx) % width]
                    v, u = (place[0] + dy) % len(pixels), (place[1] + dx) % pixels.shape[1]
                    total += 256 * ((pixels[v, u] - made) ** 2).sum()
                if guide is not None:
                    for dy, dx in itertools.product(range(-half, half + 1), repeat=2):
                        at = [y + dy, x + dx]
                        if any(not wrap[k] and not 0 <= at[k] < canvas.shape[k] for k in (0, 1)):
                            continue
                        at = (at[0] % height, at[1] % width)
                        if number > 0 or not seen[at] or (dy, dx) == (0, 0):
                            v, u = (place[0] + dy) % len(pixels), (place[1] + dx) % pixels.shape[1]
                            total += weight * ((own_guide[v, u] - guide[at]) ** 2).sum()
                return int(total)

            lay(y, x, min(found, key=distance))
            done[y, x] = seen[y, x] = True

    for number, (i, line) in itertools.product(range(method.passes), enumerate(lines)):
        # In the first pass the first rows see random pixels above them, around the border.
        start = not holes and number == 0 and i < half
        seen = done.copy()
        if start:
            seen[max(i + 1, height - half) :] = True
        choose(line, seen, start, number)
        band = min(32, height // 4)
        if number == 0 and i == len(lines) - 1 and band > 1 and canvas.wrap[0] and not holes:
            # The first rows once more, below the last; cut where both differ least.
            old = [row[:] for row in source[:band]]
            seen = done.copy()
            seen[: band + half] = False
            for again in lines[:band]:
                choose(again, seen, True, -1)
            apart = np.array(
                [
                    [((pixels[old[y][x]] - pixels[source[y][x]]) ** 2).sum() for y in range(band)]
                    for x in range(width)
                ]
            )
            cut = path_around(apart[:, :-1] + apart[:, 1:], canvas.wrap[1])
            for y, x in itertools.product(range(band), range(width)):
                if y > cut[x]:
                    lay(y, x, old[y][x])
    return np.array(
        [
            [(-1, -1) if source[y][x] is None else source[y][x] for x in range(width)]
            for y in range(height)
        ]
    )


# Exact neighborhood matching (Sabha, Peers and Dutré, 2007)

#: The direct neighbours of figure 2, and the next pixel for the end of a row that goes around.
DIRECT = [(0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)]
#: Those and the ones below, between known pixels.
ALL_AROUND = [*DIRECT, (1, 1), (1, 0), (1, -1)]


class ExactSample:
    """One level of a sample: its windows, and for each neighbour's colour the groups of places."""

    def __init__(self, pixels, mask, tiles, method, causal, guide=None):
        self.pixels, self.tiles, self.causal, self.guide = pixels.astype(int), tiles, causal, guide
        self.shape = pixels.shape[:2]
        half = (min(method.window_width, *self.shape) - 1) // 2
        self.half = half = half if causal else min(half, 7)
        self.guide_half = min(half, 4) if guide is not None else 0
        self.reach = (half, self.guide_half if causal else half, half, half)
        self.centres = window_centres(mask, self.reach, tiles)
        self.whole = set(self.centres)
        self.counted = sorted(
            {
                self._color(v + dy, u + dx)
                for v, u in self._listed()
                for dy, dx in [*ALL_AROUND, (0, 0)]
                if self._color(v + dy, u + dx)
            }
        )
        low, high = (f(np.array(self.counted), axis=0) for f in (np.min, np.max))
        self.radius = (
            int(method.tolerance * method.tolerance * ((high - low) ** 2).sum())
            if (method.tolerance is not None)
            else None
        )
        self.nearest = method.nearest_colors
        self.groups = self._groups(method.grouping)

    def _color(self, v, u):
        """The colour there; a sample that tiles goes on as far as a window may."""
        up, down, left, right = self.reach if self.tiles else (0, 0, 0, 0)
        height, width = self.shape
        if not (-up <= v < height + down and -left <= u < width + right):
            return None
        return tuple(self.pixels[v % height, u % width].tolist())

    def _listed(self):
        """Centres with room: another one half a window below, unless there is none such."""
        if not self.causal or self.tiles:
            return self.centres
        return [(v, u) for v, u in self.centres if (v + self.half, u) in self.whole] or self.centres

    def _groups(self, grouping):
        steps = [
            (dy, dx)
            for dy in range(-self.half, self.half + 1)
            for dx in range(-self.half, self.half + 1)
            if (dy, dx) < (0, 0) or (not self.causal and (dy, dx) > (0, 0))
        ]
        size = len(steps) * self.pixels.shape[2]
        limit = int(grouping * grouping * 255 * 255 * size)
        window = {p: np.array([self.at(p, step) for step in steps]).ravel() for p in self._listed()}
        result = {}
        for d, (dy, dx) in enumerate(DIRECT if self.causal else ALL_AROUND):
            lists = {}
            for v, u in window:
                if self._color(v + dy, u + dx):
                    lists.setdefault(self._color(v + dy, u + dx), []).append((v, u))
            for color, places in lists.items():
                groups = []
                for place in sorted(places, key=lambda p: (int(window[p].sum()), p)):
                    for group in reversed(groups) if steps else ():
                        if ((window[group[0]] - window[place]) ** 2).sum() <= limit:
                            group.append(place)
                            break
                    else:
                        groups.append([place])
                result[d, color] = groups
        return result

    def at(self, place, step):
        """The bytes of a window's pixel."""
        return self.pixels[
            (place[0] + step[0]) % self.shape[0], (place[1] + step[1]) % self.shape[1]
        ]

    def flat(self, place):
        """A place's number among the pixels with their padding."""
        up, _, left, right = self.reach if self.tiles else (0, 0, 0, 0)
        return (place[0] + up) * (self.shape[1] + left + right) + place[1] + left

    def settle(self, place):
        """A place in the sample that a whole window is centred on, or None."""
        if self.tiles:
            place = place[0] % self.shape[0], place[1] % self.shape[1]
        return place if place in self.whole else None

    def near(self, color):
        """The counted colours within the tolerance of the counted colour nearest to this one."""

        def squared(a, b):
            return sum((i - j) ** 2 for i, j in zip(a, b, strict=True))

        color = min(self.counted, key=lambda c: (squared(c, color), c))
        distances = [squared(c, color) for c in self.counted]
        radius = self.radius
        if self.nearest is not None:
            radius = sorted(distances)[min(self.nearest, len(distances)) - 1]
        return [c for c, d in zip(self.counted, distances, strict=True) if d <= radius]


class ExactSheet:
    """A picture in the making: a place of the sample for each pixel, or None."""

    def __init__(self, shape, channels, wrap):
        self.shape, self.wrap = shape, wrap
        self.levels = np.zeros((*shape, channels), int)
        self.done = np.zeros(shape, bool)
        self.source = [[None] * shape[1] for _ in range(shape[0])]

    def put(self, y, x, place, sample):
        self.source[y][x], self.done[y, x] = place, True
        self.levels[y, x] = sample.pixels[place]

    def window(self, y, x, sample):
        """Steps to what is compared."""
        width, half = self.shape[1], sample.half
        if not sample.causal:
            return known_window(self.done, y, x, self.wrap, sample.reach)
        steps = []
        for dy in range(-min(half, y), 0):
            across = range(-half, half + 1)
            if self.wrap[1] and 2 * half + 1 > width:
                across = range(-((width - 1) // 2), width - (width - 1) // 2)
            steps += [(dy, dx) for dx in across if self.wrap[1] or 0 <= x + dx < width]
        before = min(half, x)
        steps += [(0, dx) for dx in range(-before, 0)]
        if self.wrap[1]:  # the beginning of the row, as far as it was not seen to the left
            steps += [(0, v + width - x) for v in range(x - before) if v + width - x <= half]
        return steps


def exact_pixels(sheet, sample, order, seed, stage, method, guide=None):
    """Choose the pixels of `order`, one after the other (section 4.2)."""
    height, width = sheet.shape
    last = {}
    for y, x in np.ndindex(sheet.shape):
        if sheet.source[y][x]:
            last[sheet.source[y][x]] = (y, x)

    def repeats(place, y, x, apart):
        v, u = last.get(place, (y, x))
        return (v, u) != (y, x) and abs(v - y) < apart and abs(u - x) < apart

    def neighbors(y, x):
        for d, (dy, dx) in enumerate(DIRECT if sample.causal else ALL_AROUND):
            v = (y + dy) % height if sheet.wrap[0] else y + dy
            u = (x + dx) % width if sheet.wrap[1] else x + dx
            if 0 <= v < height and 0 <= u < width and sheet.done[v, u]:
                source = sheet.source[v][u]
                goes_on = source and sample.settle((source[0] - dy, source[1] - dx))
                yield d, tuple(sheet.levels[v, u].tolist()), goes_on

    def choose(y, x, bits, apart):
        steps = sheet.window(y, x, sample)
        wide = []
        if guide is not None:
            half = (sample.guide_half,) * 4
            wide = known_window(np.ones(sheet.shape, bool), y, x, sheet.wrap, half)

        def distance(place):
            total = 0
            for dy, dx in steps:
                seen = sheet.levels[(y + dy) % height, (x + dx) % width]
                total += int(((seen - sample.at(place, (dy, dx))) ** 2).sum())
            for dy, dx in wide:
                seen = guide[0][(y + dy) % height, (x + dx) % width]
                v, u = (place[0] + dy) % sample.shape[0], (place[1] + dx) % sample.shape[1]
                total += int(((seen.astype(int) - sample.guide[v, u]) ** 2).sum())
            return total

        beside = list(neighbors(y, x))
        first = [goes_on for _, _, goes_on in beside]
        if guide is not None:
            first.append(guide[1][y][x] and sample.settle(guide[1][y][x]))
        first = list(dict.fromkeys(place for place in first if place))
        best, chosen = None, None
        for place in first:
            if not repeats(place, y, x, apart) and (best is None or distance(place) < best):
                best, chosen = distance(place), place
        if best == 0:
            return chosen
        lists = [
            [g for c in sample.near(color) for g in sample.groups.get((d, c), [])]
            for d, color, _ in beside
        ]
        listed = sum(len(groups) for groups in lists)
        share = 2**32 * min(method.candidates, listed) // max(listed, 1)
        tested, found = set(first), []
        for groups in lists:
            for group in groups:
                key = (sample.flat(group[0]) ^ bits) % 2**32 * 2654435761 % 2**32
                if group[0] not in tested and key < share:
                    member = group[pick(bits, len(group))]
                    if not repeats(member, y, x, apart):
                        found.append((distance(group[0]), key, member))
            tested.update(group[0] for group in groups)
        if found and (best is None or min(found)[0] < best):
            return min(found)[2]
        return chosen

    for y, x in order:
        bits = random_bits(seed, stage, y * width + x)
        place = None
        if method.copying == "blocks" and sample.causal:
            inside = y > 0 and 0 < x < width - 1
            if inside:
                four = {goes_on for _, _, goes_on in list(neighbors(y, x))[:4]}
                place = four.pop() if len(four) == 1 else None
        place = place or choose(y, x, bits, method.repeat_distance) or choose(y, x, bits, 0)
        place = place or sample.centres[pick(bits, len(sample.centres))]
        sheet.put(y, x, place, sample)
        last[place] = (y, x)


def ridge_coordinates(known, basis, values, mean, ridge):
    """Coordinates z that minimise the sum of w (x - mean - basis z)**2 and of ridge z**2."""
    gram = (basis * known[:, None]).T @ basis + np.diag(ridge)
    return np.linalg.solve(gram, (basis * known[:, None]).T @ (values - mean))


def near_leaves(query, leaves, weight, visited, wanted):
    """The windows nearest in coordinates: of the `visited` leaves with the nearest means.

    `leaves` has for each (places, coordinates (n, D)); query and coordinates are bytes.
    """

    def distance(coordinates):
        difference = [int(a) - int(b) for a, b in zip(coordinates, query, strict=True)]
        return min(sum(d * d * weight >> 16 for d in difference), 40000)

    middles = [coordinates.sum(axis=0, dtype=int) // len(places) for places, coordinates in leaves]
    order = sorted(range(len(leaves)), key=lambda n: (distance(middles[n]), n))[:visited]
    windows = [(distance(c), p) for n in order for p, c in zip(*leaves[n], strict=True)]
    return [place for _, place in sorted(windows)[:wanted]]


def exact_matching(method, exemplar, canvas, seed):
    """Make all of a canvas; (H, W, 2) sources, -1 for known pixels from elsewhere.

    `method` is the settled one.
    """
    tiles = exemplar.tileable
    masks = [np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask]
    samples, shapes = [exemplar.matching()], [canvas.shape]
    for _ in range(method.levels - 1):
        samples.append(coarser(samples[-1], (tiles, tiles)))
        masks.append(coarser_mask(masks[-1], (tiles, tiles)))
        shapes.append(tuple((n + 1) // 2 for n in shapes[-1]))

    def prepared(level, causal, turned=False):
        guide = None
        if turned:
            return ExactSample(samples[level].swapaxes(0, 1), masks[level].T, tiles, method, causal)
        if level + 1 < len(samples):
            y, x = np.indices(samples[level].shape[:2]) // 2
            guide = samples[level + 1][y, x].astype(int)
        return ExactSample(samples[level], masks[level], tiles, method, causal, guide)

    if canvas.hole is not None and not canvas.hole.all():
        sample = prepared(0, False)
        sheet = ExactSheet(canvas.shape, samples[0].shape[2], canvas.wrap)
        known = exemplar.as_matching(canvas.known)
        for y, x in np.argwhere(~canvas.hole).tolist():
            sheet.levels[y, x], sheet.done[y, x] = known[y, x], True
            if canvas.known_from:
                sheet.source[y][x] = (y + canvas.known_from[0], x + canvas.known_from[1])
        exact_between(sheet, sample, seed, "exact hole", method)
        return _exact_sources(sheet.source, 0)

    coarse = None
    for level in reversed(range(len(samples))):
        sample = prepared(level, True)
        height, width = shapes[level]
        half, guide = sample.half, None
        band = [[None] * width for _ in range(half)]
        top = half
        if coarse is not None:
            above, above_top = coarse
            places = [[None] * width for _ in range(half + height)]
            colors = np.zeros((half + height, width, samples[0].shape[2]), int)
            for y, x in np.ndindex(half + height, width):
                v = max((y - half) // 2 + above_top, 0)
                sy, sx = above.source[v][x // 2]
                child = 2 * sy + (y - half) % 2, 2 * sx + x % 2
                inside = child[0] < sample.shape[0] and child[1] < sample.shape[1]
                places[y][x] = child if inside else None
                colors[y, x] = above.levels[v, x // 2]
                if y < half:
                    band[y][x] = tuple(
                        min(c, n - 1) for c, n in zip(child, sample.shape, strict=True)
                    )
            guide = colors, places
        elif method.init == "structured":
            band = exact_band(prepared(level, True, turned=True), width, seed, method)
        else:
            for y, x in np.ndindex(half, width):
                bits = int(random_bits(seed, "exact band", y, x))
                band[y][x] = sample.centres[bits % len(sample.centres)]
            top = 2 * half
        sheet = ExactSheet((top + height, width), samples[0].shape[2], (False, canvas.wrap[1]))
        for y, x in np.ndindex(half, width):
            sheet.put(y, x, band[y][x], sample)
        order = [(y, x) for y in range(half, top + height) for x in range(width)]
        exact_pixels(sheet, sample, order, seed, f"exact {level}", method, guide)
        if canvas.wrap[0] and height > 1:
            whole = ExactSheet((height, width), samples[0].shape[2], canvas.wrap)
            sample = prepared(level, False)
            for y in range(height - min(2 * sample.half + 1, height // 2)):
                for x in range(width):
                    whole.put(y, x, sheet.source[top + y][x], sample)
            if guide is not None:
                guide = guide[0][half:], guide[1][half:]
            exact_between(whole, sample, seed, f"exact seam {level}", method, guide)
            sheet.source[top:], sheet.levels[top:] = whole.source, whole.levels
        coarse = sheet, top
    return _exact_sources(sheet.source, top)


def exact_band(sample, width, seed, method):
    """The structured band of section 4.3, from a sample whose axes are exchanged."""
    half = sample.half
    sheet = ExactSheet((width, half), sample.pixels.shape[2], (False, False))
    centre = sample.centres[int(random_bits(seed, "exact block", 0)) % len(sample.centres)]
    block = min(half, width)
    for y, x in np.ndindex(block, half):
        v, u = (centre[0] - half + y) % sample.shape[0], (centre[1] - half + x) % sample.shape[1]
        sheet.put(y, x, (v, u), sample)
    order = [(y, x) for y in range(block, width) for x in range(half)]
    exact_pixels(sheet, sample, order, seed, "exact structure", method)
    return [[sheet.source[x][y][::-1] for x in range(width)] for y in range(half)]


def exact_between(sheet, sample, seed, stage, method, guide=None):
    """Layers from what is known inwards, in random order; then passes over them line by line."""
    height, width = sheet.shape
    unknown = [(y, x) for y, x in np.ndindex(sheet.shape) if not sheet.done[y, x]]
    left, order = list(unknown), []
    while left:
        layer = []
        for y, x in left:
            for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                v = v % height if sheet.wrap[0] else v
                u = u % width if sheet.wrap[1] else u
                beside = 0 <= v < height and 0 <= u < width and (v, u) not in left
                if beside and (y, x) not in layer:
                    layer.append((y, x))
        layer = layer or left
        left = [p for p in left if p not in layer]
        order += sorted(
            layer, key=lambda p: int(random_bits(seed, "exact layer", p[0] * width + p[1]))
        )
    exact_pixels(sheet, sample, order, seed, stage, method, guide)
    for number in range(method.passes):
        exact_pixels(sheet, sample, unknown, seed, f"exact pass {number}", method, guide)


def _exact_sources(source, top):
    return np.array([[place or (-1, -1) for place in row] for row in source[top:]])


# Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003) as a whole


class GraphCutTwin:
    """One output of the method "graphcut", pixel by pixel.

    `label` holds for each pixel of the canvas where in the sample it was copied from, None where
    nothing is, and "known" for a known pixel that is not in the sample.
    """

    def __init__(self, exemplar, method, canvas, seed):
        self.exemplar, self.method, self.canvas, self.seed = exemplar, method, canvas, seed
        self.pixels = exemplar.matching().astype(int)
        self.usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
        self.cells = list(np.ndindex(canvas.shape))
        self.label = dict.fromkeys(self.cells)
        self.known = {}
        if canvas.hole is not None and not canvas.hole.all():
            levels = exemplar.as_matching(canvas.known).astype(int)
            for cell in self.cells:
                if not canvas.hole[cell]:
                    self.known[cell] = levels[cell]
                    at = canvas.known_from
                    self.label[cell] = "known" if at is None else (cell[0] + at[0], cell[1] + at[1])
        self.laid = 0

    # The plane and the sample

    def step(self, cell, dy, dx):
        """The pixel beside this one on the canvas, or None."""
        y, x = cell[0] + dy, cell[1] + dx
        y, x = (
            k % n if wraps else k
            for k, n, wraps in zip((y, x), self.canvas.shape, self.canvas.wrap, strict=True)
        )
        inside = 0 <= y < self.canvas.height and 0 <= x < self.canvas.width
        return (y, x) if inside else None

    def goes_on(self, label, dy, dx):
        """What the patch has beside a pixel of this label, or None."""
        if label == "known":
            return None
        y, x = label[0] + dy, label[1] + dx
        if self.exemplar.tileable:
            y, x = y % self.exemplar.shape[0], x % self.exemplar.shape[1]
        inside = 0 <= y < self.exemplar.shape[0] and 0 <= x < self.exemplar.shape[1]
        return (y, x) if inside and self.usable[y, x] else None

    def value(self, cell, label):
        return self.known[cell] if label == "known" else self.pixels[label]

    def level(self, cell):
        """What is on the canvas."""
        return self.known[cell] if cell in self.known else self.pixels[self.label[cell]]

    # Section 3: seams

    def seam(self, p, q, step, of_p, of_q):
        """What it costs that p has one label and q = p + step another."""
        on_q, on_p = self.goes_on(of_p, *step), self.goes_on(of_q, -step[0], -step[1])
        if on_q is not None and on_q == of_q:
            return 0
        at_p, at_q = self.value(p, of_p), self.value(q, of_q)
        costs, steep = [], []
        if on_p is not None:  # what each of both has at p; then how steep q's patch is
            costs.append(np.abs(at_p - self.pixels[on_p]).sum())
            steep.append(np.abs(at_q - self.pixels[on_p]).sum())
        if on_q is not None:
            costs.append(np.abs(at_q - self.pixels[on_q]).sum())
            steep.append(np.abs(at_p - self.pixels[on_q]).sum())
        channels = self.pixels.shape[2]
        cost, slope = 510 * channels, 0
        if costs:
            cost, slope = (int(sum(part) * 2 // len(part)) for part in (costs, steep))
        return (
            256 * cost // (slope + 32 * channels) if self.method.seam_cost == "gradient" else cost
        )

    def cut(self, box, patch):
        """Which pixels a patch replaces, and what the seams cost then: SciPy's minimum cut.

        `box` lists the pixels of the canvas, `patch` for each of them that of the sample.
        """
        new = dict(zip(box, patch, strict=True))
        may = {}
        for cell in box:
            old = self.label[cell] is not None
            replaceable = self.usable[new[cell]] and not (old and cell in self.known)
            may[cell] = (0,) * old + (1,) * bool(replaceable)
        free = [cell for cell in box if len(may[cell]) == 2]
        number = {cell: i for i, cell in enumerate(free)}
        # cost = constant + sum of unary[i] * x_i + sum of arc[i, j] * x_i * (1 - x_j)
        constant, unary, arc = 0, [0] * len(free), {}
        for p in box:
            for step in ARCS:
                q = self.step(p, *step)
                if q is None or q == p or not may[p]:
                    continue
                inside = self.beside(box, p, step)
                if inside and step in ARCS[2:]:
                    continue  # seen from the other side
                if not inside and self.label[q] is None:
                    continue
                of_q = may[q] if inside else (0,)
                if not of_q:
                    continue
                table = {(i, j): self.pair(p, q, step, i, j, new) for i in may[p] for j in of_q}
                both = len(may[p]) == 2 and len(of_q) == 2
                if both:
                    table[1, 0] = max(table[1, 0], table[0, 0] - table[0, 1])
                    constant += table[0, 0]
                    unary[number[p]] += table[1, 0] - table[0, 0]
                    unary[number[q]] += table[1, 1] - table[1, 0]
                    key = number[q], number[p]
                    weight = table[0, 1] + table[1, 0] - table[0, 0] - table[1, 1]
                    arc[key] = arc.get(key, 0) + weight
                elif len(may[p]) == 2 or len(of_q) == 2:
                    chosen = p if len(may[p]) == 2 else q
                    low, high = (table[k] for k in sorted(table))
                    constant += low
                    unary[number[chosen]] += high - low
                elif (may[p], of_q) != ((0,), (0,)):
                    constant += table[may[p][0], of_q[0]]
        taken, value = least_labelling(unary, arc)
        side = [may[c] == (1,) or (len(may[c]) == 2 and taken[number[c]]) for c in box]
        return side, value + constant

    def beside(self, box, p, step):
        """Whether the neighbour belongs to the box beside it, not around the canvas."""
        at = box.index(p)
        row, column = divmod(at, self.columns)
        row, column = row + step[0], column + step[1]
        return 0 <= row < len(box) // self.columns and 0 <= column < self.columns

    def pair(self, p, q, step, p_new, q_new, new):
        if p_new and q_new:
            return 0
        of_p = new[p] if p_new else self.label[p]
        of_q = new[q] if q_new else self.label[q]
        if not p_new and not q_new and p in self.known and q in self.known:
            return 0
        return self.seam(p, q, step, of_p, of_q)

    # Section 4: placement

    def chances(self, costs, spread):
        """Whole numbers in proportion to exp(-cost / spread), of a dict of costs."""
        best = min(costs.values())
        result = {}
        for place, cost in costs.items():
            if spread > 0:
                power = 1 + min((cost - best) / spread, 64.0) / 1024
                for _ in range(10):
                    power = power * power
                result[place] = int(2.0**32 / power)
            else:
                result[place] = int(cost == best)
        return result

    def drawn(self, costs, size):
        """Candidates in the order drawn; near one that was drawn there is no other."""
        pixels = [self.pixels[at] for at in np.ndindex(self.exemplar.shape) if self.usable[at]]
        count, spread = len(pixels), 0
        for channel in np.transpose(pixels):
            spread += count * int((channel**2).sum()) - int(channel.sum()) ** 2
        chances = self.chances(costs, self.method.tolerance * (spread / count**2))
        found = []
        for k in range(self.method.candidates):
            total = sum(chances.values())
            if total == 0:
                break
            left = int(draw(self.seed, "patch", self.laid, k)) % total
            for place in sorted(chances):
                left -= chances[place]
                if left < 0:
                    break
            found.append(place)
            for y, x in chances:
                if all(abs(a - b) <= n // 16 for a, b, n in zip((y, x), place, size, strict=True)):
                    chances[y, x] = 0
        return found

    def patches(self, pixel, mend):
        """Candidates of sub-patch matching: (box, patch) of pixels."""
        side, boundary = self.method.patch_size, self.method.boundary_width
        size, corner = self.size(side, side), []
        for at, n, length, wraps in zip(
            pixel, size, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            start = at - (n // 2 if mend else min(boundary, (n - 1) // 2))
            corner.append(start if wraps else min(max(start, 0), length - n))
        box = self.rectangle(corner, size, self.canvas.shape)
        fits = {}
        for y, x in np.ndindex(self.exemplar.shape):
            if not self.exemplar.tileable and (
                y + size[0] > self.exemplar.shape[0] or x + size[1] > self.exemplar.shape[1]
            ):
                continue
            patch = self.rectangle((y, x), size, self.exemplar.shape)
            if all(self.usable[at] for at in patch):
                fits[y, x] = patch
        costs = dict.fromkeys(fits, 0.0)
        there = [i for i, cell in enumerate(box) if self.label[cell] is not None]
        if there:
            now = [self.level(box[i]) for i in there]
            for place, patch in fits.items():
                like = [self.pixels[patch[i]] for i in there]
                costs[place] = int(((np.array(now) - like) ** 2).sum()) / len(there)
        if there and self.method.variety > 0:
            costs = self.varied(costs, fits, corner, size)
            costs = self.not_continuing(costs, box, size) or costs
        return [(box, fits[place]) for place in self.drawn(costs, size)]

    def not_continuing(self, costs, box, size):
        """The places that are not next to one from which the box would just go on."""
        taken = set()
        for i, cell in enumerate(box):
            label = self.label[cell]
            if label is not None and label != "known":
                v, u = divmod(i, size[1])
                y, x = label[0] - v, label[1] - u
                if self.exemplar.tileable:
                    y, x = y % self.exemplar.shape[0], x % self.exemplar.shape[1]
                taken.add((y, x))
        near = [n // 16 for n in size]
        return {
            place: cost
            for place, cost in costs.items()
            if not any(
                abs(place[0] - y) <= near[0] and abs(place[1] - x) <= near[1] for y, x in taken
            )
        }

    def varied(self, costs, fits, corner, size):
        """Costs plus what of each place is shown within a patch of the box, every fourth pixel."""
        lines = []
        for start, n, length, wraps in zip(
            corner, size, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = range(start - n, start + 2 * n, 4)
            lines.append([k % length for k in line][:length] if wraps
                         else [k for k in line if 0 <= k < length])  # fmt: skip
        shown = {}
        for cell in itertools.product(*lines):
            shown[self.label[cell]] = shown.get(self.label[cell], 0) + 1
        seen = {place: sum(shown.get(at, 0) for at in patch) for place, patch in fits.items()}
        median = sorted(seen.values())[len(seen) // 2]
        good = min(costs[place] for place in fits if seen[place] <= median)
        once = size[0] * size[1] / 16
        return {
            place: cost + seen[place] * (self.method.variety * good / once)
            for place, cost in costs.items()
        }

    def samples(self, pixel, mend):
        """Candidates of random placement and entire patch matching: (box, patch) of pixels."""
        height, width = self.exemplar.shape
        size, wrap = self.size(height, width), self.canvas.wrap
        last = 3 if mend else 2
        rows = range(height // 4, height * last // 4 + 1)
        columns = range(width // 4, width * last // 4 + 1)
        usable = [at for at in np.ndindex(height, width) if self.usable[at]]
        some = [at for at in usable if at[0] in rows and at[1] in columns] or usable
        costs = dict.fromkeys(some, 0.0)
        if self.method.placement == "entire":
            found = {}
            for at in some:
                total = area = 0
                for v, u in usable:
                    y, x = pixel[0] - at[0] + v, pixel[1] - at[1] + u
                    cell = self.step((y, x), 0, 0)
                    if cell is not None and self.label[cell] is not None:
                        total += int(((self.level(cell) - self.pixels[v, u]) ** 2).sum())
                        area += 1
                found[at] = total / area if area else math.inf
            if any(cost < math.inf for cost in found.values()):
                costs = found
        result = []
        for at in self.drawn(costs, size):
            corner, lengths, source = [], [], []
            for p, s, n, most, length, wraps in zip(
                pixel, at, (height, width), size, self.canvas.shape, wrap, strict=True
            ):
                first, end = p - s, p - s + n
                if wraps:
                    first = max(first, p - most // 2)
                    end = min(end, first + most)
                else:
                    first, end = max(first, 0), min(end, length)
                corner.append(first)
                lengths.append(end - first)
                source.append(first - p + s)
            box = self.rectangle(corner, lengths, self.canvas.shape)
            result.append((box, self.rectangle(source, lengths, self.exemplar.shape), lengths))
        return result

    def size(self, height, width):
        """Of patches: around a wrapped axis they leave a third of the canvas."""
        return [
            min(n, max(1, 2 * length // 3) if wraps else length)
            for n, length, wraps in zip(
                (height, width), self.canvas.shape, self.canvas.wrap, strict=True
            )
        ]

    @staticmethod
    def rectangle(corner, size, shape):
        return [
            ((corner[0] + v) % shape[0], (corner[1] + u) % shape[1]) for v, u in np.ndindex(*size)
        ]

    # The whole

    def lay(self, pixel, mend):
        best = None
        kind = self.patches if self.method.placement == "subpatch" else self.samples
        for box, patch, *lengths in kind(pixel, mend):
            side = self.method.patch_size
            self.columns = (lengths[0] if lengths else self.size(side, side))[1]
            taken, cost = self.cut(box, patch)
            if best is None or cost < best[0]:
                best = cost, box, patch, taken
        for cell, at, new in zip(*best[1:], strict=True):
            if new:
                self.label[cell] = at
        self.laid += 1

    def seams(self):
        """What the seams to the right of and below each pixel cost."""
        result = np.zeros(self.canvas.shape, int)
        for p in self.cells:
            for step in ARCS[:2]:
                q = self.step(p, *step)
                if q is not None and q != p and not (p in self.known and q in self.known):
                    result[p] += self.seam(p, q, step, self.label[p], self.label[q])
        return result

    def worst(self, tried):
        """The middle of the square of cells with the worst seams; every try halves its cells."""
        cost = self.seams()
        shape = tried.shape
        total = np.array(
            [
                [cost[8 * i : 8 * i + 8, 8 * j : 8 * j + 8].sum() // 2 ** tried[i, j]
                 for j in range(shape[1])]
                for i in range(shape[0])
            ]
        )  # fmt: skip
        side = self.method.patch_size
        size = self.size(*((side, side) if side else self.exemplar.shape))
        spans = [min(max(1, n // 16), k) for n, k in zip(size, shape, strict=True)]
        best = None
        for corner in np.ndindex(shape):
            rows, columns = (
                [(c + k) % n for k in range(span)] if wraps or c + span <= n else None
                for c, span, n, wraps in zip(corner, spans, shape, self.canvas.wrap, strict=True)
            )
            if rows and columns:
                value = sum(total[i, j] for i in rows for j in columns)
                if best is None or value > best[0]:
                    best = value, corner, rows, columns
        if best[0] == 0:
            return None
        tried[np.ix_(best[2], best[3])] += 1
        return tuple(
            (8 * c + 8 * span // 2) % n if wraps else min(8 * c + 8 * span // 2, n - 1)
            for c, span, n, wraps in zip(
                best[1], spans, self.canvas.shape, self.canvas.wrap, strict=True
            )
        )

    def source(self):
        """Cover, mend; row and column of the source of each pixel that was not known."""
        for cell in self.cells:
            if self.label[cell] is None:
                self.lay(cell, mend=False)
        tried = np.zeros([-(-n // 8) for n in self.canvas.shape], int)
        for _ in range(round(self.method.refinements * self.laid)):
            worst = self.worst(tried)
            if worst is None:
                break
            self.lay(worst, mend=True)
        result = np.full((*self.canvas.shape, 2), -1)
        for cell in self.cells:
            if self.canvas.hole is None or self.canvas.hole[cell]:
                result[cell] = self.label[cell]
        return result


def least_labelling(unary, arc):
    """Labels 0 and 1 that minimise sum of unary[i] x_i + sum of arc[i, j] x_i (1 - x_j).

    Of all that do, the one with the fewest 1; from SciPy's maximum flow.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(unary)
    edges = [(count, i, -u) for i, u in enumerate(unary) if u < 0]
    edges += [(i, count + 1, u) for i, u in enumerate(unary) if u > 0]
    edges += [(i, j, weight) for (i, j), weight in arc.items() if weight]
    if not edges:
        return [False] * count, 0
    rows, columns, weights = zip(*edges, strict=True)
    shape = count + 2, count + 2
    graph = coo_array((np.array(weights, np.int32), (rows, columns)), shape).tocsr()
    flow = maximum_flow(graph, count, count + 1)
    residual = graph - flow.flow
    residual.eliminate_zeros()
    reached = set(breadth_first_order(residual, count, return_predecessors=False).tolist())
    value = flow.flow_value + sum(u for u in unary if u < 0)
    return [i in reached for i in range(count)], int(value)


# Iterative refinement (sections 3, 5 and 6 of the paper on texture refinement and fusion)


def grid_points(length, wraps, spacing):
    """Where seed points lie along an axis; on one that goes around they are spread evenly."""
    if not wraps:
        return list(range(0, length, spacing))
    count = max(1, round(length / spacing))
    return [i * length // count for i in range(count)]


def seed_points(pixels, mask, shape, wrap, spacing, matches, seed, guide=None):
    """Stochastic tiling with unit tiles (Fig. 5): {(y, x) of the output: (y, x) of the sample}.

    `guide` is that of the canvas, that of the sample, and its weight in 1/256.
    """
    usable = [tuple(at) for at in np.argwhere(mask).tolist()]
    top, left = min(y for y, _ in usable), min(x for _, x in usable)
    tiles = []
    for y, x in usable:
        corners = [(y + dy, x + dx) for dy in (0, spacing) for dx in (0, spacing)]
        if (y - top) % spacing == 0 and (x - left) % spacing == 0 and set(corners) <= set(usable):
            tiles.append(corners)
    rows, columns = (grid_points(*axis, spacing) for axis in zip(shape, wrap, strict=True))
    points = {}
    for i, j in np.ndindex(len(rows), len(columns)):
        bits = random_bits(seed, "seed point", i, j)
        if not tiles:
            points[i, j] = usable[bits % len(usable)]
            continue
        slot = [(i + di, j + dj) for di in (0, 1) for dj in (0, 1)]
        slot = [(v % len(rows) if wrap[0] else v, u) for v, u in slot]
        slot = [(v, u % len(columns) if wrap[1] else u) for v, u in slot]
        there = [k for k in range(4) if slot[k] in points]
        bound = [([*rows, shape[0] - 1][v], [*columns, shape[1] - 1][u]) for v, u in slot]
        unlike = [
            sum(((pixels[tile[k]].astype(int) - pixels[points[slot[k]]]) ** 2).sum() for k in there)
            for tile in tiles
        ]
        if guide is not None:
            shown, own, weight = guide
            for n, tile in enumerate(tiles):
                apart = sum(((shown[bound[k]] - own[tile[k]]) ** 2).sum() for k in range(4))
                unlike[n] = 256 * unlike[n] + weight * apart
        ranked = sorted(range(len(tiles)), key=lambda n: unlike[n])
        ranked = ranked[:matches] if there else [n for n in ranked if unlike[n] == min(unlike)]
        tile = tiles[ranked[bits % len(ranked)]]
        for k in range(4):
            points.setdefault(slot[k], tile[k])
    return {
        (rows[i], columns[j]): place
        for (i, j), place in points.items()
        if i < len(rows) and j < len(columns)
    }


def nearest_centre(centres, y, x):
    """The centre nearest to (y, x) along the nearest row that has any; the first of equals."""
    row = min(sorted({v for v, _ in centres}), key=lambda v: abs(v - y))
    return row, min(sorted(u for v, u in centres if v == row), key=lambda u: abs(u - x))


def window_at(pixels, y, x, reach):
    """The window around a pixel of a sample, around its borders where it tiles."""
    rows, columns = np.arange(y - reach, y + reach + 1), np.arange(x - reach, x + reach + 1)
    return pixels[np.ix_(rows % len(pixels), columns % pixels.shape[1])].astype(int)


def similar_places(pixels, centres, reach, count, candidates):
    """For each centre the places most like it; `candidates` says which are compared with it.

    Nothing within two pixels of it; of places so near to each other the best.
    """

    def near(one, other):
        return max(abs(one[0] - other[0]), abs(one[1] - other[1])) <= 2

    result = {}
    for centre in centres:
        here, found = window_at(pixels, *centre, reach), []
        for place in candidates(centre) if count else []:
            if near(place, centre):
                continue
            entry = int(((window_at(pixels, *place, reach) - here) ** 2).sum()), place
            rivals = [k for k, (_, other) in enumerate(found) if near(place, other)]
            if len(found) == count and entry[0] >= found[-1][0]:
                continue
            if rivals:
                if entry[0] >= found[rivals[0]][0]:
                    continue
                del found[rivals[0]]
            found = sorted([*found, entry], key=lambda e: e[0])[:count]
        result[centre] = [place for _, place in found]
    return result


class RefinedLevel:
    """A sample at one resolution, for `refinement`; places are of the sample on all levels."""

    def __init__(self, pixels, mask, tileable, number, reach, side, whole=False):
        self.pixels, self.mask, self.tileable = pixels, mask, tileable
        self.shape, self.number, self.reach, self.side = mask.shape, number, reach, side
        self.whole, self.similar, self.guide, self.windows = whole, {}, None, {}
        steps = list(itertools.product(range(-reach, reach + 1), repeat=2))
        self.centres = [
            (y, x)
            for y, x in np.ndindex(mask.shape)
            if all(at is not None and mask[at] for at in (self.at((y, x), *s) for s in steps))
        ]
        self.centre_set = set(self.centres)

    def at(self, place, dy, dx):
        """The pixel beside a place, 2**number pixels for a step; mirrored beyond a border."""
        result = []
        for first, step, length in zip(place, (dy, dx), self.shape, strict=True):
            first, start = divmod(first, 2**self.number)
            count = len(range(start, length, 2**self.number))
            step = first + step
            if self.whole and not self.tileable and not 0 <= step < count:
                return None
            step %= count if self.tileable else 2 * count
            step = min(step, 2 * count - 1 - step) if not self.tileable else step
            result.append(start + step * 2**self.number)
        return tuple(result)

    def around(self, place, steps):
        """Rows and columns of the pixels at some steps from a place, to index with."""
        if place not in self.windows:
            reach = range(-self.reach, self.reach + 1)
            self.windows[place] = {s: self.at(place, *s) for s in itertools.product(reach, reach)}
        window = self.windows[place]
        return tuple(np.array([window[s] for s in steps], int).reshape(-1, 2).T)

    def beside(self, place, dy, dx):
        """Where a source goes on, or None."""
        inside = self.tileable or all(
            0 <= k + d * 2**self.number < n
            for k, d, n in zip(place, (dy, dx), self.shape, strict=True)
        )
        place = self.at(place, dy, dx) if inside else None
        return place if place in self.centre_set else None

    def cell(self, place):
        """The square of the sample that a place lies in."""
        return tuple(k // self.side for k in place)


def registered_similar(pictures, masks, tileable, reach, count):
    """The places like each: exactly on the coarsest level, then around parents' similar places."""
    parents, parents_similar = None, None
    for pixels, mask in list(zip(pictures, masks, strict=True))[::-1]:
        centres = window_centres(mask, [reach] * 4, tileable)
        centre_set = set(centres)
        step = -(-(len(centres) ** 2) // 2**24)

        def candidates(centre, every=centres[::step], among=centre_set, older=parents,
                       older_similar=parents_similar):  # fmt: skip
            if older is None:
                return every
            y, x = centre
            around = [
                (2 * v + y % 2 + dy, 2 * u + x % 2 + dx)
                for v, u in older_similar[nearest_centre(older, y // 2, x // 2)]
                for dy in (-1, 0, 1)
                for dx in (-1, 0, 1)
            ]
            return [place for place in around if place in among]

        parents_similar = similar_places(pixels, centres, reach, count, candidates)
        parents = centres
    return {
        (y, x): parents_similar[nearest_centre(parents, y, x)]
        for y, x in np.ndindex(masks[0].shape)
    }


def turned_lines(unknown, turn, cyclic, to_and_fro):
    """Pixels line by line in the order of an iteration."""
    height, width = unknown.shape
    if cyclic and turn % 2:
        lines = [[(y, x) for y in range(height)] for x in range(width)]
    else:
        lines = [[(y, x) for x in range(width)] for y in range(height)]
    lines = [[at for at in line if unknown[at]] for line in lines]
    lines = [line for line in lines if line]
    backwards = turn % 4 > 1 if cyclic else turn % 2 and to_and_fro
    return [line[::-1] for line in lines[::-1]] if backwards else lines


def refinement(method, exemplar, canvas, seed, start=None, components=None):
    """Refine a canvas from coarse to fine; (H, W, 2) sources, -1 for known pixels.

    `method` is settled; `start` the sources of the other method's result; `components` those of
    the fast code, which its tests compare with their definition.
    """
    width, coherent = method.window_width, method.search == "coherent"
    reach = min(3, width // 2) if coherent else width // 2
    depth = 1
    while coherent and (2 * reach + 1) * 2 ** (depth - 1) < width:
        if min(exemplar.shape) // 2**depth < 24:
            break
        depth += 1
    tiles = (exemplar.tileable,) * 2
    masks = [np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask]
    pictures = [exemplar.matching()]
    for _ in range(depth - 1):
        mask = coarser_mask(masks[-1], tiles)
        if not window_centres(mask, [reach] * 4, exemplar.tileable):
            break  # the mask leaves nothing
        masks.append(mask)
        pictures.append(coarser(pictures[-1], tiles))
    levels = []
    for number in range(len(masks)):
        fine = coherent and not number and len(masks) > 1 and method.joints is None
        levels.append(
            RefinedLevel(
                stacked(pictures[0], number, tiles),
                stacked(masks[0], number, tiles, coarser_mask),
                exemplar.tileable, number, min(reach, 1) if fine else reach, max(1, width // 2),
                not coherent,
            )
        )  # fmt: skip
    if coherent:
        similar = registered_similar(pictures, masks, exemplar.tileable, reach, method.similar)
        for level in levels:
            level.similar = {
                place: [p for p in places if p in level.centre_set]
                for place, places in similar.items()
            }
    picture = np.zeros((*canvas.shape, exemplar.matching().shape[2]), np.uint8)
    hole = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    picture[~hole] = exemplar.as_matching(canvas.known)[~hole] if not hole.all() else 0
    kept = np.zeros(canvas.shape, bool)
    if method.joints is not None:
        for y, x in np.argwhere(hole):
            picture[y, x] = exemplar.matching()[tuple(start[y, x])]
        kept = hole & ~seam_belts(start, method.joints // 2, canvas.wrap, exemplar)
        hole = hole & ~kept
        levels = levels[:1]
    stack = [(picture, ~hole)]
    for _ in levels[1:]:
        stack.append((coarser(stack[-1][0], canvas.wrap), coarser_mask(stack[-1][1], canvas.wrap)))
    guide = guides(exemplar, canvas)
    if guide[0] is not None:
        weight = max(1, round(256 * method.guide_weight * picture.shape[2] / guide[0].shape[2]))
        shown, own = (np.asarray(g, np.uint8) for g in guide)
        for level in levels:
            level.guide = shown.astype(int), None, weight
            shown = coarser(shown, canvas.wrap)
        for level in levels:
            shown, _, weight = level.guide
            level.guide = shown, stacked(own, level.number, tiles).astype(int), weight
    below = None
    for level, (picture, known) in list(zip(levels, stack, strict=True))[::-1]:
        coarsest = below is None
        step = 2**level.number
        source = [[None] * known.shape[1] for _ in range(known.shape[0])]
        seeds = coarsest and start is None
        if seeds:
            spacing = max(1, round(max(1, width // 2) / (step * method.seed_density)))
            plain = level.guide and (level.guide[0], level.guide[1][::step, ::step], weight)
            points = seed_points(
                level.pixels[::step, ::step], level.mask[::step, ::step], known.shape, canvas.wrap,
                spacing, method.matches, seed, plain,
            )  # fmt: skip
            for (y, x), (v, u) in points.items():
                source[y][x] = nearest_centre(level.centres, v * step, u * step)
        for y, x in np.ndindex(known.shape):
            if coarsest and not seeds:
                v, u = (int(k) for k in start[y * step, x * step])
                source[y][x] = None if v < 0 else (v, u)
            elif not coarsest and not known[y, x]:  # whose parents are not known either
                v, u = below[y // 2][x // 2]
                v, u = v + y % 2 * step, u + x % 2 * step
                if exemplar.tileable:
                    v, u = v % exemplar.shape[0], u % exemplar.shape[1]
                source[y][x] = v, u
            if known[y, x]:
                source[y][x] = None
                if kept[y * step, x * step]:
                    source[y][x] = tuple(int(k) for k in start[y * step, x * step])
                elif canvas.known_from is not None:
                    v, u = y * step + canvas.known_from[0], x * step + canvas.known_from[1]
                    source[y][x] = v, u
            if source[y][x] is not None and (not seeds or known[y, x]):
                source[y][x] = nearest_centre(level.centres, *source[y][x])
        done = np.array([[s is not None for s in row] for row in source]) | known
        for y, x in np.argwhere(done & ~known):
            picture[y, x] = level.pixels[source[y][x]]
        rounds = method.iterations * (2 if coherent else 1)
        rounds = rounds if coarsest else max(1, method.iterations // 2)
        cyclic = not hole.all()
        sweep = _coherent_sweep if coherent else _component_sweep
        usage = {}
        for y, x in np.argwhere(done & ~known):
            usage[level.cell(source[y][x])] = usage.get(level.cell(source[y][x]), 0) + 1
        above = len(levels) - 1 - levels.index(level)
        settled = bool(done.all()) and (
            above > 0 or not ((cyclic and method.joints is None) or level.guide)
        )
        for turn in range(rounds):
            before, there = picture.copy(), done.copy()
            for line in turned_lines(~known, turn, cyclic, coherent):
                sweep(
                    method, level, canvas, seed, picture, done, source, ~known, line, turn,
                    cyclic, usage, above, components, settled,
                )  # fmt: skip
            if turn >= (3 if cyclic else 1):
                ratios = []
                for at in zip(*np.nonzero(~known), strict=True):
                    old, new = before[at].astype(int), picture[at].astype(int)
                    away = math.sqrt(((new - old) ** 2).sum() / max((old**2).sum(), 1))
                    ratios.append(round(away * 2**20) if there[at] else 2**20)
                if sum(ratios) / 2**20 / len(ratios) < method.threshold:
                    break
        below = source
    result = np.full((*canvas.shape, 2), -1)
    result[kept] = start[kept] if kept.any() else -1
    for y, x in np.argwhere(hole):
        result[y, x] = below[y][x]
    return result


def seam_belts(source, reach, wrap, exemplar):
    """What lies less than `reach` pixels from one beside which another source goes on."""
    height, width = source.shape[:2]
    seams = []
    for y, x in np.ndindex(height, width):
        for axis in (0, 1):
            at = [y, x]
            at[axis] += 1
            if at[axis] >= source.shape[axis] and not wrap[axis]:
                continue
            at = at[0] % height, at[1] % width
            step = [int(source[at][k]) - int(source[y, x][k]) - (k == axis) for k in (0, 1)]
            if exemplar.tileable:
                step = [s % n for s, n in zip(step, exemplar.shape, strict=True)]
            if any(step):
                seams += [(y, x), at]
    belts = np.zeros((height, width), bool)
    for y, x in seams:
        for dy, dx in itertools.product(range(1 - reach, reach), repeat=2):
            v, u = y + dy, x + dx
            if (wrap[0] or 0 <= v < height) and (wrap[1] or 0 <= u < width):
                belts[v % height, u % width] = True
    return belts


def _steps_away(picture, y, x, steps):
    """The pixels of a canvas at some steps from one, around its borders."""
    dy, dx = np.array(steps, int).reshape(-1, 2).T
    return picture[(y + dy) % len(picture), (x + dx) % picture.shape[1]].astype(int)


def _known_distance(level, here, known, place):
    """Sum of squared differences over the known pixels of a window, which are `here`."""
    return int(((level.pixels[level.around(place, known)] - here) ** 2).sum())


def _settle(level, picture, done, source, y, x, place):
    source[y][x], done[y, x], picture[y, x] = place, True, level.pixels[place]


def _asked(level, unknown):
    """In 1/256, how often each centre is to be used, for what the guide shows there."""
    shown, own, _ = level.guide
    there, wanted = {}, {}
    for at in level.centres:
        kind = tuple(own[at] // 64)
        there[kind] = there.get(kind, 0) + 1
    for at in zip(*np.nonzero(unknown), strict=True):
        kind = tuple(shown[at] // 64)
        wanted[kind] = wanted.get(kind, 0) + 1
    kinds = {at: tuple(own[at] // 64) for at in level.centres}
    least = max(256 // 4**level.number, 1)
    return {at: max(least, 256 * wanted.get(k, 0) // there[k]) for at, k in kinds.items()}


def _coherent_sweep(
    method, level, canvas, seed, picture, done, source, unknown, line, turn, cyclic, usage, above,
    components, settled,
):  # fmt: skip
    weight = round(1024 * method.evenness / 2**above)
    wanted = int(unknown.sum())
    count = len(level.centres)
    room = {}
    asked = _asked(level, unknown) if level.guide else {}
    for place in level.centres:
        room[level.cell(place)] = room.get(level.cell(place), 0) + asked.get(place, 1)
    if level.guide:
        room = {cell: 2 * n // 256 for cell, n in room.items()}
    else:
        room = {
            cell: 2 * n * max(wanted, count // 4**level.number) // count for cell, n in room.items()
        }
    tried = []
    if not settled and turn == 0:
        count = max(2**23 // wanted, 64)
        first = line[0][0] * picture.shape[1] + line[0][1]
        tried = [
            level.centres[random_bits(seed, "tried place", first, k) % len(level.centres)]
            for k in range(count if count < len(level.centres) else 0)
        ] or level.centres
    for y, x in line:
        own = source[y][x]
        beside = known_window(done, y, x, canvas.wrap, [min(1, level.reach)] * 4)
        places = [own] if own in level.centre_set else []
        for dy, dx in reversed(beside):
            other = source[(y + dy) % len(source)][(x + dx) % len(source[0])]
            place = None if other is None else level.beside(other, -dy, -dx)
            places += [place] if place is not None and place not in places else []
        near = len(places)
        places += [other for p in places for other in level.similar[p]]
        known = known_window(done, y, x, canvas.wrap, [level.reach] * 4)
        here, best = _steps_away(picture, y, x, known), None
        for k, place in enumerate([*places, *tried]):
            cell = level.cell(place)
            capacity = max(1, room[cell])
            over = usage.get(cell, 0) - capacity
            factor = 256 + min(weight * over // capacity, 2**14) if over > 0 else 256
            if k >= near:
                factor = factor * round(256 * method.coherence) // 256
            cost = _known_distance(level, here, known, place) * factor
            if level.guide:
                shown, theirs, heavy = level.guide
                every = known_window(np.ones_like(done), y, x, canvas.wrap, [level.reach] * 4)
                every += [(0, 0)]
                away = theirs[level.around(place, every)] - _steps_away(shown, y, x, every)
                cost += heavy * int((away**2).sum())
            if best is None or cost < best[0]:
                best = cost, place
        if best is None:
            continue
        if own is not None:
            usage[level.cell(own)] = usage.get(level.cell(own), 0) - 1
        usage[level.cell(best[1])] = usage.get(level.cell(best[1]), 0) + 1
        _settle(level, picture, done, source, y, x, best[1])


def component_coordinates(window, known, components, reach):
    """Coordinates of a window, (width, width, K), of which the known steps count."""
    mean = components.mean.astype(int)
    channels, width = len(mean), 2 * reach + 1
    basis = components.basis.astype(int).reshape(width, -1, width, channels)
    result = []
    for d in range(basis.shape[1]):
        total = 0
        for dy, dx in known:
            row = basis[reach + dy, d, reach + dx]
            total += int((row * (window[reach + dy, reach + dx] - mean)).sum())
        scale = (width * width - 1) * channels * 256 // (len(known) * channels) if known else 0
        level = int((basis[:, d] * mean).sum())
        value = ((total * scale + 128) >> 8) + level - int(components.offset[d])
        value = (value + (2**components.shift >> 1)) >> components.shift
        result.append(min(max(value, -4095), 4095))
    return result


def _component_sweep(
    method, level, canvas, seed, picture, done, source, unknown, line, turn, cyclic, usage, above,
    components, settled,
):  # fmt: skip
    reach = level.reach
    wrap = (True, True) if turn and not cyclic else canvas.wrap
    size = max(2 * reach + 1, 3) ** 2
    every = [
        (dy, dx) for dy in range(-reach, reach + 1) for dx in range(-reach, reach + 1) if dy or dx
    ]
    if not hasattr(level, "features"):
        level.features = [
            component_coordinates(window_at(level.pixels, *at, reach), every, components, reach)
            for at in level.centres
        ]
    for y, x in line:
        known = known_window(done, y, x, wrap, [reach] * 4)
        places, channels = range(len(level.centres)), level.pixels.shape[2]
        if len(known) * channels >= size * channels // 8:
            here = window_at(picture, y, x, reach)
            query = component_coordinates(here, known, components, reach)
            unlike = ((np.array(level.features) - query) ** 2).sum(axis=1).tolist()
            places = sorted(places, key=lambda n: unlike[n])[: method.candidates]
        here = _steps_away(picture, y, x, known)
        best = min((_known_distance(level, here, known, level.centres[n]), n) for n in places)
        _settle(level, picture, done, source, y, x, level.centres[best[1]])


# Near-regular textures: correlation and lattice (chapter 3 of the paper on them)


def normalised_correlation(f, g=None, f_mask=None, g_mask=None):
    """Equations 3.2 and 3.10 shift by shift; [y + h - 1, x + w - 1] moves g by (x, y)."""
    f = np.asarray(f, np.float64)
    f = f.reshape(*f.shape[:2], -1)
    g, g_mask = (f, f_mask) if g is None else (np.asarray(g, np.float64), g_mask)
    g = g.reshape(*g.shape[:2], -1)
    (height, width), (h, w) = f.shape[:2], g.shape[:2]
    f_mask = np.ones((height, width), bool) if f_mask is None else f_mask
    g_mask = np.ones((h, w), bool) if g_mask is None else g_mask
    result = np.zeros((height + h - 1, width + w - 1))
    for y, x in itertools.product(range(1 - h, height), range(1 - w, width)):
        here = slice(max(0, y), min(height, y + h)), slice(max(0, x), min(width, x + w))
        there = tuple(slice(s.start - by, s.stop - by) for s, by in zip(here, (y, x), strict=True))
        both = f_mask[here] & g_mask[there]
        if both.sum() < 2:
            continue
        a, b = f[here][both], g[there][both]
        a, b = a - a.mean(axis=0), b - b.mean(axis=0)
        weights = np.sqrt((a**2).sum(axis=0) * (b**2).sum(axis=0))
        if weights.sum() > 1e-9:
            result[y + h - 1, x + w - 1] = (a * b).sum() / weights.sum()
    return result


def share_of_tile(vectors, width, height):
    """Section 3.3.1: different wrapped positions of a rectangle, by the number a tile has."""
    (ux, uy), (vx, vy) = vectors
    area = abs(ux * vy - vx * uy)
    wrapped = set()
    for y, x in itertools.product(range(height), range(width)):
        # Equations 3.28 and 3.29 in whole numbers: coordinates in the tile times its area.
        a, b = (x * vy - y * vx) % area, (y * ux - x * uy) % area
        wrapped.add((a, b))
    return len(wrapped) / area


def goodness_of_vectors(correlation, vectors):
    """Equation 3.22 for whole vectors, over all significant multiples of the right half."""
    (ux, uy), (vx, vy) = vectors
    height, width = (side // 2 + 1 for side in correlation.shape)
    total, number = 0.0, 0
    for a, b in itertools.product(range(-width - height, width + height + 1), repeat=2):
        x, y = a * ux + b * vx, a * uy + b * vy
        if abs(x) >= width or abs(y) >= height or (b, a) <= (0, 0):
            continue
        if share_of_tile(vectors, width - abs(x), height - abs(y)) >= 0.85:
            total += correlation[y + height - 1, x + width - 1]
            number += 1
    return max(total, 0.0) ** 1.12 / max(number, 1), number


# Near-regular synthesis (chapter 4 of the thesis on constrained random sampling and gap filling)


class NearRegularTwin:
    """Blocks of the endless plane, each found on its own by asking for those that it hangs on.

    `pixels` are what is compared, `usable` the set of (y, x) where a window may have its corner.
    Blocks are numbered (i, j); random ones have an even sum, gaps an odd one.
    """

    def __init__(self, pixels, usable, method, seed):
        self.pixels = pixels.astype(int).tolist()
        self.channels = range(pixels.shape[2])
        self.usable, self.method, self.seed = set(usable), method, seed
        self.size, self.m = method.block_size, method.border_width // 2
        x1, y1, x2, y2 = method.lattice
        self.vectors = ((y1, x1), (y2, x2))
        det = y1 * x2 - x1 * y2
        self.inverse = ((x2 / det, -x1 / det), (-y2 / det, y1 / det))
        self.free = abs(x1 * y2 - x2 * y1) < 4
        height, width = pixels.shape[:2]
        self.steps = self.all_steps(height, width)
        self.places = {}
        self.visibility = [[self.shows(y, x) for x in range(width)] for y in range(height)]

    def shows(self, y, x):
        """How much a seam shows at a pixel of the sample."""
        if self.method.seam_cost != "gradient":
            return 1
        last = len(self.pixels) - 1, len(self.pixels[0]) - 1
        above, below = self.pixels[max(y - 1, 0)][x], self.pixels[min(y + 1, last[0])][x]
        left, right = self.pixels[y][max(x - 1, 0)], self.pixels[y][min(x + 1, last[1])]
        soft = 40 * len(self.channels)
        steep = sum((below[k] - above[k]) ** 2 + (right[k] - left[k]) ** 2 for k in self.channels)
        return max(1, 4096 * soft // (soft + steep))

    def all_steps(self, height, width):
        """Multiples in 1/65536 pixel, sorted by random bits."""
        (y1, x1), (y2, x2) = self.vectors
        spans = []
        for k in (0, 1):
            corners = [
                y * self.inverse[0][k] + x * self.inverse[1][k]
                for y in (0, height)
                for x in (0, width)
            ]
            spans.append((math.floor(min(corners)) - 1, math.ceil(max(corners))))
        low_y, high_y = min(0, y1) + min(0, y2), max(0, y1) + max(0, y2)
        low_x, high_x = min(0, x1) + min(0, x2), max(0, x1) + max(0, x2)
        found = []
        for a in range(spans[0][0], spans[0][1] + 1):
            for b in range(spans[1][0], spans[1][1] + 1):
                y, x = a * y1 + b * y2, a * x1 + b * x2
                if y + high_y > -1 and y + low_y < height and x + high_x > -1 and x + low_x < width:
                    found.append((round(y * 65536), round(x * 65536)))
        order = sorted(range(len(found)), key=lambda n: int(draw(0, "steps", n)))
        return [found[n] for n in order]

    def similar(self, i, j):
        """Places a multiple of the vectors away, in the block's own order (section 4.2.1)."""
        y, x = i * self.size - self.m, j * self.size - self.m
        parts = [y * self.inverse[0][k] + x * self.inverse[1][k] for k in (0, 1)]
        parts = [p - math.floor(p) for p in parts]
        at = [
            round((parts[0] * self.vectors[0][k] + parts[1] * self.vectors[1][k]) * 65536)
            for k in (0, 1)
        ]
        start = int(draw(self.seed, "block", i, j)) % len(self.steps)
        found = []
        for dy, dx in self.steps[start:] + self.steps[:start]:
            place = (at[0] + dy + 32768) // 65536, (at[1] + dx + 32768) // 65536
            if place in self.usable:
                found.append(place)
        return found

    def shown_again(self, place, block, other):
        """Pixels of the sample that a block from `place` and another block both show."""
        theirs = self.place(*other)
        away = place[0] - theirs[0], place[1] - theirs[1]
        if away == ((block[0] - other[0]) * self.size, (block[1] - other[1]) * self.size):
            return 0
        return max(0, self.size - abs(away[0])) * max(0, self.size - abs(away[1]))

    def place(self, i, j):
        """Source of the window of block (i, j)."""
        if (i, j) not in self.places:
            self.places[i, j] = self.drawn(i, j) if (i + j) % 2 == 0 else self.fitting(i, j)
        return self.places[i, j]

    @staticmethod
    def colour(i, j):
        return (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2

    def comes_before(self, a, b, i, j):
        return self.colour(a, b) < self.colour(i, j)

    def drawn(self, i, j):
        near = [(-1, -1), (-1, 1), (1, -1), (1, 1), (-2, 0), (2, 0), (0, -2), (0, 2)]
        before = [(i + a, j + b) for a, b in near if self.comes_before(i + a, j + b, i, j)]
        best, least = None, math.inf
        for place in self.similar(i, j)[:256]:
            again = sum(self.shown_again(place, (i, j), other) for other in before)
            if again < least:
                best, least = place, again
            if 8 * least <= self.size**2:
                break
        return best

    def border(self, i, j):
        """The border around a gap (Fig. 4.9): (v, u) in its window and the colour there."""
        side, m = self.size + 2 * self.m, self.m
        found = {}
        for v in range(side):
            for u in range(side):
                away = [v, u, side - 1 - v, side - 1 - u]
                if min(away) < 2 * m:
                    a, b = [(-1, 0), (0, -1), (1, 0), (0, 1)][away.index(min(away))]
                    y, x = self.place(i + a, j + b)
                    found[v, u] = self.pixels[y + v - a * self.size][x + u - b * self.size]
        return found

    def mismatch(self, border, place):
        if self.method.match == "gncc":
            return int((1 - self.correlation(border, place)) * 2**40)
        return sum(
            (self.pixels[place[0] + v][place[1] + u][k] - colour[k]) ** 2
            for (v, u), colour in border.items()
            for k in self.channels
        )

    def correlation(self, border, place):
        """Equation (3.13) over the border."""
        above, below = 0, 0.0
        for k in self.channels:
            g = [colour[k] for colour in border.values()]
            f = [self.pixels[place[0] + v][place[1] + u][k] for v, u in border]
            n = len(f)
            above += n * sum(a * b for a, b in zip(f, g, strict=True)) - sum(f) * sum(g)
            below += math.sqrt(n * sum(a * a for a in f) - sum(f) ** 2) * math.sqrt(
                n * sum(b * b for b in g) - sum(g) ** 2
            )
        return above / below

    def fitting(self, i, j):
        """Section 4.2.2."""
        border = self.border(i, j)
        around = [(i - 1, j), (i, j - 1), (i + 1, j), (i, j + 1)]

        def key(place):
            factor = 256
            for other in around:
                again = self.shown_again(place, (i, j), other)
                factor += round(256 * self.method.variety) * again // self.size**2
            return factor * self.mismatch(border, place)

        similar = self.similar(i, j)
        best = sorted(similar if self.free else similar[:512], key=key)[: self.method.candidates]
        reach = range(-self.method.tolerance, self.method.tolerance + 1)
        near = {(y + dy, x + dx) for y, x in best for dy in reach for dx in reach} & self.usable
        return min(near, key=lambda place: (key(place), place))

    def difference(self, a, b, y, x):
        """Squared difference of what blocks a and b have at a pixel, by how much it shows there."""
        colours, shows = [], 0
        for i, j in (a, b):
            v, u = y - i * self.size + self.m, x - j * self.size + self.m
            colours.append(self.colour_of(i, j, v, u))
            top, left = self.place(i, j)
            shows += self.visibility[top + v][left + u]
        return shows * sum((colours[0][k] - colours[1][k]) ** 2 for k in self.channels)

    def colour_of(self, i, j, v, u):
        """What block (i, j) has at a pixel of its window."""
        y, x = self.place(i, j)
        return self.pixels[y + v][x + u]

    def corner(self, i, j):
        """Where the four blocks around the upper left corner of block (i, j) meet."""
        slack = min(self.m // 2, (self.size - 1) // 4)
        box = min(3, self.m - slack)
        pair = ((i - 1, j - 1), (i, j)) if (i + j) % 2 == 0 else ((i - 1, j), (i, j - 1))
        if slack == 0:
            return i * self.size, j * self.size

        def total(step):
            y, x = i * self.size + step[0], j * self.size + step[1]
            return sum(
                self.difference(*pair, v, u)
                for v in range(y - box, y + box)
                for u in range(x - box, x + box)
            )

        steps = [(a, b) for a in range(-slack, slack + 1) for b in range(-slack, slack + 1)]
        a, b = min(steps, key=lambda step: (total(step), step[0] ** 2 + step[1] ** 2))
        return i * self.size + a, j * self.size + b

    def edge(self, i, j, upright):
        """For each line between two corners where block (i, j) begins: {line: first pixel}."""
        first = self.corner(i, j)
        last = self.corner(i + 1, j) if upright else self.corner(i, j + 1)
        before = (i, j - 1) if upright else (i - 1, j)
        if not upright:
            first, last = first[::-1], last[::-1]
        middle = (j if upright else i) * self.size

        def error(line, at):
            return self.difference(before, (i, j), *((line, at) if upright else (at, line)))

        lines = range(first[0], last[0])
        cost = {first[1]: 0}
        came = []
        for line in lines[1:]:
            now, origin = {}, {}
            for at in range(middle - self.m + 1, middle + self.m):
                if abs(at - first[1]) > line - lines[0] or abs(at - last[1]) > lines[-1] - line:
                    continue
                own = error(line, at - 1) + error(line, at)
                own += self.beyond(before, (i, j), line, at, middle, upright)
                ways = {
                    start: value
                    + own
                    + sum(
                        error(line - 1, k) + error(line, k)
                        for k in range(min(start, at), max(start, at))
                    )
                    for start, value in cost.items()
                }
                origin[at] = min(ways, key=lambda start: ways[start])
                now[at] = ways[origin[at]]
            cost = now
            came.append(origin)
        at = last[1]
        path = {lines[-1]: at}
        for line, origin in zip(lines[-2::-1], came[::-1], strict=True):
            at = origin[at]
            path[line] = at
        return path

    def beyond(self, a, b, line, at, middle, upright):
        return 0

    def owners(self, top, left, height, width):
        """Which block each pixel of a window belongs to: an array of (i, j)."""
        owner = np.zeros((height, width, 2), int)
        for y in range(top, top + height):
            for x in range(left, left + width):
                near = [
                    (i, j)
                    for i in range((y - self.m) // self.size, (y + self.m) // self.size + 1)
                    for j in range((x - self.m) // self.size, (x + self.m) // self.size + 1)
                ]
                (found,) = [block for block in near if self.owns(*block, y, x)]
                owner[y - top, x - left] = found
        return owner

    def owns(self, i, j, y, x):
        """Inside all four edges; past an edge's ends its corner counts."""

        def bound(path, line):
            return path[min(max(line, min(path)), max(path))]

        edges = [
            self.cached_edge(*e)
            for e in ((i, j, True), (i, j + 1, True), (i, j, False), (i + 1, j, False))
        ]
        return bound(edges[0], y) <= x < bound(edges[1], y) and bound(edges[2], x) <= y < bound(
            edges[3], x
        )

    def cached_edge(self, i, j, upright):
        key = (i, j, upright)
        if key not in self.__dict__.setdefault("edges", {}):
            self.edges[key] = self.edge(i, j, upright)
        return self.edges[key]

    def source(self, top, left, height, width):
        """Place of each pixel of a window: (height, width, 2)."""
        result = self.owners(top, left, height, width)
        for v in range(height):
            for u in range(width):
                i, j = result[v, u].tolist()
                y, x = self.place(i, j)
                result[v, u] = (
                    y + top + v - i * self.size + self.m,
                    x + left + u - j * self.size + self.m,
                )
        return result


class WarpedTwin(NearRegularTwin):
    """Gaps whose pieces are warped: a grid of shifts in pixels, found along their four sides."""

    def __init__(self, pixels, usable, method, seed):
        super().__init__(pixels, usable, method, seed)
        self.last = min(max(self.size // 10, 1), 8)
        levels = pixels.astype(int)
        wide = np.pad(levels, ((4, 4), (4, 4), (0, 0)), mode="edge")
        around = sum(
            wide[v : v + pixels.shape[0], u : u + pixels.shape[1]]
            for v in range(9)
            for u in range(9)
        )
        self.relief = np.clip(128 + levels - around // 81, 0, 255).tolist()
        self.nodes, self.warped = {}, {}

    def node_place(self, k):
        return k * self.size // self.last

    def side_cost(self, i, j, n, k, shift):
        """Squared difference around node k of side n, the piece shifted."""
        a, b = [(-1, 0), (0, -1), (1, 0), (0, 1)][n]
        (y, x), (oy, ox) = self.place(i, j), self.place(i + a, j + b)
        half, side = min(8, self.m), self.size + 2 * self.m
        here = self.m + self.node_place(k)
        edge = self.m + (self.size if n > 1 else 0)
        total = 0
        for t in range(max(here - half, 0), min(here + half, side)):
            for s in range(edge - half, edge + half):
                v, u = (t, s) if n % 2 else (s, t)
                own = self.relief[y + min(max(v + shift[0], 0), side - 1)][
                    x + min(max(u + shift[1], 0), side - 1)
                ]
                other = self.relief[oy + v - a * self.size][ox + u - b * self.size]
                total += sum((own[c] - other[c]) ** 2 for c in self.channels)
        return total

    def side_shift(self, i, j, n, k):
        """In pixels, along both axes: the best whole one, and what a parabola adds."""
        reach = self.method.warp
        steps = range(-reach, reach + 1)
        cost = {(a, b): self.side_cost(i, j, n, k, (a, b)) for a in steps for b in steps}
        still = cost[0, 0]

        def key(s):
            length = s[0] ** 2 + s[1] ** 2
            return cost[s] + Fraction(still * length, 4 * reach**2), length, s

        best = min(cost, key=key)
        if 4 * cost[best] > 3 * still:
            best = 0, 0
        shift = []
        for t in (0, 1):
            part = Fraction(0)
            if abs(best[t]) < reach:
                low, high = (
                    cost[(best[0] + d, best[1]) if t == 0 else (best[0], best[1] + d)]
                    for d in (-1, 1)
                )
                bend = low + high - 2 * cost[best]
                if bend > 0 and (low - high) ** 2 >= still * bend:
                    part = Fraction(math.floor(Fraction(8 * (low - high), bend) + HALF), 16)
                    part = min(max(part, -HALF), HALF)
            shift.append(best[t] + part)
        return shift

    def warp(self, i, j):
        """Shifts in 1/16 pixel at all nodes: sides evened out, and blended after Coons."""
        if (i, j) in self.nodes:
            return self.nodes[i, j]
        last = self.last
        sides = []
        for n in range(4):
            raw = [self.side_shift(i, j, n, k) for k in range(last + 1)]
            sides.append(
                [
                    [
                        (raw[max(k - 1, 0)][t] + 2 * raw[k][t] + raw[min(k + 1, last)][t]) / 4
                        for t in (0, 1)
                    ]
                    for k in range(last + 1)
                ]
            )
        above, left, below, right = sides
        for p, a, q, b in (
            (above, 0, left, 0),
            (above, last, right, 0),
            (below, 0, left, last),
            (below, last, right, last),
        ):
            p[a] = q[b] = [(p[a][t] + q[b][t]) / 2 for t in (0, 1)]
        found = {}
        for a in range(last + 1):
            for b in range(last + 1):
                y, x = Fraction(a, last), Fraction(b, last)
                for t in (0, 1):
                    total = (1 - y) * above[b][t] + y * below[b][t]
                    total += (1 - x) * left[a][t] + x * right[a][t]
                    total -= (1 - y) * ((1 - x) * above[0][t] + x * above[last][t])
                    total -= y * ((1 - x) * below[0][t] + x * below[last][t])
                    whole = math.floor(16 * total + HALF)
                    most = 16 * self.method.warp
                    found[a, b, t] = min(max(whole, -most), most)
        self.nodes[i, j] = found
        return found

    def shifted(self, i, j, v, u):
        """Which place of its window, in 1/16 pixel, a gap shows at (v, u) of it."""
        nodes, side = self.warp(i, j), self.size + 2 * self.m
        at = [min(max(k - self.m, 0), self.size) for k in (v, u)]
        low, part = [], []
        for place in at:
            k = max(k for k in range(self.last) if self.node_place(k) <= place)
            low.append(k)
            length = self.node_place(k + 1) - self.node_place(k)
            part.append(Fraction(place - self.node_place(k), length))
        (a, b), (y, x) = low, part
        result = []
        for t, k in ((0, v), (1, u)):
            shift = (1 - y) * ((1 - x) * nodes[a, b, t] + x * nodes[a, b + 1, t])
            shift += y * ((1 - x) * nodes[a + 1, b, t] + x * nodes[a + 1, b + 1, t])
            result.append(min(max(16 * k + math.floor(shift + HALF), 0), 16 * (side - 1)))
        return result

    def colour_of(self, i, j, v, u):
        """Between pixels by the cubic of Catmull and Rom, and never past the nearest four."""
        if (i + j) % 2 == 0:
            return super().colour_of(i, j, v, u)
        if (i, j, v, u) not in self.warped:
            side = self.size + 2 * self.m
            ways = []
            for place in self.shifted(i, j, v, u):
                t = Fraction(place % 16, 16)
                cubic = (
                    (-(t**3) + 2 * t**2 - t) / 2,
                    (3 * t**3 - 5 * t**2 + 2) / 2,
                    (-3 * t**3 + 4 * t**2 + t) / 2,
                    (t**3 - t**2) / 2,
                )
                at = [min(max(place // 16 + k, 0), side - 1) for k in (-1, 0, 1, 2)]
                ways.append(list(zip(at, cubic, range(4), strict=True)))
            colour = []
            for c in self.channels:
                total, near = 0, []
                for y, p, m in ways[0]:
                    for x, q, n in ways[1]:
                        level = super().colour_of(i, j, y, x)[c]
                        total += p * q * level
                        if p * q and m in (1, 2) and n in (1, 2):
                            near.append(level)
                colour.append(min(max(math.floor(total + HALF), min(near)), max(near)))
            self.warped[i, j, v, u] = colour
        return self.warped[i, j, v, u]

    def image(self, top, left, height, width):
        owner = self.owners(top, left, height, width)
        result = np.zeros((height, width, len(self.channels)), np.uint8)
        for v in range(height):
            for u in range(width):
                i, j = owner[v, u].tolist()
                at = top + v - i * self.size + self.m, left + u - j * self.size + self.m
                result[v, u] = self.colour_of(i, j, *at)
        return result


class NearRegularHoleTwin(NearRegularTwin):
    """The blocks that fill a hole. Known pixels and the hole are in coordinates of the plane."""

    def __init__(self, pixels, usable, method, seed, canvas, origin):
        super().__init__(pixels, usable, method, seed)
        self.known_from, self.hole, self.known = canvas.known_from, set(), {}
        for y, x in np.ndindex(canvas.shape):
            here = y + origin[0], x + origin[1]
            if canvas.hole[y, x]:
                self.hole.add(here)
            else:
                self.known[here] = canvas.known[y, x].tolist()
        self.near, self.beside = self.around(2 * self.m), self.around(1)

    def around(self, reach):
        """Known pixels that are so near to the hole."""
        steps = range(-reach, reach + 1)
        grown = {(y + a, x + b) for y, x in self.hole for a in steps for b in steps}
        return grown & set(self.known)

    def sees(self, i, j, where):
        """Whether some of these pixels are in the block's window."""
        rows, columns = (
            range(k * self.size - self.m, (k + 1) * self.size + self.m) for k in (i, j)
        )
        return any((y, x) in where for y in rows for x in columns)

    def similar(self, i, j):
        if not self.free:
            return super().similar(i, j)
        found = sorted(self.usable)
        start = int(draw(self.seed, "block", i, j)) % len(found)
        return found[start:] + found[:start]

    def place(self, i, j):
        if (i, j) in self.places:
            return self.places[i, j]
        if self.sees(i, j, self.hole):
            random = (i + j) % 2 == 0 and not self.sees(i, j, self.near)
            found = self.drawn(i, j) if random else self.fitting(i, j)
        else:
            found = i * self.size - self.m, j * self.size - self.m
            steps = (-1, 0, 1)
            beside = any(self.sees(i + a, j + b, self.hole) for a in steps for b in steps)
            if self.known_from is None or not beside or found not in self.usable:
                found = None
        self.places[i, j] = found
        return found

    def comes_before(self, a, b, i, j):
        if not self.sees(a, b, self.hole) or self.sees(a, b, self.near):
            return True
        return super().comes_before(a, b, i, j)

    def shown_again(self, place, block, other):
        gap = sum(block) % 2 == 1
        if not gap and sum(other) % 2 and self.sees(*other, self.hole):
            return 0  # a gap that is filled later
        if self.place(*other) is None:
            return 0
        return super().shown_again(place, block, other)

    def border(self, i, j):
        side, m = self.size + 2 * self.m, self.m
        found = {}
        for v in range(side):
            for u in range(side):
                y, x = i * self.size - m + v, j * self.size - m + u
                away = [v, u, side - 1 - v, side - 1 - u]
                if (y, x) in self.near:
                    found[v, u] = self.known[y, x]
                elif (y, x) in self.hole and (i + j) % 2 and min(away) < 2 * m:
                    a, b = [(-1, 0), (0, -1), (1, 0), (0, 1)][away.index(min(away))]
                    top, left = self.place(i + a, j + b)
                    found[v, u] = self.pixels[top + v - a * self.size][left + u - b * self.size]
        return found

    def difference(self, a, b, y, x):
        if (y, x) not in self.hole and (y, x) not in self.beside:
            return 0
        return super().difference(a, b, y, x)

    def beyond(self, a, b, line, at, middle, upright):
        """Twice what the blocks differ by from the known pixels beside the hole on a line."""
        total = 0
        for k in range(middle - self.m, middle + self.m):
            y, x = (line, k) if upright else (k, line)
            if (y, x) in self.beside:
                i, j = a if k < at else b
                v, u = self.place(i, j)
                v, u = v + y - i * self.size + self.m, u + x - j * self.size + self.m
                there, known = self.pixels[v][u], self.known[y, x]
                shows = 2 * self.visibility[v][u]
                total += 2 * shows * sum((there[c] - known[c]) ** 2 for c in self.channels)
        return total

    def corner(self, i, j):
        pair = ((i - 1, j - 1), (i, j)) if (i + j) % 2 == 0 else ((i - 1, j), (i, j - 1))
        if None in (self.place(*pair[0]), self.place(*pair[1])):
            return i * self.size, j * self.size
        return super().corner(i, j)

    def edge(self, i, j, upright):
        before = (i, j - 1) if upright else (i - 1, j)
        if None in (self.place(*before), self.place(i, j)):
            line, at = (i, j) if upright else (j, i)
            return {line * self.size: at * self.size}
        return super().edge(i, j, upright)

    def source(self, canvas, origin):
        """Place of each pixel of the hole: (height, width, 2), -1 elsewhere."""
        result = np.full((*canvas.shape, 2), -1)
        for y, x in np.argwhere(canvas.hole).tolist():
            v, u = y + origin[0], x + origin[1]
            i, j = self.owners(v, u, 1, 1)[0, 0].tolist()
            top, left = self.place(i, j)
            result[y, x] = top + v - i * self.size + self.m, left + u - j * self.size + self.m
        return result


def tile_errors(pixels, vectors, border):
    """Accumulated squared differences of opposite borders of each tile (section 4.1.1)."""
    x1, y1, x2, y2 = vectors
    sides = ((y1, x1), (y2, x2))
    height, width = pixels.shape[:2]
    levels = pixels.astype(int)
    total = np.zeros((height, width), int)
    for y in range(height):
        for x in range(width):
            for k in (0, 1):
                step = [round(part) for part in sides[k]]
                for v, u in segment_pixels(sides[1 - k], (border + 1) // 2):
                    a, b = (y + v, x + u), (y + v + step[0], x + u + step[1])
                    if all(0 <= p < height and 0 <= q < width for p, q in (a, b)):
                        total[y, x] += ((levels[a] - levels[b]) ** 2).sum()
    return total


def segment_pixels(side, reach):
    """Pixels around the segment from (0, 0) to `side`, row by row.

    A row has those within `reach` columns of the part of the segment within `reach` rows of it.
    """
    steps = 1024  # such fine ones that vectors of quarters are met exactly
    rows = {}
    low, high = math.ceil(min(0, side[0])) - reach, math.ceil(max(0, side[0])) + reach
    for row in range(low, max(high, low + 1)):
        on = [
            side[1] * t / steps
            for t in range(steps + 1)
            if row - reach <= side[0] * t / steps <= row + reach
        ]
        if not on:
            near = min((0, steps), key=lambda t: abs(side[0] * t / steps - row))
            on = [side[1] * near / steps]
        rows[row] = (math.ceil(min(on)) - reach, math.ceil(max(on)) + reach)
    return [(row, u) for row, (a, b) in rows.items() for u in range(a, max(b, a + 1))]
