"""Places on a lattice, where the sample is regular, which is no idea of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import VISIBLE_STRAIN, CanvasLattice, given_lattice

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas

_DRIFT = 16  # in photos a tile lies up to 1/16 of its shorter side off the lattice
_MOST = 4.0  # pixels, at most
_LEAST = 0.75  # pixels, so that there is a whole one at each multiple of the vectors
_UNIT = 1 << 16  # of `CanvasLattice.phase`


class LatticePlaces:
    """Which places of the sample may lie on a pixel of the canvas.

    Those from which a multiple of the vectors leads to the pixel, or nearly so; of these the best
    match is taken.

    Parameters
    ----------
    vectors : (float, float, float, float)
        x1, y1, x2, y2; rows if one of them is a pixel long.
    canvas : Canvas
        Where it goes around, so must the lattice.

    Examples
    --------
    >>> from weftex.canvas import Canvas
    >>> places = LatticePlaces((4, 0, 0, 6), Canvas(30, 30))
    >>> np.argwhere(places.of((8, 5), (10, 6), near=False)).tolist()
    [[2, 1], [2, 5], [8, 1], [8, 5]]
    """

    def __init__(self, vectors: tuple[float, ...], canvas: Canvas) -> None:
        self._lattice = CanvasLattice(vectors, canvas, VISIBLE_STRAIN)
        self._inverse = np.linalg.inv(self._lattice.sample)
        shortest = min(np.hypot(*vector) for vector in given_lattice(vectors).reduced().vectors)
        self._drift = min(max(float(shortest) / _DRIFT, _LEAST), _MOST)

    def of(
        self, pixel: tuple[int, int], shape: tuple[int, int], *, near: bool
    ) -> NDArray[np.bool_]:
        """Mark the places of a sample of that shape for a pixel; those `near` the lattice too."""
        first = self._lattice.phase(*(np.array(at) for at in pixel)) / _UNIT
        y, x = np.ogrid[: shape[0], : shape[1]]
        times = np.tensordot(
            self._inverse, np.array(np.broadcast_arrays(y - first[0], x - first[1])), (0, 0)
        )
        off = np.tensordot(self._lattice.sample, times - np.rint(times), (0, 0))
        found: NDArray[np.bool_] = abs(off).max(axis=0) <= (self._drift if near else _LEAST)
        return found


def any_in_blocks(places: NDArray[np.bool_], halvings: int) -> NDArray[np.uint8]:
    """1 where one of the places lies in a block of 2**halvings pixels a side; whole blocks only."""
    side = 1 << halvings
    rows, columns = (n >> halvings for n in places.shape)
    blocks = places[: rows * side, : columns * side].reshape(rows, side, columns, side)
    return np.asarray(blocks.any(axis=(1, 3)), np.uint8)
