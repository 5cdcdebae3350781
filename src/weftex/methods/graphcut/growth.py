"""Laying patches along minimum cuts (Kwatra et al., 2003, sections 3 and 4)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.graphcut import cut_kernels as kernels
from weftex.methods.graphcut.placement import PlacesOfPatches, PlacesOfSample
from weftex.raster.boxes import box_sums
from weftex.seams.maxflow import minimum_cut

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.graphcut import GraphCut
    from weftex.methods.graphcut.placement import Place, Places
    from weftex.methods.pixels.growth import Growth
    from weftex.search.windows import Windows

_CELL = 8  # pixels; the worst seams are looked for by squares of this side
_BAND = 64  # rows of seams that are priced at a time
_NEW = 2  # the kernel's sign for pixels that have no other choice than the patch


class Cutting:
    """One output in the making.

    Parameters
    ----------
    method : GraphCut
        With every parameter settled.
    exemplar : Exemplar
        The sample.
    windows : Windows
        Its single pixels.
    growth : Growth
        The output.
    map_ : callable
        `map`, or that of a pool of threads: candidates are cut beside each other.
    """

    def __init__(
        self,
        method: GraphCut,
        exemplar: Exemplar,
        windows: Windows,
        growth: Growth,
        map_: Callable[..., Iterable[Any]] = map,
    ) -> None:
        self.method, self.growth, self.map = method, growth, map_
        canvas = growth.canvas
        height, width = canvas.shape
        self.shape = np.array([height, width, *canvas.wrap], np.int32)
        self.sample = np.array(
            [*exemplar.shape, exemplar.tileable, method.seam_cost == "gradient"], np.int32
        )
        self.pixels = windows.pixels.reshape(-1, windows.pixels.shape[2])
        self.usable = windows.usable.ravel()
        self.levels = growth.levels.reshape(-1, self.pixels.shape[1])
        self.source, self.done = growth.source.ravel(), growth.done.ravel()
        self.fixed = self.done.copy()  # known pixels
        kind = PlacesOfPatches if method.placement == "subpatch" else PlacesOfSample
        self.places: Places = kind(method, exemplar, windows, growth)
        self.laid = 0  # patches
        self.cost = np.zeros(self.source.shape, np.int32)
        self.cells = np.zeros([-(-n // _CELL) for n in canvas.shape], np.int64)
        self.tried = np.zeros_like(self.cells)

    def cover(self) -> None:
        """Lay patches over the first pixel that is missing, until none is."""
        progress = self.growth.progress(int((self.done == 0).sum()), "pixels")
        first = 0
        while True:
            first += int(self.done[first:].argmin())
            if self.done[first]:
                break
            progress.advance(self.lay(divmod(first, self.growth.canvas.width), mend=False))

    def refine(self) -> None:
        """Lay patches over the worst seams (section 4)."""
        count = round(self.method.refinements * self.laid)
        if not count:
            return
        height, width = self.growth.canvas.shape
        for top in range(0, height, _BAND):
            self.price(top, 0, min(_BAND, height - top), width)
        progress = self.growth.progress(count, "repairs")
        for _ in range(count):
            worst = self.worst()
            if worst is None:
                progress.advance(progress.total - progress.done)
                break
            self.lay(worst, mend=True)
            progress.advance(1)

    def lay(self, pixel: tuple[int, int], *, mend: bool) -> int:
        """Lay a patch that covers a pixel; return how many were missing before."""
        tried = self.map(self.cut, self.places.draw(pixel, self.laid, mend))
        _, side, place = min(tried, key=lambda one: one[0])
        where, what = self.flat(place)
        self.laid += 1
        covered: int = kernels.paste_patch(
            self.levels, self.source, self.done, self.pixels, where, what, side
        )
        if mend:
            self.price(place.top - 1, place.left - 1, place.height + 1, place.width + 1)
        return covered

    def flat(self, place: Place) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The patch's pixels on the canvas and in the sample, as flat indices."""
        y, x = np.arange(place.height)[:, None], np.arange(place.width)
        height, width = self.growth.canvas.shape
        where = (place.top + y) % height * width + (place.left + x) % width
        height, width = (int(n) for n in self.sample[:2])
        what = (place.source_top + y) % height * width + (place.source_left + x) % width
        return where.astype(np.int32), what.astype(np.int32)

    def cut(self, place: Place) -> tuple[int, NDArray[np.uint8], Place]:
        """Section 3: what the seams in a box cost with a patch, and which of its pixels show."""
        where, what = self.flat(place)
        arcs = np.empty((*where.shape, 4), np.int32)
        old, new = np.empty((2, *where.shape), np.int32)
        state = np.empty(where.shape, np.uint8)
        settled: int = kernels.fill_capacities(
            self.levels, self.source, self.done, self.fixed, self.shape,
            self.pixels, self.usable, self.sample, where, what, arcs, old, new, state,
        )  # fmt: skip
        side, cost = minimum_cut(arcs, old, new)
        return cost + settled, (side | (state == _NEW)).astype(np.uint8), place

    def price(self, top: int, left: int, height: int, width: int) -> None:
        """Say what the seams in a box cost, and sum it up by cells."""
        rows, columns = (
            (start + np.arange(min(length, n))) % n
            if wraps
            else np.arange(max(start, 0), min(start + length, n))
            for start, length, n, wraps in zip(
                (top, left), (height, width), self.growth.canvas.shape, self.growth.canvas.wrap,
                strict=True,
            )
        )  # fmt: skip
        where = (rows[:, None] * self.growth.canvas.width + columns).astype(np.int32)
        before = self.cost[where]
        kernels.fill_seams(
            self.levels, self.source, self.done, self.fixed, self.shape,
            self.pixels, self.usable, self.sample, where, self.cost,
        )  # fmt: skip
        change = self.cost[where] - before
        np.add.at(self.cells, (rows[:, None] // _CELL, columns // _CELL), change)

    def worst(self) -> tuple[int, int] | None:
        """The middle of the square, half as wide as a patch, whose seams cost most; None if none.

        A square that was tried counts half as much the next time, or one seam that cannot be
        mended would keep the others from it.
        """
        total = self.cells >> np.minimum(self.tried, 62)
        spans = [
            min(max(1, size // (2 * _CELL)), n)
            for size, n in zip(self.places.size, total.shape, strict=True)
        ]
        around = [
            (0, (span - 1) * wraps)
            for span, wraps in zip(spans, self.growth.canvas.wrap, strict=True)
        ]
        sums = box_sums(np.pad(total, around, mode="wrap"), *spans)
        best = int(sums.argmax())
        if sums.flat[best] == 0:
            return None
        corner = divmod(best, sums.shape[1])
        cells = [
            (k + np.arange(span)) % n for k, span, n in zip(corner, spans, total.shape, strict=True)
        ]
        self.tried[np.ix_(*cells)] += 1
        y, x = (
            (k * _CELL + span * _CELL // 2) % n
            if wraps
            else min(k * _CELL + span * _CELL // 2, n - 1)
            for k, span, n, wraps in zip(
                corner, spans, self.growth.canvas.shape, self.growth.canvas.wrap, strict=True
            )
        )
        return y, x
