"""Entire patch matching and random placement (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import call
from typing import Any, NamedTuple

import numpy as np

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice, first_place, given_lattice
from weftex.analysis.rows import rows_around
from weftex.guides import Guiding
from weftex.methods.graphcut.placement import Matches, Patch, size_on
from weftex.methods.graphcut.sample import (
    CutSample,
    Level,
    box_of,
    coarsest,
    in_full_size,
    levels_of,
    on_levels,
)
from weftex.methods.pixels import Growth
from weftex.raster.arrays import Bytes, Floats, Mask, fast_size, stacked
from weftex.raster.boxes import AROUND, Hole, holes_in, nearest_hole, smaller_masks
from weftex.repeats.salience import SaliencePenalty
from weftex.search.fft_mismatch import Spectra, overlap_mismatch

_DRIFT = 16  # in photos a tile lies up to 1/16 of its shorter side off the lattice
_MOST = 4.0  # pixels, at most
_LEAST = 0.75  # pixels, so that there is a whole one at each multiple of the vectors
_OVER, _OFF = 6, 1  # units of `RowMap`: patches exceed their row, for cuts, and may lie off it
_UNIT = 1 << 16  # of `CanvasLattice.phase`
#: What is around a pixel, by the shape of the copies that may cover it: the pyramid of a box, and
#: how far the pixel is from its corner, in whole pixels of all levels.
Around = dict[tuple[int, int], tuple[list[Level], list[int]]]


class Copy(NamedTuple):
    """The sample, or one of its oriented copies."""

    corner: tuple[int, int]  # where it lies in the picture of copies
    shape: tuple[int, int]
    levels: list[Level]
    reach: list[int]  # from a pixel that it covers, in whole pixels of all levels
    places: dict[bool, list[Bytes]]  # that may lie on a pixel, centered there or not


class EntirePatchMatching:
    """The entire sample is shifted over the canvas, to where it matches or, `random`, anywhere.

    Of a picture of oriented copies each patch is one copy, but for `random`. `lattice` limits the
    shifts of a sample without copies to multiples of its vectors. Placement `rows` keeps rows whole
    if any are found, or continues them in holes; in endless textures it is as `entire`.
    """

    guiding: Guiding | None = None

    def __init__(
        self,
        sample: CutSample,
        growth: Growth,
        placement: str,
        lattice: tuple[float, ...] | None = None,
        penalty: SaliencePenalty | None = None,
    ) -> None:
        self.canvas, self.random = growth.canvas, placement == "random"
        boxes = [] if self.random else sample.boxes
        parts = [sample.part(box) for box in boxes] or [sample]
        sizes = [size_on(growth.canvas, part.windows.shape) for part in parts]
        # Quarter turns of a sample that is not square have other sides.
        self.size = max(y for y, _ in sizes), max(x for _, x in sizes)
        both = zip(parts, sizes, strict=True)
        self.reduction = min(part.reduction_for(n, part.windows.usable) for part, n in both)
        self.copies: list[Copy] = []
        self._alike: dict[tuple[int, int], list[Copy]] = {}  # the copies of each shape
        for part, box in zip(parts, boxes or [(0, 0, 0, 0)], strict=True):
            shape, levels = part.windows.usable.shape, part.levels(self.reduction)
            reach = [-(-(n - 1) // self.reduction) * self.reduction for n in shape]
            self.copies.append(Copy(box[:2], shape, levels, reach, {}))
            self._alike.setdefault(shape, []).append(self.copies[-1])
        self.levels, self.penalty = self.copies[0].levels, penalty
        self._spectra: dict[tuple[tuple[int, int], int], Spectra] = {}
        self._on_canvas = Level(growth.pixels, growth.done)
        self._holes = np.array(holes_of(growth))
        self._lattice = self._rows = None
        if placement == "rows":
            self._rows = rows_around(sample.windows.pixels, sample.windows.usable, self.canvas)
            if self.canvas.shown is None and not growth.done.any() and sample.boards is not None:
                self._rows = sample.boards.row_map(self.canvas, growth.seed)
        if lattice:
            self._lattice = CanvasLattice(lattice, self.canvas, VISIBLE_STRAIN)
            shortest = min(np.hypot(*vector) for vector in given_lattice(lattice).reduced().vectors)
            self._drift = min(max(float(shortest) / _DRIFT, _LEAST), _MOST)
            self._first = first_place(self.canvas, growth.seed)

    def matches(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> Matches:
        """See `Placement.matches`; the offsets of all copies lie one under the other."""
        # The nearest pixel in the rows and columns of the hole.
        ends = nearest_hole(self._holes, pixel)
        y, x = (min(max(p, a), b - 1) for p, (a, b) in zip(pixel, ends, strict=True))
        boxes = {shape: self._around((y, x), some[0].reach) for shape, some in self._alike.items()}
        places = [self._allowed(copy, (y, x), centered, boxes) for copy in self.copies]
        both = zip(self.copies, places, strict=True)
        k = min(coarsest(boxes[copy.shape][0], some) for copy, some in both)
        allowed = [some[k] != 0 for some in places]
        costs = [np.zeros(some.shape) for some in allowed]
        factors = [np.ones(some.shape) for some in allowed]
        if not self.random:
            jobs: list[Callable[[], Any]] = [partial(self._mismatch, boxes, allowed, k)]
            jobs += [partial(self.penalty.of, (y, x), allowed, k)] if self.penalty else []
            costs, *penalties = map_(call, jobs)
            factors = next(iter(penalties), factors)
        tops = [0, *np.cumsum([len(some) for some in allowed]).tolist()]

        def patches(drawn: list[tuple[int, int]], map_: Callable[..., Any]) -> list[Patch]:
            found: dict[tuple[int, int], Patch] = {}
            for n, copy in enumerate(self.copies):
                own = [at for at in drawn if tops[n] <= at[0] < tops[n + 1]]
                if not own:
                    continue
                here = [(v - tops[n], u) for v, u in own]
                levels, reach = boxes[copy.shape]
                full = in_full_size(here, levels[: k + 1], copy.levels, places[n], reach, map_)
                cut = self._clipped(copy, (y, x), full, [float(factors[n][at]) for at in here])
                found |= zip(own, cut, strict=True)
            return [found[at] for at in drawn]

        return Matches(
            stacked(costs, np.inf), stacked(factors, 1.0), stacked(allowed, False), k, patches
        )

    def _allowed(
        self, copy: Copy, pixel: tuple[int, int], centered: bool, boxes: Around
    ) -> list[Bytes]:
        """The pixels of a copy that may lie on the pixel, on all levels.

        In the middle if possible; on its line if there are rows; on or near the lattice.
        """
        if self._lattice is None and self._rows is None and centered in copy.places:
            return copy.places[centered]
        # The pixel lies `low` to `high` eighths of a copy's sides from its corner. Less: little of
        # it overlaps the canvas, and it matches worse. More: it covers little that is missing.
        low, high = (2, 6) if centered else (2, 4) if self.penalty is None else (1, 6)
        if self._rows is not None and self.canvas.hole is not None:
            low, high = 0, 8  # any that lies on the same line
        usable = copy.levels[0].mask
        middle = np.zeros_like(usable)
        parts = [slice(n * low // 8, n * high // 8 + 1) for n in copy.shape]
        if self._rows is not None:
            parts[self._rows.axis] = self._rows.sources(pixel, _OFF)
        middle[*parts] = usable[*parts]
        if self._rows is not None:
            return smaller_masks(middle != 0, len(copy.levels))
        if self._lattice is not None:
            near = self._drift if boxes[copy.shape][0][0].mask.any() else _LEAST
            on = self._on_lattice(self._lattice, copy.shape, pixel, near)
            for some in (middle, usable):
                if (found := on & (some != 0)).any():
                    return smaller_masks(found, len(copy.levels))
        copy.places[centered] = on_levels(middle if middle.any() else usable, copy.levels)
        return copy.places[centered]

    def _on_lattice(
        self, lattice: CanvasLattice, shape: tuple[int, int], pixel: tuple[int, int], most: float
    ) -> Mask:
        """Mark the pixels that lattice shifts lead to a pixel of the canvas, `most` pixels off."""
        first = lattice.phase(*np.add(pixel, self._first)) / _UNIT
        y, x = (np.arange(n) - at for n, at in zip(shape, first, strict=True))
        rest = []  # of multiples of the vectors
        for down, along in np.linalg.inv(lattice.sample).T:
            times = np.add.outer(down * y, along * x)
            rest.append(times - np.rint(times))
        off = [one * rest[0] + other * rest[1] for one, other in lattice.sample.T]
        found: Mask = (abs(off[0]) <= most) & (abs(off[1]) <= most)
        return found

    def _limits(self, pixel: tuple[int, int], over: int) -> list[tuple[int, int, bool]]:
        """Lines that patches on a pixel may cover, `over` units beyond a row; whether they wrap."""
        both = zip(nearest_hole(self._holes, pixel), self.canvas.wrap, strict=True)
        limits = [(*ends, wraps) for ends, wraps in both]
        if self._rows is not None and self.canvas.hole is None:
            limits[self._rows.axis] = self._rows.limits(pixel, over)
        return limits

    def _around(self, pixel: tuple[int, int], reaches: list[int]) -> tuple[list[Level], list[int]]:
        """All that a copy may cover with this pixel."""
        lines, before, limits, step = [], [], self._limits(pixel, 0), self.reduction
        for at, reach, n, (low, high, wraps) in zip(
            pixel, reaches, self.canvas.shape, limits, strict=True
        ):
            around = max((high - low) // 2, AROUND)
            around *= self._rows is None or self.canvas.hole is not None  # none of other rows
            low, high = max(low - around, 0), min(high + around, n)
            first, last = (at - reach, at + reach) if wraps else (low, high)
            before.append(min(-(-(at - first) // step) * step, reach))
            # The same length for all pixels of a hole, if the sample is not smaller.
            length = min(-(-(last - first) // step) * step, before[-1] + reach) + step
            line = np.arange(at - before[-1], at - before[-1] + length)
            line = line % n if wraps else np.where((line >= low) & (line < high), line, -1)
            lines.append(line.astype(np.int32))
        return levels_of(box_of(self._on_canvas, *lines), step), before

    def _mismatch(self, boxes: Around, allowed: list[Mask], k: int) -> list[Floats]:
        """C(t) over the overlap, for each pixel of each copy that may come to lie on this one.

        Sums of products by FFT (section 5).
        """
        found: list[Floats] = []
        for shape, alike in self._alike.items():
            box, levels = boxes[shape][0][k], [copy.levels[k] for copy in alike]
            sides = levels[0].mask.shape
            # None wraps around onto the box, which has at most `reach` pixels beyond this one.
            size = tuple(
                fast_size(min(n, (reach >> k) + 1) + side)
                for n, reach, side in zip(box.mask.shape, alike[0].reach, sides, strict=True)
            )
            spectra = self._spectra.get((shape, k))
            if spectra is None or spectra.size != size:  # the same for all pixels of a hole
                pixels = np.stack([x.pixels for x in levels])
                whole = Level(pixels, np.stack([x.mask for x in levels]))
                spectra = self._spectra[shape, k] = whole.spectra_of(size)
            totals, areas = overlap_mismatch(box.spectra_of(size), spectra)
            # Where the corner lies if each pixel of a copy lies on this one.
            ends = zip(boxes[shape][1], sides, size, strict=True)
            corners = np.ix_(*(((reach >> k) - np.arange(side)) % n for reach, side, n in ends))
            for total, area in zip(totals, areas, strict=True):
                total, area = total[corners], area[corners]
                costs = total / np.maximum(area, 1)
                # Where the sample lies apart from everything, only what it repeats counts.
                costs[area == 0] = np.inf if area[allowed[len(found)]].any() else 1.0
                found.append(costs)
        return found

    def _clipped(
        self, copy: Copy, pixel: tuple[int, int], found: list[tuple[int, int]], factors: list[float]
    ) -> list[Patch]:
        """The part of a copy that is on the canvas if these pixels of it lie on this one."""
        tops, lengths, sources = [], [], []
        for p, at, corner, side, size, (low, high, wraps) in zip(
            pixel, np.array(found).T, copy.corner, copy.shape, size_on(self.canvas, copy.shape),
            self._limits(pixel, _OVER), strict=True,
        ):  # fmt: skip
            start = p - at
            if wraps:
                low = p - size // 2
                high = np.maximum(start, low) + size
            first, last = np.maximum(start, low), np.minimum(start + side, high)
            tops.append(first)
            lengths.append(last - first)
            sources.append(first - start + corner)
        boxes = (part.tolist() for part in (*tops, *lengths, *sources))
        return [Patch(*box) for box in zip(*boxes, factors, strict=True)]


def holes_of(growth: Growth) -> list[Hole]:
    """The holes, or the entire canvas; a patch stays in one, and matches its surroundings."""
    canvas, missing = growth.canvas, growth.done == 0
    if canvas.shown is not None and canvas.hole is not None:
        missing |= canvas.hole
    found = holes_in(missing, canvas.wrap) if canvas.hole is not None else []
    return found or [[(0, n) for n in canvas.shape]]
