"""Synthesizing natural textures (Ashikhmin, 2001): pixels go on from what their neighbours copy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from weftex.method import parameter
from weftex.methods.ashikhmin import growth_kernels as kernels
from weftex.methods.pixels.growth import PixelModel, settle_window
from weftex.methods.pixels.order import scan_lines
from weftex.methods.pixels.windowed import WindowedMethod
from weftex.random import draw
from weftex.raster.masks import peeled
from weftex.seams.path import least_path
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth

_WIDTH = 5
#: Random places that stand in for candidates outside the sample. The paper takes one; among eight
#: one matches better, so the same pieces of the sample come back less often.
_REPLACEMENTS = 8
#: Rows over which the end of a wrapped canvas meets its beginning.
_BAND = 32
_CLOSING = -1  # in place of the number of a pass
_ONE = 256  # a weight of 1 in distances, which are integers


@dataclass(frozen=True)
class Ashikhmin(WindowedMethod):
    """Synthesis of natural textures from coherent candidates.

    A pixel is copied from where one of its neighbours' sources goes on, so pieces of the sample of
    any shape grow until another one fits better. A guide makes the picture follow another one.

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

    def fit(self, exemplar: Exemplar) -> AshikhminModel:
        """See `Method.fit`."""
        return AshikhminModel(self, exemplar)


class AshikhminModel(PixelModel):
    """A sample prepared for coherent candidates; see `Ashikhmin`."""

    method: Ashikhmin

    def __init__(self, method: Ashikhmin, exemplar: Exemplar) -> None:
        settled = settle_window(method, exemplar, _WIDTH)
        super().__init__(settled, exemplar)
        self._half: int = settled.window_width // 2
        self.windows = windows_of(exemplar, (self._half,) * 4)

    def grow(self, growth: Growth) -> None:
        """Choose all pixels, `passes` times (section 3); a hole in layers from its border."""
        canvas, half, windows = growth.canvas, self._half, self.windows
        start = growth.hole is None
        lines = scan_lines(*canvas.shape)
        if growth.hole is not None:
            lines = peeled(growth.hole, canvas.wrap)
        elif half:
            self._start_from_noise(growth)
        guide, weight, jumps = np.zeros((1, 1, 1), np.uint8), 0, 0
        own_guide = windows.pixels  # the picture's channels come first, those of its maps after
        if canvas.guide is not None:
            guide = self.exemplar.as_guide(canvas.guide)
            weight, jumps = round(_ONE * self.method.guide_weight), 1
            if self.exemplar.guide is not None:
                own = self.exemplar.as_guide(self.exemplar.guide)
                own_guide = windows_of(self.exemplar, (half,) * 4, own).pixels
        jumps = jumps if self.method.jumps is None else self.method.jumps
        tries = max(jumps, _REPLACEMENTS)
        scratch = _scratch(half, growth.levels.shape[2], tries)
        band = min(_BAND, canvas.height // 4) if start and canvas.wrap[0] else 0
        total = self.method.passes * sum(map(len, lines)) + band * canvas.width
        progress = growth.progress(total, "pixels")

        def choose(line: NDArray[np.int32], around: bool, number: int) -> None:
            strangers = self._random_places(
                growth.seed, "ashikhmin", number, line[:, None], np.arange(tries)
            )
            kernels.choose(
                growth.levels, growth.done, growth.source, line,
                windows.pixels, windows.usable, windows.period, half,
                canvas.wrap[0] or around, canvas.wrap[1],
                strangers, jumps, own_guide, guide, weight, number > 0, *scratch,
            )  # fmt: skip
            progress.advance(len(line))

        for number in range(self.method.passes):
            for i, line in enumerate(lines):
                noise = slice(max(i + 1, canvas.height - half), None)
                above = start and number == 0 and i < half
                if above:  # around the border, as the paper's windows go
                    growth.done[noise] = 1
                choose(line, above, number)
                if above:
                    growth.done[noise] = 0
            if number == 0 and band > 1:
                self._close(growth, lines[:band], choose)

    def _close(
        self,
        growth: Growth,
        lines: list[NDArray[np.int32]],
        choose: Callable[[NDArray[np.int32], bool, int], None],
    ) -> None:
        """Go on from the last rows over the first, and cut where old and new differ least."""
        band, hidden = len(lines), slice(0, len(lines) + self._half)
        levels, source = growth.levels[:band].copy(), growth.source[:band].copy()
        growth.done[hidden] = 0
        for line in lines:
            choose(line, True, _CLOSING)
        growth.done[hidden] = 1
        apart = ((levels.astype(np.int64) - growth.levels[:band]) ** 2).sum(axis=2)
        cut = least_path((apart[:-1] + apart[1:]).T, closed=growth.canvas.wrap[1])
        old = np.arange(band)[:, None] > cut
        growth.levels[:band][old], growth.source[:band][old] = levels[old], source[old]

    def _start_from_noise(self, growth: Growth) -> None:
        """Fill the last rows, which the windows of the first see above them, with random pixels."""
        rows = slice(max(0, growth.canvas.height - self._half), None)
        index = np.arange(growth.source.size).reshape(growth.source.shape)[rows]
        source = self._random_places(growth.seed, "ashikhmin start", index)
        growth.source[rows] = source
        growth.levels[rows] = self.windows.pixels.reshape(-1, growth.levels.shape[2])[source]

    def _random_places(
        self, seed: int, purpose: str, *place: NDArray[np.integer] | int
    ) -> NDArray[np.int32]:
        """Centres of windows of the sample, drawn evenly."""
        centres = self.windows.centres
        share = (draw(seed, purpose, *place) >> np.uint64(32)) * np.uint64(len(centres))
        places: NDArray[np.int32] = centres[share >> np.uint64(32)]
        return places


def _scratch(half: int, channels: int, tries: int) -> tuple[NDArray[Any], ...]:
    """Room for a window's runs, its bytes, and the places to compare."""
    width = 2 * half + 1
    return (
        np.empty((width * (half + 1), 3), np.int32),
        np.empty(width * width * channels, np.uint8),
        np.empty(width * width + tries + 1, np.int32),
    )
