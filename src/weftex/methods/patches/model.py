"""A sample prepared for pasting patches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas, as_canvas
from weftex.endless.boxes import canvas_of, check_period
from weftex.endless.grid import Sizes
from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.patches.analysis import PatchAnalysis
from weftex.methods.patches.method import PatchMethod
from weftex.methods.patches.pasting import Output
from weftex.methods.patches.plane_order import PatchAxis, PlaneOrder, least_period
from weftex.progress import ProgressCallback
from weftex.random import seed_number
from weftex.results.patches import PatchSynthesis, PatchWindow
from weftex.threads import thread_count

if TYPE_CHECKING:
    from weftex.endless.boxes import Asked, Box
    from weftex.endless.corners import Pieces
    from weftex.random import Seed
    from weftex.results.synthesis import Synthesis

    #: Covers an output with patches: the algorithm of a method.
    Cover = Callable[[Output, Any], None]


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
        self._pieces: Pieces | None = None

    def sample(
        self,
        size: Canvas | int | tuple[int, int],
        *,
        seed: Seed = None,
        tileable: bool | str = False,
        threads: int | None = None,
        progress: ProgressCallback | None = None,
    ) -> PatchSynthesis:
        """See `Model.sample`."""
        canvas = as_canvas(size, tileable)
        self.require(canvas)
        number, count = seed_number(seed), thread_count(threads)
        canvas.check_known(self.exemplar)
        method = self._given.resolved_on(canvas, self.method)
        output = Output(self.analysis.for_method(method), canvas, number, count, progress)
        self._cover(output, method)
        placements, weights = output.placements, output.weights()
        if method.pixelwise:  # of the window only the pixel in the middle is pasted
            reach = output.frame.boundary_width
            placements[:, :2] = (placements[:, :2] + reach - output.frame.margin) % canvas.shape
            placements[:, 2:4] += reach
            placements[:, 4] = 0
            weights = np.full((1, 1, 1), 256, np.uint16)
        placements[:, 2:4] %= self.exemplar.shape
        return PatchSynthesis(
            canvas,
            placements,
            weights,
            output.cuts,
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            known_from=canvas.known_from,
            provenance=method.describe() | {"seed": number},
            picture=output.picture(),
        )

    @property
    def _plane_boundary(self) -> int:
        """The boundary width on planes: as around a wrapped axis, room is left between two."""
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
        self, box: Box, asked: Asked, progress: ProgressCallback | None = None
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
            from weftex.endless.corners import Pieces  # looks for lattices: only when needed

            self._pieces = Pieces(self.exemplar, analysis.windows(side, side)[0])
        order = partial(plan.order, seed=asked.seed, pieces=self._pieces)
        canvas = Canvas(*plan.frame_shape)
        output = Output(analysis, canvas, asked.seed, asked.threads, progress, order)
        self._cover(output, self.method)
        top, left = (span.first - at for span, at in zip(box, plan.corner, strict=True))
        here = slice(top, top + box.shape[0]), slice(left, left + box.shape[1])
        picture = output.picture()
        return PatchWindow(
            canvas_of(box),
            output.placements,
            output.weights(),
            output.cuts,
            frame=np.array([*canvas.shape, top, left]),
            sample_shape=self.exemplar.shape,
            exemplar=self.exemplar,
            is_window=True,
            provenance=self.method.describe() | asked.told,
            picture=None if picture is None else np.ascontiguousarray(picture[here]),
        )
