"""Synthesizing natural textures (Ashikhmin, 2001): pixels go on from their neighbors' sources."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from weftex.methods.ashikhmin.choice import Choice, random_places
from weftex.methods.ashikhmin.model import Prepared, prepare
from weftex.methods.ashikhmin.settings import settle
from weftex.methods.pixels.growth import PixelModel, WindowedMethod
from weftex.parameters import parameter
from weftex.raster.masks import peeled

if TYPE_CHECKING:
    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth


@dataclass(frozen=True)
class Ashikhmin(WindowedMethod):
    """Synthesis of natural textures from coherent candidates.

    A pixel is copied from a place where the source of one of its neighbors goes on, so pieces of
    the sample of any shape grow until another one fits better. A guide makes the picture follow
    another one.

    Examples
    --------
    >>> import numpy as np, weftex
    >>> sample = weftex.Exemplar(np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8))
    >>> weftex.Ashikhmin(passes=1).fit(sample).sample((40, 50), seed=7).image.shape
    (40, 50)
    """

    slug: ClassVar[str] = "ashikhmin"
    title: ClassVar[str] = "Coherent candidates"
    paper: ClassVar[str] = (
        "M. Ashikhmin: Synthesizing natural textures. Symposium on Interactive 3D Graphics, 2001"
    )
    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known", "guide", "many"})

    window_width: int | None = parameter(
        None,
        "window around a pixel that is compared; odd, wider keeps larger shapes",
        low=1,
        parity="odd",
        unit="pixels",
        default_text="5, less if the sample has no room",
    )
    passes: int = parameter(
        2,
        "times that all pixels are chosen; after the first with the whole window",
        low=1,
        high=100,
    )
    jumps: int | None = parameter(
        None,
        "random places tried for every pixel too; more follows a guide better and breaks shapes",
        low=0,
        high=1000,
        default_text="0, with a guide 1",
    )
    guide_weight: float = parameter(
        0.3,
        "how much the guide counts beside what is made",
        low=0.01,
        high=100.0,
        needs_canvas="guide",
    )

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """See `Method.fit`."""
        settings = settle(self, exemplar)
        settled = replace(self, window_width=settings.window_width)
        return PixelModel(settled, exemplar, prepare(settings, exemplar), grow)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`."""
        return replace(self, window_width=settle(self, exemplar).window_width)


def grow(prepared: Prepared, growth: Growth) -> None:
    """Choose all pixels several times (section 3); those of a hole in layers from its border."""
    settings = prepared.settings
    choice = Choice(settings, prepared.windows, prepared.guide, growth)
    if growth.hole is not None:
        layers = peeled(growth.hole, growth.canvas.wrap)
        for number in range(settings.passes):
            for layer in layers:
                choice.choose(layer, number)
        return
    height, width = growth.canvas.shape
    lines = list(np.arange(height * width, dtype=np.int32).reshape(height, width))
    start_from_noise(prepared, growth)
    # First pass, in scan order. Each pixel has as candidates its neighbors' sources, shifted by the
    # step from the neighbor to it, and random places for those outside the sample. It is copied
    # from the one whose L-shaped window is most like its own, and the guide's like the output's:
    # see `growth_kernels.choose` and `guide_distance` there.
    for i, line in enumerate(lines):
        if i < settings.half:
            # Around the border, as the paper's windows go, to the random pixels of the last rows.
            noise = slice(max(i + 1, height - settings.half), None)
            growth.done[noise] = 1
            choice.choose(line, 0, around=True)
            growth.done[noise] = 0
        else:
            choice.choose(line, 0)
    if choice.rows_to_close:
        choice.close(lines[: choice.rows_to_close])
    # Further passes, with the whole window and candidates from all neighbors.
    for number in range(1, settings.passes):
        for line in lines:
            choice.choose(line, number)


def start_from_noise(prepared: Prepared, growth: Growth) -> None:
    """Fill the last rows, which the windows of the first see above them, with random pixels."""
    rows = slice(max(0, growth.canvas.height - prepared.settings.half), None)
    index = np.arange(growth.source.size).reshape(growth.source.shape)[rows]
    source = random_places(prepared.windows, growth.seed, "ashikhmin start", index)
    growth.source[rows] = source
    growth.pixels[rows] = prepared.windows.pixels.reshape(-1, growth.pixels.shape[2])[source]
