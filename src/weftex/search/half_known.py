"""An approximate search: windows whose principal components are near those of a half-known one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from weftex.search import exhaustive_kernels
from weftex.search import half_known_kernels as kernels
from weftex.search.exhaustive import BLOCK, whole_groups
from weftex.search.pca import main_components, one_blas_thread
from weftex.search.weighted_kernels import Picture
from weftex.search.weighted_windows import drawing, found_windows, weighted_windows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.weighted_windows import Draw, WeightedWindows
    from weftex.search.windows import Windows

_MOST_COMPONENTS = 16
_MOST_LEAVES = 16  # of up to 64 windows each, looked at for a pixel
_LEARNED_WINDOWS = 256  # that the components are learned from
_CHUNK = 4096  # windows that are projected at a time
#: The components leave errors that are alike at neighboring pixels, so the ridge counts more than
#: once; of 1, 10 and 100 it was 10 that found the nearest window most often.
_RIDGE_FACTOR = 10


@dataclass(frozen=True, eq=False)
class Components:
    """The main components of a sample's whole windows, laid out in rows as a query is.

    Attributes
    ----------
    mean : float64 array (n,)
        Of the bytes of a window.
    basis : float64 array (n, D)
        The components.
    products : float64 array (width**2, D * (D + 1) / 2)
        u u^T of each pixel's rows u of the basis, its lower half.
    ridge : float64 array (D,)
        What is added to the diagonal of the least squares.
    factor, origin : float, float64 array (D,)
        A coordinate z becomes the byte factor * z + origin, in units of the leaves' coordinates.
    """

    mean: NDArray[np.float64]
    basis: NDArray[np.float64]
    products: NDArray[np.float64]
    ridge: NDArray[np.float64]
    factor: float
    origin: NDArray[np.float64]

    def bundle(self) -> Any:
        """Return the kernels' view, with scratch."""
        keep = len(self.ridge)
        return kernels.Components(
            self.mean, self.basis, self.products, self.ridge, self.factor, self.origin,
            np.empty(keep * (keep + 1) // 2), np.empty(keep),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Leaves:
    """All windows in leaves of up to 64 with like coordinates, and the leaves' mean coordinates.

    Attributes
    ----------
    places : int32 array (n * 64,)
        Flat indices of the windows of each leaf.
    sizes : int32 array (n,)
        The number of windows in each leaf.
    planes : uint8 array (D, n * 64)
        The windows' coordinates; more components than there are, all 0, make whole groups.
    middles : uint8 array (D, m)
        The leaves' mean coordinates, filled up to whole blocks.
    """

    places: NDArray[np.int32]
    sizes: NDArray[np.int32]
    planes: NDArray[np.uint8]
    middles: NDArray[np.uint8]

    def bundle(self, candidates: int) -> Any:
        """Return the kernels' view, with scratch for so many candidates."""
        components = len(self.planes)
        value = np.empty(components, np.int16)
        weight = np.full(components, exhaustive_kernels.largest_term, np.uint16)
        cap = np.full(components, 65535, np.uint16)
        terms, middle_terms = (
            exhaustive_kernels.Terms(
                np.arange(components, dtype=np.intp) * part.shape[1], value, weight, cap
            )
            for part in (self.planes, self.middles)
        )
        return kernels.Leaves(
            self.planes.ravel(), self.middles.ravel(), self.sizes, self.places, terms, middle_terms,
            np.empty(BLOCK, np.uint16), np.empty(_MOST_LEAVES, np.int32),
            np.empty(max(_MOST_LEAVES, candidates), np.int64),
        )  # fmt: skip


class HalfKnownSearch:
    """Compares with the windows of the nearest components, and where neighbors' sources go on.

    See `WindowSearch`. The components are those of whole windows, weighted. The coordinates of a
    window of which only a part is known are estimated from that part by least squares. All windows
    are sorted into leaves of up to 64 with like coordinates, and only the nearest leaves are looked
    at.

    Components are rounded to integers, and everything else follows from them in whole numbers or
    in plain double arithmetic, so that every machine finds the same windows.

    Parameters
    ----------
    windows : Windows
        Of the sample, square.
    weights : int16 array (width, width)
        From 1 to 127. A distance is the sum of w d**2 over the known pixels.
    candidates : int
        The number of windows to compare with, beside the coherent ones.
    variance : float
        Share of the variance that the components keep; at most 16 of them.
    """

    def __init__(
        self, windows: Windows, weights: NDArray[np.int16], candidates: int, variance: float
    ) -> None:
        self.sample = weighted_windows(windows, weights)
        self.candidates = min(candidates, windows.centers.size)
        self.components, features = _fit(self.sample, variance)
        self.leaves = _leaves(features, windows.centers)

    def on(
        self,
        pixels: NDArray[np.uint8],
        done: NDArray[np.uint8],
        source: NDArray[np.int32],
        wrap: tuple[bool, bool],
        tolerance: float,
    ) -> Draw:
        """See `WindowSearch.on`."""
        sample, query, wanted = self.sample.bundle(), self.sample.query(), self.candidates
        components, leaves = self.components.bundle(), self.leaves.bundle(wanted)
        picture, found = Picture(pixels, done, source, wrap), found_windows(wanted)
        return drawing(
            lambda choices: kernels.search_half_known(
                sample, components, leaves, wanted, picture, choices, query, found
            ),
            tolerance,
        )


def _fit(sample: WeightedWindows, variance: float) -> tuple[Components, NDArray[np.uint8]]:
    """Find the components, and the coordinates of all windows as bytes (D, n)."""
    windows = sample.windows
    heavy = np.repeat(sample.weights.ravel(), sample.channels).astype(np.float64)
    middle = len(sample.weights) ** 2 // 2 * sample.channels
    heavy[middle : middle + sample.channels] = 0  # a pixel to be made is never known
    with one_blas_thread():
        some = np.linspace(0, windows.centers.size - 1, _LEARNED_WINDOWS).astype(np.intp)
        learned = _window_bytes(sample, windows.centers[some])
        mean = learned.sum(axis=0, dtype=np.int64) / len(learned)
        filters, scale = _filters((learned - mean) * np.sqrt(heavy), np.sqrt(heavy), variance)
        features, lowest, unit = _features(sample, filters)
    origin = (np.array([float((f * mean).sum()) for f in filters]) - lowest) / unit
    basis = filters / (np.maximum(heavy, 1) * scale)
    total = float((heavy * (learned - mean) ** 2).sum()) / len(learned)
    ridge = _ridge(features, unit / scale, total, len(heavy))
    return Components(
        _in_rows(mean, sample)[:, 0].copy(), _in_rows(np.ascontiguousarray(basis.T), sample),
        _products(basis, sample), ridge, scale / unit, origin,
    ), features  # fmt: skip


def _window_bytes(sample: WeightedWindows, places: NDArray[np.int32]) -> NDArray[np.uint8]:
    """The windows at flat indices, one a row."""
    width, pixels = sample.width, sample.windows.pixels
    rows, columns = np.divmod(places, pixels.shape[1])
    views = sliding_window_view(pixels, (width, width), (0, 1))
    chosen: NDArray[np.uint8] = views[rows - width // 2, columns - width // 2]
    return chosen.transpose(0, 2, 3, 1).reshape(len(chosen), -1)


def _features(
    sample: WeightedWindows, filters: NDArray[np.float64]
) -> tuple[NDArray[np.uint8], NDArray[np.int64], int]:
    """All windows' coordinates as bytes: (product - lowest) // unit."""
    centers = sample.windows.centers
    raw = np.empty((len(filters), centers.size), np.int64)
    for start in range(0, raw.shape[1], _CHUNK):
        part = _window_bytes(sample, centers[start : start + _CHUNK]).astype(np.float32)
        raw[:, start : start + len(part)] = filters.astype(np.float32) @ part.T
    lowest = raw.min(axis=1)
    raw -= lowest[:, None]
    unit = int(raw.max()) // 255 + 1
    return (raw // unit).astype(np.uint8), lowest, unit


def _in_rows(values: NDArray[np.float64], sample: WeightedWindows) -> NDArray[np.float64]:
    """Lay out values of a window's bytes as a query is, in rows of a stride."""
    width, gap = sample.width, sample.stride - sample.width * sample.channels
    lines = values.reshape(width, width * sample.channels, -1)
    return np.pad(lines, ((0, 0), (0, gap), (0, 0))).reshape(width * sample.stride, -1)


def _products(basis: NDArray[np.float64], sample: WeightedWindows) -> NDArray[np.float64]:
    """Multiply the rows u of each pixel: u u^T, its lower half row by row."""
    keep, size = len(basis), sample.width**2
    pixels = basis.reshape(keep, size, sample.channels)
    pairs = [(d, e) for d in range(keep) for e in range(d + 1)]
    products = np.zeros((size, len(pairs)))
    for n, (d, e) in enumerate(pairs):
        for k in range(sample.channels):
            products[:, n] += pixels[d, :, k] * pixels[e, :, k]
    return products


def _leaves(features: NDArray[np.uint8], centers: NDArray[np.int32]) -> Leaves:
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
    places = np.zeros(rows, np.int32)
    for n, leaf in enumerate(leaves):
        at = slice(n * BLOCK, n * BLOCK + len(leaf))
        places[at], planes[:keep, at] = centers[leaf], features[:, leaf]
        middles[:keep, n] = features[:, leaf].sum(axis=1, dtype=np.int64) // len(leaf)
    return Leaves(places, np.array([len(leaf) for leaf in leaves], np.int32), planes, middles)


def _filters(
    learned: NDArray[np.float64], root: NDArray[np.float64], variance: float
) -> tuple[NDArray[np.float64], float]:
    """Components to multiply windows with, in whole numbers, and the scale they are rounded at.

    There are fewer windows than numbers in one, so the eigenvectors are those of their products.
    """
    power, vectors = np.linalg.eigh(learned @ learned.T)
    found = learned.T @ vectors
    lengths = np.sqrt((found * found).sum(axis=0))
    found /= np.maximum(lengths, 1e-3)
    found[:, lengths < 1e-3] = 0  # a constant sample varies by rounding only
    filters = main_components(power, found, variance, _MOST_COMPONENTS) * root
    # Products with a window stay below 2**24: exact in single precision, in any order.
    scale = 0.95 * 2**24 / (255 * max(float(np.abs(filters).sum(axis=1).max()), 1e-3))
    return np.rint(filters * scale), scale


def _ridge(
    features: NDArray[np.uint8], unit: float, total: float, size: int
) -> NDArray[np.float64]:
    """A byte's variance beside the components, over that of each component."""
    values, n = features.astype(np.int64), features.shape[1]
    spread = (n * (values * values).sum(axis=1) - values.sum(axis=1) ** 2) * (unit / n) ** 2
    left = max(total - float(spread.sum()), 1e-3 * total, 1e-3) / size
    ridge: NDArray[np.float64] = _RIDGE_FACTOR * left / np.maximum(spread, 1e-3)
    return ridge
