"""Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003) as a whole."""

from __future__ import annotations

import itertools
import math

import numpy as np

from twins.maxflow import least_labelling
from twins.randomness import random_bits
from twins.windows import ARCS, beside, usable


class GraphCutTwin:
    """One output of the method "graphcut", pixel by pixel.

    `label` holds for each pixel of the canvas where in the sample it was copied from, None where
    nothing is, and "known" for a known pixel that is not in the sample.
    """

    def __init__(self, exemplar, method, canvas, seed):
        self.exemplar, self.method, self.canvas, self.seed = exemplar, method, canvas, seed
        self.pixels = exemplar.matching().astype(int)
        self.usable = usable(exemplar)
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
        return beside(cell, (dy, dx), self.canvas.shape, self.canvas.wrap)

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
        """Whether the neighbor belongs to the box beside it, not around the canvas."""
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
            left = random_bits(self.seed, "patch", self.laid, k) % total
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
        boundary = self.method.boundary_width
        size, corner = self.size(*self.patch_shape()), []
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

    def patch_shape(self):
        """Squares; of a thin sample 0.45 of either side; or the entire sample."""
        side = self.method.patch_size
        if side:
            return side, side
        if self.method.placement == "subpatch":
            return tuple(max(1, round(0.45 * n)) for n in self.exemplar.shape)
        return self.exemplar.shape

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
            self.columns = (lengths[0] if lengths else self.size(*self.patch_shape()))[1]
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
        size = self.size(*self.patch_shape())
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
