"""Synthesis initialization (section 4.3): the band above a picture, and coarser levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.exact_matching.matching import Matching, Parents, Sheet
from weftex.random import draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.exact_matching.lists import ColorLists
    from weftex.methods.exact_matching.matching import Statistics
    from weftex.methods.exact_matching.settings import Settings
    from weftex.methods.pixels.growth import Growth


def random_band(lists: ColorLists, width: int, seed: int) -> NDArray[np.int32]:
    """Choose random pixels of the sample for a band as high as a window reaches.

    Returns flat indices into the sample, (reach, width).
    """
    centers = lists.windows.to_sample(lists.windows.centers)
    bits = draw(seed, "exact band", *np.indices((lists.reach, width)))
    band: NDArray[np.int32] = centers[bits % np.uint64(len(centers))]
    return band


def structured_band(
    turned: ColorLists, width: int, settings: Settings, growth: Growth, cost: Statistics
) -> NDArray[np.int32]:
    """Make a band as a picture of its own, from its left to its right end.

    Sample and band are turned by exchanging their axes: the scan then runs along the band, and
    nearly all of each window is known. A block of the sample covers the beginning.

    Parameters
    ----------
    turned : ColorLists
        Of the turned sample.
    width : int
        Of the band, in pixels.
    settings : Settings
        See there.
    growth : Growth
        Its seed chooses.
    cost : Statistics
        Is counted up.

    Returns
    -------
    int32 array (reach, width)
        Flat indices into the sample as it was before it was turned.
    """
    windows, high = turned.windows, turned.reach
    sheet = Sheet((width, high), windows.pixels.shape[2], (False, False))
    bits = draw(growth.seed, "exact block", 0)
    corner = windows.centers[bits % np.uint64(len(windows.centers))]
    y, x = np.indices((min(high, width), high)) - high  # inside the window of that center
    block = corner + y * windows.pixels.shape[1] + x
    sheet.put(turned, windows.to_sample(block.astype(np.int32)))
    matching = Matching(turned, sheet, settings, growth, cost)
    matching.scan(range(len(block), width), "exact structure", "beginning")
    columns, rows = np.divmod(windows.to_sample(sheet.source), windows.shape[1])
    return np.ascontiguousarray((rows * windows.shape[0] + columns).T)


@dataclass(frozen=True, eq=False)
class FinishedLevel:
    """A level of the pyramid that is done, with the band above it.

    Parameters
    ----------
    pixels : uint8 array (H, W, K)
        The bytes.
    places : int32 array (H, W)
        Flat indices into the level's sample.
    top : int
        Rows of the band.
    columns : int
        Of the level's sample.
    """

    pixels: NDArray[np.uint8]
    places: NDArray[np.int32]
    top: int
    columns: int

    def picture(self, shape: tuple[int, int], level: int) -> NDArray[np.uint8]:
        """The level without its band, as large as the canvas."""
        y, x = (np.arange(n) >> level for n in shape)
        shown: NDArray[np.uint8] = self.pixels[self.top :][np.ix_(y, x)]
        return shown

    def children(
        self, top: int, shape: tuple[int, int], sample_shape: tuple[int, int]
    ) -> tuple[NDArray[np.int32], Parents]:
        """Lead to the next finer level.

        Parameters
        ----------
        top : int
            Rows of the finer level's band.
        shape : (int, int)
            Of the finer level without it.
        sample_shape : (int, int)
            Of the finer level's sample.

        Returns
        -------
        band : int32 array (top, W)
            Flat indices into the finer sample. Places beyond it are moved to its last row or
            column.
        parents : Parents
            For the band and the level.
        """
        rows = np.maximum(np.arange(-top, shape[0]) // 2 + self.top, 0)
        parents = np.ix_(rows, np.arange(shape[1]) // 2)
        y, x = np.divmod(self.places[parents], self.columns)
        y = 2 * y + (np.arange(-top, shape[0]) % 2)[:, None]
        x = 2 * x + np.arange(shape[1]) % 2
        inside = (y < sample_shape[0]) & (x < sample_shape[1])
        y, x = np.minimum(y, sample_shape[0] - 1), np.minimum(x, sample_shape[1] - 1)
        places = (y * sample_shape[1] + x).astype(np.int32)
        suggested = np.where(inside, places, np.int32(-1))
        return places[:top], Parents(np.ascontiguousarray(self.pixels[parents]), suggested)
