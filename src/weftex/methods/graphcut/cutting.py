"""Patch fitting: cutting patches out along old and new seams, and finding the worst seams.

Sections 3 and 4 of Kwatra et al., 2003.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from weftex.canvas import Canvas
from weftex.methods.graphcut import cost_kernels, graph_kernels
from weftex.methods.graphcut.placement import Patch, Placement
from weftex.methods.graphcut.sample import CutSample
from weftex.methods.pixels import Growth
from weftex.raster.boxes import box_sums
from weftex.seams import search_trees

_TOLERATED = 1.4  # times the least cost, of patches that another seed fills a hole by
_NO_PRICES = np.zeros((0, 0), np.int32)
_CELL = 8  # side in pixels of the squares that the costs of seams are summed over


class CutCanvas:
    """The canvas so far, with old seams: the labels of all patches that were pasted.

    Candidates are cut in `threads`, in blocks of the placement's `reduction` pixels a side.
    `copies`: all patches lie in one of the sample's oriented copies. Not in the paper: what a pixel
    repeats has a price in each cut, so that rarely shown parts of the sample are kept.
    """

    def __init__(
        self, sample: CutSample, growth: Growth, placement: Placement, threads: int, *, copies: bool
    ) -> None:
        self.growth, canvas, size = growth, growth.canvas, placement.size
        self.shape, self.sample_shape = canvas.shape, sample.exemplar.shape
        self.done, self.block_exponent = growth.done.ravel(), placement.reduction.bit_length() - 1
        fixed = self.done.copy()
        if canvas.shown is not None and canvas.hole is not None:
            fixed = (~canvas.hole).ravel().astype(np.uint8)
        pixels, self.runs = growth.pixels.reshape(fixed.size, -1), np.zeros(fixed.size, np.int8)
        self.labeling = cost_kernels.Labeling(
            (pixels, growth.source.ravel(), self.done, fixed, self.runs),
            self.shape,
            canvas.wrap,
            sample.kernel_arrays,
            self.sample_shape,
            sample.is_whole(copies),
        )
        cost_kernels.find_runs(self.labeling)
        # All lines of both, and a patch's length more, around the border.
        self._lines = [
            [np.arange(n + side, dtype=np.int32) % n for n, side in zip(shape, size, strict=True)]
            for shape in (self.shape, self.sample_shape)
        ]
        self._graphs = [_graph(self.labeling, *size) for _ in range(threads)]  # that are free
        # Not in the paper: seed 1 fills a hole by the cheapest patches, each other seed by others.
        fills = canvas.known is not None and (canvas.shown is None or canvas.known_from is not None)
        self.filling = (growth.seed - 1) % 2**64 if fills else 0
        self.penalty = None if fills else placement.penalty
        self.guiding = placement.guiding
        self._least, self._tolerated = math.inf, _TOLERATED if self.filling else 1.0

    def missing(self) -> Iterator[tuple[int, int]]:
        """Yield the first pixel that is missing, until none is."""
        first, done = 0, self.done.view(bool)
        while not done[first := first + int(done[first:].argmin())]:
            yield divmod(first, self.shape[1])

    def cheapest(self, patches: list[Patch], map_: Callable[..., Any] = map) -> Patch:
        """Return the patch of the least `cost`, or one that costs little more, see `filling`.

        Candidates may meet in one patch, which is cut once, with the least of their factors.
        """
        different: dict[tuple[int, ...], Patch] = {}
        for patch in patches:
            if patch.factor < different.setdefault(patch[:-1], patch).factor:
                different[patch[:-1]] = patch
        self._least = math.inf
        costs = dict(zip(different.values(), map_(self.cost, different.values()), strict=True))
        most = max(min(costs.values()) * times for times in (1.0, self._tolerated))
        good = sorted((patch for patch in costs if costs[patch] <= most), key=costs.__getitem__)
        self.filling, which = divmod(self.filling, len(good))
        return good[which]

    def cost(self, patch: Patch) -> float:
        """By how much a patch raises the cost of seams, for each missing pixel, times its factor.

        It is cut in blocks along the seam of least cost, new and old seams counted (section 3.1).
        Where another one is cheaper than this one can still be, a value between both costs.
        """
        # A little more, as rounding must not keep the cheapest one from its cost.
        least = max(self._least, 0.0) * self._tolerated / patch.factor * (1 + 1e-9)
        graph = self._graph_of(patch)
        more, covered = graph_kernels.cost_in_blocks(graph, self.block_exponent, least)
        self._graphs.append(graph)
        each: float = more / max(covered, 1)
        cost = each * patch.factor if each > 0 else each / patch.factor
        self._least = min(self._least, cost)
        return cost

    def paste(self, patch: Patch) -> int:
        """Cut a patch in smaller and smaller blocks and copy it; return the pixels that it adds."""
        graph = self._graph_of(patch)
        # From half as wide as in `cost`: of all candidates, only this one is cut finely.
        covered: int = graph_kernels.paste_patch(graph, max(0, self.block_exponent - 1))
        self._graphs.append(graph)
        return covered

    def _graph_of(self, patch: Patch) -> graph_kernels.Graph:
        """Take a free graph, and set it to the box of a patch."""
        (down, along), (from_rows, from_columns) = self._lines
        y, x = patch.top % self.shape[0], patch.left % self.shape[1]
        v, u = patch.source_top % self.sample_shape[0], patch.source_left % self.sample_shape[1]
        box = (
            down[y : y + patch.height],
            along[x : x + patch.width],
            from_rows[v : v + patch.height],
            from_columns[u : u + patch.width],
        )
        graph = self._graphs.pop()
        penalty = self.penalty
        prices = _NO_PRICES if penalty is None else penalty.prices(box)
        exponent = 0 if penalty is None else penalty.cell.bit_length() - 1
        if self.guiding is not None:
            prices, exponent = self.guiding.prices(box, prices, exponent), 0
        graph.set_box(*box, prices, exponent)
        return graph


def _graph(labeling: cost_kernels.Labeling, height: int, width: int) -> graph_kernels.Graph:
    """Allocate the graph of a patch."""
    return graph_kernels.Graph(
        labeling,
        choice=np.empty((height, width), np.uint8),
        side=np.empty((height, width), np.uint8),
        near=np.empty((height, width), np.uint8),
        costs=np.empty(max(height, width), np.int32),
        arcs=np.empty((height, width, 4), np.int32),
        from_source=np.empty((height, width), np.int32),
        to_sink=np.empty((height, width), np.int32),
        **search_trees(height, width),
    )


class WorstSeams:
    """The costs of all seams of a covered canvas, kept up to date as patches are pasted.

    The worst, to be refined, are in the square of cells, half as wide as a patch, that costs most.
    """

    def __init__(self, cut_canvas: CutCanvas, canvas: Canvas, patch_size: tuple[int, int]) -> None:
        self.labeling, self.canvas = cut_canvas.labeling, canvas
        self.cost = np.zeros(canvas.shape, np.int32)
        self.cells = np.zeros([-(-n // _CELL) for n in canvas.shape], np.int64)
        self.tried = np.zeros_like(self.cells)
        self.idle = 0  # patches since one lowered the cost of seams
        self.spans = [
            min(max(1, size // (2 * _CELL)), n)
            for size, n in zip(patch_size, self.cells.shape, strict=True)
        ]
        self.guiding, self.guided = cut_canvas.guiding, np.zeros(canvas.shape, np.int32)
        self.update(0, 0, *canvas.shape)

    def update_around(self, patch: Patch) -> None:
        """Update the costs of seams that a patch may have changed."""
        before = int(self.cells.sum())
        self.update(patch.top - 1, patch.left - 1, patch.height + 1, patch.width + 1)
        self.idle = 0 if int(self.cells.sum()) < before else self.idle + 1

    def update(self, top: int, left: int, height: int, width: int) -> None:
        """Update the costs of the seams in a box."""
        lines = []
        for start, length, n, wraps in zip(
            (top, left), (height, width), self.canvas.shape, self.canvas.wrap, strict=True
        ):
            line = start + np.arange(length, dtype=np.int32)
            lines.append(line[:n] % n if wraps else line[(line >= 0) & (line < n)])
        rows, columns = lines
        cost_kernels.sum_seams(self.labeling, rows, columns, self.cost, self.cells, _CELL)
        if self.guiding is not None:
            guided, box = self.guiding.now(rows, columns), np.ix_(rows, columns)
            cells = np.ix_(rows // _CELL, columns // _CELL)
            np.add.at(self.cells, cells, guided - self.guided[box])
            self.guided[box] = guided

    def worst(self) -> tuple[int, int] | None:
        """The middle of the square, half a patch wide, whose seams cost most; None if none do.

        A tried cell counts half next time, or a seam that cannot be improved would block others.
        """
        both = zip(self.spans, self.canvas.wrap, strict=True)
        beyond = [(0, span - 1 if wraps else 0) for span, wraps in both]
        cost = np.pad(self.cells >> np.minimum(self.tried, 62), beyond, mode="wrap")
        squares = box_sums(cost, *self.spans)
        first = np.unravel_index(squares.argmax(), squares.shape)
        if squares[first] == 0:
            return None
        middle, cells = [], []
        for at, span, count, n, wraps in zip(
            first, self.spans, self.cells.shape, self.canvas.shape, self.canvas.wrap, strict=True
        ):
            cells.append((at + np.arange(span)) % count)
            center = int(at) * _CELL + span * _CELL // 2
            middle.append(center % n if wraps else min(center, n - 1))
        self.tried[np.ix_(*cells)] += 1
        return middle[0], middle[1]
