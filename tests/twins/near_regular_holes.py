"""Near-regular synthesis in a hole."""

from __future__ import annotations

import numpy as np

from twins.near_regular import NearRegularTwin
from twins.randomness import random_bits


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
        start = random_bits(self.seed, "block", i, j) % len(found)
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
