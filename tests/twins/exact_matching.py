"""Exact neighborhood matching (Sabha, Peers and Dutré, 2007)."""

from __future__ import annotations

import numpy as np

from twins.pyramids import pyramid
from twins.randomness import pick, random_bits
from twins.windows import beside, inwards, known_window, steps_away, usable, window_centers

#: The direct neighbors of figure 2, and the next pixel for the end of a row that goes around.
DIRECT = [(0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)]


#: Those and the ones below, between known pixels.
ALL_AROUND = [*DIRECT, (1, 1), (1, 0), (1, -1)]


class ExactSample:
    """One level of a sample: its windows, and for each neighbor's color the groups of places."""

    def __init__(self, pixels, mask, tiles, method, causal, guide=None):
        self.pixels, self.tiles, self.causal, self.guide = pixels.astype(int), tiles, causal, guide
        self.shape = pixels.shape[:2]
        half = (min(method.window_width, *self.shape) - 1) // 2
        self.half = half = half if causal else min(half, 7)
        self.guide_half = min(half, 4) if guide is not None else 0
        self.reach = (half, self.guide_half if causal else half, half, half)
        self.centers = window_centers(mask, self.reach, tiles)
        self.whole = set(self.centers)
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
        """The color there; a sample that tiles goes on as far as a window may."""
        up, down, left, right = self.reach if self.tiles else (0, 0, 0, 0)
        height, width = self.shape
        if not (-up <= v < height + down and -left <= u < width + right):
            return None
        return tuple(self.pixels[v % height, u % width].tolist())

    def _listed(self):
        """Centers with room: another one half a window below, unless there is none such."""
        if not self.causal or self.tiles:
            return self.centers
        return [(v, u) for v, u in self.centers if (v + self.half, u) in self.whole] or self.centers

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
        """A place in the sample that a whole window is centered on, or None."""
        if self.tiles:
            place = place[0] % self.shape[0], place[1] % self.shape[1]
        return place if place in self.whole else None

    def near(self, color):
        """The counted colors within the tolerance of the counted color nearest to this one."""

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
    width = sheet.shape[1]
    last = {}
    for y, x in np.ndindex(sheet.shape):
        if sheet.source[y][x]:
            last[sheet.source[y][x]] = (y, x)

    def repeats(place, y, x, apart):
        v, u = last.get(place, (y, x))
        return (v, u) != (y, x) and abs(v - y) < apart and abs(u - x) < apart

    def neighbors(y, x):
        for d, (dy, dx) in enumerate(DIRECT if sample.causal else ALL_AROUND):
            at = beside((y, x), (dy, dx), sheet.shape, sheet.wrap)
            if at is not None and sheet.done[at]:
                source = sheet.source[at[0]][at[1]]
                goes_on = source and sample.settle((source[0] - dy, source[1] - dx))
                yield d, tuple(sheet.levels[at].tolist()), goes_on

    def choose(y, x, bits, apart):
        steps = sheet.window(y, x, sample)
        wide = []
        if guide is not None:
            half = (sample.guide_half,) * 4
            wide = known_window(np.ones(sheet.shape, bool), y, x, sheet.wrap, half)

        seen = steps_away(sheet.levels, y, x, steps)
        shown = None if guide is None else steps_away(guide[0], y, x, wide)

        def distance(place):
            total = ((seen - steps_away(sample.pixels, *place, steps)) ** 2).sum()
            if guide is not None:
                total += ((shown - steps_away(sample.guide, *place, wide)) ** 2).sum()
            return int(total)

        around = list(neighbors(y, x))
        first = [goes_on for _, _, goes_on in around]
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
            for d, color, _ in around
        ]
        listed, most = sum(len(groups) for groups in lists), method.candidates
        share = 2**32
        if 0 < most < listed:
            share = 2**32 * most // listed
            union = {group[0] for groups in lists for group in groups} - set(first)
            met = sum((sample.flat(p) ^ bits) % 2**32 * 2654435761 % 2**32 < share for p in union)
            if 0 < met < most:
                share = share * most // met
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
        place = place or sample.centers[pick(bits, len(sample.centers))]
        sheet.put(y, x, place, sample)
        last[place] = (y, x)


def exact_matching(method, exemplar, canvas, seed):
    """Make all of a canvas; (H, W, 2) sources, -1 for known pixels from elsewhere.

    `method` is the settled one.
    """
    tiles = exemplar.tileable
    samples, masks = pyramid(exemplar.matching(), usable(exemplar), (tiles, tiles), method.levels)
    shapes = [canvas.shape]
    for _ in range(method.levels - 1):
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
                bits = random_bits(seed, "exact band", y, x)
                band[y][x] = sample.centers[bits % len(sample.centers)]
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
    center = sample.centers[random_bits(seed, "exact block", 0) % len(sample.centers)]
    block = min(half, width)
    for y, x in np.ndindex(block, half):
        v, u = (center[0] - half + y) % sample.shape[0], (center[1] - half + x) % sample.shape[1]
        sheet.put(y, x, (v, u), sample)
    order = [(y, x) for y in range(block, width) for x in range(half)]
    exact_pixels(sheet, sample, order, seed, "exact structure", method)
    return [[sheet.source[x][y][::-1] for x in range(width)] for y in range(half)]


def exact_between(sheet, sample, seed, stage, method, guide=None):
    """Layers from what is known inwards, in random order; then passes over them line by line."""
    width = sheet.shape[1]
    unknown = [(y, x) for y, x in np.ndindex(sheet.shape) if not sheet.done[y, x]]
    order = []
    for layer in inwards(sheet.done, sheet.wrap):
        order += sorted(layer, key=lambda p: random_bits(seed, "exact layer", p[0] * width + p[1]))
    exact_pixels(sheet, sample, order, seed, stage, method, guide)
    for number in range(method.passes):
        exact_pixels(sheet, sample, unknown, seed, f"exact pass {number}", method, guide)


def _exact_sources(source, top):
    return np.array([[place or (-1, -1) for place in row] for row in source[top:]])
