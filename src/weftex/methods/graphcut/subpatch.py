"""Sub-patch matching (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from operator import call
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.methods.graphcut.copies import Copy, box_of, copies_of, places_in_full
from weftex.methods.graphcut.kept import kept
from weftex.methods.graphcut.places import (
    Matches,
    Place,
    draw_matches,
    on_copies,
    sample_copies,
    size_on_canvas,
    smallest,
)
from weftex.methods.graphcut.repeats import Repeats
from weftex.random import draw
from weftex.raster.boxes import box_sums
from weftex.search.translation import window_mismatch
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

_MOST_PIXELS = 2**20  # of a sample that is searched as a whole
_PART = 2**19  # pixels of the part of a larger one that is searched
_CONTINUING = 16  # a patch that lies 1/16 of itself off the place that continues, continues too
_NEAR = 1  # patch; what is shown again within this distance costs
_MOST = 4.0  # times that a patch is shown already count; more are no worse
# What it costs to show all of a patch again once nearby, in line, anywhere as often as the mean.
_AGAIN = 1.0, 0.25, 0.25
_LOOK = 2  # pixels of the smallest copy; so many apart what is shown is looked at


class Part(NamedTuple):
    """The part of the sample that a patch is looked for in, in full size and on smaller copies."""

    top: int
    left: int
    corners: list[NDArray[np.uint8]]  # 1 where the patch's upper left corner may lie
    copies: list[Copy]


class Arranged(NamedTuple):
    """A sample arranged for patches of one size."""

    corners: NDArray[np.uint8]  # 1 where a patch's upper left corner may lie
    reduction: int  # see `Placement`
    copies: list[Copy]  # what is matched, so large that patches at all corners are whole
    sample: list[Copy]
    part: Part  # all of it


def arranged_for(settings: Settings, size: tuple[int, int]) -> Arranged:
    """Arrange a sample for patches of a size."""
    exemplar = settings.exemplar
    windows = windows_of(exemplar, (0, size[0] - 1, 0, size[1] - 1))
    corners = windows.usable[: exemplar.shape[0], : exemplar.shape[1]]
    reduction = settings.reduction_of(size, corners)
    whole = Copy(windows.pixels, np.ones_like(windows.usable))  # windows at corners are whole
    copies = copies_of(whole, reduction)
    part = Part(0, 0, on_copies(corners, copies), copies)
    return Arranged(corners, reduction, copies, sample_copies(settings, reduction), part)


class SubPatchMatching:
    """Sub-patch matching: a patch of the canvas is looked for everywhere in the sample.

    It is looked for on a small copy, and what was found there in larger ones. Of large samples each
    patch is looked for in a part of its own, drawn at random. Both are no ideas of the paper.
    """

    def __init__(self, settings: Settings, growth: Growth) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size = height, width = size_on_canvas(settings.patch_shape, growth)
        self.overlap = [min(settings.boundary_width, (n - 1) // 2) for n in self.size]
        exemplar = settings.exemplar
        arranged = kept(
            settings.windows,
            (*self.size, settings.halvings),
            lambda: arranged_for(settings, self.size),
        )
        self.corners, self.reduction = arranged.corners, arranged.reduction
        self.copies, self.sample = arranged.copies, arranged.sample
        self.on_canvas = Copy(growth.pixels, growth.done)
        # Where the hole of a block of a plane ends.
        self.ends: list[int] | None = None
        if self.canvas.shown is not None:
            missing = self.canvas.shown < 0
            self.ends = [int(np.flatnonzero(missing.any(axis=1 - a))[-1]) + 1 for a in (0, 1)]
        self.repeats: Repeats | None = None
        if settings.variety > 0:
            near = _NEAR * height, _NEAR * width
            self.repeats = Repeats(exemplar, growth, self.size, near, _LOOK * self.reduction)
        self.sides = exemplar.shape
        self.whole: Part | None = None
        if exemplar.shape[0] * exemplar.shape[1] <= _MOST_PIXELS:
            self.whole = arranged.part
        else:
            self.starts = np.flatnonzero(self.corners)
            self.sides = _sides_of_part(exemplar.shape, self.size)

    def part(self, number: int) -> Part:
        """The part of the sample that the `number`-th patch is looked for in."""
        if self.whole is not None:
            return self.whole
        # Around one of its places, so that there is one.
        bits = int(draw(self.growth.seed, "part of the sample", number)[()])
        place = divmod(int(self.starts[bits % len(self.starts)]), self.corners.shape[1])
        top, left = (
            min(max(at - (side - length) // 2, 0), n - side) // self.reduction * self.reduction
            for at, side, length, n in zip(
                place, self.sides, self.size, self.corners.shape, strict=True
            )
        )
        inside = np.zeros(self.sides, np.uint8)  # a patch must not hang over the part's border
        rows, columns = (side - n + 1 for side, n in zip(self.sides, self.size, strict=True))
        inside[:rows, :columns] = self.corners[top : top + rows, left : left + columns]
        copies = [
            copy.part(top >> k, left >> k, *(side >> k for side in self.sides))
            for k, copy in enumerate(self.copies)
        ]
        return Part(top, left, on_copies(inside, copies), copies)

    def candidates(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> list[Place]:
        """See `Placement.candidates`."""
        part, (top, left) = self.part(number), self._corner(pixel, centered)
        if self.repeats is not None:
            self.repeats.turn_to(top, left)
        y = ((top + np.arange(self.size[0])) % self.canvas.height).astype(np.int32)
        x = ((left + np.arange(self.size[1])) % self.canvas.width).astype(np.int32)
        boxes = copies_of(box_of(self.on_canvas, y, x), self.reduction)
        k = smallest(boxes, part.corners)
        allowed = part.corners[k] != 0
        costs, prices = np.zeros(allowed.shape), np.ones(allowed.shape)
        if boxes[k].mask.any():
            spectra, box = part.copies[k].spectra, boxes[k]
            rows, columns = (
                slice(first >> k, (first >> k) + n)
                for first, n in zip((part.top, part.left), allowed.shape, strict=True)
            )

            def mismatch() -> NDArray[np.float64]:  # section 5
                total = window_mismatch(spectra, box.spectra_of(spectra.size))
                return total[: allowed.shape[0], : allowed.shape[1]] / int(box.mask.sum())

            def price() -> NDArray[np.float64]:  # not in the paper
                if self.repeats is None:
                    return prices
                shown = self.repeats.shown(top, left, k)[:, rows, columns]
                return prices_of(self.settings, *shown, self.repeats.used(k)[rows, columns])

            costs, prices = map_(call, (mismatch, price))
            if self.repeats is not None:
                apart = allowed & ~self._continuing(part, y, x, k)
                allowed = apart if apart.any() else allowed
        matches = Matches(costs, prices, allowed, k)
        drawn = draw_matches(
            self.settings, self.growth.seed, number, matches, self.sample, self.size
        )
        found = places_in_full(drawn, boxes[: k + 1], part.copies, part.corners, (0, 0))
        return [
            Place(top, left, *self.size, part.top + v, part.left + u, float(prices[at]))
            for (v, u), at in zip(found, drawn, strict=True)
        ]

    def _corner(self, pixel: tuple[int, int], centered: bool) -> list[int]:
        """The upper left corner on the canvas of a patch that covers a pixel."""
        corner: list[int] = []
        for at, size, overlap, n, wraps in zip(
            pixel, self.size, self.overlap, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            first = at - (size // 2 if centered else overlap)
            if self.ends is not None and not centered:
                first = _evenly(at, self.ends[len(corner)], size, overlap)
            corner.append(first if wraps else min(max(first, 0), n - size))
        return corner

    def _continuing(
        self, part: Part, y: NDArray[np.int32], x: NDArray[np.int32], k: int
    ) -> NDArray[np.bool_]:
        """Places from which the patch would go on as something in its box does in the sample."""
        sample, shape, step = self.settings.exemplar.shape, part.corners[k].shape, 1 << k
        source = self.growth.source[np.ix_(y[::step], x[::step])]
        v, u = np.nonzero(source >= 0)
        sample_y, sample_x = np.divmod(source[v, u], sample[1])
        corners = [sample_y - v * step, sample_x - u * step]
        if self.settings.exemplar.tileable:
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


def prices_of(settings: Settings, *shown: NDArray[np.float64]) -> NDArray[np.float64]:
    """By what the costs of places are multiplied for what they show again: nearby, in line, at all.

    These are shares of the cost of a match, so a match that is clearly better is never given up.
    """
    prices = np.ones(shown[0].shape)
    for weight, each in zip(_AGAIN, shown, strict=True):
        prices += settings.variety * (weight * np.minimum(each, _MOST))
    return prices


def _sides_of_part(shape: tuple[int, int], patch: tuple[int, int]) -> tuple[int, int]:
    """Height and width of the part of a sample that is searched: one and a half patches or more."""
    height, width = (
        min(n, max(round(_PART**0.5), side * 3 // 2)) for n, side in zip(shape, patch, strict=True)
    )
    return height, width


def _evenly(at: int, end: int, size: int, overlap: int) -> int:
    """Where a patch begins, so that the last one ends as far beyond the hole as it may begin."""
    left = end - at + overlap
    count = -(-left // (size - overlap))
    return at + -(-left // count) - size
