"""Graph-cut textures (Kwatra, Schödl, Essa, Turk and Bobick, 2003) as a whole."""

from __future__ import annotations

import functools

import numpy as np

from twins.graphcut_placement import Placing
from twins.maxflow import least_labelling
from twins.windows import ARCS, beside, usable

REACH = 2  # blocks


class GraphCutTwin(Placing):
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
        # These are asked for again and again.
        self.seam, self.places = functools.cache(self.seam), functools.cache(self.places)
        self.reduction = functools.cache(self.reduction)

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
        cost, slope = 1020 * channels, 0
        if costs:  # where one of both ends
            more = [1, 1] if len(costs) == 2 else [4, 2]
            cost, slope = (int(sum(part)) * n for part, n in zip((costs, steep), more, strict=True))
        return (
            256 * cost // (slope + 32 * channels) if self.method.seam_cost == "gradient" else cost
        )

    def choices(self, box, patch):
        """What each pixel of a box may be: old (0), new (1) or both."""
        may = {}
        for cell, at in zip(box, patch, strict=True):
            old = self.label[cell] is not None
            replaceable = self.usable[at] and not (old and cell in self.known)
            may[cell] = (0,) * old + (1,) * bool(replaceable)
        return may

    def cut(self, box, patch, block=1, may=None):
        """Which pixels a patch replaces, what seams cost then, and before: SciPy's minimum cut.

        `box` lists the pixels of the canvas, `patch` for each of them that of the sample. Pixels
        that may be both are in blocks, all of which are old or new.
        """
        new = dict(zip(box, patch, strict=True))
        may = may or self.choices(box, patch)
        free = [cell for cell in box if len(may[cell]) == 2]
        blocks = dict.fromkeys(self.block(box, cell, block) for cell in free)
        blocks = {key: i for i, key in enumerate(blocks)}
        number = {cell: blocks[self.block(box, cell, block)] for cell in free}
        # cost = constant + sum of unary[i] * x_i + sum of arc[i, j] * x_i * (1 - x_j)
        constant, unary, arc, before = 0, [0] * len(blocks), {}, 0
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
                if len(may[p]) == 2 or len(of_q) == 2:
                    before += table.get((0, 0), 0)
                both = len(may[p]) == 2 and len(of_q) == 2
                if both:
                    table[1, 0] = max(table[1, 0], table[0, 0] - table[0, 1])
                    constant += table[0, 0]
                    unary[number[p]] += table[1, 0] - table[0, 0]
                    unary[number[q]] += table[1, 1] - table[1, 0]
                    key = number[q], number[p]
                    weight = table[0, 1] + table[1, 0] - table[0, 0] - table[1, 1]
                    if key[0] != key[1]:
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
        return side, value + constant, before

    def block(self, box, cell, block):
        """Row and column of the block that a pixel of a box is in."""
        row, column = divmod(box.index(cell), self.columns)
        return row // block, column // block

    def narrowed(self, box, may, side, block):
        """Both is for pixels of blocks within `REACH` of where old and new meet; outside is old."""
        shown = {}
        for cell, new in zip(box, side, strict=True):
            key = self.block(box, cell, block)
            shown[key] = shown.get(key, set()) | ({int(new)} if may[cell] else set())
        result = {}
        for cell, new in zip(box, side, strict=True):
            row, column = self.block(box, cell, block)
            near = set()
            for i in range(row - REACH, row + REACH + 1):
                for j in range(column - REACH, column + REACH + 1):
                    near |= shown.get((i, j), {0})
            result[cell] = may[cell] if near == {0, 1} or len(may[cell]) < 2 else (int(new),)
        return result

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

    # The whole

    def lay(self, pixel, mend):
        best = None
        kind = self.patches if self.method.placement == "subpatch" else self.samples
        block = self.reduction()
        for box, patch, columns, price in kind(pixel, mend):
            self.columns = columns
            _, after, before = self.cut(box, patch, block)
            missing = sum(may == (1,) for may in self.choices(box, patch).values())
            cost = (after - before) / max(missing, 1)
            cost = cost * price if cost > 0 else cost / price
            if best is None or cost < best[0]:
                best = cost, box, patch, columns
        _, box, patch, self.columns = best
        may, block = self.choices(box, patch), max(1, block // 2)
        side, *_ = self.cut(box, patch, block)
        while block > 1:
            may = self.narrowed(box, may, side, block)
            block = max(1, block // 4)
            side, *_ = self.cut(box, patch, block, may)
        for cell, at, new in zip(box, patch, side, strict=True):
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
