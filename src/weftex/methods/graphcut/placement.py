"""Where patches come from: placement and matching (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from weftex.methods.graphcut.copies import Copy, box_of, copies_of, places_in_full
from weftex.methods.graphcut.draws import drawn_places
from weftex.methods.graphcut.repeats import Repeats
from weftex.notes import note
from weftex.random import draw
from weftex.raster.boxes import box_sums
from weftex.search.translation import fast_size, overlap_mismatch, window_mismatch
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

_MOST_PIXELS = 2**20  # of a sample that is searched as a whole
_PART = 2**19  # pixels of the part of a larger one that is searched
_CONTINUING = 16  # a patch that lies 1/16 of itself off the place that continues, continues too
_NEAR = 1  # patch; what is shown again within this distance costs
_MOST = 4.0  # times that a patch is shown already count; more are no worse
# Matches: what it costs to show all of a patch again once nearby, in line, and anywhere as often as
# the mean. Entire patches must not be shifted for that, or courses and boards break.
_AGAIN = {"subpatch": (1.0, 0.25, 0.25), "entire": (0.05, 0.025, 0.025)}
_AROUND = 32  # pixels around a hole that are matched, or half as many as it is wide
_LOOK = 2  # pixels of the smallest copy; so many apart what is shown is looked at


class Place(NamedTuple):
    """A box on the canvas, and the place in the sample of its upper left pixel."""

    top: int
    left: int
    height: int
    width: int
    source_top: int
    source_left: int
    price: float = 1.0  # by which the cost of its seam is multiplied for what it shows again


class Placement(Protocol):
    """A way to find places for patches."""

    size: tuple[int, int]  # height and width of a patch on this canvas, in pixels
    reduction: int  # how many times smaller the copies are that matches and cuts begin on

    def candidates(self, pixel: tuple[int, int], number: int, centered: bool) -> list[Place]:
        """Draw places for a patch, the `number`-th one, that covers a pixel (row, column).

        The pixel is in the middle of the patch if `centered`, else near its upper left corner.
        """


def placement_of(settings: Settings, growth: Growth) -> Placement:
    """Return the way that `settings.placement` names."""
    if settings.placement == "subpatch":
        return SubPatchMatching(settings, growth)
    return EntirePatchMatching(settings, growth, random=settings.placement == "random")


class Part(NamedTuple):
    """The part of the sample that a patch is looked for in, in full size and on smaller copies."""

    top: int
    left: int
    corners: list[NDArray[np.uint8]]  # 1 where the patch's upper left corner may lie
    copies: list[Copy]


class SubPatchMatching:
    """Sub-patch matching: a patch of the canvas is looked for everywhere in the sample.

    It is looked for on a small copy, and what was found there in larger ones. Of large samples each
    patch is looked for in a part of its own, drawn at random. Both are no ideas of the paper.
    """

    def __init__(self, settings: Settings, growth: Growth) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size = height, width = _size_on_canvas(settings.patch_shape, growth)
        self.overlap = [min(settings.boundary_width, (n - 1) // 2) for n in self.size]
        exemplar = settings.exemplar
        windows = windows_of(exemplar, (0, height - 1, 0, width - 1))
        self.corners = windows.usable[: exemplar.shape[0], : exemplar.shape[1]]
        self.reduction = settings.reduction_of(self.size, self.corners)
        whole = Copy(windows.pixels, np.ones_like(windows.usable))  # windows at corners are whole
        self.copies = copies_of(whole, self.reduction)
        self.sample = sample_copies(settings, self.reduction)
        self.on_canvas = Copy(growth.pixels, growth.done)
        self.repeats: Repeats | None = None
        if settings.variety > 0:
            near = _NEAR * height, _NEAR * width
            self.repeats = Repeats(exemplar, growth, self.size, near, _LOOK * self.reduction)
        self.sides = exemplar.shape
        self.whole: Part | None = None
        if exemplar.shape[0] * exemplar.shape[1] <= _MOST_PIXELS:
            self.whole = Part(0, 0, _on_copies(self.corners, self.copies), self.copies)
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
        return Part(top, left, _on_copies(inside, copies), copies)

    def candidates(self, pixel: tuple[int, int], number: int, centered: bool) -> list[Place]:
        """See `Placement.candidates`."""
        part, (top, left) = self.part(number), self._corner(pixel, centered)
        if self.repeats is not None:
            self.repeats.turn_to(top, left)
        y = ((top + np.arange(self.size[0])) % self.canvas.height).astype(np.int32)
        x = ((left + np.arange(self.size[1])) % self.canvas.width).astype(np.int32)
        boxes = copies_of(box_of(self.on_canvas, y, x), self.reduction)
        k = _smallest(boxes, part.corners)
        allowed = part.corners[k] != 0
        costs, prices = np.zeros(allowed.shape), np.ones(allowed.shape)
        if boxes[k].mask.any():
            spectra = part.copies[k].spectra
            total = window_mismatch(spectra, boxes[k].spectra_of(spectra.size))  # section 5
            costs = total[: allowed.shape[0], : allowed.shape[1]] / int(boxes[k].mask.sum())
            if self.repeats is not None:  # not in the paper
                rows, columns = (first >> k for first in (part.top, part.left))
                shown = self.repeats.shown(top, left, k)[:, rows:, columns:]
                shown = shown[:, : allowed.shape[0], : allowed.shape[1]]
                used = self.repeats.used(k)[rows:, columns:]
                used = used[: allowed.shape[0], : allowed.shape[1]]
                prices = prices_of(self.settings, *shown, used)
                apart = allowed & ~self._continuing(part, y, x, k)
                allowed = apart if apart.any() else allowed
        spread = self.settings.tolerance * variance_of(self.sample[: k + 1])
        draws = self.growth.seed, number, self.settings.candidates
        size = tuple(n >> k for n in self.size)
        drawn = drawn_places(costs * prices, allowed, spread, draws, size)
        note("matches", costs=costs, prices=prices, allowed=allowed, drawn=drawn, halvings=k)
        found = places_in_full(drawn, boxes[: k + 1], part.copies, part.corners, (0, 0))
        return [
            Place(top, left, *self.size, part.top + v, part.left + u, float(prices[at]))
            for (v, u), at in zip(found, drawn, strict=True)
        ]

    def _corner(self, pixel: tuple[int, int], centered: bool) -> list[int]:
        """The upper left corner on the canvas of a patch that covers a pixel."""
        corner = []
        for at, size, overlap, n, wraps in zip(
            pixel, self.size, self.overlap, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            first = at - (size // 2 if centered else overlap)
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


class EntirePatchMatching:
    """Entire patch matching, or random placement: the sample is shifted over the canvas."""

    def __init__(self, settings: Settings, growth: Growth, *, random: bool) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size, self.random = _size_on_canvas(settings.patch_shape, growth), random
        self.usable = settings.windows.usable
        self.reduction = settings.reduction_of(self.size, self.usable)
        self.copies = sample_copies(settings, self.reduction)
        self.on_canvas = Copy(growth.pixels, growth.done)
        shape = settings.exemplar.shape
        # How far the sample reaches from a pixel that it covers, in whole pixels of all copies.
        self.reach = [-(-(n - 1) // self.reduction) * self.reduction for n in shape]
        # What is missing, and what around it is matched: not all of a photo that has a hole.
        missing = growth.done == 0
        self.holes = [
            (0, n) if wraps else _ends(missing.any(axis=1 - axis))
            for axis, (n, wraps) in enumerate(zip(self.canvas.shape, self.canvas.wrap, strict=True))
        ]
        self.repeats: Repeats | None = None
        if settings.variety > 0 and not random:
            near = shape[0] // 2, shape[1] // 2
            self.repeats = Repeats(settings.exemplar, growth, shape, near, _LOOK * self.reduction)

    def candidates(self, pixel: tuple[int, int], number: int, centered: bool) -> list[Place]:
        """See `Placement.candidates`."""
        y, x = (
            min(max(at, low), high - 1) for at, (low, high) in zip(pixel, self.holes, strict=True)
        )
        pixel = y, x
        if self.repeats is not None:
            self.repeats.turn_to(y, x)
        # Eighths of the sample that cover the pixel. With fewer, little of it is on what is there
        # already, and it matches worse; with more, it covers little that is missing.
        low, high = (2, 6) if centered else (2, 4) if self.repeats is None else (1, 6)
        middle = np.zeros_like(self.usable)
        rows, columns = (slice(n * low // 8, n * high // 8 + 1) for n in self.usable.shape)
        middle[rows, columns] = self.usable[rows, columns]
        places = _on_copies(middle if middle.any() else self.usable, self.copies)
        boxes = self._around(pixel)
        k = _smallest(boxes, places)
        allowed = places[k] != 0
        costs, prices = np.zeros(allowed.shape), np.ones(allowed.shape)
        if not self.random:
            costs = self._mismatch(boxes[k], allowed, k)
            if self.repeats is not None:
                shown = self.repeats.shown(*pixel, k)
                shown = shown[:, : allowed.shape[0], : allowed.shape[1]]
                # From the place of the box's corner to that of the pixel.
                first = [-(reach >> k) for reach in self.reach]
                used = self.repeats.used_where(self._missing(pixel, k), k, first)
                used = used[: allowed.shape[0], : allowed.shape[1]]
                prices = prices_of(self.settings, *shown, used)
        spread = self.settings.tolerance * variance_of(self.copies[: k + 1])
        draws = self.growth.seed, number, self.settings.candidates
        size = tuple(n >> k for n in self.size)
        drawn = drawn_places(costs * prices, allowed, spread, draws, size)
        note("matches", costs=costs, prices=prices, allowed=allowed, drawn=drawn, halvings=k)
        found = places_in_full(drawn, boxes[: k + 1], self.copies, places, self.reach)
        return [
            self._clipped(pixel, at, float(prices[place]))
            for at, place in zip(found, drawn, strict=True)
        ]

    def _around(self, pixel: tuple[int, int]) -> list[Copy]:
        """All of the canvas that the sample may cover with this pixel, and copies of it."""
        return copies_of(box_of(self.on_canvas, *self._lines(pixel)), self.reduction)

    def _lines(self, pixel: tuple[int, int]) -> list[NDArray[np.int32]]:
        """Its rows and columns on the canvas, -1 beyond it."""
        lines = []
        for at, reach, (low, high), n, wraps in zip(
            pixel, self.reach, self.holes, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = np.arange(at - reach, at + reach + self.reduction)
            around = max((high - low) // 2, _AROUND)
            low, high = max(low - around, 0), min(high + around, n)
            line = line % n if wraps else np.where((line >= low) & (line < high), line, -1)
            lines.append(line.astype(np.int32))
        return lines

    def _missing(self, pixel: tuple[int, int], k: int) -> NDArray[np.bool_]:
        """Which pixels of the k-th copy of that are missing."""
        rows, columns = (line[:: 1 << k] for line in self._lines(pixel))
        missing: NDArray[np.bool_] = self.growth.done[np.ix_(rows, columns)] == 0
        missing &= (rows >= 0)[:, None] & (columns >= 0)
        return missing

    def _mismatch(self, box: Copy, allowed: NDArray[np.bool_], k: int) -> NDArray[np.float64]:
        """C(t) over the overlap, for each pixel of the sample that may come to lie on this one."""
        size = [fast_size(n) for n in box.mask.shape]
        both = overlap_mismatch(box.spectra_of(size), self.copies[k].spectra_of(size))
        # Place (0, 0) of the corner has the last pixel within reach on this one.
        rows, columns = (reach >> k for reach in self.reach)
        total, area = (
            a[: rows + 1, : columns + 1][::-1, ::-1][: allowed.shape[0], : allowed.shape[1]]
            for a in both
        )
        costs: NDArray[np.float64] = total / np.maximum(area, 1)
        if area[allowed].any():  # the sample might lie apart from everything
            costs[area == 0] = np.inf
        return costs

    def _clipped(self, pixel: tuple[int, int], at: tuple[int, int], price: float) -> Place:
        """The part of the sample that is on the canvas if its pixel `at` lies on this one."""
        tops, lengths, sources = [], [], []
        for p, s, side, size, (low, high), wraps in zip(
            pixel, at, self.usable.shape, self.size, self.holes, self.canvas.wrap,
            strict=True,
        ):  # fmt: skip
            first, last = p - s, p - s + side
            if wraps:
                first = max(first, p - size // 2)
                last = min(last, first + size)
            else:
                first, last = max(first, low), min(last, high)
            tops.append(first)
            lengths.append(last - first)
            sources.append(first - (p - s))
        (top, left), (height, width), (y, x) = tops, lengths, sources
        return Place(top, left, height, width, y, x, price)


def sample_copies(settings: Settings, reduction: int) -> list[Copy]:
    """The sample and smaller copies."""
    return copies_of(Copy(settings.windows.pixels, settings.windows.usable), reduction)


def variance_of(copies: list[Copy]) -> float:
    """Variance of the sample, sigma**2, on the smallest of some copies that has a usable pixel."""
    return next(copy.variance for copy in reversed(copies) if copy.mask.any())


def _on_copies(places: NDArray[np.uint8], copies: list[Copy]) -> list[NDArray[np.uint8]]:
    """Those of the places that a smaller copy has, for each."""
    result = []
    for k, copy in enumerate(copies):
        height, width = copy.mask.shape
        result.append(np.ascontiguousarray(places[:: 1 << k, :: 1 << k][:height, :width]))
    return result


def _smallest(boxes: list[Copy], places: list[NDArray[np.uint8]]) -> int:
    """The smallest copy that has a place, and of the box whatever there is."""
    there = boxes[0].mask.any()
    return next(
        k
        for k in range(len(boxes) - 1, -1, -1)
        if places[k].any() and (boxes[k].mask.any() or not there)
    )


def prices_of(settings: Settings, *shown: NDArray[np.float64]) -> NDArray[np.float64]:
    """By what the costs of places are multiplied for what they show again: nearby, in line, at all.

    These are shares of the cost of a match, so a match that is clearly better is never given up.
    """
    prices = np.ones(shown[0].shape)
    for weight, each in zip(_AGAIN[settings.placement], shown, strict=True):
        prices += settings.variety * (weight * np.minimum(each, _MOST))
    return prices


def _ends(some: NDArray[np.bool_]) -> tuple[int, int]:
    """The first that is true, and one after the last; all if none is."""
    found = np.flatnonzero(some)
    return (int(found[0]), int(found[-1]) + 1) if len(found) else (0, len(some))


def _sides_of_part(shape: tuple[int, int], patch: tuple[int, int]) -> tuple[int, int]:
    """Height and width of the part of a sample that is searched: one and a half patches or more."""
    height, width = (
        min(n, max(round(_PART**0.5), side * 3 // 2)) for n, side in zip(shape, patch, strict=True)
    )
    return height, width


def _size_on_canvas(patch_shape: tuple[int, int], growth: Growth) -> tuple[int, int]:
    """The patch's size; around a wrapped axis it leaves something that it can be joined to."""
    canvas = growth.canvas
    height, width = (
        min(side, max(1, 2 * n // 3) if wraps else n)
        for side, n, wraps in zip(patch_shape, canvas.shape, canvas.wrap, strict=True)
    )
    return height, width
