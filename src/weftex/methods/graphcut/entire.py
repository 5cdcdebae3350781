"""Entire patch matching and random placement (Kwatra et al., 2003, section 4)."""

from __future__ import annotations

from operator import call
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.methods.graphcut import match_kernels
from weftex.methods.graphcut.copies import Copy, box_of, copies_of, places_in_full
from weftex.methods.graphcut.places import (
    Matches,
    Place,
    draw_matches,
    on_copies,
    sample_copies,
    size_on_canvas,
    smallest,
)
from weftex.methods.graphcut.regular import LatticePlaces, on_smaller
from weftex.methods.graphcut.repeats import DIRECT
from weftex.methods.graphcut.shown import ShownAgain
from weftex.search.translation import fast_size, overlap_mismatch

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Protocol

    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

    class Prices(Protocol):
        """What it costs to show again what the canvas shows already; see `ShownAgain`."""

        def turn_to(self, pixel: tuple[int, int]) -> None:
            """Say which pixel the next patch covers; the one before is laid."""

        def of(
            self,
            pixel: tuple[int, int],
            allowed: NDArray[np.bool_],
            k: int,
            offset: list[int],
            missing: Callable[[], NDArray[np.bool_]],
        ) -> NDArray[np.float64]:
            """By what the costs of places are multiplied."""


_AROUND = 32  # pixels around a hole that are matched, or half as many as it is wide


class Found(NamedTuple):
    """How well places match that come to lie on a pixel of the canvas."""

    pixel: tuple[int, int]
    boxes: list[Copy]  # what the sample may cover there, in full size and on smaller copies
    places: list[NDArray[np.uint8]]  # of the sample, likewise
    matches: Matches


