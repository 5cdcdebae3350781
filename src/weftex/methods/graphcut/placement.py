"""Where patches come from (Kwatra et al., 2003, section 4): matching, and drawing of matches."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.random import draw
from weftex.raster.boxes import box_sums
from weftex.search.translation import (
    Spectra,
    fast_size,
    overlap_mismatch,
    window_mismatch,
)
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.graphcut import GraphCut
    from weftex.methods.pixels.growth import Growth
    from weftex.search.windows import Windows

_FAR = 64.0  # e**-64 is no chance at all
_CHANCES = 2.0**32  # of the best match
_APART = 16  # candidates lie more than this part of a patch from each other
_THIN = 4  # every fourth pixel, both ways, tells what is shown nearby


class Place(NamedTuple):
    """A box on the canvas, and where in the sample its corner comes from."""

    top: int
    left: int
    height: int
    width: int
    source_top: int
    source_left: int


class Places:
    """Places for patches; drawn by P(t) = exp(-C(t) / (k sigma**2)), equation (5).

    Attributes
    ----------
    size : tuple of int
        Height and width of the patches, in pixels.
    """

    size: tuple[int, ...]

    def __init__(
        self, method: GraphCut, exemplar: Exemplar, windows: Windows, growth: Growth
    ) -> None:
        self.method, self.exemplar, self.growth = method, exemplar, growth
        self.canvas, self.seed = growth.canvas, growth.seed
        self.levels, self.usable = windows.pixels, windows.usable
        self.spread = method.tolerance * variance(self.levels[self.usable != 0])

    def draw(self, pixel: tuple[int, int], number: int, mend: bool) -> list[Place]:
        """Candidates for a patch that covers a pixel.

        Parameters
        ----------
        pixel : (int, int)
            On the canvas.
        number : int
            Of the patch, for the random bits.
        mend : bool
            The pixel is to be in the middle of the patch; otherwise `boundary_width` from the
            upper and left side.
        """
        raise TypeError(f"{type(self).__name__} does not define draw")

    def drawn(
        self, costs: NDArray[np.float64], allowed: NDArray[np.bool_], number: int
    ) -> list[tuple[int, int]]:
        """Draw candidates that are not next to each other, as (row, column) of `costs`."""
        chances = np.where(allowed, chances_of(costs, allowed, self.spread), 0)
        bits = draw(self.seed, "patch", number, np.arange(self.method.candidates))
        reach = [length // _APART for length in self.size]
        found: list[tuple[int, int]] = []
        for bit in bits:
            sums = chances.ravel().cumsum()
            if not sums[-1]:
                break
            at = int(sums.searchsorted(int(bit) % int(sums[-1]), side="right"))
            y, x = divmod(at, chances.shape[1])
            found.append((y, x))
            chances[max(y - reach[0], 0) : y + reach[0] + 1][
                :, max(x - reach[1], 0) : x + reach[1] + 1
            ] = 0
        return found


class PlacesOfPatches(Places):
    """Sub-patch matching: a patch of the canvas is looked for everywhere in the sample."""

    def __init__(
        self, method: GraphCut, exemplar: Exemplar, windows: Windows, growth: Growth
    ) -> None:
        super().__init__(method, exemplar, windows, growth)
        side, boundary = method.patch_size, method.boundary_width
        assert side is not None and boundary is not None
        # Around a wrapped axis a patch leaves something that it can be joined to.
        self.size = tuple(
            min(side, max(1, 2 * n // 3) if wraps else n)
            for n, wraps in zip(self.canvas.shape, self.canvas.wrap, strict=True)
        )
        self.overlap = [min(boundary, (n - 1) // 2) for n in self.size]
        height, width = self.size
        corners = windows_of(exemplar, (0, height - 1, 0, width - 1))
        self.corners = corners.usable[: exemplar.shape[0], : exemplar.shape[1]] != 0
        tiles = exemplar.tileable
        self.transform = tuple(n if tiles else fast_size(n) for n in exemplar.shape)
        self.spectra = Spectra(self.levels, self.usable, self.transform)

    def draw(self, pixel: tuple[int, int], number: int, mend: bool) -> list[Place]:
        """See `Places.draw`."""
        top, left = (
            at - (size // 2 if mend else overlap)
            if wraps
            else min(max(at - (size // 2 if mend else overlap), 0), n - size)
            for at, size, overlap, n, wraps in zip(
                pixel, self.size, self.overlap, self.canvas.shape, self.canvas.wrap, strict=True
            )
        )
        y = (top + np.arange(self.size[0])) % self.canvas.height
        x = (left + np.arange(self.size[1])) % self.canvas.width
        there = self.growth.done[np.ix_(y, x)]
        costs, allowed = np.zeros(self.corners.shape), self.corners
        if there.any():
            if self.method.variety > 0:
                allowed = self.corners & ~self.continuing(y, x)
                allowed = allowed if allowed.any() else self.corners
            box = Spectra(self.growth.levels[np.ix_(y, x)], there, self.transform)
            total = window_mismatch(self.spectra, box)
            costs = total[: costs.shape[0], : costs.shape[1]] / int(there.sum())
            if self.method.variety > 0:
                costs = self.varied(costs, top, left)
        drawn = self.drawn(costs, allowed, number)
        return [Place(top, left, self.size[0], self.size[1], y, x) for y, x in drawn]

    def continuing(self, y: NDArray[np.int64], x: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Places from which the patch would go on as something in its box does in the sample."""
        source = self.growth.source[np.ix_(y, x)]
        v, u = np.nonzero(source >= 0)
        sample_y, sample_x = np.divmod(source[v, u], self.exemplar.shape[1])
        near = [size // _APART for size in self.size]
        corners = [sample_y - v, sample_x - u]
        if self.exemplar.tileable:
            corners = [c % n for c, n in zip(corners, self.exemplar.shape, strict=True)]
        rows, columns = (c + k for c, k in zip(corners, near, strict=True))
        height, width = (n + 2 * k for n, k in zip(self.exemplar.shape, near, strict=True))
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        taken = np.zeros((height, width), bool)
        taken[rows[inside], columns[inside]] = True
        return box_sums(taken, *(2 * k + 1 for k in near)) > 0

    def varied(self, costs: NDArray[np.float64], top: int, left: int) -> NDArray[np.float64]:
        """Add to the cost of a place in the sample for what of it is shown nearby.

        All of a patch shown once adds, at a variety of 1, the cost of the best match among the
        half of the places that are shown least: what is good enough in this material.
        """
        around = []
        for start, size, n, wraps in zip(
            (top, left), self.size, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            lines = np.arange(start - size, start + 2 * size, _THIN)
            around.append(lines[:n] % n if wraps else lines[(lines >= 0) & (lines < n)])
        source = self.growth.source[np.ix_(*around)].ravel()
        shown = np.bincount(source[source >= 0], minlength=self.usable.size)
        shown = shown.reshape(self.exemplar.shape)
        beyond = [(0, size - 1) for size in self.size]
        shown = box_sums(np.pad(shown, beyond, mode="wrap"), *self.size)
        seen = shown[self.corners]
        median = np.partition(seen, len(seen) // 2)[len(seen) // 2]
        good = float(costs[self.corners][seen <= median].min())
        once = self.size[0] * self.size[1] / _THIN**2
        result: NDArray[np.float64] = costs + shown * (self.method.variety * good / once)
        return result


class PlacesOfSample(Places):
    """Entire patch matching, or random placement: the sample is shifted over the canvas."""

    def __init__(
        self, method: GraphCut, exemplar: Exemplar, windows: Windows, growth: Growth
    ) -> None:
        super().__init__(method, exemplar, windows, growth)
        self.size = tuple(
            min(side, max(1, 2 * n // 3) if wraps else n)
            for side, n, wraps in zip(
                exemplar.shape, self.canvas.shape, self.canvas.wrap, strict=True
            )
        )
        self.reach = [n - 1 for n in exemplar.shape]
        self.transform = tuple(fast_size(2 * n + 1) for n in self.reach)
        self.spectra = Spectra(self.levels, self.usable, self.transform)

    def draw(self, pixel: tuple[int, int], number: int, mend: bool) -> list[Place]:
        """See `Places.draw`."""
        height, width = self.exemplar.shape
        low, high = (1, 3) if mend else (1, 2)  # quarters of the sample that cover the pixel
        allowed = np.zeros((height, width), bool)
        allowed[
            height * low // 4 : height * high // 4 + 1, width * low // 4 : width * high // 4 + 1
        ] = True
        allowed &= self.usable != 0
        if not allowed.any():
            allowed = self.usable != 0
        costs = np.zeros((height, width))
        if self.method.placement == "entire":
            costs = self.mismatch(pixel, allowed)
        return [self.clipped(pixel, at) for at in self.drawn(costs, allowed, number)]

    def mismatch(self, pixel: tuple[int, int], allowed: NDArray[np.bool_]) -> NDArray[np.float64]:
        """C(t) of equation (4), for the sample's pixel that comes to lie on this one."""
        around, inside = [], []
        for at, reach, n, wraps in zip(
            pixel, self.reach, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = np.arange(at - reach, at + reach + 1)
            inside.append((line >= 0) & (line < n) | wraps)
            around.append(line % n)
        there = self.growth.done[np.ix_(*around)] * np.outer(*inside)
        canvas = Spectra(self.growth.levels[np.ix_(*around)], there, self.transform)
        total, area = overlap_mismatch(canvas, self.spectra)
        # Place (0, 0) of the corner has the sample's last pixel on this one.
        total, area = (
            a[: self.reach[0] + 1, : self.reach[1] + 1][::-1, ::-1] for a in (total, area)
        )
        costs: NDArray[np.float64] = total / np.maximum(area, 1)
        if area[allowed].any():  # the sample might lie apart from everything
            costs[area == 0] = np.inf
        return costs

    def clipped(self, pixel: tuple[int, int], at: tuple[int, int]) -> Place:
        """The sample with its pixel `at` on this one, as far as it is on the canvas."""
        tops, lengths, sources = [], [], []
        for p, s, side, size, n, wraps in zip(
            pixel,
            at,
            self.exemplar.shape,
            self.size,
            self.canvas.shape,
            self.canvas.wrap,
            strict=True,
        ):
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


def variance(pixels: NDArray[np.uint8]) -> float:
    """Variance of pixels (N, K), all channels together, from exact sums."""
    total = [int(k) for k in pixels.sum(axis=0, dtype=np.int64)]
    squares = sum(int(np.square(k, dtype=np.int64).sum()) for k in pixels.T)
    count = len(pixels)
    return (count * squares - sum(t * t for t in total)) / (count * count)


def chances_of(
    costs: NDArray[np.float64], allowed: NDArray[np.bool_], spread: float
) -> NDArray[np.int64]:
    """Whole numbers in proportion to exp(-cost / spread).

    exp(x) is taken as (1 + x / 1024)**1024, which every machine rounds alike.
    """
    above: NDArray[np.float64] = np.maximum(costs - costs[allowed].min(), 0)
    if spread > 0:
        power = 1 + np.minimum(above / spread, _FAR) / 1024
        for _ in range(10):
            power *= power
        return np.asarray(_CHANCES / power, np.int64)
    return np.asarray(above == 0, np.int64)
