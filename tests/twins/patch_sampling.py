"""Patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001) and image quilting as a whole.

"Section", "equation" and "figure" are those of Real-time texture synthesis by patch-based sampling.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from twins.boundary_zone import zone_of, zone_weights
from twins.compositing import blend_pixel
from twins.patch_repeats import laid_nearby, mark_repeats
from twins.randomness import pick, random_bits
from twins.seams import cut_row, cut_sides, cut_weights
from twins.windows import rectangle, usable

#: A source that repeats nothing may have this times the squared distance of one that does.
VARIETY = 1.7


#: Patches of a hole that one more should not repeat: so many, the latest laid.
NEARBY = 11


#: Earlier patches of the grid that lie around one, as (rows, columns) away, in the order they ask.
AROUND = [(0, -2), (0, -1), *((-1, k) for k in range(-2, 2)), *((-2, k) for k in range(-2, 3))]


def choose(keys, marks, energy, bits, *, epsilon=None, tolerance=None, similarity=False):
    """Index of the candidate drawn, by one of `epsilon` and `tolerance`.

    `keys` are A d**2, `energy` A d_max**2 / epsilon**2, `marks` those of `mark_repeats`.
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


def sample_exhaustive(exemplar, method, canvas, seed, *, corners=None, finish=True):
    """Steps 1 to 6 of section 2.2: placements (y, x, source y, source x), and the picture.

    `corners` say where windows go, in order; a canvas with holes needs them.
    """
    size, width = method.patch_size, method.boundary_width
    pixelwise = size == 1
    window = [2 * width + 1] * 2 if pixelwise else [min(size, n) for n in canvas.shape]
    center = (width, width)
    if not pixelwise:
        width = zone_width(method, canvas)
    sample = exemplar.matching(method.edge_weight).astype(int)
    places = _windows_of(exemplar, window)
    stack = np.array([rectangle(sample, place, window) for place in places])
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
            bits = random_bits(seed, "patch", number)
        else:
            bits = random_bits(seed, "patch", *step)
        wanted = buffer[here][zone]
        if not zone.any() or math.inf in rule.values():
            chosen = pick(bits, len(places))
        else:
            keys = ((stack[:, zone] - wanted) ** 2).sum(axis=(1, 2)).tolist()
            marks = [""] * len(places)
            if method.repeat_distance > 0 and not pixelwise:
                if holes:
                    nearby = laid_nearby(corner, placements, [2 * side for side in window], NEARBY)
                else:
                    steps = _grid_steps(method, canvas)
                    grid = dict(zip(steps, placements, strict=False))
                    asked = [(step[0] + a, step[1] + b) for a, b in AROUND]
                    nearby = [grid[k] for k in asked if k in grid]
                marks = mark_repeats(
                    corner, places, nearby, round(method.repeat_distance * size), int(bits) & 1
                )
            energy = int((wanted**2).sum())
            chosen = choose(keys, marks, energy, bits, **rule)
        source = places[chosen]
        weights = zone_weights(
            known, width, frozen[here] & inside if holes else None, method.blend == "none"
        )
        if pixelwise:
            weights[:] = 0
            weights[center] = 256
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
    mask = usable(exemplar)
    found = []
    for y, x in itertools.product(*map(range, exemplar.shape)):
        fits = y + window[0] <= exemplar.shape[0] and x + window[1] <= exemplar.shape[1]
        if (fits or exemplar.tileable) and rectangle(mask, (y, x), window).all():
            found.append((y, x))
    return found


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


def compare(method, exemplar, canvas, seed=5, exact=True):
    """Assert that a method makes the picture that the twin makes; return its result."""
    result = method.fit(exemplar).sample(canvas, seed=seed)
    corners = None
    if canvas.hole is not None:
        reach = method.boundary_width if method.patch_size == 1 else 0
        corners = (result.placements[:, :2] - reach).tolist()
    placements, picture = sample_exhaustive(exemplar, method, canvas, seed, corners=corners)
    assert [tuple(p) for p in result.placements[:, :4].tolist()] == placements
    if exact:
        assert np.array_equal(result.image, picture)
        assert np.array_equal(result.render(), picture)
    else:
        assert np.allclose(result.image, picture, rtol=1e-5)
    return result
