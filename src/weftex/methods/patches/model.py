"""A sample prepared for pasting patches, and an output while it is covered with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from threading import get_ident
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.endless.boxes import Box, PlaneRequest, canvas_of, check_period
from weftex.endless.corners import SamplePieces
from weftex.endless.grid import Sizes
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.patches.analysis import PatchAnalysis, Zones, ZoneSearch
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.orders import (
    Order,
    Run,
    frame_of,
    scan_patches,
    scan_pixels,
    spiral_patches,
)
from weftex.methods.patches.patch_kernels import SKIPPED, Patches, Shortlist, Tolerance, lay_patches
from weftex.methods.patches.plane_order import PatchAxis, PlaneOrder, least_period
from weftex.progress import Progress, ProgressCallback
from weftex.results.paste_kernels import Layout
from weftex.results.patches import PatchSynthesis
from weftex.results.synthesis import Synthesis
from weftex.threads import thread_map

#: Covers an output with patches: the algorithm of a method.
Cover = Callable[["PatchCanvas", Any], None]


class PatchModel(Model):
    """A sample prepared for a method that pastes patches.

    `cover`, a function of a module, covers a canvas with them.
    """

    method: PatchMethod

    def __init__(self, method: PatchMethod, exemplar: Exemplar, cover: Cover) -> None:
        self.exemplar, self._given, self._cover = exemplar, method, cover
        self.method = method.resolved(exemplar)
        smaller = method.resolved_on(Canvas(1, 1), self.method) != self.method
        self.analysis = PatchAnalysis(self.method, exemplar, ahead=not smaller)
        self._pieces: SamplePieces | None = None

    def make(
        self, canvas: Canvas, seed: int, threads: int, progress: ProgressCallback | None
    ) -> PatchSynthesis:
        """See `Model.make`."""
        canvas.check_known(self.exemplar)
        method = self._given.resolved_on(canvas, self.method)
        output = PatchCanvas(self.analysis.for_method(method), canvas, seed, threads, progress)
        self._cover(output, method)
        placements = output.placements
        if method.pixelwise:  # of the window only the pixel in the middle is pasted
            reach = output.frame.boundary_width
            placements[:, :2] = (placements[:, :2] + reach - output.frame.margin) % canvas.shape
            placements[:, 2:4] += reach
            placements[:, 4] = 0
        placements[:, 2:4] %= self.exemplar.shape
        about, known_from = method.describe() | {"seed": seed}, canvas.known_from
        return output.synthesis(canvas, about, picture=output.picture(), known_from=known_from)

    @property
    def _plane_boundary(self) -> int:
        """The boundary width on planes: as on a wrapped axis, two zones of a patch do not touch."""
        assert self.method.boundary_width
        return max(1, min(self.method.boundary_width, self.method.window_side // 4))

    def block_sizes(self) -> Sizes:
        """See `Model.block_sizes`: edges are one patch wide."""
        if self.method.pixelwise:
            return super().block_sizes()
        axis = PatchAxis.of(self.method.window_side, self._plane_boundary, None)
        step = axis.patches.period
        return Sizes(pitch=step * axis.nodes.period, belt=step)

    def make_window(
        self, box: Box, asked: PlaneRequest, progress: ProgressCallback | None = None
    ) -> Synthesis:
        """See `Model.make_window`: patches of a plane have an order of their own."""
        if self.method.pixelwise:
            return super().make_window(box, asked, progress)
        side, width = self.method.window_side, self._plane_boundary
        check_period(asked.period, least_period(side, width))
        analysis = self.analysis.for_method(replace(self.method, boundary_width=width))
        down, across = asked.period or (None, None)
        axes = PatchAxis.of(side, width, down), PatchAxis.of(side, width, across)
        plan = PlaneOrder(axes, box)
        if self._pieces is None:
            self._pieces = SamplePieces(self.exemplar, analysis.windows(side, side)[0])
        order = partial(plan.order, seed=asked.seed, pieces=self._pieces)
        canvas = Canvas(*plan.frame.shape)
        output = PatchCanvas(analysis, canvas, asked.seed, asked.threads, progress, order)
        self._cover(output, self.method)
        here, picture = box.within(plan.frame), output.picture()
        picture = None if picture is None else np.ascontiguousarray(picture[here])
        frame = np.array([*canvas.shape, *(at.start for at in here)])
        about = self.method.describe() | asked.told
        return output.synthesis(canvas_of(box), about, picture=picture, frame=frame, is_window=True)


class PatchCanvas:
    """A canvas while it is covered with patches.

    `plane` makes the order of the patches of a plane's window; by default the canvas determines it.
    """

    def __init__(
        self,
        analysis: PatchAnalysis,
        canvas: Canvas,
        seed: int,
        threads: int,
        callback: ProgressCallback | None,
        plane: Callable[[Zones], Order] | None = None,
    ) -> None:
        self.analysis, self.method = analysis, analysis.method
        self.frame = frame_of(self.method, canvas)
        self.seed, self._threads, self._callback = seed, threads, callback
        self._wanted = self.method.candidates or 0  # 0: all windows are compared
        self._zones = Zones(analysis, self.frame.boundary_width)
        # (H, W, K): the frame as it is matched; 0 where nothing was pasted
        self.pixels = np.zeros((*self.frame.shape, analysis.pixels.shape[2]), np.uint8)
        if self.frame.known is not None and plane is None:
            self.pixels[self.frame.inside] = self._known_pixels()
        self.order = plane(self._zones) if plane else self._order(seed)
        # (n, 5): y, x of each patch, y, x of its source, number of its zone
        self.placements = np.zeros((len(self.order.corners), 5), np.int32)
        self.placements[:, :2] = self.order.corners
        # (n, 2 * (rows + columns)) or (0, 0): minimum-error paths, see `paste_kernels.Layout`
        self.cuts = np.zeros((0, 0), np.uint16)
        if self.method.blend == "cut" and not self.method.pixelwise:
            self.cuts = np.zeros((len(self.placements), 2 * sum(self.frame.window)), np.uint16)
        pictures, pasted = (analysis.pixels, analysis.transposed), (self.placements, self.cuts)
        drawn = self.order.bits, self.order.around
        self._patches = Patches(*pictures, *pasted, *drawn, self.method.keep_apart)
        #: The candidates of a patch, of each thread.
        self._shortlists: dict[int, Shortlist] = {}

    def _order(self, seed: int) -> Order:
        """The order of the patches by the canvas."""
        if self.frame.known is not None:
            return spiral_patches(self.frame, self._zones, seed)
        if self.method.pixelwise:
            return scan_pixels(self.frame, self._zones, seed)
        return scan_patches(self.frame, self._zones, seed, self._threads)

    def _known_pixels(self) -> NDArray[np.uint8]:
        """The known pixels of the canvas, as they are matched."""
        exemplar, canvas = self.analysis.exemplar, self.frame.canvas
        if canvas.shown is not None:  # a block of a plane
            return self.analysis.pixels[np.divmod(canvas.shown, exemplar.shape[1])]
        if exemplar.maps:
            raise InvalidInputError("a hole's surroundings lack the sample's maps; use weftex.fill")
        assert canvas.known is not None
        return exemplar.as_matching(canvas.known)

    def paste_in_order(self, paste: Callable[[Run], None]) -> None:
        """Call `paste` with every run of the order, in threads where runs are independent."""
        order = self.order
        progress = Progress(self._callback, order.total, order.stage, self._preview)

        def paste_piece(piece: list[Run]) -> None:
            for run in piece:
                paste(run)

        with thread_map(self._threads if order.parallel else 1) as map_:
            for step in order.steps:
                list(map_(paste_piece, step.pieces))
                progress.advance(step.done)

    def search_for(self, run: Run) -> ZoneSearch:
        """Return the search of the sample's windows by the boundary zone of a run."""
        return self._zones.searches[run.zone]

    def choose_and_paste(self, run: Run, search: ZoneSearch, tolerance: Tolerance) -> None:
        """Choose the sources of a run's patches within a tolerance, and paste each patch."""
        self.placements[run.first : run.last, 4] = run.zone
        weights = self._zones.weights[run.zone]
        layout = Layout(self.placements, weights, self.cuts, *self.frame.shape)
        shortlist = self._shortlist()
        # A kd-tree is searched from Python, for one patch at a time.
        step = run.last - run.first if search.tree is None else 1
        for first in range(run.first, run.last, step):
            if search.tree is not None:
                y, x = self.placements[first, :2].tolist()
                shortlist.put(search.nearest_in_tree(self.pixels, y, x, self._wanted))
            lay_patches(
                self.pixels, self._patches, first, first + step, layout, search.kernel,
                tolerance, shortlist,
            )  # fmt: skip

    def _shortlist(self) -> Shortlist:
        """Return this thread's candidates, allocated for any patch."""
        if get_ident() not in self._shortlists:
            analysis, window, wanted = self.analysis, self.frame.window, self._wanted
            room = len(analysis.windows(*window)[1])
            if wanted:  # the stride is halved until it is 1; it is at most the side of a block
                room = wanted + SKIPPED * analysis.square_side
            numbers = window[0] * window[1] * analysis.pixels.shape[2]
            depth = max(self.frame.boundary_width, min(window) // 2)  # of a band with a path
            self._shortlists[get_ident()] = Shortlist(
                wanted,
                corners=np.empty(room, np.int32),
                distances=np.empty(room, np.int64),
                marks=np.empty(room, np.uint8),
                zone=np.empty(numbers, np.uint8),
                means=np.empty(numbers, np.int32),
                coordinates=np.empty(numbers, np.int16),
                path=np.empty((max(window), depth), np.int64),
            )
        return self._shortlists[get_ident()]

    def synthesis(self, canvas: Canvas, about: dict[str, Any], **more: Any) -> PatchSynthesis:
        """Return the patches as a result on a canvas, which may be a part of the frame."""
        found = [search.zone.weight for search in self._zones.searches]
        weights = np.stack(found) if found else np.zeros((0, *self.frame.window), np.uint16)
        if self.method.pixelwise:
            weights = np.full((1, 1, 1), 256, np.uint16)
        return PatchSynthesis(
            canvas,
            self.placements,
            weights,
            self.cuts,
            exemplar=self.analysis.exemplar,
            provenance=about,
            **more,
        )

    def picture(self) -> NDArray[np.uint8] | None:
        """The matched pixels where they are the picture itself, so that it need not be rendered."""
        exemplar = self.analysis.exemplar
        if self.pixels.dtype != exemplar.pixels.dtype or exemplar.mixing.kind:
            return None
        if self.pixels.shape[2] != exemplar.channels:
            return None
        if self.method.blend == "feather-at-end" and not self.method.pixelwise:
            return None
        shape = *self.frame.canvas.shape, *exemplar.pixels.shape[2:]
        return self.pixels[self.frame.inside].reshape(shape)

    def _preview(self) -> NDArray[np.uint8]:
        return self.pixels[self.frame.inside][..., : self.analysis.exemplar.channels].copy()
