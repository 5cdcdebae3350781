"""Slow, obvious twins of weft's kernels and orderings, written from the definitions.

"Section", "equation" and "figure" are those of Liang, Liu, Xu, Guo and Shum (2001), Real-time
texture synthesis by patch-based sampling. Nothing here is clever, nothing is shared with the
package but the random bits (`weft.random.draw`), the bytes that matching looks at
(`Exemplar.matching`, which has tests of its own) and the nouns.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from weft.random import draw

#: A source that repeats nothing may have this times the squared distance of one that does.
VARIETY = 1.7

#: Patches of a hole that one more should not repeat: so many, the latest laid.
NEARBY = 11
#: What a step of a path costs where the patch cannot show: more than any path where it can.
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


def coarser(levels, wrap):
    """Every second pixel of the 1 4 6 4 1 mean, rounded; beyond a border the last pixel goes on."""
    height, width = levels.shape[:2]
    result = np.zeros(((height + 1) // 2, (width + 1) // 2, levels.shape[2]), np.uint8)
    for y, x in np.ndindex(result.shape[:2]):
        total = np.full(levels.shape[2], 128)
        for v, u in itertools.product(range(-2, 3), repeat=2):
            weight = (1, 4, 6, 4, 1)[v + 2] * (1, 4, 6, 4, 1)[u + 2]
            at = _tap(2 * y + v, height, wrap[0]), _tap(2 * x + u, width, wrap[1])
            total += weight * levels[at].astype(int)
        result[y, x] = total // 256
    return result


def coarser_mask(mask, wrap):
    """Whether all pixels that count for a coarser one are in the mask."""
    height, width = mask.shape
    result = np.ones(((height + 1) // 2, (width + 1) // 2), bool)
    for y, x in np.ndindex(result.shape):
        for v, u in itertools.product(range(-2, 3), repeat=2):
            result[y, x] &= mask[_tap(2 * y + v, height, wrap[0]), _tap(2 * x + u, width, wrap[1])]
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
        for _ in range(1 + method.passes):
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
    """Unknown pixels, those next to known ones first, in random order within a layer."""
    known, order = known.copy(), []
    height, width = known.shape
    while not known.all():
        layer = []
        for y, x in np.argwhere(~known).tolist():
            for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                inside = (wrap[0] or 0 <= v < height) and (wrap[1] or 0 <= u < width)
                if inside and known[v % height, u % width]:
                    layer.append((y, x))
                    break
        layer = layer or np.argwhere(~known).tolist()
        layer.sort(key=lambda p: (draw(seed, "wei-levoy order", p[0] * width + p[1]), p))
        order += [tuple(p) for p in layer]
        for p in layer:
            known[tuple(p)] = True
    return order


# Coherent candidates (Ashikhmin, 2001)


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
    guide = None if canvas.guide is None else exemplar.as_matching(canvas.guide).astype(int)
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

    for number, (i, line) in itertools.product(range(method.passes), enumerate(lines)):
        # In the first pass the first rows see random pixels above them, around the border.
        start = not holes and number == 0 and i < half
        for y, x in line:
            seen = done.copy()
            if start:
                seen[max(i + 1, height - half) :] = True
            wrap = (canvas.wrap[0] or start, canvas.wrap[1])
            steps = known_window(seen, y, x, wrap, reach)
            found = coherent_places(source, y, x, steps, exemplar, allowed)
            if number:
                found = [source[y][x]] + [place for place in found if place != source[y][x]]
            tries = max(jumps, 8) if None in found or not found else jumps
            found = [place for place in found if place is not None] + [
                random_place("ashikhmin", number, y * width + x, k) for k in range(tries)
            ]

            def distance(place, y=y, x=x, steps=steps, seen=seen, wrap=wrap, number=number):
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
                        if number or not seen[at] or (dy, dx) == (0, 0):
                            v, u = (place[0] + dy) % len(pixels), (place[1] + dx) % pixels.shape[1]
                            own = pixels[v, u, : guide.shape[2]]
                            total += weight * ((own - guide[at]) ** 2).sum()
                return int(total)

            lay(y, x, min(found, key=distance))
            done[y, x] = True
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
                for v, u in self.centres
                for dy, dx in [*ALL_AROUND, (0, 0)]
                if self._color(v + dy, u + dx)
            }
        )
        low, high = (f(np.array(self.counted), axis=0) for f in (np.min, np.max))
        self.radius = (
            int(method.tolerance**2 * ((high - low) ** 2).sum())
            if (method.tolerance is not None)
            else None
        )
        self.nearest = method.nearest_colors
        self.groups = self._groups(method.grouping)

    def _color(self, v, u):
        if self.tiles and self.half:
            v, u = v % self.shape[0], u % self.shape[1]
        inside = 0 <= v < self.shape[0] and 0 <= u < self.shape[1]
        return tuple(self.pixels[v, u].tolist()) if inside else None

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
                    for group in reversed(groups):
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
        height, width = self.shape
        half = sample.half
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
        tested, found = set(first), []
        for d, color, _ in beside:
            groups = [g for c in sample.near(color) for g in sample.groups.get((d, c), [])]
            for group in groups:
                if group[0] not in tested:
                    member = group[pick(bits, len(group))]
                    if not repeats(member, y, x, apart):
                        key = (sample.flat(group[0]) ^ bits) % 2**32 * 2654435761 % 2**32
                        found.append((distance(group[0]), key, member))
            tested.update(group[0] for group in groups)
        if found and (best is None or min(found)[0] < best):
            return min(found)[2]
        return chosen

    for y, x in order:
        bits = random_bits(seed, stage, y * width + x)
        place = None
        if method.copying == "blocks" and sample.causal:
            inside = 0 < y and 0 < x < width - 1
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
        return sum(d * d * weight >> 16 for d in difference)

    middles = [coordinates.sum(axis=0, dtype=int) // len(places) for places, coordinates in leaves]
    order = sorted(range(len(leaves)), key=lambda n: (distance(middles[n]), n))[:visited]
    windows = [(distance(c), p) for n in order for p, c in zip(*leaves[n], strict=True)]
    return [place for _, place in sorted(windows)[:wanted]]
