"""The mean tile of a sample: what is regular in it, without what is not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.analysis.canvas_lattice import CanvasLattice
from weftex.search.translation import Spectra, fast_size, window_mismatch

if TYPE_CHECKING:
    from numpy.typing import NDArray


class MeanTile:
    """The mean of all usable pixels at the same place of the tile, to about a pixel."""

    def __init__(
        self,
        pixels: NDArray[np.uint8],
        vectors: tuple[float, ...],
        mask: NDArray[np.bool_] | None = None,
    ) -> None:
        self._lattice = CanvasLattice(vectors)
        self._bins = [max(1, round(float(np.hypot(*v)))) for v in self._lattice.sample]
        y, x = np.indices(pixels.shape[:2])
        cell = self._lattice.cell(y, x, self._bins).ravel()
        colors = pixels.reshape(-1, pixels.shape[2])
        if mask is not None:
            cell, colors = cell[mask.ravel()], colors[mask.ravel()]
        size = self._bins[0] * self._bins[1]
        count = np.bincount(cell, minlength=size)
        total = np.stack([np.bincount(cell, color, minlength=size) for color in colors.T], axis=1)
        mean = np.rint(total / np.maximum(count, 1)[:, None])
        mean[count == 0] = np.rint(colors.mean(axis=0))
        self._mean = mean.astype(np.uint8)

    def at(self, y: Any, x: Any) -> NDArray[np.uint8]:
        """Colors (..., K) of pixels of the endless plane of mean tiles."""
        cell = self._lattice.cell(np.asarray(y), np.asarray(x), self._bins)
        result: NDArray[np.uint8] = self._mean[cell]
        return result

    def offset(self, known: NDArray[np.uint8], mask: NDArray[np.bool_]) -> tuple[int, int]:
        """Where in the plane of mean tiles the corner of a picture fits its known pixels best."""
        reach = np.ceil(np.abs(self._lattice.sample).sum(axis=0)).astype(int)
        size = tuple(fast_size(int(n + r)) for n, r in zip(mask.shape, reach, strict=True))
        plane = self.at(*np.indices(tuple(n + r for n, r in zip(mask.shape, reach, strict=True))))
        picture = Spectra(plane, np.ones(plane.shape[:2], bool), size)
        error = window_mismatch(picture, Spectra(known, mask, size))[: reach[0], : reach[1]]
        y, x = np.unravel_index(int(error.argmin()), error.shape)
        return int(y), int(x)
