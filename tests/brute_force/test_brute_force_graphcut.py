"""Graph cut: each cut costs what SciPy's maximum flow says, with old seams (sections 3 and 3.1)."""

import dataclasses

import numpy as np
import pytest

import weftex
from random_cases import random_canvas, random_cases, random_exemplar
from weftex.methods.graphcut.cutting import CutCanvas
from weftex.methods.graphcut.sample import CutSample
from weftex.reference.graphcut import NEW, OLD, Graph
from weftex.repeats.salience import SaliencePenalty
from weftex.search.windows import windows_of


def seam_cost(exemplar, gradients, step, label, pixel, other, other_pixel):
    """M(s, t, A, B) of eq. (1), or M' of section 5; labels are places of the sample, or None."""
    a_t = label and continued(exemplar, label, step)
    if a_t and a_t == other:
        return 0
    b_s = other and continued(exemplar, other, np.negative(step))
    sides = [(pixel, other_pixel, b_s), (other_pixel, pixel, a_t)]
    sides = [(here, there, exemplar.pixels[place]) for here, there, place in sides if place]
    cost = sum(abs(here - shown.astype(int)).sum() for here, _, shown in sides)
    across = sum(abs(there - shown.astype(int)).sum() for _, there, shown in sides)
    if len(sides) < 2:  # a patch ends here
        cost, across = (4 * cost, 2 * across) if sides else (4 * 255 * len(pixel), 0)
    return int(256 * cost // (across + 32 * len(pixel)) if gradients else cost)


def continued(exemplar, label, step):
    """The place of the sample beside one; None where there is none, or no usable one."""
    place = label[0] + step[0], label[1] + step[1]
    if exemplar.tileable:
        place = place[0] % exemplar.shape[0], place[1] % exemplar.shape[1]
    inside = 0 <= place[0] < exemplar.shape[0] and 0 <= place[1] < exemplar.shape[1]
    return tuple(map(int, place)) if inside and exemplar.mask[place] else None


def pairs_of(shape, wrap):
    """All neighbors of a canvas, as (pixel, pixel, step)."""
    for y, x in np.ndindex(shape):
        for step in ((0, 1), (1, 0)):
            v, u = y + step[0], x + step[1]
            if (v < shape[0] or wrap[0]) and (u < shape[1] or wrap[1]):
                yield (y, x), (v % shape[0], u % shape[1]), step


def least_cost(arcs):
    """The value of the minimum cut between the terminals, by the reference."""
    graph = Graph()
    for arc in arcs:
        graph.join(*arc)
    side = graph.new_side()
    new = [node in side for node in graph.numbers]
    return sum(capacity for i, j, capacity in graph.arcs if new[i] and not new[j])


@random_cases(10)
@pytest.mark.parametrize("placement", ["subpatch", "entire"])
def test_each_cut_is_a_minimum_cut(rng, placement, monkeypatch):
    """On every canvas; of costs by gradients, which are no metric, none is worse than before."""
    exemplar = random_exemplar(rng, *rng.integers(14, 18, 2))
    canvas = random_canvas(rng, *rng.integers(20, 26, 2))
    gradients = bool(rng.integers(2))
    kind = {"placement": placement, "halvings": 0, "candidates": 2}
    kind |= {"refinements": float(rng.choice([0, 0.5])), "tolerance": 0.1}
    guide = None
    if placement == "subpatch":
        if rng.integers(2):  # labels that are asked for
            own = rng.integers(0, 3, exemplar.shape, np.uint8)
            own[-1, :3], guide = (0, 1, 2), rng.integers(0, 3, canvas.shape, np.uint8)
            exemplar = exemplar.changed(guide=own)
            canvas = dataclasses.replace(canvas, guide=guide)
            usual = CutSample(exemplar, windows_of(exemplar, (0, 0, 0, 0)), gradients, 0).usual_cost
        kind |= {"patch_size": int(rng.integers(5, 12)), "boundary_width": 2}
    method = weftex.GraphCut(seam_cost="gradient" if gradients else "difference", **kind)
    compared = []

    def paste(self, patch):
        """Cut a patch, and compare with all that might have been made of its box."""
        shape, growth = self.shape, self.growth
        before, done = growth.source.copy(), growth.done.copy() > 0
        pixels = growth.pixels.astype(int)
        fixed = done & ~canvas.hole if canvas.hole is not None else np.zeros(shape, bool)
        covered = whole(self, patch)
        new, price, sample = {}, {}, exemplar.shape

        def label(source, p):
            return divmod(int(source[p]), sample[1]) if source[p] >= 0 else None

        for v, u in np.ndindex(patch.height, patch.width):
            place = (patch.source_top + v) % sample[0], (patch.source_left + u) % sample[1]
            p = (patch.top + v) % shape[0], (patch.left + u) % shape[1]
            if exemplar.mask[place] and not fixed[p]:
                new[p], price[p] = place, 0
                if self.penalty is not None:
                    price[p] = int(prices[-1][v // self.penalty.cell, u // self.penalty.cell])
                if guide is not None:
                    shown = label(before, p)
                    wrong = [at and exemplar.guide[at] != guide[p] for at in (place, shown)]
                    price[p] += round(2 * usual) * (bool(wrong[0]) - bool(wrong[1]))

        def cost(step, p, q, old_p, old_q):
            """What it costs that p, and q, are old or not."""
            ends = []
            for at, old in ((p, old_p), (q, old_q)):
                place = label(before, at) if old else new[at]
                ends += [place, exemplar.pixels[place].astype(int) if place else pixels[at]]
            return seam_cost(exemplar, gradients, step, *ends)

        node = {
            p: (p if p in new else OLD) if done[p] else NEW
            for p in [*new, *zip(*np.nonzero(done), strict=True)]
        }
        # Not in the paper: what a pixel repeats has a price, if it becomes new.
        arcs = [(p, OLD if price[p] > 0 else NEW, abs(price[p])) for p in new if done[p]]
        always = sum(min(price[p], 0) if done[p] else price[p] for p in new)
        made, metric = (
            sum(
                price[p]
                for p in new
                if label(growth.source, p) == new[p]
                and (not done[p] or growth.source[p] != before[p] or price[p] < 0)
            ),
            True,
        )
        after = growth.source
        for p, q, step in pairs_of(shape, canvas.wrap):
            if p not in node or q not in node or (p not in new and q not in new) or p == q:
                continue
            is_new = [
                k in new and label(after, k) == new[k] and (not done[k] or after[k] != before[k])
                for k in (p, q)
            ]
            made += 0 if all(is_new) else cost(step, p, q, not is_new[0], not is_new[1])
            if node[p] == node[q] == NEW:
                continue
            both = cost(step, p, q, True, True) if done[p] and done[q] else 0
            a = cost(step, p, q, True, False) if done[p] and q in new else 0
            b = cost(step, p, q, False, True) if p in new and done[q] else 0
            if (p, q) == (node[p], node[q]) and (both or a != b):  # Fig. 3: a seam node
                arcs += [(p, (p, q), a), ((p, q), q, b), ((p, q), NEW, both)]
            elif node[p] == NEW or node[q] == NEW:
                arcs.append((node[p], node[q], a + b))
            elif q in new and p in new:
                arcs.append((p, q, a))
            else:
                inner, change = (p, b) if p in new else (q, a)
                arcs += [(inner, OLD, change), (inner, NEW, both)]
            metric &= abs(a - b) <= both <= a + b or (p, q) != (node[p], node[q])
        least = least_cost(arcs) + always
        compared.append(made)
        assert made >= least
        if metric and not gradients:
            assert made == least
        return covered

    def recorded(self, *patch):
        prices.append(priced(self, *patch))
        return prices[-1]

    whole, priced, prices = CutCanvas.paste, SaliencePenalty.prices, []
    monkeypatch.setattr(SaliencePenalty, "prices", recorded)
    monkeypatch.setattr(CutCanvas, "paste", paste)
    method.fit(exemplar).sample(canvas, seed=int(rng.integers(100)))
    assert compared
