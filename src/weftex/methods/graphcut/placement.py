"""Where patches come from: placement and matching (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from weftex.random import draw
from weftex.raster.boxes import box_sums
from weftex.search.translation import Spectra, fast_size, overlap_mismatch, window_mismatch
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

_LARGEST_EXPONENT = 64.0  # e**-64 is no chance at all
_BEST_CHANCE = 2.0**32  # the chance of the best match, as a whole number
_APART = 16  # candidates lie more than 1/16 of a patch from each other
_MOST_PIXELS = 2**20  # of a sample that is searched as a whole
_PART = 2**19  # pixels of the part of a larger one that is searched
_SHOWN_STEP = 4  # every fourth pixel, both ways, is looked at for places that are shown nearby


class Place(NamedTuple):
    """A box on the canvas, and the place in the sample of its upper left pixel."""

    top: int
    left: int
    height: int
    width: int
    source_top: int
    source_left: int


class Placement(Protocol):
    """A way to find places for patches."""

    size: tuple[int, int]  # height and width of a patch on this canvas, in pixels

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
    """The part of the sample that a patch is looked for in."""

    top: int
    left: int
    corners: NDArray[np.bool_]  # where the patch's upper left corner may lie
    spectra: Spectra


class SubPatchMatching:
    """Sub-patch matching: a patch of the canvas is looked for everywhere in the sample.

    Transforms of large samples take seconds and gigabytes. There each patch is looked for in a part
    of its own, drawn at random, which is no idea of the paper.
    """

    def __init__(self, settings: Settings, growth: Growth) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size = _size_on_canvas(settings.patch_shape, growth)
        height, width = self.size
        self.overlap = [min(settings.boundary_width, (n - 1) // 2) for n in self.size]
        exemplar = settings.exemplar
        corners = windows_of(exemplar, (0, height - 1, 0, width - 1))
        self.corners = corners.usable[: exemplar.shape[0], : exemplar.shape[1]] != 0
        self.sides = exemplar.shape
        if exemplar.shape[0] * exemplar.shape[1] <= _MOST_PIXELS:
            tiles = exemplar.tileable
            transform = tuple(n if tiles else fast_size(n) for n in exemplar.shape)
            self.whole: Part | None = self._part(0, 0, exemplar.shape, transform)
        else:
            self.whole = None
            self.starts = np.flatnonzero(self.corners)
            self.sides = _sides_of_part(exemplar.shape, self.size)

    def _part(
        self, top: int, left: int, shape: tuple[int, int], transform: tuple[int, ...]
    ) -> Part:
        windows, (rows, columns) = self.settings.windows, shape
        here = np.s_[top : top + rows, left : left + columns]
        spectra = Spectra(windows.pixels[here], windows.usable[here], transform)
        return Part(top, left, self.corners[here], spectra)

    def part(self, number: int) -> Part:
        """The part of the sample that the `number`-th patch is looked for in."""
        if self.whole is not None:
            return self.whole
        # Around one of its places, so that there is one.
        bits = int(draw(self.growth.seed, "part of the sample", number)[()])
        place = divmod(int(self.starts[bits % len(self.starts)]), self.corners.shape[1])
        top, left = (
            min(max(at - (side - length) // 2, 0), n - side)
            for at, side, length, n in zip(
                place, self.sides, self.size, self.corners.shape, strict=True
            )
        )
        part = self._part(top, left, self.sides, tuple(fast_size(n) for n in self.sides))
        inside = np.zeros_like(part.corners)  # a patch must not hang over the part's border
        rows, columns = (side - n + 1 for side, n in zip(self.sides, self.size, strict=True))
        inside[:rows, :columns] = part.corners[:rows, :columns]
        return part._replace(corners=inside)

    def candidates(self, pixel: tuple[int, int], number: int, centered: bool) -> list[Place]:
        """See `Placement.candidates`."""
        settings, part = self.settings, self.part(number)
        top, left = self._corner(pixel, centered)
        y = (top + np.arange(self.size[0])) % self.canvas.height
        x = (left + np.arange(self.size[1])) % self.canvas.width
        there = self.growth.done[np.ix_(y, x)]
        allowed, (rows, columns) = part.corners, part.corners.shape
        costs = np.zeros((rows, columns))
        if there.any():
            box = Spectra(self.growth.pixels[np.ix_(y, x)], there, part.spectra.size)
            total = window_mismatch(part.spectra, box)  # C(t), by FFT as in section 5
            costs = total[:rows, :columns] / int(there.sum())
            if settings.variety > 0:  # not in the paper
                costs = self._varied(part, costs, top, left)
                apart = part.corners & ~self._continuing(part, y, x)
                allowed = apart if apart.any() else part.corners
        drawn = drawn_places(costs, allowed, settings, self.growth.seed, number, self.size)
        return [Place(top, left, *self.size, part.top + y, part.left + x) for y, x in drawn]

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
        self, part: Part, y: NDArray[np.int64], x: NDArray[np.int64]
    ) -> NDArray[np.bool_]:
        """Places from which the patch would go on as something in its box does in the sample."""
        sample, shape = self.settings.exemplar.shape, part.corners.shape
        source = self.growth.source[np.ix_(y, x)]
        v, u = np.nonzero(source >= 0)
        sample_y, sample_x = np.divmod(source[v, u], sample[1])
        corners = [sample_y - v - part.top, sample_x - u - part.left]
        if self.settings.exemplar.tileable:
            corners = [c % n for c, n in zip(corners, sample, strict=True)]
        near = [size // _APART for size in self.size]
        rows, columns = (c + k for c, k in zip(corners, near, strict=True))
        height, width = (n + 2 * k for n, k in zip(shape, near, strict=True))
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        taken = np.zeros((height, width), bool)
        taken[rows[inside], columns[inside]] = True
        return box_sums(taken, *(2 * k + 1 for k in near)) > 0

    def _varied(
        self, part: Part, costs: NDArray[np.float64], top: int, left: int
    ) -> NDArray[np.float64]:
        """Add to the cost of each place in the sample for its pixels that are shown nearby.

        All of a patch shown once adds, at a variety of 1, the cost of the best match among the half
        of the places that are shown least: a cost that is good enough in this material.
        """
        around = []
        for start, size, n, wraps in zip(
            (top, left), self.size, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            lines = np.arange(start - size, start + 2 * size, _SHOWN_STEP)
            around.append(lines[:n] % n if wraps else lines[(lines >= 0) & (lines < n)])
        source = self.growth.source[np.ix_(*around)].ravel()
        rows, columns = part.corners.shape
        y, x = np.divmod(source[source >= 0], self.settings.exemplar.shape[1])
        y, x = y - part.top, x - part.left
        inside = (y >= 0) & (y < rows) & (x >= 0) & (x < columns)
        places = y[inside] * columns + x[inside]
        shown = np.bincount(places, minlength=rows * columns).reshape(rows, columns)
        shown = np.pad(shown, [(0, size - 1) for size in self.size], mode="wrap")
        shown = box_sums(shown, *self.size)
        seen = shown[part.corners]
        median = np.partition(seen, len(seen) // 2)[len(seen) // 2]
        good = float(costs[part.corners][seen <= median].min())
        once = self.size[0] * self.size[1] / _SHOWN_STEP**2
        result: NDArray[np.float64] = costs + shown * (self.settings.variety * good / once)
        return result


class EntirePatchMatching:
    """Entire patch matching, or random placement: the sample is shifted over the canvas."""

    def __init__(self, settings: Settings, growth: Growth, *, random: bool) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size, self.random = _size_on_canvas(settings.patch_shape, growth), random
        self.usable = settings.windows.usable != 0
        self.reach = [n - 1 for n in settings.patch_shape]
        self.transform = tuple(fast_size(2 * n + 1) for n in self.reach)
        self.spectra = Spectra(settings.windows.pixels, self.usable, self.transform)

    def candidates(self, pixel: tuple[int, int], number: int, centered: bool) -> list[Place]:
        """See `Placement.candidates`."""
        height, width = self.usable.shape
        low, high = (1, 3) if centered else (1, 2)  # quarters of the sample that cover the pixel
        allowed = np.zeros((height, width), bool)
        allowed[
            height * low // 4 : height * high // 4 + 1, width * low // 4 : width * high // 4 + 1
        ] = True
        allowed &= self.usable
        if not allowed.any():
            allowed = self.usable
        costs = np.zeros((height, width)) if self.random else self._mismatch(pixel, allowed)
        seed = self.growth.seed
        drawn = drawn_places(costs, allowed, self.settings, seed, number, self.size)
        return [self._clipped(pixel, at) for at in drawn]

    def _mismatch(self, pixel: tuple[int, int], allowed: NDArray[np.bool_]) -> NDArray[np.float64]:
        """C(t) over the overlap, for each pixel of the sample that may come to lie on this one."""
        around, inside = [], []
        for at, reach, n, wraps in zip(
            pixel, self.reach, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = np.arange(at - reach, at + reach + 1)
            inside.append((line >= 0) & (line < n) | wraps)
            around.append(line % n)
        there = self.growth.done[np.ix_(*around)] * np.outer(*inside)
        canvas = Spectra(self.growth.pixels[np.ix_(*around)], there, self.transform)
        total, area = overlap_mismatch(canvas, self.spectra)
        # Place (0, 0) of the corner has the sample's last pixel on this one.
        total, area = (
            a[: self.reach[0] + 1, : self.reach[1] + 1][::-1, ::-1] for a in (total, area)
        )
        costs: NDArray[np.float64] = total / np.maximum(area, 1)
        if area[allowed].any():  # the sample might lie apart from everything
            costs[area == 0] = np.inf
        return costs

    def _clipped(self, pixel: tuple[int, int], at: tuple[int, int]) -> Place:
        """The part of the sample that is on the canvas if its pixel `at` lies on this one."""
        tops, lengths, sources = [], [], []
        for p, s, side, size, n, wraps in zip(
            pixel, at, self.usable.shape, self.size, self.canvas.shape, self.canvas.wrap,
            strict=True,
        ):  # fmt: skip
            first, last = p - s, p - s + side
            if wraps:
                first = max(first, p - size // 2)
                last = min(last, first + size)
            else:
                first, last = max(first, 0), min(last, n)
            tops.append(first)
            lengths.append(last - first)
            sources.append(first - (p - s))
        return Place(*tops, *lengths, *sources)


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


def drawn_places(
    costs: NDArray[np.float64],
    allowed: NDArray[np.bool_],
    settings: Settings,
    seed: int,
    number: int,
    size: tuple[int, int],
) -> list[tuple[int, int]]:
    """Draw places by P(t), proportional to exp(-C(t) / (k * sigma**2)), not next to each other.

    Returns (row, column) of `costs` for each candidate.
    """
    chances = np.where(allowed, chances_of(costs, allowed, settings.spread), 0)
    found: list[tuple[int, int]] = []
    for bits in draw(seed, "patch", number, np.arange(settings.candidates)):
        sums = chances.ravel().cumsum()
        if not sums[-1]:
            break
        at = int(sums.searchsorted(int(bits) % int(sums[-1]), side="right"))
        y, x = divmod(at, chances.shape[1])
        found.append((y, x))
        near_y, near_x = (length // _APART for length in size)
        chances[max(y - near_y, 0) : y + near_y + 1, max(x - near_x, 0) : x + near_x + 1] = 0
    return found


def chances_of(
    costs: NDArray[np.float64], allowed: NDArray[np.bool_], spread: float
) -> NDArray[np.int64]:
    """Whole numbers in proportion to exp(-cost / spread).

    exp(x) is taken as (1 + x / 1024)**1024, which every machine rounds alike.
    """
    above: NDArray[np.float64] = np.maximum(costs - costs[allowed].min(), 0)
    if spread > 0:
        power = 1 + np.minimum(above / spread, _LARGEST_EXPONENT) / 1024
        for _ in range(10):
            power *= power
        return np.asarray(_BEST_CHANCE / power, np.int64)
    return np.asarray(above == 0, np.int64)
