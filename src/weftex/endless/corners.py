"""Where the pieces of the sample come from that a plane begins with."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from weftex.analysis.scale import structure_scale, sure_lattice
from weftex.exemplar import Exemplar
from weftex.random import draw
from weftex.raster.arrays import Bytes

_TRIES = 16  # places that are drawn until one lies right
_ROWS = 0.6  # confidence from which rows are kept


class SamplePieces:
    """Sample positions for the nodes of a plane; neighbors come from different quarters.

    `usable` marks allowed top left corners. `vectors` is the lattice x1, y1, x2, y2, by default the
    sample's, or its rows x1, y1, or empty; with a lattice all pieces lie in phase.
    """

    def __init__(self, exemplar: Exemplar, usable: Bytes, vectors: tuple[float, ...] = ()) -> None:
        self.usable, self.vectors = usable, vectors or sure_vectors(exemplar)
        places = np.argwhere(usable)
        self._quarters = [
            [_half(half, 1, right) for right in (0, 1)]
            for half in (_half(places, 0, lower) for lower in (0, 1))
        ]

    @cached_property
    def numbers(self) -> NDArray[np.int64]:
        """The number of each usable place, row by row; the last number where the last is not."""
        counts: NDArray[np.int64] = (self.usable != 0).cumsum(dtype=np.int64) - 1
        return counts.reshape(self.usable.shape)

    def pick(self, seed: int, nodes: NDArray[np.int64], at: NDArray[np.int64]) -> NDArray[np.int64]:
        """Rows and columns (n, 2) in the sample of the pieces at `nodes` (n, 2).

        `at` (n, 2) is the position of each piece's corner on the plane in pixels.
        """
        tries = np.arange(_TRIES if self.vectors else 1)
        bits = draw(seed, "piece", nodes[:, :1], nodes[:, 1:], tries)
        found = np.empty((len(nodes), 2), np.int64)
        for k, (i, j) in enumerate((nodes % 2).tolist()):
            quarter = self._quarters[i][j]
            places = quarter[bits[k] % np.uint64(len(quarter))]
            found[k] = places[0]
            for y, x in places.tolist() if self.vectors else ():
                v, u = self._in_phase(y, x, *at[k].tolist())
                inside = 0 <= v < self.usable.shape[0] and 0 <= u < self.usable.shape[1]
                if inside and self.usable[v, u]:
                    found[k] = v, u
                    break
        return found

    def _in_phase(self, y: int, x: int, top: int, left: int) -> tuple[int, int]:
        """The place nearest to (y, x) that is whole vectors away from (top, left)."""
        down, across = top - y, left - x
        x1, y1, *second = self.vectors
        if second:
            x2, y2 = second
            area = x1 * y2 - x2 * y1
            first = round((across * y2 - down * x2) / area)
            times = round((down * x1 - across * y1) / area)
            return top - round(first * y1 + times * y2), left - round(first * x1 + times * x2)
        # Across rows alone: the rest of the way is as it was drawn.
        far = (across * x1 + down * y1) / (x1 * x1 + y1 * y1)
        rest = far - round(far)
        return y + round(rest * y1), x + round(rest * x1)


def sure_vectors(exemplar: Exemplar) -> tuple[float, ...]:
    """The lattice of a sample, or the vector across its rows, if that is sure."""
    lattice = None if exemplar.pieces else structure_scale(exemplar).lattice
    if lattice is None:
        return ()
    rows = len(lattice.vectors) == 1 and lattice.confidence >= _ROWS
    if not rows and sure_lattice(exemplar) is None:
        return ()
    return tuple(float(part) for vector in lattice.vectors for part in vector)


def _half(places: NDArray[np.int64], axis: int, which: int) -> NDArray[np.int64]:
    """The places whose row or column is above the median, or not; all if there are none."""
    above = places[:, axis] > np.median(places[:, axis])
    half = places[above if which else ~above]
    return half if len(half) else places
