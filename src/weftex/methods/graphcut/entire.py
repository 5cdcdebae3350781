"""Entire patch matching and random placement (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Callable
from operator import call
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice, given_lattice
from weftex.methods.graphcut.placement import Matches, Patch, size_on
from weftex.methods.graphcut.sample import (
    Level,
    Sample,
    box_of,
    coarsest,
    in_full_size,
    levels_of,
    on_levels,
)
from weftex.methods.pixels import Growth
from weftex.raster.arrays import fast_size
from weftex.repeats import Offsets, Penalty
from weftex.search.translation import Spectra, overlap_mismatch

_AROUND = 32  # pixels around a hole that are matched, or half as many as it is wide
_DRIFT = 16  # in photos a tile lies up to 1/16 of its shorter side off the lattice
_MOST = 4.0  # pixels, at most
_LEAST = 0.75  # pixels, so that there is a whole one at each multiple of the vectors
_UNIT = 1 << 16  # of `CanvasLattice.phase`


class EntirePatchMatching:
    """The entire sample is shifted over the canvas, to where it matches or, `random`, anywhere.

    `lattice` limits the shifts to multiples of its vectors. `copy` is the number of an oriented
    copy, `copies` that of all.
    """

    def __init__(
        self,
        sample: Sample,
        growth: Growth,
        *,
        random: bool = False,
        lattice: tuple[float, ...] | None = None,
        copy: int = 0,
        penalty: Penalty | None = None,
    ) -> None:
        self.growth, self.canvas, self.random, self.copy = growth, growth.canvas, random, copy
        self.usable = sample.windows.usable
        self.size = size_on(growth.canvas, sample.windows.shape)
        self.reduction = sample.reduction_for(self.size, self.usable)
        self.levels = sample.levels(self.reduction)
        self.penalty = penalty
        self._spectra: dict[int, Spectra] = {}
        self._on_canvas = Level(growth.pixels, growth.done)
        # How far the sample reaches from a pixel that it covers, in whole pixels of all levels.
        self._reach = [-(-(n - 1) // self.reduction) * self.reduction for n in self.usable.shape]
        self._holes = holes_of(growth)
        self._lattice = None
        if lattice:
            self._lattice = CanvasLattice(lattice, self.canvas, VISIBLE_STRAIN)
            shortest = min(np.hypot(*vector) for vector in given_lattice(lattice).reduced().vectors)
            self._drift = min(max(float(shortest) / _DRIFT, _LEAST), _MOST)

    def matches(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> Matches:
        """See `Placement.matches`."""
        pixel = self.in_hole(pixel)
        if self.penalty is not None:
            self.penalty.next_patch(pixel)
        return self.match(pixel, centered, map_)

    def in_hole(self, pixel: tuple[int, int]) -> tuple[int, int]:
        """The nearest pixel in the rows and columns of the hole."""
        y, x = (min(max(at, a), b - 1) for at, (a, b) in zip(pixel, self._holes, strict=True))
        return y, x

    def match(
        self,
        pixel: tuple[int, int],
        centered: bool,
        map_: Callable[..., Any] = map,
        halvings: int | None = None,
    ) -> Matches:
        """Match all offsets, on the given level or the coarsest one that can be."""
        # Eighths of the sample that cover the pixel. With fewer, little of it overlaps the canvas,
        # and it matches worse; with more, it covers little that is missing.
        low, high = (2, 6) if centered else (2, 4) if self.penalty is None else (1, 6)
        middle = np.zeros_like(self.usable)
        rows, columns = (slice(n * low // 8, n * high // 8 + 1) for n in self.usable.shape)
        middle[rows, columns] = self.usable[rows, columns]
        boxes = levels_of(box_of(self._on_canvas, *self._lines(pixel)), self.reduction)
        places = self._allowed(pixel, middle, bool(boxes[0].mask.any()))
        k = coarsest(boxes, places) if halvings is None else halvings
        allowed = places[k] != 0
        costs, factors = np.zeros(allowed.shape), np.ones(allowed.shape)
        if not self.random:

            def mismatch() -> NDArray[np.float64]:
                return self._mismatch(boxes[k], allowed, k)

            def penalty() -> NDArray[np.float64]:
                if self.penalty is None:
                    return factors
                return self.penalty.of(Offsets(pixel, allowed, k, copy=self.copy))

            costs, factors = map_(call, (mismatch, penalty))

        def patches(drawn: list[tuple[int, int]], map_: Callable[..., Any]) -> list[Patch]:
            full = in_full_size(drawn, boxes[: k + 1], self.levels, places, self._reach, map_)
            return self._clipped(pixel, full, [float(factors[place]) for place in drawn])

        return Matches(costs, factors, allowed, k, patches)

    def _allowed(
        self, pixel: tuple[int, int], middle: NDArray[np.uint8], near: bool
    ) -> list[NDArray[np.uint8]]:
        """The pixels of the sample that may lie on the pixel, on all levels.

        In the middle where that is possible, and on the lattice, or `near` it too.
        """
        if self._lattice is not None:
            on = self._on_lattice(self._lattice, pixel, self._drift if near else _LEAST)
            for some in (middle, self.usable):
                if (found := on & (some != 0)).any():
                    return on_smaller(found, len(self.levels))
        return on_levels(middle if middle.any() else self.usable, self.levels)

    def _on_lattice(
        self, lattice: CanvasLattice, pixel: tuple[int, int], most: float
    ) -> NDArray[np.bool_]:
        """Mark the pixels that lattice shifts lead to a pixel of the canvas, `most` pixels off."""
        first = lattice.phase(*np.add(pixel, self.canvas.origin)) / _UNIT
        y, x = (np.arange(n) - at for n, at in zip(self.usable.shape, first, strict=True))
        rest = []  # of multiples of the vectors
        for down, along in np.linalg.inv(lattice.sample).T:
            times = np.add.outer(down * y, along * x)
            rest.append(times - np.rint(times))
        off = [one * rest[0] + other * rest[1] for one, other in lattice.sample.T]
        found: NDArray[np.bool_] = (abs(off[0]) <= most) & (abs(off[1]) <= most)
        return found

    def _lines(self, pixel: tuple[int, int]) -> list[NDArray[np.int32]]:
        """The rows and columns that the sample may cover with this pixel, -1 beyond the canvas."""
        lines = []
        for at, reach, (low, high), n, wraps in zip(
            pixel, self._reach, self._holes, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = np.arange(at - reach, at + reach + self.reduction)
            around = max((high - low) // 2, _AROUND)
            low, high = max(low - around, 0), min(high + around, n)
            line = line % n if wraps else np.where((line >= low) & (line < high), line, -1)
            lines.append(line.astype(np.int32))
        return lines

    def _mismatch(self, box: Level, allowed: NDArray[np.bool_], k: int) -> NDArray[np.float64]:
        """C(t) over the overlap, for each pixel of the sample that may come to lie on this one.

        Sums of products by FFT (section 5).
        """
        level = self.levels[k]
        size = [fast_size(n) for n in box.mask.shape]
        if k not in self._spectra:  # boxes of a level have one size
            self._spectra[k] = level.spectra_of(size)
        both = overlap_mismatch(box.spectra_of(size), self._spectra[k])
        # Place (0, 0) of the corner has the last pixel within reach on this one.
        rows, columns = (reach >> k for reach in self._reach)
        total, area = (
            a[: rows + 1, : columns + 1][::-1, ::-1][: allowed.shape[0], : allowed.shape[1]]
            for a in both
        )
        costs: NDArray[np.float64] = total / np.maximum(area, 1)
        if area[allowed].any():  # the sample might lie apart from everything
            costs[area == 0] = np.inf
        return costs

    def _clipped(
        self, pixel: tuple[int, int], found: list[tuple[int, int]], factors: list[float]
    ) -> list[Patch]:
        """The part of the sample that is on the canvas if these pixels of it lie on this one."""
        tops, lengths, sources = [], [], []
        for p, at, side, size, (low, high), wraps in zip(
            pixel, np.array(found).reshape(-1, 2).T, self.usable.shape, self.size, self._holes,
            self.canvas.wrap, strict=True,
        ):  # fmt: skip
            start = p - at
            if wraps:
                first = np.maximum(start, p - size // 2)
                last = np.minimum(start + side, first + size)
            else:
                first, last = np.maximum(start, low), np.minimum(start + side, high)
            tops.append(first)
            lengths.append(last - first)
            sources.append(first - start)
        boxes = (part.tolist() for part in (*tops, *lengths, *sources))
        return [Patch(*box) for box in zip(*boxes, factors, strict=True)]


def holes_of(growth: Growth) -> list[tuple[int, int]]:
    """Rows and columns that are missing or may change: the first, and one after the last.

    They and their surroundings are matched, not all of a photo with a hole.
    """
    canvas, missing = growth.canvas, growth.done == 0
    if canvas.shown is not None and canvas.hole is not None:
        missing |= canvas.hole
    holes = []
    for axis, (n, wraps) in enumerate(zip(canvas.shape, canvas.wrap, strict=True)):
        some = np.flatnonzero(missing.any(axis=1 - axis))
        all_ = wraps or not len(some)
        holes.append((0, n) if all_ else (int(some[0]), int(some[-1]) + 1))
    return holes


def on_smaller(places: NDArray[np.bool_], count: int) -> list[NDArray[np.uint8]]:
    """Levels of a mask, each half as large: 1 where one of four pixels is; whole squares only."""
    copies = [places.view(np.uint8)]
    while len(copies) < count:
        rows, columns = (n // 2 * 2 for n in copies[-1].shape)
        either = copies[-1][:rows:2, :columns] | copies[-1][1:rows:2, :columns]
        copies.append(either[:, ::2] | either[:, 1::2])
    return copies


class OrientedMatching:
    """Entire patch matching where the sample is a picture of copies: each patch is of one copy."""

    def __init__(self, sample: Sample, growth: Growth, penalty: Penalty | None) -> None:
        self.boxes, self.penalty = sample.boxes, penalty
        self.ways = [
            EntirePatchMatching(sample.part(box), growth, copy=number, penalty=penalty)
            for number, box in enumerate(self.boxes)
        ]
        # Quarter turns of a sample that is not square have other sides.
        height, width = (max(sides) for sides in zip(*(way.size for way in self.ways), strict=True))
        self.size, self.reduction = (height, width), self.ways[0].reduction
        self.levels = self.ways[0].levels

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

        def patches(drawn: list[tuple[int, int]], map_: Callable[..., Any]) -> list[Patch]:
            return self._in_copies(found, tops[:-1].tolist(), drawn, map_)

        return Matches(costs, factors, allowed, least, patches)

    def _in_copies(
        self,
        found: list[Matches],
        tops: list[int],
        drawn: list[tuple[int, int]],
        map_: Callable[..., Any],
    ) -> list[Patch]:
        """The patches of drawn offsets, the matches of each copy from row `tops` on."""
        which = np.searchsorted(tops, [y for y, _ in drawn], side="right") - 1
        patches: dict[tuple[int, int], Patch] = {}
        for k, (top, left, _, _) in enumerate(self.boxes):
            own = [at for at, of in zip(drawn, which, strict=True) if of == k]
            if not own:
                continue
            cut = found[k].patches([(y - tops[k], x) for y, x in own], map_)
            for at, patch in zip(own, cut, strict=True):
                corner = {"source_top": patch.source_top + top}
                patches[at] = patch._replace(**corner, source_left=patch.source_left + left)
        return [patches[at] for at in drawn]
