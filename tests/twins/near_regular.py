"""Near-regular synthesis (chapter 4 of the thesis): constrained random sampling, gap filling."""

from __future__ import annotations

import math

import numpy as np

from twins.randomness import random_bits
from weftex.reference.near_regular import multiples_of


def usable_of(model):
    """Where whole windows lie in a model's sample."""
    y, x = np.nonzero(model.blocks.windows.usable)
    return list(zip(y.tolist(), x.tolist(), strict=True))


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
        height, width = pixels.shape[:2]
        steps = multiples_of(np.array(self.vectors), (height, width))
        self.steps = [(round(y * 65536), round(x * 65536)) for y, x in steps.tolist()]
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

    def similar(self, i, j):
        """Places a multiple of the vectors away, in the block's own order (section 4.2.1)."""
        y, x = i * self.size - self.m, j * self.size - self.m
        parts = [y * self.inverse[0][k] + x * self.inverse[1][k] for k in (0, 1)]
        parts = [p - math.floor(p) for p in parts]
        at = [
            round((parts[0] * self.vectors[0][k] + parts[1] * self.vectors[1][k]) * 65536)
            for k in (0, 1)
        ]
        start = random_bits(self.seed, "block", i, j) % len(self.steps)
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
    def color(i, j):
        return (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2

    def drawn(self, i, j):
        near = [(-1, -1), (-1, 1), (1, -1), (1, 1), (-2, 0), (2, 0), (0, -2), (0, 2)]
        before = [(i + a, j + b) for a, b in near if self.color(i + a, j + b) < self.color(i, j)]
        best, least = None, math.inf
        for place in self.similar(i, j)[:256]:
            again = sum(self.shown_again(place, (i, j), other) for other in before)
            if again < least:
                best, least = place, again
            if 8 * least <= self.size**2:
                break
        return best

    def border(self, i, j):
        """The border around a gap (Fig. 4.9): (v, u) in its window and the color there."""
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
        return sum(
            (self.pixels[place[0] + v][place[1] + u][k] - color[k]) ** 2
            for (v, u), color in border.items()
            for k in self.channels
        )

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
        best = sorted(similar[:512], key=key)[: self.method.candidates]
        reach = range(-self.method.tolerance, self.method.tolerance + 1)
        near = {(y + dy, x + dx) for y, x in best for dy in reach for dx in reach} & self.usable
        return min(near, key=lambda place: (key(place), place))

    def difference(self, a, b, y, x):
        """Squared difference of what blocks a and b have at a pixel, by how much it shows there."""
        colors, shows = [], 0
        for i, j in (a, b):
            v, u = y - i * self.size + self.m, x - j * self.size + self.m
            colors.append(self.color_of(i, j, v, u))
            top, left = self.place(i, j)
            shows += self.visibility[top + v][left + u]
        return shows * sum((colors[0][k] - colors[1][k]) ** 2 for k in self.channels)

    def color_of(self, i, j, v, u):
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
