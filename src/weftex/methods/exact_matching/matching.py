"""Texture synthesis (section 4.2) and its initialization (4.3): pixels of a sheet, one by one."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from weftex.methods.exact_matching import match_kernels as kernels
from weftex.methods.exact_matching.lists import ColorLists
from weftex.methods.pixels import Growth
from weftex.random import draw
from weftex.raster.arrays import Bytes, Indices
from weftex.raster.masks import grown, peeled
from weftex.raster.pyramids import children
from weftex.search.picture_kernels import Picture
from weftex.search.windows import new_query

_MOST_NEIGHBORS = 8
_PASSES = 2  # over pixels between known ones, after the first


class Parents(NamedTuple):
    """The next coarser level, for each pixel of a sheet."""

    pixels: Bytes  # (H, W, K): bytes of the pixel's parent
    # (H, W): flat index into the sample that continues the parent's source, or -1
    suggested: Indices

    def below(self, row: int) -> Parents:
        """Those of the rows from one on."""
        return Parents(self.pixels[row:], self.suggested[row:])


class Sheet:
    """A level of the output, below the `top` rows of the band that it begins with."""

    def __init__(
        self, lists: ColorLists, shape: tuple[int, int], wrap: tuple[bool, bool], top: int = 0
    ) -> None:
        self.lists, self.wrap, self.top = lists, wrap, top
        # (H, W, K): the bytes that are compared
        self.pixels = np.zeros((*shape, lists.windows.pixels.shape[2]), np.uint8)
        self.done = np.zeros(shape, np.uint8)  # (H, W): 1 where a pixel is known or made
        # (H, W): flat index into the pixels of the lists' windows, or -1
        self.source = np.full(shape, -1, np.int32)
        self.color = np.full(shape, -1, np.int32)  # (H, W): number of the color, or -1

    @property
    def places(self) -> Indices:
        """Flat indices into the sample, (H, W)."""
        return self.lists.windows.to_sample(self.source)

    def put(self, places: Indices, row: int = 0) -> None:
        """Copy pixels to some rows from one on; `places` are flat indices into the sample."""
        rows = slice(row, row + len(places))
        source = self.lists.windows.from_sample(places)
        self.pixels[rows] = self.lists.windows.pixels.reshape(-1, self.pixels.shape[2])[source]
        self.source[rows], self.done[rows] = source, 1
        self.name_colors()

    def name_colors(self) -> None:
        """Find the color numbers of known pixels that touch an unknown one.

        A color that is not listed takes the number of the nearest one.
        """
        wanted = (self.color < 0) & (self.done > 0) & grown(self.done == 0, 1, self.wrap)
        source = self.source[wanted]
        number = self.lists.index.number.ravel()[source]
        unlisted = source < 0
        number[unlisted] = self.lists.index.nearest(self.pixels[wanted][unlisted])
        self.color[wanted] = number

    def parents(
        self, top: int, shape: tuple[int, int], sample_shape: tuple[int, int]
    ) -> tuple[Indices, Parents]:
        """Return the band (top, W) and the `Parents` of the next finer level.

        `shape` is the finer level's without its band of `top` rows. The band has flat indices into
        the finer sample, clamped to its last row and column.
        """
        rows, columns = np.arange(-top, shape[0])[:, None], np.arange(shape[1])
        above = np.maximum(rows // 2 + self.top, 0), columns // 2
        y, x = children(self.places[above], self.lists.windows.shape[1], rows, columns)
        inside = (y < sample_shape[0]) & (x < sample_shape[1])
        y, x = np.minimum(y, sample_shape[0] - 1), np.minimum(x, sample_shape[1] - 1)
        places = (y * sample_shape[1] + x).astype(np.int32)
        suggested = np.where(inside, places, np.int32(-1))
        return places[:top], Parents(np.ascontiguousarray(self.pixels[above]), suggested)


def random_band(lists: ColorLists, width: int, seed: int) -> Indices:
    """Return (reach, width) flat indices of random pixels of the sample: a band one reach high."""
    centers = lists.windows.to_sample(lists.windows.centers)
    bits = draw(seed, "exact band", *np.indices((lists.reach, width)))
    band: Indices = centers[bits % np.uint64(len(centers))]
    return band


def structured_band(turned: ColorLists, width: int, method: Any, growth: Growth) -> Indices:
    """Return (reach, width) flat indices into the sample: a band synthesized from left to right.

    Sample and band are transposed, so nearly all of each window is known. A block of the sample
    covers the beginning.
    """
    windows, high = turned.windows, turned.reach
    sheet = Sheet(turned, (width, high), (False, False))
    bits = draw(growth.seed, "exact block", 0)
    corner = windows.centers[bits % np.uint64(len(windows.centers))]
    y, x = np.indices((min(high, width), high)) - high  # inside the window of that center
    block = corner + y * windows.pixels.shape[1] + x
    sheet.put(windows.to_sample(block.astype(np.int32)))
    Matching(sheet, method, growth).scan(range(len(block), width), "exact structure", "beginning")
    columns, rows = np.divmod(sheet.places, windows.shape[1])
    return np.ascontiguousarray((rows * windows.shape[0] + columns).T)


class Matching:
    """Synthesizes pixels of a sheet; `parents` are its next coarser level."""

    def __init__(
        self, sheet: Sheet, method: Any, growth: Growth, parents: Parents | None = None
    ) -> None:
        self.sheet, self._method, self._growth = sheet, method, growth
        lists, channels = sheet.lists, sheet.pixels.shape[2]
        if parents is None:
            parents = Parents(np.empty((0, 0, channels), np.uint8), np.empty((0, 0), np.int32))
        self._lists = lists.for_kernels()
        self._picture = Picture(sheet.pixels, sheet.done, sheet.source, sheet.wrap)
        self._last = np.empty(lists.windows.usable.size, np.int32)
        #: The stamp of the search that met a window last.
        self.seen = np.zeros(lists.windows.usable.size, np.int32)
        of_neighbors = np.empty(_MOST_NEIGHBORS, np.int32)
        everywhere = np.ones(parents.suggested.shape, np.uint8)
        self._search = kernels.PixelSearch(
            (
                lists.causal, lists.reach, lists.coarse_reach, method.repeat_distance,
                method.candidates,
            ),
            (parents.pixels, everywhere, _centers_at(lists, parents.suggested)),
            [new_query(reach, channels) for reach in (lists.reach, lists.coarse_reach)],
            (of_neighbors, np.empty(_MOST_NEIGHBORS + 1, np.intp), of_neighbors.copy()),
            sheet.color,
            self._last,
            self.seen,
        )  # fmt: skip
        self._begin_pass()

    def scan(self, rows: range, purpose: str, stage: str, shown: Bytes | None = None) -> None:
        """Synthesize rows of the sheet in scan order.

        Random bits are drawn for `purpose`, progress is reported as `stage`, and finished rows are
        copied to `shown` (len(rows), W, K).
        """
        width = self.sheet.done.shape[1]
        progress = self._growth.progress(len(rows), stage)
        for i, row in enumerate(rows):
            self.make(np.arange(row * width, (row + 1) * width, dtype=np.int32), purpose)
            if shown is not None:
                shown[i] = self.sheet.pixels[row]
            progress.advance(1)

    def fill(self, purpose: str) -> None:
        """Synthesize all unknown pixels inward from the known ones, then again with whole windows.

        Beyond the paper: windows reach to all sides, and all eight neighbors are direct ones.
        """
        unknown = self.sheet.done == 0
        progress = self._growth.progress(int(unknown.sum()) * (1 + _PASSES), "pixels")
        for layer in peeled(unknown, self.sheet.wrap):
            # Nothing else is left to chance here, unless colors are few.
            bits = draw(self._growth.seed, "exact layer", layer)
            self.make(layer[np.argsort(bits, kind="stable")], purpose)
            progress.advance(len(layer))
        order = np.flatnonzero(unknown).astype(np.int32)
        lines = np.split(order, np.flatnonzero(np.diff(order // unknown.shape[1])) + 1)
        for number in range(_PASSES):
            self._begin_pass()
            for line in lines:
                self.make(line, f"exact pass {number}")
                progress.advance(len(line))

    def _begin_pass(self) -> None:
        """Note for each place of the sample the last pixel of the sheet that is copied from it."""
        self._last.fill(-1)
        made = np.flatnonzero(self.sheet.source >= 0)
        np.maximum.at(self._last, self.sheet.source.ravel()[made], made)

    def make(self, order: Indices, purpose: str) -> None:
        """Make the pixels of these flat indices, one after the other."""
        bits = draw(self._growth.seed, purpose, order)
        compared = kernels.match_pixels(self._lists, self._picture, self._search, order, bits)
        about = self._growth.about  # columns of Table 1
        about["pixels_chosen"] = about.get("pixels_chosen", 0) + len(order)
        about["windows_compared"] = about.get("windows_compared", 0) + compared


def _centers_at(lists: ColorLists, places: Indices) -> Indices:
    """Turn flat indices into the sample into those of the windows; -1 where none is centered."""
    found = lists.windows.from_sample(places)
    usable = lists.windows.usable.ravel()[found] > 0
    return np.where((places >= 0) & usable, found, np.int32(-1))
