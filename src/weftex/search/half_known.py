"""An approximate search: windows whose principal components are near those of a half-known one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from weftex.search import half_known_kernels as kernels
from weftex.search.exhaustive import BLOCK, WindowSearch, whole_groups
from weftex.search.pca import main_components, one_blas_thread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.exhaustive import Drawn
    from weftex.search.windows import Windows

_MOST = 16  # components
_LEAVES = 16  # of up to 64 windows each, looked at for a pixel
_TERM = 6383  # as in the kernels
_LEARN = 256  # windows that the components are learnt from
#: What neighbouring pixels have beside the components is alike, so it counts more than once against
#: what they say; of 1, 10 and 100 it was 10 that found the nearest window most often.
_ALIKE = 10


class HalfKnownSearch(WindowSearch):
    """Compares with the windows of the nearest components, and where neighbours' sources go on.

    The components are those of whole windows, weighted. The coordinates of a window of which only
    a part is known are estimated from that part by least squares. All windows are sorted into
    leaves of up to 64 with like coordinates, and only the nearest leaves are looked at.

    Components are rounded to integers, and everything else follows from them in whole numbers or
    in plain double arithmetic, so that every machine finds the same windows.

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
        heavy = np.repeat(weights.ravel(), self.channels).astype(np.float64)
        middle = len(weights) ** 2 // 2 * self.channels
        heavy[middle : middle + self.channels] = 0  # a pixel to be made is never known
        with one_blas_thread():
            learn = self._views(np.linspace(0, windows.centres.size - 1, _LEARN).astype(np.intp))
            mean = learn.sum(axis=0, dtype=np.int64) / len(learn)
            filters, scale = _filters((learn - mean) * np.sqrt(heavy), np.sqrt(heavy), variance)
            features, origin, unit = self._features(filters)
        self.factor = scale / unit
        self.origin = (np.array([float((f * mean).sum()) for f in filters]) - origin) / unit
        basis = filters / (np.maximum(heavy, 1) * scale)
        total = float((heavy * (learn - mean) ** 2).sum()) / len(learn)
        self.ridge = _ridge(features, unit / scale, total, len(heavy))
        self._lay_out(basis, mean)
        self._sort_into_leaves(features)

    def _views(self, part: Any) -> NDArray[np.uint8]:
        """Some of the windows, one a row."""
        width, pixels = len(self.weights), self.windows.pixels
        rows, columns = np.divmod(self.windows.centres[part], pixels.shape[1])
        views = sliding_window_view(pixels, (width, width), (0, 1))
        chosen: NDArray[np.uint8] = views[rows - width // 2, columns - width // 2]
        return chosen.transpose(0, 2, 3, 1).reshape(len(chosen), -1)

    def _features(
        self, filters: NDArray[np.float64]
    ) -> tuple[NDArray[np.uint8], NDArray[np.int64], int]:
        """All windows' coordinates as bytes: (product - origin) // unit."""
        raw = np.empty((len(filters), self.windows.centres.size), np.int64)
        for start in range(0, raw.shape[1], 4096):
            part = self._views(slice(start, start + 4096)).astype(np.float32)
            raw[:, start : start + len(part)] = filters.astype(np.float32) @ part.T
        origin = raw.min(axis=1)
        raw -= origin[:, None]
        unit = int(raw.max()) // 255 + 1
        return (raw // unit).astype(np.uint8), origin, unit

    def _lay_out(self, basis: NDArray[np.float64], mean: NDArray[np.float64]) -> None:
        """Basis and mean in rows as the kernels have them; u u^T of each pixel, its lower half."""
        width, keep = len(self.weights), len(basis)
        gap = self.stride - width * self.channels

        def rows(values: NDArray[np.float64]) -> NDArray[np.float64]:
            lines = values.reshape(width, width * self.channels, -1)
            return np.pad(lines, ((0, 0), (0, gap), (0, 0))).reshape(width * self.stride, -1)

        self.basis, self.mean = rows(np.ascontiguousarray(basis.T)), rows(mean)[:, 0].copy()
        pixels = basis.reshape(keep, width * width, self.channels)
        pairs = [(d, e) for d in range(keep) for e in range(d + 1)]
        self.products = np.zeros((width * width, len(pairs)))
        for n, (d, e) in enumerate(pairs):
            for k in range(self.channels):
                self.products[:, n] += pixels[d, :, k] * pixels[e, :, k]

    def _sort_into_leaves(self, features: NDArray[np.uint8]) -> None:
        """Halve the windows along the component that they vary most in, until 64 are left."""
        keep, count = features.shape
        parts, leaves = [np.arange(count)], []
        while parts:
            part = parts.pop()
            if len(part) <= BLOCK:
                leaves.append(part)
                continue
            inside = features[:, part]
            widest = int(np.argmax(inside.max(axis=1) - inside.min(axis=1)))
            order = part[np.argsort(inside[widest], kind="stable")]
            half = -(-len(part) // BLOCK) // 2 * BLOCK  # so that all leaves but one are full
            parts += [order[half:], order[:half]]
        terms, rows = whole_groups(keep), len(leaves) * BLOCK
        columns = -(-len(leaves) // BLOCK) * BLOCK
        planes, middles = np.zeros((terms, rows), np.uint8), np.zeros((terms, columns), np.uint8)
        self.centres = np.zeros(rows, np.int32)
        for n, leaf in enumerate(leaves):
            at = slice(n * BLOCK, n * BLOCK + len(leaf))
            self.centres[at], planes[:keep, at] = self.windows.centres[leaf], features[:, leaf]
            middles[:keep, n] = features[:, leaf].sum(axis=1, dtype=np.int64) // len(leaf)
        self.planes, self.middles = planes.ravel(), middles.ravel()
        self.at, self.at_middles = (np.arange(terms, dtype=np.intp) * n for n in (rows, columns))
        self.leaves = np.array([len(leaf) for leaf in leaves], np.int32)
        self.weight = np.full(terms, _TERM, np.uint16)
        self.cap = np.full(terms, 65535, np.uint16)

    def scratch(self) -> tuple[NDArray[Any], ...]:
        """See `WindowSearch.scratch`."""
        keep, found = len(self.ridge), self.candidates + 9  # 8 neighbours and -1 for no window
        return (
            *super().scratch(),
            np.empty(keep * (keep + 1) // 2),
            np.empty(keep),
            np.empty(len(self.at), np.int16),
            np.empty(BLOCK, np.uint16),
            np.empty(_LEAVES, np.int32),
            np.empty(max(_LEAVES, self.candidates), np.int64),
            np.empty(found, np.int32),
            np.empty(found, np.int64),
        )

    def _run(self, canvas: tuple[Any, ...], out: Drawn, scratch: tuple[NDArray[Any], ...]) -> None:
        arguments = [
            *canvas, self.weights, self.flat, self.windows.usable, self.windows.period,
            self.stride, self.candidates, self.mean, self.basis, self.products, self.ridge,
            self.factor, self.origin, self.planes, self.at, self.middles, self.at_middles,
            self.leaves, self.centres, self.weight, self.cap, *out, *scratch,
        ]  # fmt: skip
        kernels.search_half_known(*arguments)


def _filters(
    learn: NDArray[np.float64], root: NDArray[np.float64], variance: float
) -> tuple[NDArray[np.float64], float]:
    """Components to multiply windows with, in whole numbers, and what they are scaled by.

    There are fewer windows than numbers in one, so the eigenvectors are those of their products.
    """
    power, vectors = np.linalg.eigh(learn @ learn.T)
    found = learn.T @ vectors
    lengths = np.sqrt((found * found).sum(axis=0))
    found /= np.maximum(lengths, 1e-3)
    found[:, lengths < 1e-3] = 0  # what a constant sample varies by is rounding
    filters = main_components(power, found, variance, _MOST) * root
    # Products with a window stay below 2**24: exact in single precision, in any order.
    scale = 0.95 * 2**24 / (255 * max(float(np.abs(filters).sum(axis=1).max()), 1e-3))
    return np.rint(filters * scale), scale


def _ridge(
    features: NDArray[np.uint8], unit: float, total: float, size: int
) -> NDArray[np.float64]:
    """What the components leave of a byte's variance, over that of each component."""
    levels, n = features.astype(np.int64), features.shape[1]
    spread = (n * (levels * levels).sum(axis=1) - levels.sum(axis=1) ** 2) * (unit / n) ** 2
    left = max(total - float(spread.sum()), 1e-3 * total, 1e-3) / size
    ridge: NDArray[np.float64] = _ALIKE * left / np.maximum(spread, 1e-3)
    return ridge
