"""Texture synthesis (section 4.2): pixels of a picture, one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.methods.exact_matching import match_kernels as kernels
from weftex.random import draw
from weftex.raster.masks import grown, peeled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.exact_matching.lists import ColorLists
    from weftex.methods.exact_matching.settings import Settings
    from weftex.methods.pixels.growth import Growth

_MOST_NEIGHBORS = 8


@dataclass
class Statistics:
    """What one output costs: columns of Table 1.

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

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the seconds of a block to `initialization` or `synthesis`."""
        start = perf_counter()
        yield
        setattr(self, stage, getattr(self, stage) + perf_counter() - start)


class Parents(NamedTuple):
    """The next coarser level, for each pixel of a sheet.

    Attributes
    ----------
    pixels : uint8 array (H, W, K)
        Bytes of the pixel's parent.
    suggested : int32 array (H, W)
        Flat index into the sample that the parent's source leads to, or -1.
    """

    pixels: NDArray[np.uint8]
    suggested: NDArray[np.int32]


class Sheet:
    """A picture in the making.

    Attributes
    ----------
    pixels : uint8 array (H, W, K)
        The bytes that distances are taken on.
    done : uint8 array (H, W)
        1 where a pixel is known or made.
    source : int32 array (H, W)
        Flat index into the pixels of the lists' windows, or -1.
    color : int32 array (H, W)
        Number of the color, or -1.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis go around.
    """

    def __init__(self, shape: tuple[int, int], channels: int, wrap: tuple[bool, bool]) -> None:
        self.wrap = wrap
        self.pixels = np.zeros((*shape, channels), np.uint8)
        self.done = np.zeros(shape, np.uint8)
        self.source = np.full(shape, -1, np.int32)
        self.color = np.full(shape, -1, np.int32)

    def put(self, lists: ColorLists, places: NDArray[np.int32]) -> None:
        """Copy pixels to the first rows; `places` are flat indices into the sample."""
        rows = slice(len(places))
        source = lists.windows.from_sample(places)
        self.pixels[rows] = lists.windows.pixels.reshape(-1, self.pixels.shape[2])[source]
        self.source[rows] = source
        self.done[rows] = 1
        self.name_colors(lists)

    def name_colors(self, lists: ColorLists) -> None:
        """Find the color numbers of known pixels; of a color that is not listed, the nearest one's.

        Only known pixels that touch an unknown one are looked up.
        """
        wanted = (self.color < 0) & (self.done > 0) & grown(self.done == 0, 1, self.wrap)
        source = self.source[wanted]
        number = lists.index.number.ravel()[source]
        strange = source < 0
        number[strange] = lists.index.nearest(self.pixels[wanted][strange])
        self.color[wanted] = number


class Matching:
    """Makes pixels of a sheet.

    Parameters
    ----------
    lists : ColorLists
        The windows to choose from.
    sheet : Sheet
        The picture to fill.
    settings : Settings
        See there.
    growth : Growth
        Its seed breaks ties; it reports on progress.
    cost : Statistics
        Is counted up.
    parents : Parents, optional
        The next coarser level.
    """

    def __init__(
        self,
        lists: ColorLists,
        sheet: Sheet,
        settings: Settings,
        growth: Growth,
        cost: Statistics,
        parents: Parents | None = None,
    ) -> None:
        self.sheet, self._settings, self._growth, self._cost = sheet, settings, growth, cost
        channels = sheet.pixels.shape[2]
        if parents is None:
            parents = Parents(np.empty((0, 0, channels), np.uint8), np.empty((0, 0), np.int32))
        self._sample = lists.for_kernels()
        self._picture = kernels.Picture(
            sheet.pixels, sheet.done, sheet.source, sheet.color, sheet.wrap,
            parents.pixels, np.ones(parents.suggested.shape, np.uint8),
            _centers_at(lists, parents.suggested),
        )  # fmt: skip
        self._rule = kernels.Rule(
            lists.causal, lists.reach, lists.coarse_reach, settings.repeat_distance,
            lists.causal and settings.copying == "blocks", settings.candidates,
        )  # fmt: skip
        self._last = np.empty(lists.windows.usable.size, np.int32)
        self._search = kernels.Search(
            self._last,
            np.zeros(lists.windows.usable.size, np.int32),
            lists.recent(),
            [_window_room(reach, channels) for reach in (lists.reach, lists.coarse_reach)],
            (np.empty(_MOST_NEIGHBORS, np.int32), np.empty(_MOST_NEIGHBORS + 1, np.intp)),
        )
        self._begin_pass()

    def scan(
        self, rows: range, purpose: str, stage: str, shown: NDArray[np.uint8] | None = None
    ) -> None:
        """Make rows of the sheet in scanline order.

        Parameters
        ----------
        rows : range
            Of the sheet.
        purpose : str
            Of the random bits.
        stage : str
            For the progress.
        shown : uint8 array (len(rows), W, K), optional
            Takes each row when it is made.
        """
        width = self.sheet.done.shape[1]
        progress = self._growth.progress(len(rows), stage)
        for i, row in enumerate(rows):
            self._make(np.arange(row * width, (row + 1) * width, dtype=np.int32), purpose)
            if shown is not None:
                shown[i] = self.sheet.pixels[row]
            progress.advance(1)

    def fill(self, purpose: str) -> None:
        """Make all unknown pixels from the known ones inwards; then again, with whole windows.

        Beyond the paper. Windows look to all sides, and all eight neighbors are direct ones.
        """
        unknown = self.sheet.done == 0
        passes = self._settings.passes
        progress = self._growth.progress(int(unknown.sum()) * (1 + passes), "pixels")
        for layer in peeled(unknown, self.sheet.wrap):
            # Nothing else is left to chance here, unless colors are few.
            bits = draw(self._growth.seed, "exact layer", layer)
            self._make(layer[np.argsort(bits, kind="stable")], purpose)
            progress.advance(len(layer))
        order = np.flatnonzero(unknown).astype(np.int32)
        lines = np.split(order, np.flatnonzero(np.diff(order // unknown.shape[1])) + 1)
        for number in range(passes):
            self._begin_pass()
            for line in lines:
                self._make(line, f"exact pass {number}")
                progress.advance(len(line))

    def _begin_pass(self) -> None:
        """Note for each place of the sample the last pixel of the sheet that is copied from it."""
        self._last.fill(-1)
        made = np.flatnonzero(self.sheet.source >= 0)
        np.maximum.at(self._last, self.sheet.source.ravel()[made], made)

    def _make(self, order: NDArray[np.int32], purpose: str) -> None:
        """Make the pixels of these flat indices, one after the other."""
        bits = draw(self._growth.seed, purpose, order)
        self._cost.pixels += len(order)
        self._cost.tested += kernels.match_pixels(
            self._sample, self._picture, self._rule, self._search, order, bits
        )


def _centers_at(lists: ColorLists, places: NDArray[np.int32]) -> NDArray[np.int32]:
    """Turn flat indices into the sample into those of the windows; -1 where none is centered."""
    found = lists.windows.from_sample(places)
    usable = lists.windows.usable.ravel()[found] > 0
    return np.where((places >= 0) & usable, found, np.int32(-1))


def _window_room(reach: int, channels: int) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Space for the runs and the bytes of a window."""
    side = 2 * reach + 1
    runs = np.empty((side * (reach + 1) + 1, 3), np.int32)
    return runs, np.empty(side * side * channels, np.uint8)
