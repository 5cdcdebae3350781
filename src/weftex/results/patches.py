"""Results of patch methods: patches of the sample pasted over each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.canvas import MAX_PIXELS, Canvas
from weftex.io.npz import DamageError
from weftex.results import paste_kernels
from weftex.results.synthesis import Synthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.raster.mixing import Mixing
    from weftex.results.synthesis import Place, Window

_MOST_LAYERS = 4  # of patches that show at one pixel


class PatchSynthesis(Synthesis):
    """A result made of overlapping patches of the sample, in pasting order.

    `placements`, `weights` and `cuts` are those of `paste_kernels.Layout`. Of a window of a larger
    result, whose patches may extend beyond its border, `frame` (4,) is height and width of the
    larger canvas, and the window's row and column in it. Of a rectified sample, `lookup` (H, W)
    has the flat sample index of each of its pixels.
    """

    ARRAYS = {"placements": np.int32, "weights": np.uint16, "cuts": np.uint16}  # noqa: RUF012
    OPTIONAL = {"frame": np.int64, "lookup": np.int32}  # noqa: RUF012

    def __init__(
        self,
        canvas: Canvas,
        placements: NDArray[np.int32],
        weights: NDArray[np.uint16],
        cuts: NDArray[np.uint16],
        frame: NDArray[np.int64] | None = None,
        lookup: NDArray[np.int32] | None = None,
        **about: Any,
    ) -> None:
        super().__init__(canvas, **about)
        self.placements, self.weights, self.cuts = placements, weights, cuts
        self.frame, self.lookup = frame, lookup

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
        place = np.stack([v + at[:, 2], u + at[:, 3]], axis=1) % self.sample_shape
        if self.lookup is not None:
            index = self.lookup[place[:, 0], place[:, 1]]
            place = np.stack(np.divmod(index, self.sample_shape[1]), axis=1)
        coordinates[there] = place
        total = share.sum(axis=2, keepdims=True)  # below 1 where more patches meet than are kept
        share /= np.where(total > 0, total, 1)
        return coordinates, share

    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, mixing: Mixing) -> None:
        rows, columns, down, right = self._frame
        top, left, scale = window[0] + down, window[1] + right, out.shape[0] // window[2]
        patches = self.placements, self.weights, self.cuts, rows, columns
        layout = paste_kernels.Layout(*patches, top, left, scale, *mixing)
        given = pixels if self.lookup is None else self._rectified(pixels, self.lookup)
        paste_kernels.paste_all(out, given, layout)

    def _rectified(self, pixels: NDArray[Any], lookup: NDArray[np.int32]) -> NDArray[Any]:
        height, width = self.sample_shape
        scale = pixels.shape[0] // height
        blocks = pixels.reshape(height, scale, width, scale, -1)
        y, x = np.divmod(lookup, width)
        moved = blocks[y, :, x].transpose(0, 2, 1, 3, 4).reshape(pixels.shape)
        return np.ascontiguousarray(moved)

    def _moved_arrays(
        self, shape: tuple[int, int], sample: tuple[int, int], to: Place, source_to: Place
    ) -> dict[str, NDArray[Any]]:
        placements = self.placements.copy()
        placements[:, :2] = (placements[:, :2] + to) % shape
        placements[:, 2:4] = (placements[:, 2:4] + source_to) % sample
        moved = self.arrays() | {"placements": placements}
        if self.lookup is not None:
            moved["lookup"] = self._moved_lookup(self.lookup, sample, source_to)
        return moved

    def _moved_lookup(
        self, own: NDArray[np.int32], sample: tuple[int, int], source_to: Place
    ) -> NDArray[np.int32]:
        lookup = np.arange(sample[0] * sample[1], dtype=np.int32).reshape(sample)
        places = [*np.divmod(own, self.sample_shape[1]), *map(np.arange, self.sample_shape)]
        y, x, rows, columns = (
            (k + at) % n for k, at, n in zip(places, [*source_to] * 2, [*sample] * 2, strict=True)
        )
        lookup[np.ix_(rows, columns)] = y * sample[1] + x
        return lookup

    @classmethod
    def _check(cls, canvas: Canvas, sample: tuple[int, int], arrays: dict[str, Any]) -> None:
        placements, weights, cuts = (arrays[name] for name in PatchSynthesis.ARRAYS)
        frame, lookup, extent = arrays.get("frame"), arrays.get("lookup"), canvas.shape
        if frame is not None:
            if frame.shape != (4,) or frame.min() < 0 or frame.max() >= MAX_PIXELS:
                raise DamageError("its frame is none")
            if ((frame[2:] + canvas.shape) > frame[:2]).any():
                raise DamageError("its canvas lies outside of its frame")
            extent = (int(frame[0]), int(frame[1]))
        if lookup is not None and lookup.shape != sample:
            raise DamageError("its moved pixels do not fit its sample")
        if lookup is not None and ((lookup < 0) | (lookup >= lookup.size)).any():
            raise DamageError("its moved pixels lie outside")
        if placements.shape[1:] != (5,) or weights.ndim != 3 or cuts.ndim != 2:
            raise DamageError("its arrays have other shapes")
        if (weights > 256).any():
            raise DamageError("its weights are above 256")
        if cuts.size and cuts.shape != (len(placements), 2 * sum(weights.shape[1:])):
            raise DamageError("its cuts do not fit its patches")
        below = (*extent, *sample, len(weights))
        if len(placements) and ((placements < 0) | (placements >= np.array(below))).any():
            raise DamageError("its patches lie outside")
