"""Where patches of graph-cut textures come from, on copies and in full."""

from __future__ import annotations

import math

import numpy as np

from twins.graphcut_copies import copies, mismatch
from twins.graphcut_repeats import Repeating
from twins.randomness import random_bits
from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.reference.graphcut import chances_of


class Placing(Repeating):
    """The part of `GraphCutTwin` that finds places."""

    def reduction(self):
        """How many times smaller the copies are that matches begin on."""
        size, least, most = self.size(*self.patch_shape()), 24, 4
        if self.method.halvings is not None:
            least, most = 1, self.method.halvings
        places = set(self.places())
        result = 1
        while 2 * result <= 2**most and 2 * result * least <= min(size):
            if not any(y % (2 * result) == x % (2 * result) == 0 for y, x in places):
                break
            result *= 2
        return result

    def places(self):
        """Where the corner of a patch may lie; usable pixels, if it is the entire sample."""
        shape = self.exemplar.shape
        if self.method.placement != "subpatch":
            return [at for at in np.ndindex(shape) if self.usable[at]]
        size, found = self.size(*self.patch_shape()), []
        for y, x in np.ndindex(shape):
            if self.exemplar.tileable or (y + size[0] <= shape[0] and x + size[1] <= shape[1]):
                patch = self.rectangle((y, x), size, shape)
                if all(self.usable[at] for at in patch):
                    found.append((y, x))
        return found

    def chances(self, costs, spread):
        """Whole numbers in proportion to exp(-cost / spread), of a dict of costs."""
        return dict(zip(costs, chances_of(np.array([*costs.values()]), spread), strict=True))

    def drawn(self, costs, size, copy):
        """Candidates in the order drawn; near one that was drawn there is no other."""
        costs = {place: cost for place, cost in costs.items() if cost < math.inf}
        pixels, mask = copy
        count, spread = int(mask.sum()), 0
        for channel in pixels[mask].T:
            spread += count * int((channel**2).sum()) - int(channel.sum()) ** 2
        tolerance = self.method.tolerance
        spread = (0.003 if tolerance is None else tolerance) * (spread / count**2)
        chances, found = self.chances(costs, spread), []
        for k in range(self.method.candidates):
            total = sum(chances.values())
            if total == 0:
                left = {place: cost for place, cost in costs.items() if place in chances}
                if spread > 0 or not left:
                    break
                chances = self.chances(left, 0.0)
                total = sum(chances.values())
            left = random_bits(self.seed, "patch", self.laid, k) % total
            for place in sorted(chances):
                left -= chances[place]
                if left < 0:
                    break
            found.append(place)
            for y, x in list(chances):
                if all(abs(a - b) <= n // 32 for a, b, n in zip((y, x), place, size, strict=True)):
                    del chances[y, x]
        return found

    def nudged(self, place, boxes, samples, allowed, offset):
        """A place of the smallest copy on larger and larger ones: the best of nine on each."""
        marked = [set(self.on_copy(allowed, samples, k)) for k in range(len(boxes))]
        for k in range(len(boxes) - 2, -1, -1):
            y, x = 2 * place[0], 2 * place[1]
            near = [(y, x), *((y + v, x + u) for v in (-1, 0, 1) for u in (-1, 0, 1))]
            costs = {}
            for at in near:
                if at not in costs and at in marked[k]:
                    corner = (at[0] - (offset[0] >> k), at[1] - (offset[1] >> k))
                    costs[at] = mismatch(boxes[k], samples[k], *corner)
            place = min(costs, key=costs.get)
        return place

    def smallest(self, boxes, samples, allowed):
        """The smallest copy that has places, and of the box whatever there is."""
        k = len(boxes) - 1
        while not self.on_copy(allowed, samples, k) or (
            boxes[0][1].any() and not boxes[k][1].any()
        ):
            k -= 1
        return k

    def on_copy(self, places, samples, k):
        """Those of some places that the k-th copy has, on it."""
        height, width = samples[k][1].shape
        whole = self.method.lattice is not None  # all of a block, not only its corner
        found = [(y >> k, x >> k) for y, x in sorted(places) if whole or y % 2**k == x % 2**k == 0]
        found = list(dict.fromkeys(sorted(found)))
        return [(y, x) for y, x in found if y < height and x < width]

    def patches(self, pixel, mend):
        """Candidates of sub-patch matching: (box, patch, columns, price) of pixels."""
        boundary = self.method.boundary_width
        size, corner = self.size(*self.patch_shape()), []
        for at, n, length, wraps in zip(
            pixel, size, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            start = at - (n // 2 if mend else min(boundary, (n - 1) // 2))
            corner.append(start if wraps else min(max(start, 0), length - n))
        box = self.rectangle(corner, size, self.canvas.shape)
        there = np.reshape([self.label[cell] is not None for cell in box], size)
        levels = np.zeros((*size, self.pixels.shape[2]), int)
        for i, cell in enumerate(box):
            if self.label[cell] is not None:
                levels[divmod(i, size[1])] = self.level(cell)
        pads = [(0, n - 1 if self.exemplar.tileable else 0) for n in size]
        whole = np.pad(self.pixels, (*pads, (0, 0)), mode="wrap")
        reduction = self.reduction()
        boxes = copies(levels, there, reduction)
        samples = copies(whole, np.ones(whole.shape[:2]), reduction)
        allowed = set(self.places())
        k = self.smallest(boxes, samples, allowed)
        costs = dict.fromkeys(self.on_copy(allowed, samples, k), 0.0)
        prices = dict.fromkeys(costs, 1.0)
        if boxes[k][1].any():
            costs = {at: mismatch(boxes[k], samples[k], *at) for at in costs}
            if self.method.variety > 0:
                shown = self.shown(costs, k, corner, size, size)
                missing = list(np.ndindex(*(max(1, n >> k) for n in size)))
                used = self.used(costs, k, missing)
                prices = self.priced({at: (*each, used[at]) for at, each in shown.items()})
                costs = self.not_continuing(costs, k, box, size) or costs
        sample = copies(self.pixels, self.usable, reduction)[: k + 1]
        copy = next(c for c in reversed(sample) if c[1].any())
        result, costs = [], {at: cost * prices[at] for at, cost in costs.items()}
        for place in self.drawn(costs, [n >> k for n in size], copy):
            at = self.nudged(place, boxes[: k + 1], samples, allowed, (0, 0))
            patch = self.rectangle(at, size, self.exemplar.shape)
            result.append((box, patch, size[1], prices[place]))
        return result

    def samples(self, pixel, mend):
        """Candidates of random placement and entire patches, as of `patches`."""
        height, width = self.exemplar.shape
        size, wrap, holes = self.size(height, width), self.canvas.wrap, []
        for axis, length in enumerate(self.canvas.shape):
            lines = [cell[axis] for cell in self.cells if cell not in self.known]
            holes.append((0, length) if wrap[axis] else (min(lines), max(lines) + 1))
        pixel = [min(max(p, low), high - 1) for p, (low, high) in zip(pixel, holes, strict=True)]
        around = [
            range(low - max((high - low) // 2, 32), high + max((high - low) // 2, 32))
            if not wraps else range(length)
            for (low, high), wraps, length in zip(holes, wrap, self.canvas.shape, strict=True)
        ]  # fmt: skip
        varied = self.method.placement == "entire" and self.method.variety > 0
        low, high = (2, 6) if mend else (1, 6) if varied else (2, 4)
        rows = range(height * low // 8, height * high // 8 + 1)
        columns = range(width * low // 8, width * high // 8 + 1)
        usable = self.places()
        allowed = {at for at in usable if at[0] in rows and at[1] in columns} or set(usable)
        reduction = self.reduction()
        if self.method.lattice is not None:
            begun = any(label is not None for label in self.label.values())
            on = self.on_lattice(pixel, near=begun)
            allowed = allowed & on or set(usable) & on or allowed
        reach = [-(-(n - 1) // reduction) * reduction for n in (height, width)]
        lengths = [2 * n + reduction for n in reach]
        there = np.zeros(lengths, bool)
        levels = np.zeros((*lengths, self.pixels.shape[2]), int)
        for y, x in np.ndindex(*lengths):
            cell = self.step((pixel[0] - reach[0] + y, pixel[1] - reach[1] + x), 0, 0)
            if cell is None or any(c not in r for c, r in zip(cell, around, strict=True)):
                continue
            if self.label[cell] is not None:
                there[y, x], levels[y, x] = True, self.level(cell)
        boxes = copies(levels, there, reduction)
        samples = copies(self.pixels, self.usable, reduction)
        k = self.smallest(boxes, samples, allowed)
        costs = dict.fromkeys(self.on_copy(allowed, samples, k), 0.0)
        prices = dict.fromkeys(costs, 1.0)
        if self.method.placement == "entire":
            corner = [n >> k for n in reach]
            found = {
                at: mismatch(boxes[k], samples[k], at[0] - corner[0], at[1] - corner[1])
                for at in costs
            }
            if any(cost < math.inf for cost in found.values()):
                costs = found
            if self.method.variety > 0:
                missing = []
                for y in range(0, lengths[0], 2**k):
                    for x in range(0, lengths[1], 2**k):
                        cell = self.step((pixel[0] - reach[0] + y, pixel[1] - reach[1] + x), 0, 0)
                        if (
                            cell is not None
                            and self.label[cell] is None
                            and all(c in r for c, r in zip(cell, around, strict=True))
                        ):
                            missing.append(((y - reach[0]) >> k, (x - reach[1]) >> k))
                used, again = self.used(costs, k, missing), self.in_sight(pixel, holes)
                for at in costs:
                    seen = again[tuple((c << k) // self.cell() for c in at)]
                    more = 0.3 * seen + 0.05 * min(used[at], 4.0)
                    prices[at] = 1 + self.method.variety * more
        copy = next(c for c in reversed(samples[: k + 1]) if c[1].any())
        result, costs = [], {at: cost * prices[at] for at, cost in costs.items()}
        for place in self.drawn(costs, [n >> k for n in size], copy):
            at = self.nudged(place, boxes[: k + 1], samples, allowed, reach)
            corner, lengths, source = [], [], []
            for p, s, n, most, (low, high), wraps in zip(
                pixel, at, (height, width), size, holes, wrap, strict=True
            ):
                first, end = p - s, p - s + n
                if wraps:
                    first = max(first, p - most // 2)
                    end = min(end, first + most)
                else:
                    first, end = max(first, low), min(end, high)
                corner.append(first)
                lengths.append(end - first)
                source.append(first - p + s)
            box = self.rectangle(corner, lengths, self.canvas.shape)
            patch = self.rectangle(source, lengths, self.exemplar.shape)
            result.append((box, patch, lengths[1], prices[place]))
        return result

    def on_lattice(self, pixel, near):
        """Places from which whole multiples of the vectors lead to a pixel, or nearly."""
        x1, y1, x2, y2 = self.method.lattice
        vectors = np.array([[y1, x1], [y2, x2]])
        lengths = [np.hypot(*v) for v in vectors]
        shortest = min(n for n in lengths if n > 1.01 or min(lengths) > 1.01)
        reach = min(max(shortest / 16, 0.75), 4.0) if near else 0.75
        first = CanvasLattice(self.method.lattice, self.canvas).phase(*map(np.array, pixel)) / 65536
        found = set()
        for at in np.ndindex(self.exemplar.shape):
            times = (at - first) @ np.linalg.inv(vectors)
            if abs((times - np.rint(times)) @ vectors).max() <= reach:
                found.add(at)
        return found

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
