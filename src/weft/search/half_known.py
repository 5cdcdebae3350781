"""An approximate search: windows whose principal components are near those of a half-known one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from weft.search import _half_known_kernels as kernels
from weft.search.exhaustive import WindowSearch, whole_groups
from weft.search.pca import one_blas_thread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weft.search.exhaustive import Drawn
    from weft.search.windows import Windows

_BLOCK = 64  # as in the kernels
_MOST = 16  # components
_LEARN = 256  # windows that the components are learnt from
#: What is left of neighbouring pixels beside the components is alike, so it counts more often than
#: once against what they say; 10 found the most nearest windows on pebbles and bricks, of 1 to 100.
_ALIKE = 10


class HalfKnownSearch(WindowSearch):
    """Compares with the windows of the nearest components, and where neighbours' sources go on.

    The components are those of whole windows, weighted; the coordinates of a window of which only
    a part is known are estimated from that by least squares. Components are rounded to integers,
    and everything else follows from them in whole numbers or in plain double arithmetic, so that
    every machine finds the same windows.

    Parameters
    ----------
    windows, weights
        As for `WindowSearch`.
    candidates : int
        The number of windows to compare with, beside the coherent ones.
    variance : float
        Share of the variance that the components keep; at most 16 of them.
    """

    def __init__(
        self, windows: Windows, weights: NDArray[np.int16], candidates: int, variance: float
    ) -> None:
        super().__init__(windows, weights)
        self.candidates = min(candidates, windows.centres.size)
        with one_blas_thread():
            self._fit(variance)

    def _fit(self, variance: float) -> None:
        width, windows = len(self.weights), self.windows
        views = sliding_window_view(windows.pixels, (width, width), (0, 1))
        rows, columns = np.divmod(windows.centres, windows.pixels.shape[1])
        corners = rows - width // 2, columns - width // 2

        def take(part: Any) -> NDArray[Any]:
            chosen = views[corners[0][part], corners[1][part]]
            return chosen.transpose(0, 2, 3, 1).reshape(len(chosen), -1)

        weights = np.repeat(self.weights.ravel(), self.channels).astype(np.float64)
        middle = len(weights) // 2 // self.channels * self.channels
        weights[middle : middle + self.channels] = 0  # a pixel to be made is never known
        count = min(_LEARN, windows.centres.size)
        learn = take(np.linspace(0, windows.centres.size - 1, count).astype(np.intp))
        mean = learn.sum(axis=0, dtype=np.int64) / count
        learn = learn - mean
        power, vectors = np.linalg.eigh((learn * weights) @ learn.T)
        power, vectors = power[::-1], vectors[:, ::-1]
        total = float((weights * (learn * learn).sum(axis=0)).sum()) / count
        keep = min(_MOST, int((np.cumsum(power) < variance * count * total).sum()) + 1)
        keep = min(keep, int((power > 1e-6 * max(power[0], 1)).sum()))
        filters = (learn.T @ vectors[:, :keep]).T * weights
        largest = np.abs(filters).argmax(axis=1)
        filters *= np.sign(filters[np.arange(keep), largest])[:, None]
        # Each sum of a filter stays under 2**24: exact in single precision, in any order.
        filters /= np.sqrt((filters**2 / np.maximum(weights, 1)).sum(axis=1))[:, None]
        longest = max((np.abs(filters).sum(axis=1)).max(initial=0), 1e-9)
        scale = 0.95 * 2**24 / (255 * longest)
        filters = np.rint(filters * scale)
        raw = np.empty((keep, windows.centres.size), np.int32)
        for start in range(0, raw.shape[1], 4096):
            part = take(slice(start, start + 4096)).astype(np.float32)
            raw[:, start : start + len(part)] = filters.astype(np.float32) @ part.T
        low = raw.min(axis=1, initial=2**31 - 1).astype(np.int64)
        unit = int((raw.max(axis=1, initial=-(2**31)) - low).max(initial=0)) // 255 + 1
        terms = max(4, whole_groups(keep))
        size = windows.usable.size + _BLOCK
        self.planes = np.zeros((terms, size), np.uint8)
        self.planes[:keep, windows.centres] = (raw - low[:, None]) // unit

        stretch = self.stride - width * self.channels
        basis = filters / (np.maximum(weights, 1) * scale)  # u of each component

        def padded(values: NDArray[Any]) -> NDArray[Any]:
            lines = values.reshape(width, width * self.channels, -1)
            return np.pad(lines, ((0, 0), (0, stretch), (0, 0))).reshape(width * self.stride, -1)

        self.basis = np.ascontiguousarray(padded(basis.T))
        self.mean = np.ascontiguousarray(padded(mean)[:, 0])
        pixels = basis.reshape(keep, width * width, self.channels)
        pairs = [(d, e) for d in range(keep) for e in range(d + 1)]
        self.products = np.zeros((width * width, len(pairs)))
        for n, (d, e) in enumerate(pairs):
            for k in range(self.channels):
                self.products[:, n] += pixels[d, :, k] * pixels[e, :, k]
        # Variances of whole numbers too, so that the last bits are the same everywhere.
        n = windows.centres.size
        levels = self.planes[:keep, windows.centres].astype(np.int64)
        spread = n * (levels * levels).sum(axis=1) - levels.sum(axis=1) ** 2
        spread = spread * (unit / n / scale) ** 2
        left = max(total - float(spread.sum()), 1e-3 * total) / max(len(weights), 1)
        self.ridge = _ALIKE * left / np.maximum(spread, 1e-9)
        self.factor = scale / unit
        centre = np.array([float((f * mean).sum()) for f in filters])
        self.origin = (centre - low) / unit
        self.at = np.arange(terms, dtype=np.intp) * size
        self.weight = np.where(np.arange(terms) < keep, 65535 // terms, 0).astype(np.uint16)

    def scratch(self) -> tuple[NDArray[Any], ...]:
        """See `WindowSearch.scratch`."""
        keep, found = len(self.ridge), self.candidates + 9  # 8 neighbours and -1 for no window
        return (
            *super().scratch(),
            np.empty(keep * (keep + 1) // 2),
            np.empty(keep),
            np.empty(len(self.at), np.int16),
            np.empty(_BLOCK, np.uint16),
            np.empty(self.candidates, np.int64),
            np.empty(found, np.int32),
            np.empty(found, np.int64),
        )

    def _run(self, canvas: tuple[Any, ...], out: Drawn, scratch: tuple[NDArray[Any], ...]) -> None:
        kernels.search_half_known(
            *canvas, self.weights, self.flat, self.windows.usable, self.allowed,
            self.windows.period, self.blocks, self.stride, self.candidates, self.mean, self.basis,
            self.products, self.ridge, self.factor, self.origin, self.planes, self.at, self.weight,
            *out, *scratch,
        )  # fmt: skip
