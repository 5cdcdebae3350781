"""What Liang et al. (2001), section 3, search windows with: kd-tree, quadtree pyramid, components.

Principal components are rounded to integers and so are the coordinates. A matrix product of
integers is exact in floating point as long as no sum passes 2**24, whatever the order of summation;
so the coordinates, and with them the candidates, are the same on every machine and thread count.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import missing_packages
from weftex.raster.arrays import Bytes, Floats, Indices
from weftex.threads import one_blas_thread

_VARIANCE = 0.97  # that components keep, as in the paper
MOST_COMPONENTS = 48  # keeps a sum of squares in the kernel under 2**31
_MOST_LEARNED = 4096  # windows that the components are learned from
_LONGEST_VECTOR = 2047  # of coordinates


def kd_tree(points: NDArray[np.integer]) -> Any:
    """Return the kd-tree of section 3.1 over points (n, K), as SciPy has it.

    Without balancing, SciPy splits by the sliding midpoint rule, as the paper wants.
    """
    try:
        from scipy.spatial import cKDTree
    except ImportError:
        raise missing_packages("kd-trees need SciPy", "kdtree") from None
    return cKDTree(points, leafsize=8, balanced_tree=False, compact_nodes=False)


class QuadtreePyramid:
    """The quadtree pyramid of section 3.2: means over squares at every pixel of a sample (H, W, C).

    The paper keeps all four shifts of each halving, so level 3 is 16 small pictures: the pixels of
    one picture of means, sorted by shift. Rows of a shift are contiguous, as the kernel wants them.
    """

    def __init__(self, pixels: Bytes) -> None:
        self.pixels = pixels
        self._nodes: dict[tuple[int, int], Bytes] = {}

    def nodes(self, side: int, stride: int) -> Bytes:
        """Return (channel, shift y, shift x, row, column): rounded means of side x side squares.

        `side` is a power of two; the paper's level 3 is 4. Windows are `stride` pixels apart.
        """
        if (side, stride) not in self._nodes:
            rows, columns = (max(0, n - side + 1) for n in self.pixels.shape[:2])
            down, across = -(-rows // stride), -(-columns // stride)
            channels = self.pixels.shape[2]
            found = np.zeros((channels, stride, stride, down, across), np.uint8)
            means = np.zeros((down * stride, across * stride), np.uint8)
            for channel in range(channels):  # one at a time: samples may be of 12 megapixels
                means[:rows, :columns] = _square_means(self.pixels[..., channel], side)
                squares = means.reshape(down, stride, across, stride)
                found[channel] = squares.transpose(1, 3, 0, 2)
            self._nodes[side, stride] = found
        return self._nodes[side, stride]

    def windows(self, squares: Indices, side: int, stride: int, rows: int, columns: int) -> Bytes:
        """Return (squares * channels, rows * columns): every window's, in the kernel's order.

        `rows` and `columns` count windows, `stride` pixels apart.
        """
        nodes = self.nodes(side, stride)
        found = np.empty((len(squares), nodes.shape[0], rows, columns), np.uint8)
        for k, (v, u) in enumerate(squares.tolist()):
            i, j = v // stride, u // stride
            found[k] = nodes[:, v % stride, u % stride, i : i + rows, j : j + columns]
        return found.reshape(-1, rows * columns)


def _square_means(level: Bytes, side: int) -> NDArray[Any]:
    """Means over squares at every pixel, rounded as the kernel `square_means` rounds them."""
    total: NDArray[Any] = level.astype(np.uint16 if side <= 16 else np.uint32)  # holds sums
    step = 1
    while step < side:
        total = total[:-step] + total[step:]
        total = total[:, :-step] + total[:, step:]
        step *= 2
    total += total.dtype.type(side * side // 2)
    total >>= total.dtype.type(2 * (side.bit_length() - 1))
    return total


@dataclass(frozen=True, eq=False)
class Components:
    """Principal components (section 3.3) of windows' bytes or means, with all coordinates."""

    basis: NDArray[np.int16]  # (D, K): components, scaled and rounded
    offset: Indices  # (D,): subtracted from a product with `basis`
    shift: int  # to the right, with rounding, which brings coordinates to their range
    coordinates: NDArray[np.int16]  # (D, n): of the windows; one component is one row


def fit_pca(windows: Bytes, variance: float = _VARIANCE) -> Components:
    """Return the components of the columns of `windows`, (K, n), and the columns' coordinates.

    At most 48 components keep this share of the variance.
    """
    size, count = windows.shape
    with one_blas_thread():
        learn = windows[:, np.linspace(0, count - 1, min(count, _MOST_LEARNED)).astype(np.int64)]
        learn = learn.astype(np.float64)
        # Integers in float64: the products and sums are exact, so every machine gets this matrix.
        sums = learn.sum(axis=1)
        scatter = learn.shape[1] * (learn @ learn.T) - np.outer(sums, sums)
        power, vectors = np.linalg.eigh(scatter)
        vectors = main_components(power, vectors, variance)
        unit = min(2000.0, 0.95 * 2**24 / (255 * size**0.5))
        basis = np.ascontiguousarray(np.rint(vectors * unit), np.int16)
        weights = basis.astype(np.float32)
        raw = np.empty((len(basis), count), np.int32)
        for start in range(0, count, 8192):
            part = windows[:, start : start + 8192].astype(np.float32)
            raw[:, start : start + 8192] = weights @ part
        return Components(basis, *coordinates_of(raw))


def main_components(power: Floats, vectors: Floats, variance: float) -> Floats:
    """Return the main eigenvectors from `eigh` as rows, with a positive largest entry.

    They keep this share of the variance, unless that takes more than `MOST_COMPONENTS`.
    """
    power, vectors = power[::-1].clip(0), vectors[:, ::-1]
    reached = np.cumsum(power) >= variance * power.sum()
    needed = int(np.argmax(reached)) + 1 if reached.any() else len(power)
    kept = vectors[:, : min(needed, MOST_COMPONENTS)].T
    largest = np.abs(kept).argmax(axis=1)
    result: Floats = kept * np.sign(kept[np.arange(len(kept)), largest])[:, None]
    return result


def coordinates_of(raw: NDArray[np.integer]) -> tuple[Indices, int, NDArray[np.int16]]:
    """Return `offset`, `shift`, `coordinates` of `Components`: products with `basis` in 16 bits.

    `raw` has one component a row. No window is further than 2047 from 0.
    """
    offset = ((raw.max(axis=1) + raw.min(axis=1)) // 2).astype(np.int32)
    raw = raw - offset[:, None]
    longest = float(np.sqrt((raw.astype(np.float64) ** 2).sum(axis=0).max()))
    shift = 0
    while longest / 2**shift > _LONGEST_VECTOR:
        shift += 1
    coordinates = ((raw + ((1 << shift) >> 1)) >> shift).astype(np.int16)
    return offset, shift, np.ascontiguousarray(coordinates)
