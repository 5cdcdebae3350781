"""Offsets on a lattice, for regular samples; not in the paper."""

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
    """The pixels of the sample that may lie on a pixel of the canvas, a lattice shift away.

    `vectors` are x1, y1, x2, y2; rows if one of them is a pixel long.

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
        """Mark the pixels of a sample of a shape that may lie on a pixel; `near` it marks more."""
        first = self._lattice.phase(*(np.array(at) for at in pixel)) / _UNIT
        y, x = (np.arange(n) - at for n, at in zip(shape, first, strict=True))
        parts = []  # of multiples of the vectors, that are left
        for down, along in self._inverse.T:
            times = np.add.outer(down * y, along * x)
            times -= np.rint(times)
            parts.append(times)
        most, found = self._drift if near else _LEAST, np.full(shape, True)
        for one, other in self._lattice.sample.T:
            found &= abs(one * parts[0] + other * parts[1]) <= most
        return found


def on_smaller(places: NDArray[np.bool_], count: int) -> list[NDArray[np.uint8]]:
    """Levels of a mask, each half as large: 1 where one of four pixels is; whole squares only."""
    copies = [places.view(np.uint8)]
    while len(copies) < count:
        rows, columns = (n // 2 * 2 for n in copies[-1].shape)
        upper, lower = (copies[-1][first:rows:2, :columns] for first in (0, 1))
        either = upper | lower
        copies.append(either[:, ::2] | either[:, 1::2])
    return copies
