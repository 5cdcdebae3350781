"""Synthesizing natural textures (Ashikhmin, 2001): pixels continue their neighbors' sources."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from weftex.exemplar import Exemplar
from weftex.methods.ashikhmin.choice import Choice, random_places
from weftex.methods.pixels import Growth, PixelModel, WindowedMethod, square_width
from weftex.parameters import parameter
from weftex.raster.masks import peeled
from weftex.search.windows import Windows, square_windows

_PROPOSED_WIDTH = 5


@dataclass(frozen=True)
class Ashikhmin(WindowedMethod):
    """Synthesis of natural textures from coherent candidates.

    The candidates of a pixel are the sample pixels that continue the sources of its neighbors. So
    pieces of the sample grow, in any shape, until another piece fits better. With a guide, the
    output follows another picture.

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
        "side of the square window that is compared, odd; wider keeps larger shapes",
        low=1,
        parity="odd",
        unit="px",
        default_text="5, less for a very small sample",
        control="size",
    )
    passes: int = parameter(
        2,
        "number of passes over all pixels; passes after the first compare the whole window",
        low=1,
        high=100,
    )
    guide_weight: float = parameter(
        0.3,
        "weight of the guide against the pixels made so far; higher follows the guide more closely",
        low=0.01,
        high=100.0,
        needs_canvas="guide",
    )

    def fit_exemplar(self, exemplar: Exemplar) -> PixelModel:
        """Find the whole windows of a sample and of its guide."""
        method = self.resolved(exemplar)
        width = method.window_for(0)
        windows = square_windows(exemplar, width)
        guide = windows.pixels  # the picture's channels come first, those of its maps after
        if exemplar.guide is not None:
            guide = square_windows(exemplar, width, exemplar.as_guide(exemplar.guide)).pixels
        return PixelModel(method, exemplar, Prepared(method, windows, guide), grow)

    def resolved(self, exemplar: Exemplar) -> Self:
        """See `Method.resolved`."""
        return replace(
            self, window_width=square_width(self.window_width, exemplar, _PROPOSED_WIDTH)
        )


@dataclass(frozen=True, eq=False)
class Prepared:
    """A sample prepared for synthesis from coherent candidates."""

    method: Ashikhmin  # resolved
    windows: Windows  # the sample's whole windows
    guide: NDArray[np.uint8]  # (H, W, K): the sample's own for their pixels, or these themselves

    @property
    def half(self) -> int:
        """How far a window reaches from its center, in pixels."""
        return self.method.window_for(0) // 2


def grow(prepared: Prepared, growth: Growth) -> None:
    """Choose all pixels several times (section 3); those of a hole in layers from its border."""
    method, half = prepared.method, prepared.half
    guided = growth.canvas.guide is not None
    weight = method.guide_weight if guided else 0.0
    choice = Choice(prepared.windows, half, prepared.guide, weight, growth)
    choice.progress = growth.progress(choice.count(method.passes), "pixels")
    if growth.hole is not None:
        layers = peeled(growth.hole, growth.canvas.wrap)
        for number in range(method.passes):
            for layer in layers:
                choice.choose(layer, number)
        return
    height, width = growth.canvas.shape
    lines = list(np.arange(height * width, dtype=np.int32).reshape(height, width))
    start_from_noise(prepared, growth)
    # First pass, in scan order. Each pixel has as candidates its neighbors' sources, shifted by the
    # step from the neighbor to it, and random places for those outside the sample. It is copied
    # from the one whose L-shaped window is most like its own, and the guide's like the output's:
    # see `candidate_kernels.choose` and `guide_distance` there.
    for i, line in enumerate(lines):
        if i < half and height > 2 * half:
            # Around the border, as the paper's windows go, to the random pixels above, not below.
            noise = slice(height - half + i, None)
            growth.done[noise] = 1
            choice.choose(line, 0, around=True)
            growth.done[noise] = 0
        else:
            choice.choose(line, 0)
    if choice.rows_to_close:
        choice.close(lines[: choice.rows_to_close])
    # Further passes, with the whole window and candidates from all neighbors.
    for number in range(1, method.passes):
        for line in lines:
            choice.choose(line, number)


def start_from_noise(prepared: Prepared, growth: Growth) -> None:
    """Fill the last rows, which the windows of the first see above them, with random pixels."""
    rows = slice(max(0, growth.canvas.height - prepared.half), None)
    index = np.arange(growth.source.size).reshape(growth.source.shape)[rows]
    source = random_places(prepared.windows, growth.seed, "ashikhmin start", index)
    growth.source[rows] = source
    growth.pixels[rows] = prepared.windows.pixels.reshape(-1, growth.pixels.shape[2])[source]
