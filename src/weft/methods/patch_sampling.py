"""Patch-based sampling (Liang, Liu, Xu, Guo and Shum, 2001)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weft.canvas import Canvas, as_canvas
from weft.errors import InvalidInputError
from weft.method import parameter
from weft.methods import _patch_kernels
from weft.methods.patch_analysis import PatchAnalysis, PatchMethod, SearchStructure
from weft.methods.patch_order import patch_starts, patches_around, spiral, wavefronts
from weft.progress import Progress, ProgressCallback
from weft.random import draw, seed_number
from weft.search.boundary_zone import BoundaryZone
from weft.synthesis import Synthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.random import Seed

_THREADS_FROM = 512  # patches; fewer are laid faster by one thread
_PIECE = 16  # patches that a thread takes at a time


@dataclass(frozen=True)
class PatchSampling(PatchMethod):
    """Patch-based sampling.

    Patches of the sample are pasted in scan order. Each is drawn at random from those whose
    boundary zone matches what is there already within a tolerance, and blended into it.

    Examples
    --------
    >>> import weft
    >>> sample = weft.Exemplar(np.random.default_rng(0).integers(0, 255, (48, 48), np.uint8))
    >>> weft.PatchSampling(patch_size=16).fit(sample).sample((60, 80), seed=7).image.shape
    (60, 80)
    """

    slug: ClassVar[str] = "patch-sampling"
    title: ClassVar[str] = "Patch-based sampling"
    paper: ClassVar[str] = (
        "L. Liang, C. Liu, Y.-Q. Xu, B. Guo, H.-Y. Shum: Real-time texture synthesis by "
        "patch-based sampling. ACM Transactions on Graphics 20(3), 2001"
    )

    epsilon: float = parameter(
        0.2,
        "relative error of a matching zone; 0 takes the best, inf anything (chaos mosaic)",
        low=0.0,
    )
    choice: str = parameter(
        "uniform",
        "draw from the matching patches evenly or by the similarity factors alpha_i",
        choices=("uniform", "similarity"),
    )
    blend: str = parameter(
        "feather",
        "joining patches: feathered after each or at the end, cut along least error, or pasted",
        choices=("feather", "feather-at-end", "cut", "none"),
    )

    def rule(self) -> tuple[float, bool, bool]:
        """Equation (1) with d_max of section 2.4."""
        return self.epsilon, False, self.choice == "similarity"


class PatchModel(PatchAnalysis):
    """A sample prepared for patch-based sampling; `sample` makes outputs from it."""

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> Synthesis:
        """Make an output (sections 2.2 and 2.3).

        Parameters
        ----------
        size : Canvas, int or (int, int)
            What to make: height and width, or a Canvas.
        seed : int, numpy Generator or None
            The same seed gives the same bytes, at any number of threads.
        tileable : bool or {"x", "y"}
            Axes that are to repeat without a seam.
        threads : int, optional
            At most so many; by default as many as there are processors.
        progress : callable, optional
            See `weft.progress.ProgressCallback`.

        Returns
        -------
        Synthesis
        """
        canvas = as_canvas(size, tileable)
        self.method.require(canvas)
        if threads is not None and threads < 1:
            raise InvalidInputError(f"threads is {threads}; it must be 1 or more")
        return _Run(self, canvas, seed_number(seed), threads, progress).result()


class _Run:
    """One output in the making."""

    def __init__(
        self,
        model: PatchModel,
        canvas: Canvas,
        seed: int,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> None:
        self.model, self.canvas, self.seed = model, canvas, seed
        self.threads = threads or os.cpu_count() or 1
        self.callback = progress
        self.method, self.exemplar = model.method, model.exemplar
        # A pixel's window hangs over the border where the canvas does not wrap.
        reach = model.boundary_width if model.pixelwise else 0
        self.margin = tuple(0 if wraps else reach for wraps in canvas.wrap)
        # A window no larger than the canvas, a zone no wider than half of what wraps.
        self.window = tuple(
            model.window if model.pixelwise else min(model.window, length)
            for length in canvas.shape
        )
        height, width = (n + 2 * m for n, m in zip(canvas.shape, self.margin, strict=True))
        self.buffer = np.zeros((height, width, model.pixels.shape[2]), np.uint8)
        self.structures: list[SearchStructure] = []
        self.by_key: dict[tuple[int, ...] | bytes, int] = {}
        self.placements = np.zeros((0, 5), np.int32)
        self.cuts = np.zeros((0, 0), np.uint16)

    def result(self) -> Synthesis:
        """Fill the canvas and describe what was done."""
        if self.canvas.known is not None and not self.canvas.hole.all():  # type: ignore[union-attr]
            self._fill_holes()
        elif self.model.pixelwise:
            self._scan_pixels()
        else:
            self._scan_patches()
        placements, weights = self.placements, self._weights()
        if self.model.pixelwise:
            reach = self.model.boundary_width
            placements[:, :2] = (placements[:, :2] + reach - self.margin) % self.canvas.shape
            placements[:, 2:4] += reach
            placements[:, 4] = 0
            weights = np.full((1, 1, 1), 256, np.uint16)
        placements[:, 2:4] %= self.exemplar.shape
        return Synthesis(
            self.canvas,
            placements,
            weights,
            self.cuts,
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            known_from=self.canvas.known_from,
            provenance=self.method.describe() | {"seed": self.seed},
            picture=self._picture(),
        )

    def _scan_patches(self) -> None:
        """Steps 1 to 6 of section 2.2, row by row from the first corner."""
        overlap = self.model.boundary_width
        starts = [
            patch_starts(length, window, min(overlap, window - 1), wraps)
            for length, window, wraps in zip(
                self.canvas.shape, self.window, self.canvas.wrap, strict=True
            )
        ]
        rows, columns = (len(s) for s in starts)
        self._allocate(rows * columns)
        grid = np.meshgrid(*starts, indexing="ij")
        self.placements[:, :2] = np.stack(grid, axis=-1).reshape(-1, 2)
        bits = draw(self.seed, "patch", *np.indices((rows, columns))).ravel()
        if self.method.repeat_distance > 0:
            self.around = patches_around(rows, columns)
        zones = {
            (i, j): self._grid_zone(starts, i, j)
            for i in {0, min(1, rows - 1), rows - 1}
            for j in {0, min(1, columns - 1), columns - 1}
        }
        progress = self._progress(rows * columns, "patches")

        def lay(piece: tuple[int, int, int]) -> None:
            i, first, last = piece
            row = i if i in (0, rows - 1) else 1
            while first < last:  # patches of one zone at a time
                column = first if first in (0, columns - 1) else 1
                stop = min(last, columns - 1 if column == 1 and columns > 2 else first + 1)
                self._lay(zones[row, column], bits, i * columns + first, i * columns + stop)
                first = stop

        def advance(pieces: list[tuple[int, int, int]]) -> None:
            progress.advance(sum(last - first for _, first, last in pieces))

        # Around a wrapped axis every patch of a row hangs on the whole row above.
        serial = self.threads == 1 or self.canvas.wrap[1] or rows * columns < _THREADS_FROM
        if serial:
            for i in range(rows):
                lay((i, 0, columns))
                advance([(i, 0, columns)])
            return
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(self.threads) as pool:
            for pieces in wavefronts(rows, columns, _PIECE):
                list(pool.map(lay, pieces))
                advance(pieces)

    def _grid_zone(self, starts: list[list[int]], i: int, j: int) -> int:
        """The configuration of Fig. 3 and Fig. 5 for a patch of the grid."""
        (height, width), overlap = self.canvas.shape, self.model.boundary_width
        known = np.zeros(self.window, bool)
        known[:overlap] |= i > 0
        known[:, :overlap] |= j > 0
        if self.canvas.wrap[0] and i > 0 and i == len(starts[0]) - 1:
            known[height - starts[0][i] :] = True
        if self.canvas.wrap[1] and j > 0 and j == len(starts[1]) - 1:
            known[:, width - starts[1][j] :] = True
        return self._zone_number(known.tobytes(), known)

    def _scan_pixels(self) -> None:
        """Section 2.5: patches of one pixel, whose zone is the causal neighborhood."""
        height, width = self.canvas.shape
        self._allocate(height * width)
        y, x = np.indices((height, width)).reshape(2, -1)
        self.placements[:, 0], self.placements[:, 1] = self._corner(y, x)
        bits = draw(self.seed, "patch", y, x)
        progress = self._progress(height * width, "pixels")
        for i in range(height):
            numbers = [self._causal_zone(i, j) for j in range(width)]
            first = 0
            for j in range(1, width + 1):
                if j == width or numbers[j] != numbers[first]:
                    self._lay(numbers[first], bits, i * width + first, i * width + j)
                    first = j
            progress.advance(width)

    def _corner(self, y: NDArray[np.int64], x: NDArray[np.int64]) -> list[NDArray[np.int64]]:
        reach = self.model.boundary_width
        pairs = zip((y, x), self.margin, self.buffer.shape, strict=False)
        return [(at + margin - reach) % length for at, margin, length in pairs]

    def _causal_zone(self, i: int, j: int) -> int:
        (height, width), reach = self.canvas.shape, self.model.boundary_width
        key = (min(i, reach), max(i - height, -reach - 1), min(j, reach), max(j - width, -reach - 1))
        if not self.canvas.wrap[0]:
            key = (key[0], 0, *key[2:])
        if key in self.by_key:
            return self.by_key[key]
        y, x = (np.arange(at - reach, at + reach + 1) for at in (i, j))
        there = np.ones((len(y), len(x)), bool)
        if self.canvas.wrap[0]:
            y %= height
        if self.canvas.wrap[1]:
            x %= width
        else:
            there &= (x >= 0) & (x < width)
        there &= (y >= 0)[:, None]
        number = self._zone_number(key, there & (y[:, None] * width + x < i * width + j))
        return number

    def _fill_holes(self) -> None:
        """Section 2.3: patches in spiral order, over the surroundings that are known."""
        known, hole = self.canvas.known, self.canvas.hole
        assert known is not None and hole is not None
        matching = self.exemplar.as_matching(known, self.method.edge_weight)
        if matching.shape[2] != self.buffer.shape[2]:  # the sample's maps have no say here
            raise InvalidInputError("holes cannot be filled from a sample with maps")
        top, left = self.margin
        inside = (slice(top, top + hole.shape[0]), slice(left, left + hole.shape[1]))
        self.buffer[inside] = matching
        unknown = np.zeros(self.buffer.shape[:2], bool)
        unknown[inside] = hole
        outside = np.ones(self.buffer.shape[:2], bool)
        outside[inside] = False
        frozen = ~unknown
        corners = self._hole_corners(unknown)
        self._allocate(len(corners))
        bits = draw(self.seed, "patch", np.arange(len(corners)))
        progress = self._progress(int(hole.sum()), "pixels")
        used = 0
        rows, columns = (np.arange(n) for n in self.window)
        for y, x in corners:
            at = np.ix_((y + rows) % unknown.shape[0], (x + columns) % unknown.shape[1])
            missing = unknown[at]
            done = missing
            if self.model.pixelwise:
                reach = self.model.boundary_width
                done = np.zeros_like(missing)
                done[reach, reach] = missing[reach, reach]
            if not done.any():
                continue
            key = (~missing & ~outside[at]).tobytes() + frozen[at].tobytes()
            number = self._zone_number(key, ~missing & ~outside[at], frozen[at] & ~missing)
            self.placements[used, :2] = y, x
            self._lay(number, bits, used, used + 1)
            unknown[at] = missing & ~done
            used += 1
            progress.advance(int(done.sum()))
        self.placements, self.cuts = self.placements[:used], self.cuts[:used]

    def _hole_corners(self, unknown: NDArray[np.bool_]) -> list[tuple[int, int]]:
        """Corners of windows that cover the holes, each group of holes spirally inwards."""
        if self.model.pixelwise:
            reach = self.model.boundary_width
            return [(y - reach, x - reach) for y, x in spiral(unknown)]
        overlap = self.model.boundary_width
        grids = []
        for axis in (0, 1):
            there = np.flatnonzero(unknown.any(axis=1 - axis))
            start, stop = int(there[0]) - overlap, int(there[-1]) + 1 + overlap
            length, window = unknown.shape[axis], self.window[axis]
            if not self.canvas.wrap[axis]:
                start, stop = max(start, 0), min(stop, length)
            slack = max(window - (stop - start), 0)
            start -= slack // 2
            if not self.canvas.wrap[axis]:
                start = min(max(start, 0), max(length - window, 0))
            offsets = patch_starts(max(stop - start, window), window, overlap, wrap=False)
            grids.append([start + k for k in offsets])
        rows, columns = (np.arange(n) for n in self.window)
        height, width = unknown.shape
        cells = np.array(
            [
                [
                    unknown[np.ix_((y + rows) % height, (x + columns) % width)].any()
                    for x in grids[1]
                ]
                for y in grids[0]
            ]
        )
        return [(grids[0][i], grids[1][j]) for i, j in spiral(cells)]

    def _zone_number(
        self,
        key: tuple[int, ...] | bytes,
        known: NDArray[np.bool_],
        frozen: NDArray[np.bool_] | None = None,
    ) -> int:
        if key not in self.by_key:
            self.structures.append(self.model.structure(known, frozen))
            self.by_key[key] = len(self.structures) - 1
        return self.by_key[key]

    def _weights(self) -> NDArray[np.uint16]:
        return np.stack([s.zone.weight for s in self.structures])

    def _allocate(self, count: int) -> None:
        self.placements = np.zeros((count, 5), np.int32)
        self.around = np.zeros((count, 0), np.int32)
        if self.method.seam == "cut" and not self.model.pixelwise:
            self.cuts = np.zeros((count, 2 * sum(self.window)), np.uint16)

    def _progress(self, total: int, stage: str) -> Progress:
        return Progress(self.callback, total, stage, self._preview)

    def _preview(self) -> NDArray[np.uint8]:
        inside = self._inside()
        return inside[..., : self.exemplar.channels].copy()

    def _inside(self) -> NDArray[np.uint8]:
        top, left = self.margin
        height, width = self.canvas.shape
        return self.buffer[top : top + height, left : left + width]

    def _picture(self) -> NDArray[np.uint8] | None:
        """The matching buffer where it is the picture itself, so that it need not be rendered."""
        if self.model.pixels.dtype != self.exemplar.pixels.dtype or self.exemplar.alpha:
            return None
        if self.model.pixels.shape[2] != self.exemplar.channels:
            return None
        if self.method.seam == "feather-at-end" and not self.model.pixelwise:
            return None
        return self._inside().reshape(*self.canvas.shape, *self.exemplar.pixels.shape[2:])

    def _lay(self, number: int, bits: NDArray[np.uint64], first: int, last: int) -> None:
        """Choose and lay patches `first` to `last`, all of one zone."""
        structure = self.structures[number]
        model, method, zone = self.model, self.method, structure.zone
        tolerance, relative, weighted = method.rule()
        placements = self.placements[first:last]
        placements[:, 4] = number
        given = np.zeros(0, np.int32)
        channels = self.buffer.shape[2]
        if structure.tree is not None:
            if last - first > 1:
                for k in range(first, last):
                    self._lay(number, bits, k, k + 1)
                return
            given = structure.tree_candidates(self.buffer, *placements[0, :2], method.candidates)
        room = len(structure.positions)
        if structure.search != 0:
            room = method.candidates + 54 * structure.nodes.shape[1]
        weight = zone.weight
        if method.seam == "feather-at-end":
            weight = np.where(weight > 0, 256, 0).astype(np.uint16)
        components = structure.pca.basis.shape[0]
        columns = structure.usable.shape[1]
        _patch_kernels.sample_patches(
            self.buffer,
            model.pixels,
            model.turned,
            structure.usable,
            structure.positions,
            structure.nodes,
            zone.runs,
            zone.blocks,
            zone.side,
            weight[None],
            zone.bands,
            structure.pca.basis,
            structure.pca.offset,
            structure.pca.shift,
            structure.pca.features,
            given,
            structure.search,
            method.candidates,
            tolerance,
            relative,
            weighted,
            bits[first:last],
            self.placements,
            self.around[first:last],
            round(method.repeat_distance * model.patch_size),
            placements,
            self.cuts[first:last],
            np.empty(zone.area * channels, np.uint8),
            np.empty(len(zone.blocks) * channels, np.int32),
            np.empty(components, np.int16),
            np.empty(columns, np.int32),
            np.empty(columns, np.int64),
            np.empty(room, np.int64),
            np.empty(room, np.int32),
            np.empty(room, np.uint8),
            np.empty((max(weight.shape), int(zone.bands[0])), np.int64),
        )
