"""What it costs to show places of the sample again, which is no idea of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut.repeats import Repeats
from weftex.methods.graphcut.sight import Sight

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.methods.graphcut.copies import Copy
    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

# What it costs to show again in sight all that is new, and as often as the mean what is anywhere.
_AGAIN, _USED = 0.3, 0.05
_MOST = 4.0  # times the mean that count; more are no worse
_LOOK = 2  # pixels of the smallest copy; so many apart what is shown is looked at


class ShownAgain:
    """By what the costs of places are multiplied for what they show again.

    These are shares of what a match costs, so one that is clearly better is never given up.

    Parameters
    ----------
    settings, growth
        The sample and the canvas.
    sample : Copy
        The sample in full size.
    holes : list of (int, int)
        First row and one after the last where something is missing, and columns.
    reduction : int
        How many times smaller the smallest copy is.
    """

    def __init__(
        self,
        settings: Settings,
        growth: Growth,
        sample: Copy,
        holes: list[tuple[int, int]],
        reduction: int,
    ) -> None:
        shape = settings.exemplar.shape
        self.variety = settings.variety
        self.repeats = Repeats(settings.exemplar, growth, shape, shape, _LOOK * reduction)
        self.sight = Sight(growth, sample, holes)

    def turn_to(self, pixel: tuple[int, int]) -> None:
        """Say which pixel the next patch covers; the one before is laid."""
        self.repeats.turn_to(*pixel)

    def of(
        self,
        pixel: tuple[int, int],
        allowed: NDArray[np.bool_],
        k: int,
        offset: list[int],
        missing: Callable[[], NDArray[np.bool_]],
    ) -> NDArray[np.float64]:
        """Of the places that come to lie on a pixel.

        Parameters
        ----------
        pixel : (int, int)
            Of the canvas.
        allowed : bool array
            The places, every 2**k-th both ways; of others nothing is said.
        k : int
        offset : (int, int)
            From the corner of `missing` to the pixel.
        missing : callable
            Tells which pixels around it are missing, every 2**k-th both ways.
        """
        used = self.repeats.used_where(missing(), k, offset, allowed)
        rows, columns, cells = cells_of(allowed, k, self.sight.cell, self.sight.count)
        again = self.sight.again(pixel, cells)
        return priced(self.variety, again[np.ix_(rows, columns)], used)


def cells_of(
    allowed: NDArray[np.bool_], k: int, cell: int, count: list[int]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]:
    """The cell of each row and column of places, and 1 for the cells that have a place."""
    rows, columns = ((np.arange(n) << k) // cell for n in allowed.shape)
    cells, (v, u) = np.zeros(count, np.uint8), np.nonzero(allowed)
    cells[rows[v], columns[u]] = 1
    return rows, columns, cells


def priced(
    variety: float, again: NDArray[np.float64], used: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The price of what is in sight, and of what is used so many times as often as the mean."""
    prices: NDArray[np.float64] = 1 + variety * (_AGAIN * again + _USED * np.minimum(used, _MOST))
    return prices
