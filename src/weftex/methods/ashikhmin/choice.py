"""The choice of pixels among coherent candidates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.ashikhmin import growth_kernels as kernels
from weftex.notes import note, parts
from weftex.random import draw
from weftex.seams.path import least_path

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.ashikhmin.settings import Settings
    from weftex.methods.pixels.growth import Growth
    from weftex.search.windows import Windows

#: Random places that stand in for candidates outside the sample. The paper takes one; among eight
#: one matches better, so the same pieces of the sample come back less often.
_REPLACEMENTS = 8
#: Rows over which the end of a wrapped canvas meets its beginning.
_ROWS_TO_CLOSE = 32
_CLOSING = -1  # instead of the number of a pass
_ONE = 256  # a weight of 1 in distances, which are integers


class Choice:
    """Chooses the pixels of one output.

    Parameters
    ----------
    settings : Settings
        See there.
    windows : Windows
        Of the sample.
    guide : uint8 array (H, W, K)
        The sample's own guide for the pixels of the windows.
    growth : Growth
        The output.

    Attributes
    ----------
    rows_to_close : int
        Rows that are made twice where the canvas wraps along y; at least 2, or 0.
    """

    def __init__(
        self, settings: Settings, windows: Windows, guide: NDArray[np.uint8], growth: Growth
    ) -> None:
        self._windows, self._half, self._growth = windows, settings.half, growth
        canvas = growth.canvas
        followed, weight, jumps = np.zeros((1, 1, 1), np.uint8), 0, settings.jumps
        if canvas.guide is not None:
            followed = growth.exemplar.as_guide(canvas.guide)
            weight, jumps = round(_ONE * settings.guide_weight), settings.jumps_with_guide
        growth.about["jumps"] = jumps
        self._tries = max(jumps, _REPLACEMENTS)
        width, channels = settings.window_width, growth.pixels.shape[2]
        self._sample = kernels.Sample(windows, guide, settings.half)
        self._picture = kernels.Picture(
            growth.pixels, growth.done, growth.source, canvas.wrap, followed, weight
        )
        self._candidates = np.empty(width * width + self._tries + 1, np.int32)
        self._search = kernels.Search(
            jumps,
            np.empty((width * (settings.half + 1), 3), np.int32),
            np.empty(width * width * channels, np.uint8),
            self._candidates,
        )
        rows = min(_ROWS_TO_CLOSE, canvas.height // 4)
        self.rows_to_close = rows if rows > 1 and growth.hole is None and canvas.wrap[0] else 0
        pixels = canvas.height * canvas.width if growth.hole is None else int(growth.hole.sum())
        total = settings.passes * pixels + self.rows_to_close * canvas.width
        self._progress = growth.progress(total, "pixels")

    def choose(self, line: NDArray[np.int32], number: int, *, around: bool = False) -> None:
        """Choose some pixels one after the other.

        Parameters
        ----------
        line : int32 array
            Their flat indices.
        number : int
            Of the pass; from 1 on, the pixel's own source is a candidate too.
        around : bool
            Windows go around the canvas along y, even if it does not wrap.
        """
        seed, tries = self._growth.seed, np.arange(self._tries)
        strangers = random_places(self._windows, seed, "ashikhmin", number, line[:, None], tries)
        for part, asked in parts(line, self._growth.canvas.width):
            if asked:
                self._candidates.fill(-1)
                note("window", growth=self._growth, number=number, half=self._half)
            kernels.choose(
                *(self._sample, self._picture, self._search),
                *(line[part], strangers[part], around, number > 0),
            )
            if asked:
                note("chosen", growth=self._growth, places=self._candidates)
        self._progress.advance(len(line))

    def close(self, lines: list[NDArray[np.int32]]) -> None:
        """Make the first lines again, below the last; cut where old and new differ least."""
        growth, rows = self._growth, len(lines)
        hidden = slice(0, rows + self._half)
        pixels, source = growth.pixels[:rows].copy(), growth.source[:rows].copy()
        growth.done[hidden] = 0
        for line in lines:
            self.choose(line, _CLOSING, around=True)
        growth.done[hidden] = 1
        apart = ((pixels.astype(np.int64) - growth.pixels[:rows]) ** 2).sum(axis=2)
        cut = least_path((apart[:-1] + apart[1:]).T, closed=growth.canvas.wrap[1])
        old = np.arange(rows)[:, None] > cut
        growth.pixels[:rows][old], growth.source[:rows][old] = pixels[old], source[old]


def random_places(
    windows: Windows, seed: int, purpose: str, *place: NDArray[np.integer] | int
) -> NDArray[np.int32]:
    """Draw centers of windows evenly, one for each place; see `weftex.random.draw`."""
    centers = windows.centers
    share = (draw(seed, purpose, *place) >> np.uint64(32)) * np.uint64(len(centers))
    places: NDArray[np.int32] = centers[share >> np.uint64(32)]
    return places
