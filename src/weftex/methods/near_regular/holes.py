"""Blocks that fill a hole and go on with what is known around it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.lattices.mean_tile import known_levels
from weftex.methods.near_regular import gap_kernels as kernels
from weftex.methods.near_regular.block_sample import NO_SEARCH, in_no_order
from weftex.methods.near_regular.blocks import Blocks
from weftex.progress import Progress
from weftex.raster.masks import grown
from weftex.search.boundary_zone import runs_over

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.methods.near_regular.block_axis import Axis
    from weftex.methods.near_regular.block_sample import BlockSample
    from weftex.progress import ProgressCallback
    from weftex.results.patches import PatchSynthesis

_HOLE, _BESIDE, _OFF = 0, 1, 2  # the kernels' states of a pixel
_KNOWN = 5  # and their wedge of pixels that are there already


class HoleBlocks(Blocks):
    """A canvas with known pixels in the making.

    Blocks that see known pixels take the piece that fits those best, drawn ones too; only those
    in the midst of a hole are random. Which of two blocks a pixel of the hole's border belongs to
    also hangs on how well either would go on beyond it.
    """

    def __init__(
        self,
        sample: BlockSample,
        canvas: Canvas,
        origin: tuple[int, int],
        seed: int,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> None:
        super().__init__(sample, canvas, origin, seed, threads, progress)
        assert canvas.hole is not None
        self.hole = canvas.hole
        self.known = np.ascontiguousarray(known_levels(canvas, sample.exemplar))
        around = grown(self.hole, 2 * sample.margin or 1, canvas.wrap)
        #: Known pixels that count: as near to the hole as a border is wide.
        self.near = around & ~self.hole
        self.state = np.where(self.hole, _HOLE, _OFF).astype(np.uint8)
        self.state[grown(self.hole, 1, canvas.wrap) & ~self.hole] = _BESIDE
        self.laid = self._see(self.hole)
        #: Drawn blocks that see known pixels, so that they are not random.
        self.bound = self.laid & ~self.gap & self._see(self.near)
        self.drawn = self.laid & ~self.gap & ~self.bound
        self._check()

    def _lines(self, axis: Axis, block: int, count: int) -> tuple[NDArray[Any], NDArray[np.bool_]]:
        """Canvas lines of a block's window, and which of them are on the canvas."""
        length = self.canvas.shape[0 if axis is self.rows else 1]
        at = axis.edges[block] - self.sample.margin + np.arange(count)
        return at % length, ((at >= 0) & (at < length)) | bool(axis.period)

    def _see(self, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which blocks have some of these pixels in their windows."""
        side = self.sample.side
        result = np.zeros(self.place.shape, bool)
        for i in range(self.rows.shown.start, self.rows.shown.stop):
            y, inside = self._lines(self.rows, i, side)
            row = mask[y[inside]].any(axis=0)
            for j in range(self.columns.shown.start, self.columns.shown.stop):
                x, within = self._lines(self.columns, j, side)
                result[i, j] = row[x[within]].any()
        return result

    def _check(self) -> None:
        """Refuse a hole for a block of which the sample has no whole piece."""
        if self.sample.free:
            return
        for i, j in np.argwhere(self.laid).tolist():
            if not self._usable((self.phase[i, j] + self.sample.steps + 2**15) >> 16).any():
                y, x = (
                    max(int(axis.edges[k]), 0) for axis, k in ((self.rows, i), (self.columns, j))
                )
                side, name = self.sample.side, self.sample.exemplar.name
                raise InvalidInputError(
                    f"no whole piece of {side}x{side} pixels that the lattice leads to from x {x}, "
                    f"y {y} lies on usable pixels of {name}; make block_size and border_width "
                    "smaller, cover less with the mask, or give a sample to fill it from"
                )

    def _usable(self, places: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether whole windows lie at these places."""
        windows = self.sample.windows
        if windows.period[2]:
            places = places % windows.period[2:]
        inside: NDArray[np.bool_] = np.all((places >= 0) & (places < windows.usable.shape), axis=-1)
        inside[inside] = windows.usable[places[inside, 0], places[inside, 1]] > 0
        return inside

    def _chosen(self, map_: Callable[..., Iterable[Any]]) -> PatchSynthesis:
        self._keep()
        self._fit(np.argwhere(self.bound), "blocks", map_)
        return super()._chosen(map_)

    def _fill(self, map_: Callable[..., Iterable[Any]]) -> None:
        self._fit(np.argwhere(self.gap & self.laid), "gaps", map_)

    def _keep(self) -> None:
        """What is known beside the hole and part of the sample is not to be shown again."""
        if self.canvas.known_from is None:
            return
        beside = grown(self.laid, 1, (self.rows.period > 0, self.columns.period > 0)) & ~self.laid
        cells = np.argwhere(beside)
        place = np.stack([self.rows.edges[cells[:, 0]], self.columns.edges[cells[:, 1]]], axis=1)
        place += np.array(self.canvas.known_from) - self.sample.margin
        windows = self.sample.windows
        there = self._usable(place)
        if windows.period[2]:
            place = place % windows.period[2:]
        flat = place[:, 0] * windows.pixels.shape[1] + place[:, 1]
        self.place[cells[there, 0], cells[there, 1]] = flat[there]

    def _fit(self, cells: NDArray[Any], stage: str, map_: Callable[..., Iterable[Any]]) -> None:
        """Choose these blocks by all that is there around them."""
        progress = Progress(self.callback, len(cells), stage, self._preview)

        def fit(cell: NDArray[Any]) -> None:
            self._fit_block(*cell.tolist())

        for _ in map_(fit, cells):
            progress.advance(1)

    def _fit_block(self, i: int, j: int) -> None:
        sample, windows, method = self.sample, self.sample.windows, self.method
        height, width = int(self.rows.sizes[i]), int(self.columns.sizes[j])
        wedges = np.zeros((height + 2 * sample.margin, width + 2 * sample.margin), np.uint8)
        if self.gap[i, j]:
            wedges[:] = sample.border(height, width, self.reach).wedges
        (y, inside), (x, within) = (
            self._lines(axis, k, n)
            for axis, k, n in zip((self.rows, self.columns), (i, j), wedges.shape, strict=True)
        )
        there = inside[:, None] & within
        at = np.ix_(y, x)
        wedges[~there | ~self.hole[at]] = 0
        wedges[there & self.near[at]] = _KNOWN
        runs = in_no_order(runs_over(wedges > 0))
        if sample.free and len(runs) == 0:
            count = np.uint64(len(windows.centres))
            self.place[i, j] = windows.centres[int(self.bits[i, j] % count)]
            return
        low, side, basis, offset, shift, features, places = NO_SEARCH
        channels, wanted = sample.pixels.shape[2], method.candidates or 1
        kernels.fill_gaps(
            sample.pixels, sample.turned, windows.usable, windows.period,
            sample.steps, windows.centres, np.array([[i, j]], np.int32), self.phase, self.bits,
            self.rows.edges, self.columns.edges, self.wrap, wedges, runs,
            low, side, basis, offset, shift, features, places,
            method.tolerance or 0, wanted, round(256 * (method.variety or 0.0)),
            method.match == "gncc",
            np.ascontiguousarray(self.known[at]),
            np.empty(int((wedges > 0).sum()) * channels, np.uint8),
            np.empty(0, np.int32),
            np.empty(1, np.int16),
            np.empty(wanted, np.int64),
            np.empty(wanted, np.int32),
            self.place,
        )  # fmt: skip

    def _laid(
        self, cuts: NDArray[np.uint16], zones: NDArray[np.int64], weights: NDArray[np.uint16]
    ) -> PatchSynthesis:
        """Known pixels stay: patches have no weight there."""
        (lines, first), (across, begin) = self.kept
        found: dict[bytes, int] = {}
        own = [np.zeros_like(weights[0])]
        for i, j in np.argwhere(self.laid[self.rows.shown, self.columns.shown]).tolist():
            (y, inside), (x, within) = (
                self._lines(axis, k + axis.shown.start, self.sample.side)
                for axis, k in ((self.rows, i), (self.columns, j))
            )
            shown = self.hole[np.ix_(y, x)] & inside[:, None] & within
            v, u = int(first[i]), int(begin[j])
            weight = weights[zones[i, j]] * shown[v : v + lines, u : u + across]
            key = weight.tobytes()
            if key not in found:
                found[key] = len(own)
                own.append(weight)
            zones[i, j] = found[key]
        return super()._laid(cuts, zones, np.stack(own))

    def _preview(self) -> NDArray[np.uint8]:
        canvas = super()._preview()
        canvas[~self.hole] = self.known[~self.hole][:, : canvas.shape[2]]
        return canvas
