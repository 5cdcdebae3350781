"""A sample prepared for laying patches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import Canvas, as_canvas
from weftex.exemplar import Exemplar
from weftex.method import Model
from weftex.methods.patches.analysis import PatchAnalysis
from weftex.methods.patches.pasting import Output
from weftex.methods.patches.settings import PatchMethod, PatchSettings
from weftex.progress import ProgressCallback
from weftex.random import seed_number
from weftex.results.patches import PatchSynthesis
from weftex.threads import thread_count

if TYPE_CHECKING:
    from weftex.random import Seed


class PatchModel(Model):
    """A sample prepared for a method that lays patches; `sample` makes outputs from it.

    Parameters
    ----------
    method : PatchMethod
        Parameters.
    settings : PatchSettings
        What they settle to for this sample.
    exemplar : Exemplar
        The sample.
    cover : callable
        The algorithm: covers an `Output`, given the method. A function of a module, so that models
        can be pickled.
    """

    method: PatchMethod

    def __init__(
        self,
        method: PatchMethod,
        settings: PatchSettings,
        exemplar: Exemplar,
        cover: Callable[[Output, Any], None],
    ) -> None:
        compared = settings.search != "exhaustive" and not settings.anything
        self.method = replace(
            method,
            patch_size=settings.patch_size,
            randomness=None,
            boundary_width=settings.boundary_width,
            candidates=settings.candidates if compared else None,
        )
        self.exemplar = exemplar
        self.analysis = PatchAnalysis(settings, exemplar)
        self._cover = cover

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
        self.method.require(canvas)
        number, count = seed_number(seed), thread_count(threads)
        canvas.check_known(self.exemplar)
        output = Output(self.analysis, canvas, number, count, progress)
        self._cover(output, self.method)
        placements, weights = output.placements, output.weights()
        if output.settings.pixelwise:  # of the window only the pixel in the middle is laid
            reach = output.settings.boundary_width
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
            provenance=self.method.describe() | {"seed": number},
            picture=output.picture(),
        )
