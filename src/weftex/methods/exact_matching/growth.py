"""How exact neighborhood matching makes an output: where it begins, and in which order it goes."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.exact_matching.candidates import Matching, Sheet
from weftex.random import draw
from weftex.raster.masks import peeled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.exact_matching import ExactMatchingModel
    from weftex.methods.exact_matching.candidates import Guide
    from weftex.methods.pixels.growth import Growth


@dataclass
class Statistics:
    """What one output cost: columns of Table 1.

    Attributes
    ----------
    tested : int
        Windows that were compared.
    pixels : int
        Pixels that they were compared for, those of the beginning included.
    initialization, synthesis : float
        Seconds.
    """

    tested: int = 0
    pixels: int = 0
    initialization: float = 0.0
    synthesis: float = 0.0


class ExactGrowth:
    """One output in the making.

    Parameters
    ----------
    model : ExactMatchingModel
        The sample.
    growth : Growth
        What to make.
    statistics : Statistics
        To be counted up.
    """

    def __init__(self, model: ExactMatchingModel, growth: Growth, statistics: Statistics) -> None:
        self.model, self.method = model, model.method
        self.growth, self.statistics = growth, statistics
        self.shapes = [growth.canvas.shape]
        while len(self.shapes) < len(model.samples):
            height, width = self.shapes[-1]
            self.shapes.append(((height + 1) // 2, (width + 1) // 2))

    def scan(self) -> None:
        """Section 4.2; from coarse to fine, if there are levels."""
        done: Level | None = None
        for level in reversed(range(len(self.shapes))):
            done = self._scan_level(level, done)
            self.growth.levels[:] = done.picture(self.growth.canvas.shape, level)
        assert done is not None
        self.growth.source[:] = done.places[done.top :]

    def fill(self) -> None:
        """Make what is not known between what is."""
        growth = self.growth
        candidates = self.model.candidates(0, "full")
        sheet = Sheet(growth.canvas.shape, growth.levels.shape[2], growth.canvas.wrap)
        sheet.levels, sheet.done = growth.levels, growth.done
        sheet.source = candidates.windows.from_sample(growth.source)
        self._between(Matching(candidates, sheet, self.method, self.growth.seed, "exact hole"))
        growth.source[:] = candidates.windows.to_sample(sheet.source)

    def _scan_level(self, level: int, coarser: Level | None) -> Level:
        """Make one level line by line, below a band that is there first and cropped at the end."""
        candidates = self.model.candidates(level, "causal")
        sample, wrap = self.model.samples[level], self.growth.canvas.wrap
        height, width = self.shapes[level]
        start = perf_counter()
        top = candidates.reach
        guide: Guide | None = None
        if coarser is None:
            band = self._beginning(level, width)
            if self.method.init == "random":
                top += candidates.reach  # rows that see random pixels are cropped too
        else:
            children, inside = coarser.children(top, (height, width), sample.shape)
            band = children[:top]
            suggested = np.where(inside, children, np.int32(-1))
            guide = coarser.below(top, (height, width)), suggested
        sheet = Sheet((top + height, width), sample.channels, (False, wrap[1]))
        candidates.put(sheet, np.s_[: len(band)], band)
        stage = f"exact {level}"
        matching = Matching(candidates, sheet, self.method, self.growth.seed, stage, guide)
        self._lines(matching, len(band), top, "beginning")
        middle = perf_counter()
        self._lines(matching, top, top + height, "rows", shown=level == 0)
        places = candidates.windows.to_sample(sheet.source)
        if wrap[0] and height > 1:
            self._close(level, sheet, places, top, guide)
        self.statistics.initialization += middle - start
        self.statistics.synthesis += perf_counter() - middle
        return Level(sheet.levels, places, top, sample.shape)

    def _lines(
        self, matching: Matching, first: int, last: int, stage: str, shown: bool = False
    ) -> None:
        """Scan some rows of a sheet."""
        width = matching.sheet.done.shape[1]
        progress = self.growth.progress(last - first, stage)
        for row in range(first, last):
            self._make(matching, np.arange(row * width, (row + 1) * width, dtype=np.int32))
            if shown:
                self.growth.levels[row - first] = matching.sheet.levels[row]
            progress.advance(1)

    def _make(self, matching: Matching, order: NDArray[np.int32]) -> None:
        self.statistics.tested += matching.make(order)
        self.statistics.pixels += len(order)

    # ------------------------------------------------------------ initialisation, section 4.3

    def _beginning(self, level: int, width: int) -> NDArray[np.int32]:
        """Places for the band above the canvas, as high as a window reaches."""
        candidates = self.model.candidates(level, "causal")
        if self.method.init == "structured":
            return self._structured_band(level, width)
        centres = candidates.windows.to_sample(candidates.windows.centres)
        bits = draw(self.growth.seed, "exact band", *np.indices((candidates.reach, width)))
        band: NDArray[np.int32] = centres[bits % np.uint64(len(centres))]
        return band

    def _structured_band(self, level: int, width: int) -> NDArray[np.int32]:
        """A band made as a picture of its own, from its left to its right end.

        Sample and band are turned by exchanging their axes: the scan then runs along the band, and
        nearly all of each window is known. A block of the sample covers the beginning.
        """
        candidates = self.model.candidates(level, "turned")
        windows, high = candidates.windows, candidates.reach
        sheet = Sheet((width, high), windows.pixels.shape[2], (False, False))
        bits = draw(self.growth.seed, "exact block", 0)
        corner = windows.centres[bits % np.uint64(len(windows.centres))]
        y, x = np.indices((min(high, width), high)) - high  # inside the window of that centre
        block = corner + y * windows.pixels.shape[1] + x
        candidates.put(sheet, np.s_[: len(y)], windows.to_sample(block.astype(np.int32)))
        matching = Matching(candidates, sheet, self.method, self.growth.seed, "exact structure")
        self._lines(matching, len(y), width, "beginning")
        columns, rows = np.divmod(windows.to_sample(sheet.source), windows.shape[1])
        return np.ascontiguousarray((rows * windows.shape[0] + columns).T)

    # ------------------------------------------------------------------ between known pixels

    def _between(self, matching: Matching) -> None:
        """From the known pixels inwards; then over it again, now that windows are whole."""
        sheet = matching.sheet
        unknown = sheet.done == 0
        matching.candidates.name_colors(sheet)
        progress = self.growth.progress(int(unknown.sum()) * (1 + self.method.passes), "pixels")
        for layer in peeled(unknown, sheet.wrap):
            # Nothing else is left to chance here, unless colours are few.
            shuffled = np.argsort(draw(self.growth.seed, "exact layer", layer), kind="stable")
            self._make(matching, layer[shuffled])
            progress.advance(len(layer))
        order = np.flatnonzero(unknown).astype(np.int32)
        lines = np.split(order, np.flatnonzero(np.diff(order // unknown.shape[1])) + 1)
        for number in range(self.method.passes):
            again = matching.again(f"exact pass {number}")
            for line in lines:
                self._make(again, line)
                progress.advance(len(line))

    def _close(
        self,
        level: int,
        sheet: Sheet,
        places: NDArray[np.int32],
        top: int,
        guide: Guide | None,
    ) -> None:
        """Make the last rows of a level again, between those above and the first ones."""
        candidates = self.model.candidates(level, "full")
        height, width = places[top:].shape
        rows = min(2 * candidates.reach + 1, height // 2)
        whole = Sheet((height, width), sheet.levels.shape[2], self.growth.canvas.wrap)
        candidates.put(whole, np.s_[: height - rows], places[top : top + height - rows])
        if guide is not None:
            guide = guide[0][top:], guide[1][top:]
        stage = f"exact seam {level}"
        self._between(Matching(candidates, whole, self.method, self.growth.seed, stage, guide))
        places[top:] = candidates.windows.to_sample(whole.source)
        sheet.levels[top:] = whole.levels


@dataclass(frozen=True)
class Level:
    """A level of the pyramid that is done, with the band above it.

    Parameters
    ----------
    levels : uint8 array (H, W, K)
        The bytes.
    places : int32 array (H, W)
        Flat indices into the level's sample.
    top : int
        Rows of the band.
    sample_shape : (int, int)
        Of the level.
    """

    levels: NDArray[np.uint8]
    places: NDArray[np.int32]
    top: int
    sample_shape: tuple[int, int]

    def picture(self, shape: tuple[int, int], level: int) -> NDArray[np.uint8]:
        """The level without its band, as large as the canvas."""
        y, x = (np.arange(n) >> level for n in shape)
        shown: NDArray[np.uint8] = self.levels[self.top :][np.ix_(y, x)]
        return shown

    def below(self, top: int, shape: tuple[int, int]) -> NDArray[np.uint8]:
        """The bytes of each finer pixel's parent, for a canvas of this shape below `top` rows."""
        return np.ascontiguousarray(self.levels[np.ix_(*self._parents(top, shape))])

    def children(
        self, top: int, shape: tuple[int, int], sample_shape: tuple[int, int]
    ) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """Where each finer pixel's parent leads to in the finer sample, and whether that is in it.

        Places beyond it are moved to its last row or column.
        """
        v, u = np.divmod(self.places[np.ix_(*self._parents(top, shape))], self.sample_shape[1])
        v = 2 * v + (np.arange(-top, shape[0]) % 2)[:, None]
        u = 2 * u + np.arange(shape[1]) % 2
        inside = (v < sample_shape[0]) & (u < sample_shape[1])
        v, u = np.minimum(v, sample_shape[0] - 1), np.minimum(u, sample_shape[1] - 1)
        return (v * sample_shape[1] + u).astype(np.int32), inside

    def _parents(
        self, top: int, shape: tuple[int, int]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        rows = np.arange(-top, shape[0]) // 2 + self.top
        return np.maximum(rows, 0), np.arange(shape[1]) // 2
