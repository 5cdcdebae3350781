"""Corners of a plane: pieces of the sample, copied whole."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.planes.grid import Block


class Corners:
    """Where corners may be cut from a sample.

    Parameters
    ----------
    exemplar : Exemplar
        The sample; its mask is respected.
    side : int
        Of a corner, in pixels.
    """

    def __init__(self, exemplar: Exemplar, side: int) -> None:
        self.shape, self.side = exemplar.shape, side
        places = np.empty((0, 2), np.int64)
        try:
            usable = windows_of(exemplar, (0, side - 1, 0, side - 1)).usable
            places = np.argwhere(usable[: self.shape[0], : self.shape[1]])
        except InvalidInputError:
            pass  # no piece as large can be used; the method makes one
        self.places = places

    def cut(self, block: Block, bits: int) -> NDArray[np.int32] | None:
        """Flat indices of the piece for a corner; None where the sample has no piece so large.

        Corners beside each other come from other quarters of the sample, so that no copies lie
        side by side, although no corner knows of another.
        """
        if not len(self.places):
            return None
        rows = _half(self.places, 0, block.row % 2)
        own = _half(rows, 1, block.column % 2)
        y, x = own[bits % len(own)]
        v = (y + np.arange(self.side)) % self.shape[0]
        u = (x + np.arange(self.side)) % self.shape[1]
        piece: NDArray[np.int32] = (v[:, None] * self.shape[1] + u).astype(np.int32)
        return piece


def _half(places: NDArray[np.int64], axis: int, which: int) -> NDArray[np.int64]:
    """The places whose row or column is above the median, or not; all if there are none."""
    above = places[:, axis] > np.median(places[:, axis])
    half = places[above if which else ~above]
    return half if len(half) else places
