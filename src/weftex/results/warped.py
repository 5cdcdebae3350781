"""Results whose last patches are warped, and so resampled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.io.npz import DamageError
from weftex.results import paste_kernels, warp_kernels
from weftex.results.patches import RectifiedSynthesis

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.raster.mixing import Mixing
    from weftex.results.synthesis import Window

_LARGEST_BLOCK = 1 << 24  # px; no sample is as large


class WarpedSynthesis(RectifiedSynthesis):
    """Patches of a sample, the last of which are warped.

    Rendering interpolates, at any resolution and depth, and stays between the nearest pixels of
    the sample; `source` and `layers` say which pixel is the nearest.

    Parameters
    ----------
    warps : int16 array (k, n, n, 2)
        Shifts in 1/16 pixel over each of the last k patches, see `weftex.results.warp_kernels`.
    within : int32 array (k, 5)
        First row and column of the patch in its window, the block's height and width, and how far
        the window reaches beyond it.
    **about
        As for `RectifiedSynthesis`.
    """

    ARRAYS = {**RectifiedSynthesis.ARRAYS, "warps": np.int16, "within": np.int32}  # noqa: RUF012

    def __init__(
        self, *plan: Any, warps: NDArray[np.int16], within: NDArray[np.int32], **about: Any
    ) -> None:
        super().__init__(*plan, **about)
        self.warps, self.within = warps, within

    def _within(
        self, patch: NDArray[np.int32], y: NDArray[Any], x: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        v, u = (np.array(np.broadcast_to(k, patch.shape), np.int64).ravel() for k in (y, x))
        first = len(self.placements) - len(self.warps)
        warps = warp_kernels.Warps(self.warps, self.within)
        warp_kernels.displace(np.ravel(patch), v, u, first, warps)
        return v.reshape(patch.shape), u.reshape(patch.shape)

    def _lay(self, out: NDArray[Any], pixels: NDArray[Any], window: Window, mixing: Mixing) -> None:
        top, left, height, width = window
        scale = out.shape[0] // height
        pixels = self._rectified(pixels)
        rows, columns = self.weights.shape[1:]
        warps = warp_kernels.Warps(self.warps, self.within)
        piece = np.empty((rows * scale, columns * scale, pixels.shape[2]), pixels.dtype)
        first = len(self.placements) - len(self.warps)
        place = self.placements
        # A patch goes around with its canvas.
        seen = ((place[:, 0] - top) % self.shape[0] < height) | (
            (place[:, 0] - top) % self.shape[0] + rows > self.shape[0]
        )
        seen &= ((place[:, 1] - left) % self.shape[1] < width) | (
            (place[:, 1] - left) % self.shape[1] + columns > self.shape[1]
        )

        view = paste_kernels.View(top, left, scale, *mixing)

        def lay(source: NDArray[Any], placements: NDArray[np.int32], k: slice) -> None:
            layout = paste_kernels.Layout(placements, self.weights, self.cuts[k], *self.shape)
            paste_kernels.paste_all(out, source, layout, view)

        lay(pixels, place[:first], slice(first))
        for k in np.flatnonzero(seen[first:]).tolist():
            here = slice(first + k, first + k + 1)
            if not self.warps[k].any():
                lay(pixels, place[here], here)
                continue
            y, x = place[first + k, 2:4].tolist()
            warp_kernels.warp_into(piece, pixels, y, x, columns, warps, k, view)
            at = place[here].copy()
            at[:, 2:4] = 0
            lay(piece, at, here)

    @classmethod
    def _check(cls, canvas: Canvas, sample: tuple[int, int], arrays: dict[str, Any]) -> None:
        super()._check(canvas, sample, arrays)
        warps, within = arrays["warps"], arrays["within"]
        nodes = warps.shape[1:2] if warps.ndim == 4 else (0,)
        if nodes[0] < 2 or warps.shape[1:] != (*nodes, *nodes, 2):
            raise DamageError("its warps have another shape")
        if len(warps) > len(arrays["placements"]) or within.shape != (len(warps), 5):
            raise DamageError("its warps do not fit its patches")
        least = np.array([0, 0, 1, 1, 0])
        if ((within < least) | (within > _LARGEST_BLOCK)).any():
            raise DamageError("its warps lie outside")
