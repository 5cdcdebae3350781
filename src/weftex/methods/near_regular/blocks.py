"""Blocks of one output: drawn, filled in between and joined (sections 4.2.1 to 4.2.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.lattices.canvas_lattice import CanvasLattice
from weftex.methods.near_regular import block_kernels as kernels
from weftex.methods.near_regular import gap_kernels, seam_kernels
from weftex.methods.near_regular.block_axis import Axis
from weftex.methods.near_regular.rows import ANY, rows_shown
from weftex.methods.near_regular.warps import Warps
from weftex.progress import Progress, ProgressCallback
from weftex.random import draw
from weftex.results.patches import PatchSynthesis, RectifiedSynthesis
from weftex.results.warped import WarpedSynthesis
from weftex.threads import thread_count

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.methods.near_regular.block_sample import BlockSample, Border

_PIECE = 32  # gaps that a thread fills at a time, at most
_LINES = 4  # of blocks that a thread cuts at a time
_BOX = 3  # half the side of what is compared where four blocks meet


class Blocks:
    """One output in the making."""

    def __init__(
        self,
        sample: BlockSample,
        canvas: Canvas,
        origin: tuple[int, int],
        seed: int,
        threads: int | None,
        progress: ProgressCallback | None,
    ) -> None:
        self.sample, self.canvas, self.seed = sample, canvas, seed
        self.origin, self.method = origin, sample.method
        self.threads, self.callback = thread_count(threads), progress
        size = sample.side - 2 * sample.margin
        limit = max(1, self.method.tolerance or 0) / size
        self.lattice = CanvasLattice(sample.vectors, canvas, limit)
        self.rows, self.columns = (
            Axis(length, size, sample.margin, at, wraps, pitch)
            for length, at, wraps, pitch in zip(
                canvas.shape, origin, canvas.wrap, sample.pitch, strict=True
            )
        )
        self.wrap = np.array([self.rows.period, self.columns.period], np.int32)
        least = min(int(axis.sizes.min()) for axis in (self.rows, self.columns))
        #: How far seams leave the grid; less than `sample.margin` where blocks are small.
        self.reach = min(sample.margin, max(0, least - 1) // 2)
        self.kept = [
            axis.kept(length, sample.side, sample.margin, self.reach)
            for axis, length in zip((self.rows, self.columns), canvas.shape, strict=True)
        ]
        shape = self.rows.count, self.columns.count
        self.place = np.full(shape, -1, np.int32)
        number = self.rows.numbers[:, None], self.columns.numbers[None, :]
        self.bits = draw(seed, "block", *number)
        corner = [
            axis.edges[:-1] + at - sample.margin
            for axis, at in zip((self.rows, self.columns), origin, strict=True)
        ]
        self.phase = np.ascontiguousarray(
            self.lattice.phase(corner[0][:, None], corner[1][None, :])
        )
        self.gap = (number[0] + number[1]) % 2 == 1
        self.number = number
        self.drawn, self.laid = ~self.gap, np.ones(shape, bool)
        #: Where a hole is filled: the canvas's bytes, and which of them are known.
        self.known = np.zeros((0, 0, 0), np.uint8)
        self.state = np.zeros((0, 0), np.uint8)
        #: Which rows of the sample blocks are to show, see `rows_shown`.
        self.row = rows_shown(self) if canvas.known is None else None
        self.warps: Warps | None = None

    def result(self) -> PatchSynthesis:
        """Choose all blocks and describe how they are laid."""
        if self.threads > 1:
            with ThreadPoolExecutor(self.threads) as pool:
                return self._chosen(pool.map)
        return self._chosen(map)

    def _chosen(self, map_: Callable[..., Iterable[Any]]) -> PatchSynthesis:
        self._draw()
        self._fill(map_)
        if self.method.warp:
            self.warps = Warps(self, map_)
        return self._laid(*self._joined(map_))

    def _draw(self) -> None:
        """Section 4.2.1: every second block, one colour after the other."""
        windows = self.sample.windows
        i, j = self.number
        color = (i + j) // 2 % 2 * 2 + (i - j) // 2 % 2
        for k in range(4):
            for steps, cells in self._by_rows(np.argwhere(self.drawn & (color == k))):
                kernels.draw_blocks(
                    windows.usable, windows.period, steps, windows.centres,
                    cells, self.phase, self.bits,
                    self.rows.edges, self.columns.edges, self.wrap, self.place,
                )  # fmt: skip

    def _by_rows(
        self, cells: NDArray[Any]
    ) -> Iterable[tuple[NDArray[np.int64], NDArray[np.int32]]]:
        """Steps that lead to the rows that blocks are to show, and these blocks."""
        cells = np.ascontiguousarray(cells, np.int32)
        if self.row is None:
            yield self.sample.steps, cells
            return
        row = self.row[cells[:, 0], cells[:, 1]]
        for number in np.unique(row):
            own = self.sample.rows == number if number != ANY else slice(None)
            yield (
                np.ascontiguousarray(self.sample.steps[own]),
                np.ascontiguousarray(cells[row == number]),
            )

    def _fill(self, map_: Callable[..., Iterable[Any]]) -> None:
        """Section 4.2.2: the gaps that show, each by its four neighbours."""
        shown = np.zeros(self.gap.shape, bool)
        shown[self.rows.shown, self.columns.shown] = True
        cells = np.argwhere(self.gap & shown).astype(np.int32)
        progress = Progress(self.callback, len(cells), "gaps", self._preview)
        jobs, most = [], min(_PIECE, len(cells) // 8 + 1)
        sizes = self.rows.sizes[cells[:, 0]], self.columns.sizes[cells[:, 1]]
        for height in np.unique(sizes[0]):
            for width in np.unique(sizes[1]):
                own = np.ascontiguousarray(cells[(sizes[0] == height) & (sizes[1] == width)])
                if len(own):
                    border = self.sample.border(int(height), int(width), self.reach)
                    jobs += [(border, own[k : k + most]) for k in range(0, len(own), most)]

        def fill(job: tuple[Border, NDArray[np.int32]]) -> int:
            border, piece = job
            self._fill_piece(border, piece)
            return len(piece)

        for done in map_(fill, jobs):
            progress.advance(done)

    def _fill_piece(self, border: Border, cells: NDArray[np.int32]) -> None:
        sample, windows, method = self.sample, self.sample.windows, self.sample.method
        channels, wanted = sample.pixels.shape[2], method.candidates or 1
        low, side, basis, offset, shift, features, places = sample.search
        if sample.free and len(low) == 0:  # no borders to look at: any place
            i, j = cells.T
            choice = self.bits[i, j] % np.uint64(len(windows.centres))
            self.place[i, j] = windows.centres[choice.astype(np.int64)]
            return
        for steps, own in self._by_rows(cells):
            gap_kernels.fill_gaps(
                sample.pixels, sample.turned, windows.usable, windows.period,
                steps, windows.centres, own, self.phase, self.bits,
                self.rows.edges, self.columns.edges, self.wrap, border.wedges, border.runs,
                low, side, basis, offset, shift, features, places,
                method.tolerance or 0, wanted, round(256 * (method.variety or 0.0)),
                method.match == "gncc",
                np.zeros((*border.wedges.shape, channels), np.uint8),
                np.empty(int((border.wedges > 0).sum()) * channels, np.uint8),
                np.empty(len(low) * channels, np.int32),
                np.empty(len(basis), np.int16),
                np.empty(wanted, np.int64),
                np.empty(wanted, np.int32),
                self.place,
            )  # fmt: skip

    def _joined(
        self, map_: Callable[..., Iterable[Any]]
    ) -> tuple[NDArray[np.uint16], NDArray[np.int64], NDArray[np.uint16]]:
        """Section 4.2.3, or seams along least error: cuts, zones of all blocks, and weights."""
        rows = self.rows.shown.stop - self.rows.shown.start
        columns = self.columns.shown.stop - self.columns.shown.start
        if self.method.blend == "cut":
            cuts = self._cuts(*self._paths(map_))
            weights = np.full((1, self.kept[0][0], self.kept[1][0]), 128, np.uint16)
            return cuts, np.zeros((rows, columns), np.int64), weights
        zones = np.zeros((rows, columns), np.int64)
        known: dict[tuple[Any, ...], int] = {}
        weights_of = []
        profiles = [self._profiles(axis, k) for k, axis in enumerate((self.rows, self.columns))]
        for i in range(rows):
            for j in range(columns):
                kind = profiles[0][i][0], profiles[1][j][0]
                if kind not in known:
                    known[kind] = len(known)
                    weights_of.append(_weights(profiles[0][i], profiles[1][j]))
                zones[i, j] = known[kind]
        return np.zeros((0, 0), np.uint16), zones, np.stack(weights_of)

    def _profiles(self, axis: Axis, k: int) -> list[tuple[Any, NDArray[np.float64], bool]]:
        """How much of each line of the window is the block's (eqs. 4.9 and 4.10).

        With what tells apart the profiles, and whether the block is of the second kind.
        """
        width = (self.method.blend_width or 0) if self.method.blend == "feather" else 0
        width = min(width, 2 * self.reach)
        side, margin, length = self.sample.side, self.sample.margin, self.canvas.shape[k]
        found = []
        for block in range(axis.shown.start, axis.shown.stop):
            size, start = int(axis.sizes[block]), int(axis.edges[block]) - margin
            # x of eq. (4.9), 1 at the first line that is blended
            at = np.arange(side) - margin + width // 2 + 1
            share = np.clip(at, 0, width + 1) / (width + 1)
            share -= np.clip(at - size, 0, width + 1) / (width + 1)
            low, high = 0, side
            if not axis.period:
                low, high = max(0, -start), min(side, length - start)
                share[:low] = share[max(high, 0) :] = 0
            odd = bool((axis.first + block) % 2)
            lines, first = self.kept[k][0], int(self.kept[k][1][block - axis.shown.start])
            share = share[first : first + lines]
            found.append(((size, low, high, odd), share, odd))
        return found

    def _paths(
        self, map_: Callable[..., Iterable[Any]]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Where blocks begin, for each line of their windows: from the left, and from above."""
        count, reach = (self.rows.count, self.columns.count), self.reach
        corners = np.zeros((count[0] + 1, count[1] + 1, 2), np.int32)
        side = self.sample.side
        inset = self.sample.margin - reach
        upright = np.full((count[0], count[1] + 1, side), self.sample.margin, np.int32)
        lying = np.full((count[0] + 1, count[1], side), self.sample.margin, np.int32)
        if reach == 0:
            return upright, lying
        least = min(int(axis.sizes.min()) for axis in (self.rows, self.columns))
        slack = min(reach // 2, (least - 1) // 4)
        box = min(_BOX, reach - slack)
        parity = (self.rows.first + self.columns.first) % 2
        shown = self.rows.shown
        about = self.rows.edges, self.columns.edges, self.wrap

        def meet(i: int) -> None:
            scratch = np.empty((2 * reach, 2 * reach), np.int64)
            seam_kernels.meet(
                self.sample.pixels, self.sample.visibility, self.place, *about, parity,
                inset, reach, slack, box, self.state, scratch, corners, i, i + 1,
            )  # fmt: skip

        def cut(lines: range) -> None:
            scratch = (
                self.known,
                self.state,
                np.empty((side, 2 * reach), np.int64),
                np.empty((side if len(self.state) else 0, 2 * reach + 1), np.int64),
                np.empty((side, 2 * reach + 1), np.int64),
                np.empty((side, 2 * reach + 1), np.int32),
                np.empty(side, np.int32),
            )
            looked = self.sample.pixels, self.sample.visibility, self.place
            if self.warps:
                beside = {k % count[0] for k in range(lines.start - 1, lines.stop)}
                looked = self.warps.shown(sorted(beside))
            shared = *looked, *about, corners, inset, reach
            ends = lines.start, min(lines.stop, shown.stop)
            seam_kernels.cut_edges(*shared, True, *scratch, upright, *ends)
            seam_kernels.cut_edges(*shared, False, *scratch, lying, lines.start, lines.stop)

        lines = range(shown.start, shown.stop + 1)
        list(map_(meet, lines))
        list(map_(cut, (lines[k : k + _LINES] for k in range(0, len(lines), _LINES))))
        return upright, lying

    def _cuts(self, upright: NDArray[np.int32], lying: NDArray[np.int32]) -> NDArray[np.uint16]:
        """First and last own columns and rows of each block, as `PatchSynthesis` keeps them."""
        rows, columns = self.rows.shown, self.columns.shown
        after = [slice(s.start + 1, s.stop + 1) for s in (rows, columns)]
        left = upright[rows, columns]
        right = upright[rows, after[1]] + self.columns.sizes[columns][None, :, None]
        top = lying[rows, columns]
        bottom = lying[after[0], columns] + self.rows.sizes[rows][:, None, None]
        (lines, first), (across, begin) = self.kept
        down = first[:, None, None] + np.arange(lines)
        along = begin[None, :, None] + np.arange(across)
        left, right = (
            np.clip(np.take_along_axis(c, np.broadcast_to(down, (*c.shape[:2], lines)), 2)
                    - begin[None, :, None], 0, across)
            for c in (left, right)
        )  # fmt: skip
        top, bottom = (
            np.clip(np.take_along_axis(c, np.broadcast_to(along, (*c.shape[:2], across)), 2)
                    - first[:, None, None], 0, lines)
            for c in (top, bottom)
        )  # fmt: skip
        y = self.rows.edges[:-1][rows][:, None, None] - self.sample.margin + down
        x = self.columns.edges[:-1][columns][None, :, None] - self.sample.margin + along
        height, width = self.canvas.shape
        if not self.rows.period:
            off = np.broadcast_to((y < 0) | (y >= height), left.shape)
            left, right = np.where(off, across, left), np.where(off, 0, right)
        if not self.columns.period:
            off = np.broadcast_to((x < 0) | (x >= width), top.shape)
            top, bottom = np.where(off, lines, top), np.where(off, 0, bottom)
        return np.concatenate([left, right, top, bottom], axis=2).astype(np.uint16)

    def _laid(
        self, cuts: NDArray[np.uint16], zones: NDArray[np.int64], weights: NDArray[np.uint16]
    ) -> PatchSynthesis:
        """Placements by kind: drawn ones of even rows, of odd rows, then the gaps."""
        rows, columns, sample = self.rows.shown, self.columns.shown, self.sample
        place = self.place[rows, columns]
        place = sample.windows.to_sample(place.ravel()).reshape(place.shape)
        i, j = np.indices(place.shape)
        y, x = np.divmod(place, sample.exemplar.shape[1])
        margin, height, width = sample.margin, *sample.exemplar.shape
        v, u = self.kept[0][1][i], self.kept[1][1][j]
        placements = np.stack(
            [
                (self.rows.edges[:-1][rows][i] - margin + v) % self.canvas.height,
                (self.columns.edges[:-1][columns][j] - margin + u) % self.canvas.width,
                (y + v) % height,
                (x + u) % width,
                zones,
            ],
            axis=-1,
        )
        kind = 2 * self.gap[rows, columns] + self.rows.numbers[rows][:, None] % 2
        order = np.argsort(kind.ravel(), kind="stable")
        order = order[self.laid[rows, columns].ravel()[order]]
        placements = placements.reshape(-1, 5)[order].astype(np.int32)
        if cuts.ndim == 3:
            cuts = np.ascontiguousarray(cuts.reshape(kind.size, -1)[order])
        about: dict[str, Any] = {"seed": self.seed}
        if any(self.origin):
            about["origin"] = list(self.origin)
        if any(self.canvas.wrap):
            about["strain"] = round(self.lattice.strain, 6)
        about = {
            "sample_shape": sample.exemplar.shape,
            "exemplar": sample.exemplar,
            "known_from": self.canvas.known_from,
            "provenance": self.method.describe() | about,
        }
        plan = self.canvas, np.ascontiguousarray(placements), weights, cuts
        lookup = sample.lookup
        if self.warps:
            if lookup is None:
                lookup = np.arange(height * width, dtype=np.int32).reshape(height, width)
            warps, within = self.warps.of(order, v, u)
            return WarpedSynthesis(*plan, lookup=lookup, warps=warps, within=within, **about)
        if lookup is None:
            return PatchSynthesis(*plan, **about)
        return RectifiedSynthesis(*plan, lookup=lookup, **about)

    def _preview(self) -> NDArray[np.uint8]:
        """The blocks that are there, with straight edges."""
        canvas = np.zeros((*self.canvas.shape, self.sample.exemplar.channels), np.uint8)
        width, margin = self.sample.pixels.shape[1], self.sample.margin
        for i in range(self.rows.shown.start, self.rows.shown.stop):
            for j in range(self.columns.shown.start, self.columns.shown.stop):
                if self.place[i, j] < 0:
                    continue
                y, x = np.divmod(int(self.place[i, j]), width)
                top, left = (int(axis.edges[k]) for axis, k in ((self.rows, i), (self.columns, j)))
                v, u = max(0, -top), max(0, -left)
                part = canvas[
                    top + v : int(self.rows.edges[i + 1]), left + u : int(self.columns.edges[j + 1])
                ]
                y, x = y + margin + v, x + margin + u
                part[:] = self.sample.pixels[
                    y : y + part.shape[0], x : x + part.shape[1], : canvas.shape[2]
                ]
        return canvas


def _weights(
    rows: tuple[Any, NDArray[np.float64], bool], columns: tuple[Any, NDArray[np.float64], bool]
) -> NDArray[np.uint16]:
    """Weights in 1/256 that lay four kinds of blocks, one after the other, as eqs. 4.6 to 4.8 say.

    Of the four blocks at a corner each is of another kind. One is laid with its share of what it
    and those before it have.
    """
    (_, along_y, odd_y), (_, along_x, odd_x) = rows, columns
    shares = {}
    for other_y in (False, True):
        for other_x in (False, True):
            y = along_y if other_y == odd_y else 1 - along_y
            x = along_x if other_x == odd_x else 1 - along_x
            # Drawn ones of even rows, drawn ones of odd rows, gaps of even rows, of odd rows.
            shares[2 * (other_y != other_x) + other_y] = np.outer(y, x)
    kind = 2 * (odd_y != odd_x) + odd_y
    own = shares[kind]
    before = sum(shares[k] for k in range(kind + 1))
    result = np.rint(256 * own / np.where(own > 0, before, 1))
    return result.astype(np.uint16)