class EntirePatchMatching:
    """Entire patch matching, or random placement: the sample is shifted over the canvas.

    Parameters
    ----------
    settings, growth
        The sample and the canvas.
    random : bool
        Anywhere, whether it matches or not.
    prices : Prices, optional
        What it costs to show a place again, instead of `ShownAgain`.
    """

    def __init__(
        self, settings: Settings, growth: Growth, *, random: bool, prices: Prices | None = None
    ) -> None:
        self.settings, self.growth, self.canvas = settings, growth, growth.canvas
        self.size, self.random = size_on_canvas(settings.patch_shape, growth), random
        self.usable = settings.windows.usable
        self.reduction = settings.reduction_of(self.size, self.usable)
        self.copies = sample_copies(settings, self.reduction)
        self.on_canvas = Copy(growth.pixels, growth.done)
        shape = settings.windows.shape
        # How far the sample reaches from a pixel that it covers, in whole pixels of all copies.
        self.reach = [-(-(n - 1) // self.reduction) * self.reduction for n in shape]
        self.holes = holes_of(growth)
        self.regular = LatticePlaces(settings.lattice, self.canvas) if settings.lattice else None
        self.prices = prices
        if prices is None and settings.variety > 0 and not random:
            self.prices = ShownAgain(settings, growth, self.copies[0], self.holes, self.reduction)

    def candidates(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> list[Place]:
        """See `Placement.candidates`."""
        found = self.found(pixel, centered, map_)
        copies, seed = self.copies, self.growth.seed
        drawn = draw_matches(self.settings, seed, number, found.matches, copies, self.size)
        return self.placed(found, drawn, map_)

    def found(
        self,
        pixel: tuple[int, int],
        centered: bool,
        map_: Callable[..., Any] = map,
        halvings: int | None = None,
    ) -> Found:
        """Match all places; see `Placement.candidates`.

        On the copy that is halved `halvings` times, if that is given.
        """
        y, x = (
            min(max(at, low), high - 1) for at, (low, high) in zip(pixel, self.holes, strict=True)
        )
        pixel = y, x
        if self.prices is not None:
            self.prices.turn_to(pixel)
        # Eighths of the sample that cover the pixel. With fewer, little of it is on what is there
        # already, and it matches worse; with more, it covers little that is missing.
        low, high = (2, 6) if centered else (2, 4) if self.prices is None else (1, 6)
        middle = np.zeros_like(self.usable)
        rows, columns = (slice(n * low // 8, n * high // 8 + 1) for n in self.usable.shape)
        middle[rows, columns] = self.usable[rows, columns]
        boxes = self._around(pixel)
        places = self._places(pixel, middle, bool(boxes[0].mask.any()))
        k = smallest(boxes, places) if halvings is None else halvings
        allowed = places[k] != 0
        costs, prices = np.zeros(allowed.shape), np.ones(allowed.shape)
        if not self.random:

            def mismatch() -> NDArray[np.float64]:
                return self._mismatch(boxes[k], allowed, k)

            def price() -> NDArray[np.float64]:
                if self.prices is None:
                    return prices
                offset = [reach >> k for reach in self.reach]
                return self.prices.of(pixel, allowed, k, offset, lambda: self._missing(pixel, k))

            costs, prices = map_(call, (mismatch, price))
        return Found(pixel, boxes, places, Matches(costs, prices, allowed, k))

    def placed(
        self, found: Found, drawn: list[tuple[int, int]], map_: Callable[..., Any] = map
    ) -> list[Place]:
        """The patches of places that were drawn on a smaller copy."""
        pixel, boxes, places, (_, prices, _, k) = found
        full = places_in_full(drawn, boxes[: k + 1], self.copies, places, self.reach, map_)
        return self._clipped(pixel, full, [float(prices[place]) for place in drawn])

    def _places(
        self, pixel: tuple[int, int], middle: NDArray[np.uint8], near: bool
    ) -> list[NDArray[np.uint8]]:
        """Where in the sample the pixel may lie, in full size and on the smaller copies.

        In the middle where that is possible, and on the lattice, or `near` it too.
        """
        if self.regular is not None:
            on = self.regular.of(pixel, self.usable.shape, near=near)
            for some in (middle, self.usable):
                if (found := on & (some != 0)).any():
                    return on_smaller(found, len(self.copies))
        return on_copies(middle if middle.any() else self.usable, self.copies)

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
        copy = self.copies[k]
        if allowed.sum() * copy.mask.size <= DIRECT:
            direct = np.full(allowed.shape, np.inf)
            offset = np.array([reach >> k for reach in self.reach], np.int32)
            match_kernels.match_places(
                box.kernel, copy.kernel, allowed.view(np.uint8), offset, copy.all_count, direct
            )
            return direct if (direct < np.inf).any() else np.zeros(allowed.shape)
        size = [fast_size(n) for n in box.mask.shape]
        both = overlap_mismatch(box.spectra_of(size), copy.spectra_of(size))
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

    def _clipped(
        self, pixel: tuple[int, int], found: list[tuple[int, int]], prices: list[float]
    ) -> list[Place]:
        """The part of the sample that is on the canvas if these pixels of it lie on this one."""
        tops, lengths, sources = [], [], []
        for p, at, side, size, (low, high), wraps in zip(
            pixel, np.array(found).reshape(-1, 2).T, self.usable.shape, self.size, self.holes,
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
        return [Place(*box) for box in zip(*boxes, prices, strict=True)]


def holes_of(growth: Growth) -> list[tuple[int, int]]:
    """Rows and columns of what is missing or may change: the first, and one after the last.

    It and what is around are matched, not all of a photo with a hole.
    """
    canvas, missing = growth.canvas, growth.done == 0
    if canvas.shown is not None and canvas.hole is not None:
        missing |= canvas.hole
    return [
        (0, n) if wraps else _ends(missing.any(axis=1 - axis))
        for axis, (n, wraps) in enumerate(zip(canvas.shape, canvas.wrap, strict=True))
    ]


def _ends(some: NDArray[np.bool_]) -> tuple[int, int]:
    """The first that is true, and one after the last; all if none is."""
    found = np.flatnonzero(some)
    return (int(found[0]), int(found[-1]) + 1) if len(found) else (0, len(some))
