"""Laying patches: the algorithm of sections 2.2, 2.3 and 2.5 of Liang et al. (2001)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.methods.patches import patch_kernels as _patch_kernels
from weftex.methods.patches.order import patch_starts, patches_around, spiral, wavefronts
from weftex.progress import Progress, ProgressCallback
from weftex.random import draw
from weftex.results.patches import PatchSynthesis
from weftex.threads import thread_count

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.patches.analysis import PatchAnalysis, SearchStructure

_THREADS_FROM = 512  # patches; fewer are laid faster by one thread
_NEARBY = 11  # patches around a hole's patch that it should not repeat
_PIECE = 16  # patches that a thread takes at a time


class Pasting:
    """One output in the making."""

    def __init__(
        self,
        model: PatchAnalysis,
        canvas: Canvas,
        seed: int,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> None:
        self.model, self.canvas, self.seed = model, canvas, seed
        self.threads = thread_count(threads)
        self.callback = progress
        self.method, self.exemplar = model.method, model.exemplar
        # A pixel's window hangs over the border where the canvas does not wrap.
        reach = model.boundary_width if model.pixelwise else 0
        self.margin = tuple(0 if wraps else reach for wraps in canvas.wrap)
        # A window no larger than the canvas, a zone no wider than half of what wraps.
        self.window_side = tuple(
            model.window_side if model.pixelwise else min(model.window_side, length)
            for length in canvas.shape
        )
        height, width = (n + 2 * m for n, m in zip(canvas.shape, self.margin, strict=True))
        self.buffer = np.zeros((height, width, model.pixels.shape[2]), np.uint8)
        # In a wrapped row the last patch has zones on both sides and must have room between them.
        wrapped = [w // 4 for w, wraps in zip(self.window_side, canvas.wrap, strict=True) if wraps]
        self.width = model.boundary_width
        if not model.pixelwise:
            self.width = max(1, min([self.width, *wrapped]))
        self.structures: list[SearchStructure] = []
        self.by_key: dict[tuple[int, ...] | bytes, int] = {}
        canvas.check_known(model.exemplar)
        self.placements = np.zeros((0, 5), np.int32)
        self.cuts = np.zeros((0, 0), np.uint16)

    def result(self) -> PatchSynthesis:
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
        return PatchSynthesis(
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
        starts = [
            patch_starts(length, window, min(self.width, window - 1), wraps)
            for length, window, wraps in zip(
                self.canvas.shape, self.window_side, self.canvas.wrap, strict=True
            )
        ]
        rows, columns = (len(s) for s in starts)
        self._allocate(rows * columns)
        grid = np.meshgrid(*starts, indexing="ij")
        self.placements[:, :2] = np.stack(grid, axis=-1).reshape(-1, 2)
        bits = draw(self.seed, "patch", *np.indices((rows, columns))).ravel()
        if self.method.repeat_distance > 0:
            self.around = patches_around(rows, columns)
        kinds = [
            [(k > 0, max(0, at + window - length) if k and wraps else 0) for k, at in enumerate(s)]
            for s, window, length, wraps in zip(
                starts, self.window_side, self.canvas.shape, self.canvas.wrap, strict=True
            )
        ]
        zones = {
            (row, column): self._grid_zone(row, column)
            for row in dict.fromkeys(kinds[0])
            for column in dict.fromkeys(kinds[1])
        }
        progress = self._progress(rows * columns, "patches")

        def lay(piece: tuple[int, int, int]) -> None:
            i, first, last = piece
            while first < last:  # patches of one zone at a time
                stop = first + 1
                while stop < last and kinds[1][stop] == kinds[1][first]:
                    stop += 1
                zone = zones[kinds[0][i], kinds[1][first]]
                self._lay(zone, bits, i * columns + first, i * columns + stop)
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

        ends = np.add(starts[1], self.window_side[1])
        overlapped = np.searchsorted(starts[1], ends) - 1 - np.arange(columns)
        reach = max(1, int(overlapped.max()))
        with ThreadPoolExecutor(self.threads) as pool:
            for pieces in wavefronts(rows, columns, _PIECE, reach):
                list(pool.map(lay, pieces))
                advance(pieces)

    def _grid_zone(self, row: tuple[bool, int], column: tuple[bool, int]) -> int:
        """The configuration of Fig. 3 and Fig. 5 for a patch of the grid.

        `row` and `column` say whether there are patches before, and how far the patch reaches
        around a wrapped border.
        """
        known = np.zeros(self.window_side, bool)
        known[: self.width] |= row[0]
        known[:, : self.width] |= column[0]
        known[self.window_side[0] - row[1] :] = True
        known[:, self.window_side[1] - column[1] :] = True
        return self._zone_number(known.tobytes(), known, often=not (row[1] or column[1]))

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
        key = (
            min(i, reach),
            max(i - height, -reach - 1),
            min(j, reach),
            max(j - width, -reach - 1),
        )
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
        if self.exemplar.maps:
            raise InvalidInputError("a hole's surroundings lack the sample's maps; use weftex.fill")
        matching = self.exemplar.as_matching(known, self.method.edge_weight)
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
        if self.method.repeat_distance > 0 and not self.model.pixelwise:
            self.around = np.full((len(corners), _NEARBY), -1, np.int32)
        progress = self._progress(int(hole.sum()), "pixels")
        used = 0
        rows, columns = (np.arange(n) for n in self.window_side)
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
            if self.method.repeat_distance > 0 and not self.model.pixelwise:
                self.around[used] = self._laid_nearby(used)
            self._lay(number, bits, used, used + 1)
            unknown[at] = missing & ~done
            used += 1
            progress.advance(int(done.sum()))
        self.placements, self.cuts = self.placements[:used], self.cuts[:used]

    def _laid_nearby(self, number: int) -> NDArray[np.int32]:
        """The latest patches laid within two windows of this one, -1 where there are fewer."""
        away = np.abs(self.placements[:number, :2] - self.placements[number, :2])
        near = np.flatnonzero((away < 2 * np.array(self.window_side)).all(axis=1))[-_NEARBY:]
        return np.pad(near, (0, _NEARBY - len(near)), constant_values=-1).astype(np.int32)

    def _hole_corners(self, unknown: NDArray[np.bool_]) -> list[tuple[int, int]]:
        """Corners of windows that cover the holes, each group of holes spirally inwards."""
        height, width = unknown.shape
        if not unknown.any():
            return []
        if self.model.pixelwise:
            reach = self.model.boundary_width
            return [((y - reach) % height, (x - reach) % width) for y, x in spiral(unknown)]
        overlap = self.model.boundary_width
        grids = []
        for axis in (0, 1):
            there = np.flatnonzero(unknown.any(axis=1 - axis))
            start, stop = int(there[0]) - overlap, int(there[-1]) + 1 + overlap
            length, window = unknown.shape[axis], self.window_side[axis]
            if not self.canvas.wrap[axis]:
                start, stop = max(start, 0), min(stop, length)
            slack = max(window - (stop - start), 0)
            start -= slack // 2
            if not self.canvas.wrap[axis]:
                start = min(max(start, 0), max(length - window, 0))
            shared = min(overlap, window - 1)
            offsets = patch_starts(max(stop - start, window), window, shared, wrap=False)
            grids.append([(start + k) % length for k in offsets])
        rows, columns = (np.arange(n) for n in self.window_side)
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
        often: bool = False,
    ) -> int:
        if key not in self.by_key:
            width = None if self.width == self.model.boundary_width else self.width
            structure = self.model.structure(known, frozen, width=width, often=often)
            self.structures.append(structure)
            self.by_key[key] = len(self.structures) - 1
        return self.by_key[key]

    def _weights(self) -> NDArray[np.uint16]:
        if not self.structures:
            return np.zeros((0, *self.window_side), np.uint16)
        return np.stack([s.zone.weight for s in self.structures])

    def _allocate(self, count: int) -> None:
        self.placements = np.zeros((count, 5), np.int32)
        self.around = np.zeros((count, 0), np.int32)  # nothing to keep away from
        if self.method.seam == "cut" and not self.model.pixelwise:
            self.cuts = np.zeros((count, 2 * sum(self.window_side)), np.uint16)

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
            y, x = (int(k) for k in placements[0, :2])
            given = structure.tree_candidates(self.buffer, y, x, method.candidates)
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
