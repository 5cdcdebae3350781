"""Results of patch methods: patches of the sample pasted over each other."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import MAX_PIXELS, Canvas
from weftex.io.npz import DamageError
from weftex.raster.mixing import Mixing
from weftex.results import paste_kernels
from weftex.results.sources import Place, Window
from weftex.results.synthesis import Synthesis

_MOST_LAYERS = 4  # of patches that show at one pixel


class PatchSynthesis(Synthesis):
    """A result made of overlapping patches of the sample, in pasting order.

    `placements`, `weights` and `cuts` are those of `paste_kernels.Layout`. Of a window of a larger
    result, whose patches may extend beyond its border, `frame` (4,) is height and width of the
    larger canvas, and the window's row and column in it.
    """

    ARRAYS = {"placements": np.int32, "weights": np.uint16, "cuts": np.uint16}  # noqa: RUF012
    OPTIONAL = {"frame": np.int64, "parts": np.uint16}  # noqa: RUF012

    def __init__(
        self,
        canvas: Canvas,
        placements: NDArray[np.int32],
        weights: NDArray[np.uint16],
        cuts: NDArray[np.uint16],
        frame: NDArray[np.int64] | None = None,
        **about: Any,
    ) -> None:
        super().__init__(canvas, **about)
        self.placements, self.weights, self.cuts = placements, weights, cuts
        self.frame = frame

    @property
    def _frame(self) -> tuple[int, int, int, int]:
        """Height and width of what patches go around, and where the canvas's corner is in it."""
        if self.frame is None:
            return *self.shape, 0, 0
        rows, columns, top, left = self.frame.tolist()
        return rows, columns, top, left

    def _layers(self, window: Window) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        rows, columns, down, right = self._frame
        top, left, height, width = window[0] + down, window[1] + right, *window[2:]
        patch = np.full((height, width, _MOST_LAYERS), -1, np.int32)
        share = np.zeros((height, width, _MOST_LAYERS), np.float32)
        patches = self.placements, self.weights, self.cuts, rows, columns
        paste_kernels.layer_all(patch, share, paste_kernels.Layout(*patches, top, left))
        y, x, _ = there = np.nonzero((patch >= 0) & (share > 0))
        shown = patch[there]
        at = self.placements[shown].astype(np.int64)
        v, u = (y + top - at[:, 0]) % rows, (x + left - at[:, 1]) % columns
        coordinates = np.full((*patch.shape, 2), -1, np.int32)
        coordinates[there] = np.stack([v + at[:, 2], u + at[:, 3]], axis=1) % self.sample_shape
        total = share.sum(axis=2, keepdims=True)  # below 1 where more patches meet than are kept
        share /= np.where(total > 0, total, 1)
        return coordinates, share

    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, mixing: Mixing) -> None:
        rows, columns, down, right = self._frame
        top, left, scale = window[0] + down, window[1] + right, out.shape[0] // window[2]
        patches = self.placements, self.weights, self.cuts, rows, columns
        layout = paste_kernels.Layout(*patches, top, left, scale, *mixing)
        paste_kernels.paste_all(out, pixels, layout)

    def _moved_arrays(
        self, shape: tuple[int, int], sample: tuple[int, int], to: Place, source_to: Place
    ) -> dict[str, NDArray[Any]]:
        placements = self.placements.copy()
        placements[:, :2] = (placements[:, :2] + to) % shape
        placements[:, 2:4] = (placements[:, 2:4] + source_to) % sample
        return self.arrays() | {"placements": placements}

    @classmethod
    def _check(cls, canvas: Canvas, sample: tuple[int, int], arrays: dict[str, Any]) -> None:
        placements, weights, cuts = (arrays[name] for name in PatchSynthesis.ARRAYS)
        frame, extent = arrays.get("frame"), canvas.shape
        if frame is not None:
            if frame.shape != (4,) or frame.min() < 0 or frame.max() >= MAX_PIXELS:
                raise DamageError("its frame is invalid")
            if ((frame[2:] + canvas.shape) > frame[:2]).any():
                raise DamageError("its canvas is outside its frame")
            extent = (int(frame[0]), int(frame[1]))
        if placements.shape[1:] != (5,) or weights.ndim != 3 or cuts.ndim != 2:
            raise DamageError("its arrays have other shapes")
        if (weights > 256).any():
            raise DamageError("its weights are above 256")
        if cuts.size and cuts.shape != (len(placements), 2 * sum(weights.shape[1:])):
            raise DamageError("its cuts do not fit its patches")
        below = (*extent, *sample, len(weights))
        if len(placements) and ((placements < 0) | (placements >= np.array(below))).any():
            raise DamageError("its patches lie outside")
