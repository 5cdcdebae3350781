"""What graph-cut textures show already, and what showing it again costs."""

from __future__ import annotations

import math

import numpy as np

from twins.graphcut_copies import copies


class Repeating:
    """The part of `GraphCutTwin` that prices places by what the canvas shows."""

    def not_continuing(self, costs, k, box, size):
        """The places that are not next to one from which the box would just go on."""
        taken = set()
        for i, cell in enumerate(box):
            label = self.label[cell]
            v, u = divmod(i, size[1])
            if label is None or label == "known" or v % 2**k or u % 2**k:
                continue
            y, x = label[0] - v, label[1] - u
            if self.exemplar.tileable:
                y, x = y % self.exemplar.shape[0], x % self.exemplar.shape[1]
            taken.add(tuple((c + 2**k // 2) // 2**k for c in (y, x)))
        near = [math.ceil(n // 16 / 2**k) for n in size]
        return {
            place: cost
            for place, cost in costs.items()
            if not any(
                abs(place[0] - y) <= near[0] and abs(place[1] - x) <= near[1] for y, x in taken
            )
        }

    def shown(self, places, k, corner, size, near):
        """How much of a patch from each place is shown already, nearby and in rows or columns."""
        step = max(4, 2 * self.reduction())
        seen, lined = dict.fromkeys(places, 0), dict.fromkeys(places, 0)
        for cell in self.cells:
            label = self.label[cell]
            if label is None or label == "known" or cell[0] % step or cell[1] % step:
                continue
            away = []
            for at, first, n, length, wraps in zip(
                cell, corner, size, self.canvas.shape, self.canvas.wrap, strict=True
            ):
                before = length // 2 - n // 2
                away.append((at - first + before) % length - before if wraps else at - first)
            for place in seen:
                nearby, in_line = self.again([c << k for c in place], label, away, size, near)
                seen[place] += nearby
                lined[place] += in_line
        once = size[0] * size[1] / step**2
        return {at: (seen[at] / once, lined[at] / once) for at in places}

    def priced(self, shown):
        """By what the costs of places are multiplied: nearby, in line, at all."""
        weights, variety = (1.0, 0.25, 0.25), self.method.variety
        prices = dict.fromkeys(shown, 1.0)
        for at, each in shown.items():
            for weight, once in zip(weights, each, strict=False):
                prices[at] += variety * (weight * min(once, 4.0))
        return prices

    def used(self, places, k, missing):
        """How often the canvas shows what a patch would show, over the mean.

        `missing` lists those pixels of the k-th copy as seen from each place.
        """
        step, side = max(4, 2 * self.reduction()), 2**k
        counts = {(y // side, x // side): 0 for y, x in np.ndindex(self.exemplar.shape)}
        for cell in self.cells:
            label = self.label[cell]
            if label not in (None, "known") and not cell[0] % step and not cell[1] % step:
                counts[label[0] // side, label[1] // side] += 1
        mean, result = sum(counts.values()) / len(counts), {}
        last = [1 + at for at in max(counts)]
        for place in places:
            found = [(place[0] + y, place[1] + x) for y, x in missing]
            if self.exemplar.tileable and self.method.placement == "subpatch":
                found = [tuple(np.mod(at, last)) for at in found]
            found = [counts[at] for at in found if at in counts]
            result[place] = sum(found) / (max(len(found) * mean, mean) or 1.0)
        return result

    def again(self, place, label, away, size, near):
        """How often a patch from a place of the sample shows this label again, at what distance."""
        shape, nearby, lined = self.exemplar.shape, 0, 0
        around = (-1, 0, 1) if self.exemplar.tileable else (0,)
        for v in around:
            for u in around:
                at = label[0] + v * shape[0], label[1] + u * shape[1]
                if all(p <= a < p + n for p, a, n in zip(place, at, size, strict=True)):
                    far = [abs(a - b - p) for a, b, p in zip(at, away, place, strict=True)]
                    in_line = [f <= n // 16 for f, n in zip(far, size, strict=True)]
                    nearby += all(f <= n for f, n in zip(far, near, strict=True))
                    lined += sum(in_line)
        return nearby, lined

    def cell(self):
        """Side of the squares by which the canvas is looked over for what it shows again."""
        side = 1
        while min(self.exemplar.shape) >= 32 * side:
            side *= 2
        return side

    def in_sight(self, pixel, holes):
        """Share of what a patch would newly show that is shown near there already, by salience."""
        cell, shape = self.cell(), self.exemplar.shape
        pixels, usable = copies(self.pixels, self.usable, cell)[-1]
        count = max(usable.sum(), 1)
        away = np.square(pixels - pixels[usable].sum(axis=0) / count).sum(axis=2) * usable
        mean = float(away.sum() / count)
        salience = np.rint(16 * (np.minimum(away / mean, 8) if mean else usable)).astype(int)
        cells = [math.ceil(n / cell) for n in shape]

        def around(reach, ends):
            for y in range(-reach[0], reach[0] + 1, cell):
                for x in range(-reach[1], reach[1] + 1, cell):
                    at = [p + d for p, d in zip(pixel, (y, x), strict=True)]
                    if all(
                        wraps or low <= a < high
                        for a, (low, high), wraps in zip(at, ends, self.canvas.wrap, strict=True)
                    ):
                        yield (y, x), self.label[tuple(np.mod(at, self.canvas.shape))]

        missing = [
            (y // cell, x // cell)
            for (y, x), label in around([n * cell for n in cells], holes)
            if label is None
        ]
        pieces = {}
        far = [math.ceil(int(3 * n) / cell) * cell for n in shape]
        for (y, x), label in around(far, [(0, n) for n in self.canvas.shape]):
            if label not in (None, "known"):
                place = [min(c // cell, n - 1) for c, n in zip(label, salience.shape, strict=True)]
                pieces.setdefault((y - label[0], x - label[1]), set()).add(tuple(place))
        result, salience = {}, dict(np.ndenumerate(salience))
        for at in np.ndindex(*cells):
            total = 0
            found = {(at[0] + y, at[1] + x) for y, x in missing} & salience.keys()
            new = sum(int(salience[f]) for f in found)
            for shift, places in pieces.items():
                off = [abs(a * cell + d) / n for a, d, n in zip(at, shift, shape, strict=True)]
                away = np.sqrt(off[0] ** 2 + off[1] ** 2)
                in_line = 2 * max(1 - 6 * min(off), 0) * max(1 - away / 2, 0)
                in_line *= self.canvas.hole is None
                weight = int(np.rint(64 * (max(1 - away / 1.25, 0) + in_line)))
                if weight > 0:
                    total += weight * sum(int(salience[f]) for f in found & places)
            result[at] = total / max(64 * new, 1)
        return result
