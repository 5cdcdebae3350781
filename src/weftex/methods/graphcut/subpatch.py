"""Sub-patch matching (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from weftex.random import draw
from weftex.raster.arrays import Bytes, Mask
from weftex.raster.boxes import box_sums
from weftex.repeats.salience import SaliencePenalty
from weftex.search.fft_mismatch import window_mismatch
from weftex.search.windows import windows_of

_MOST_PIXELS = 2**20  # of a sample that is searched as a whole
_PART = 2**19  # pixels of the part of a larger one that is searched
_CONTINUING = 16  # a patch that lies 1/16 of itself off the place that continues, continues too


class Part(NamedTuple):
    """The part of the sample that a patch is looked for in."""

    top: int
    left: int
    corners: list[Bytes]  # of each level: 1 where the patch's corner may lie
    levels: list[Level]  # so large that patches at all corners are whole


class Arranged(NamedTuple):
    """A sample arranged for patches of one size."""

    corners: Bytes  # 1 where a patch's upper left corner may lie
    reduction: int  # see `Placement`
    levels: list[Level]  # of the sample
    whole: Part


def arranged_for(sample: CutSample, size: tuple[int, int]) -> Arranged:
    """Arrange a sample for patches of a size."""
    height, width = sample.exemplar.shape
    windows = windows_of(sample.exemplar, (0, size[0] - 1, 0, size[1] - 1))
    corners = windows.usable[:height, :width]
    reduction = sample.reduction_for(size, corners)
    # Windows at corners are whole, so all pixels count.
    levels = levels_of(Level(windows.pixels, np.ones_like(windows.usable)), reduction)
    whole = Part(0, 0, on_levels(corners, levels), levels)
    return Arranged(corners, reduction, sample.levels(reduction), whole)


class SubPatchMatching:
    """A patch of the canvas is looked for everywhere in the sample, coarse to fine.

    Of large samples each patch is looked for in a part of its own, drawn at random. Both are not in
    the paper. `overlap` is how far patches reach over the pixels before them.
    """

    def __init__(
        self,
        sample: CutSample,
        growth: Growth,
        patch_shape: tuple[int, int],
        overlap: int,
        penalty: SaliencePenalty | None = None,
        guiding: Guiding | None = None,
    ) -> None:
        self.exemplar, self.growth, self.canvas = sample.exemplar, growth, growth.canvas
        self.size = size_on(growth.canvas, patch_shape)
        self.overlap = [min(overlap, (n - 1) // 2) for n in self.size]
        if self.size not in sample.made:
            sample.made[self.size] = arranged_for(sample, self.size)
        self._arranged: Arranged = sample.made[self.size]
        self.reduction, self.levels = self._arranged.reduction, self._arranged.levels
        self.penalty, self.guiding = penalty, guiding
        if penalty is not None:
            penalty.covers = self.size
        self._on_canvas = Level(growth.pixels, growth.done)
        # Where the hole of a block of a plane ends.
        self._ends: list[int] | None = None
        if self.canvas.shown is not None:
            missing = self.canvas.shown < 0
            self._ends = [int(np.flatnonzero(missing.any(axis=1 - a))[-1]) + 1 for a in (0, 1)]
        # Height and width of the part of a large sample: one and a half patches or more.
        self._sides: list[int] | None = None
        shape = self.exemplar.shape
        if shape[0] * shape[1] > _MOST_PIXELS:
            self._starts = np.flatnonzero(self._arranged.corners)
            self._sides = [
                min(n, max(round(_PART**0.5), side * 3 // 2))
                for n, side in zip(shape, self.size, strict=True)
            ]

    def part(self, number: int) -> Part:
        """The part of the sample that the `number`-th patch is looked for in."""
        if self._sides is None:
            return self._arranged.whole
        # Around one of its corners, so that there is one.
        corners, sides = self._arranged.corners, self._sides
        bits = int(draw(self.growth.seed, "part of the sample", number)[()])
        place = divmod(int(self._starts[bits % len(self._starts)]), corners.shape[1])
        top, left = (
            min(max(at - (side - length) // 2, 0), n - side) // self.reduction * self.reduction
            for at, side, length, n in zip(place, sides, self.size, corners.shape, strict=True)
        )
        inside = np.zeros(sides, np.uint8)  # a patch must not hang over the part's border
        rows, columns = (side - n + 1 for side, n in zip(sides, self.size, strict=True))
        inside[:rows, :columns] = corners[top : top + rows, left : left + columns]
        levels = [
            level.part(top >> k, left >> k, sides[0] >> k, sides[1] >> k)
            for k, level in enumerate(self._arranged.whole.levels)
        ]
        return Part(top, left, on_levels(inside, levels), levels)

    def matches(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> Matches:
        """See `Placement.matches`."""
        part, (top, left) = self.part(number), self._corner(pixel, centered)
        y = ((top + np.arange(self.size[0])) % self.canvas.height).astype(np.int32)
        x = ((left + np.arange(self.size[1])) % self.canvas.width).astype(np.int32)
        box = box_of(self._on_canvas, y, x)
        if self.guiding is not None:  # what the guide does not ask for is to go
            box.mask[self.guiding.look(y, x) > self.guiding.price / 2] = 0
        boxes = levels_of(box, self.reduction)
        k = coarsest(boxes, part.corners)
        allowed, box, level = part.corners[k] != 0, boxes[k], part.levels[k]
        costs, factors = np.zeros(allowed.shape), np.ones(allowed.shape)
        if self.penalty is not None:
            here = np.s_[part.top >> k :, part.left >> k :]
            places = np.zeros_like(self._arranged.whole.corners[k], bool)
            places[here][: allowed.shape[0], : allowed.shape[1]] = allowed
            factors = self.penalty.of((top, left), [places], k)[0][here]
            factors = factors[: allowed.shape[0], : allowed.shape[1]]
        if box.mask.any():  # section 5
            total = window_mismatch(level.spectra, box.spectra_of(level.spectra.size))
            costs = total[: allowed.shape[0], : allowed.shape[1]] / int(box.mask.sum())
            if self.penalty is not None:
                apart = allowed & ~self._continuing(part, y, x, k)
                allowed = apart if apart.any() else allowed
        if self.guiding is not None:
            apart = self.guiding.mismatch(y, x, k)[part.top >> k :, part.left >> k :]
            apart = apart[: allowed.shape[0], : allowed.shape[1]]
            costs = costs + level.variance * apart

        def patches(drawn: list[tuple[int, int]], map_: Callable[..., Any]) -> list[Patch]:
            found = in_full_size(drawn, boxes[: k + 1], part.levels, part.corners, (0, 0))
            return [
                Patch(top, left, *self.size, part.top + v, part.left + u, float(factors[at]))
                for (v, u), at in zip(found, drawn, strict=True)
            ]

        return Matches(costs, factors, allowed, k, patches)

    def _corner(self, pixel: tuple[int, int], centered: bool) -> tuple[int, int]:
        """The upper left corner on the canvas of a patch that covers a pixel."""
        corner: list[int] = []
        for at, size, overlap, n, wraps in zip(
            pixel, self.size, self.overlap, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            first = at - (size // 2 if centered else overlap)
            if self._ends is not None and not centered:
                # The last patch ends as far beyond the hole as the first may begin before it.
                left = self._ends[len(corner)] - at + overlap
                first = at + -(-left // -(-left // (size - overlap))) - size
            corner.append(first if wraps else min(max(first, 0), n - size))
        return corner[0], corner[1]

    def _continuing(self, part: Part, y: NDArray[np.int32], x: NDArray[np.int32], k: int) -> Mask:
        """Offsets from which the patch would continue something in its box as the sample does."""
        sample, shape, step = self.exemplar.shape, part.corners[k].shape, 1 << k
        source = self.growth.source[np.ix_(y[::step], x[::step])]
        v, u = np.nonzero(source >= 0)
        sample_y, sample_x = np.divmod(source[v, u], sample[1])
        corners = [sample_y - v * step, sample_x - u * step]
        if self.exemplar.tileable:
            corners = [c % n for c, n in zip(corners, sample, strict=True)]
        near = [-(-(size // _CONTINUING) // step) for size in self.size]
        rows, columns = (
            (c - first + step // 2) // step + reach
            for c, first, reach in zip(corners, (part.top, part.left), near, strict=True)
        )
        height, width = (n + 2 * reach for n, reach in zip(shape, near, strict=True))
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        taken = np.zeros((height, width), bool)
        taken[rows[inside], columns[inside]] = True
        return box_sums(taken, *(2 * reach + 1 for reach in near)) > 0
