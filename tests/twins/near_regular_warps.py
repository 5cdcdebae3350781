"""Near-regular synthesis whose gaps are warped."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from twins.near_regular import NearRegularTwin

HALF = Fraction(1, 2)


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

    def color_of(self, i, j, v, u):
        """Between pixels by the cubic of Catmull and Rom, and never past the nearest four."""
        if (i + j) % 2 == 0:
            return super().color_of(i, j, v, u)
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
            color = []
            for c in self.channels:
                total, near = 0, []
                for y, p, m in ways[0]:
                    for x, q, n in ways[1]:
                        level = super().color_of(i, j, y, x)[c]
                        total += p * q * level
                        if p * q and m in (1, 2) and n in (1, 2):
                            near.append(level)
                color.append(min(max(math.floor(total + HALF), min(near)), max(near)))
            self.warped[i, j, v, u] = color
        return self.warped[i, j, v, u]

    def image(self, top, left, height, width):
        owner = self.owners(top, left, height, width)
        result = np.zeros((height, width, len(self.channels)), np.uint8)
        for v in range(height):
            for u in range(width):
                i, j = owner[v, u].tolist()
                at = top + v - i * self.size + self.m, left + u - j * self.size + self.m
                result[v, u] = self.color_of(i, j, *at)
        return result
