"""Entire patches of a sample and its oriented copies; not in the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut.entire import EntirePatchMatching
from weftex.methods.graphcut.placement import Matches, Patch

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from weftex.methods.graphcut.sample import Sample
    from weftex.methods.pixels.growth import Growth
    from weftex.repeats import Penalty


class OrientedMatching:
    """Entire patch matching where the sample is a picture of copies: each patch is of one copy."""

    def __init__(self, sample: Sample, growth: Growth) -> None:
        self.boxes = sample.boxes
        self.ways = [
            EntirePatchMatching(sample.part(box), growth, copy=number)
            for number, box in enumerate(self.boxes)
        ]
        # Quarter turns of a sample that is not square have other sides.
        height, width = (max(sides) for sides in zip(*(way.size for way in self.ways), strict=True))
        self.size, self.reduction = (height, width), self.ways[0].reduction
        self.levels = self.ways[0].levels
        self.penalty: Penalty | None = None  # that of all ways, too

    def matches(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> Matches:
        """See `Placement.matches`; the offsets of all copies lie one under the other."""
        pixel = self.ways[0].in_hole(pixel)
        if self.penalty is not None:
            self.penalty.next_patch(pixel)
        found = [way.match(pixel, centered, map_) for way in self.ways]
        least = min(each.halvings for each in found)
        found = [
            each if each.halvings == least else way.match(pixel, centered, map_, least)
            for way, each in zip(self.ways, found, strict=True)
        ]
        tops = np.cumsum([0, *(len(each.allowed) for each in found)])
        shape = tops[-1], max(each.allowed.shape[1] for each in found)
        costs, factors, allowed = np.full(shape, np.inf), np.ones(shape), np.zeros(shape, bool)
        for top, each in zip(tops[:-1], found, strict=True):
            here = np.s_[top : top + each.allowed.shape[0], : each.allowed.shape[1]]
            costs[here], factors[here], allowed[here] = each.costs, each.factors, each.allowed
        return Matches(costs, factors, allowed, least, (found, tops[:-1].tolist()))

    def patches(
        self, matches: Matches, drawn: list[tuple[int, int]], map_: Callable[..., Any] = map
    ) -> list[Patch]:
        """See `Placement.patches`."""
        found, tops = matches.found
        which = np.searchsorted(tops, [y for y, _ in drawn], side="right") - 1
        patches: dict[tuple[int, int], Patch] = {}
        for k, (way, (top, left, _, _)) in enumerate(zip(self.ways, self.boxes, strict=True)):
            own = [at for at, of in zip(drawn, which, strict=True) if of == k]
            if not own:
                continue
            cut = way.patches(found[k], [(y - tops[k], x) for y, x in own], map_)
            for at, patch in zip(own, cut, strict=True):
                corner = {"source_top": patch.source_top + top}
                patches[at] = patch._replace(**corner, source_left=patch.source_left + left)
        return [patches[at] for at in drawn]
