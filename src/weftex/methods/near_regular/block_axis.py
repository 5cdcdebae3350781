"""Blocks along one axis of a plane or of a canvas that goes around (section 4.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Blocks around those that show that their sources hang on: 1 beside a gap, and 2 for each colour
#: but the last, which is drawn with regard to the ones before.
_RING = 7
_UNIT = 1 << 16  # of a pixel, that pitches are in


class Axis:
    """Blocks along one axis.

    Parameters
    ----------
    length, origin : int
        Of the canvas, and where in the plane it begins.
    size, margin : int
        Of a block, at most, and how far its window reaches beyond it.
    wraps : bool
        The canvas goes around.
    pitch : (int, int), optional
        From block to block and to the one numbered 0, in 1/65536 pixel; the size and 0 by default.

    Attributes
    ----------
    first : int
        Number of the first block; numbers count from the plane's origin.
    edges : int64 array (n + 1,)
        Where blocks begin and the last one ends, in canvas pixels.
    period : int
        The canvas's length if it goes around, else 0.
    shown : slice
        The blocks that can show.
    """

    def __init__(
        self,
        length: int,
        size: int,
        margin: int,
        origin: int,
        wraps: bool,
        pitch: tuple[int, int] | None = None,
    ) -> None:
        if wraps:
            count = 2 * max(1, -(-length // (2 * size)))
            self.first, self.period, self.shown = 0, length, slice(0, count)
            self.edges = np.arange(count + 1, dtype=np.int64) * length // count
        else:
            step, shift = pitch or (size * _UNIT, 0)
            begin = ((origin - margin) * _UNIT - shift) // step
            end = ((origin + length - 1 + margin) * _UNIT - shift) // step + 1
            self.first, self.period = begin - _RING, 0
            self.shown = slice(_RING, end - begin + _RING)
            numbers = np.arange(begin - _RING, end + _RING + 1, dtype=np.int64)
            self.edges = (numbers * step + shift) // _UNIT - origin
        self.sizes = np.diff(self.edges)
        self.numbers = self.first + np.arange(len(self.sizes), dtype=np.int64)

    @property
    def count(self) -> int:
        """How many blocks there are."""
        return len(self.sizes)

    def kept(
        self, length: int, side: int, margin: int, reach: int
    ) -> tuple[int, NDArray[np.int64]]:
        """What of the blocks' windows is laid: how many lines, and from which one on.

        All of them, unless the canvas is smaller than a window. No window may lie over itself.
        """
        lines = min(side, length)
        first = np.full(self.shown.stop - self.shown.start, margin - reach)
        if not self.period:
            first = np.maximum(first, margin - self.edges[:-1][self.shown])
        return lines, np.minimum(first, side - lines)
