"""The windows of a sample, searched by a boundary zone (section 3 of Liang et al., 2001)."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import missing_packages
from weftex.methods.patches import zone_kernels
from weftex.methods.patches.boundary_zone import BoundaryZone
from weftex.methods.patches.zone_kernels import SOURCES, ZoneWindows
from weftex.search.pca import ZonePCA, fit_pca

#: How candidates are found: compare all, or the paper's accelerations and what they combine to.
SEARCHES = ("exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca")
_ALL, _BLOCKS, _COMPONENTS, _TREE = SOURCES
_TREE_ERROR = 0.5  # a neighbor that the kd-tree finds may be farther than the true one by this
_MOST_POSITIONS = 16384  # windows that the default search compares; more are thinned out first
_NO_PCA = ZonePCA(np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0, np.zeros((1, 1), np.int16))


class QuadtreePyramid:
    """The quadtree pyramid of section 3.2: means over blocks at every pixel of a sample (H, W, C).

    The paper keeps all four shifts of each halving, so level 3 is 16 small pictures: the pixels of
    one picture of means, sorted by shift. Rows of a shift are contiguous, as the kernel wants them.
    """

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        self.pixels = pixels
        self._nodes: dict[tuple[int, int], NDArray[np.uint8]] = {}

    def nodes(self, side: int, stride: int) -> NDArray[np.uint8]:
        """Return (channel, shift y, shift x, row, column): rounded means of side x side blocks.

        `side` is a power of two; the paper's level 3 is 4. Windows are `stride` pixels apart.
        """
        if (side, stride) not in self._nodes:
            rows, columns = (max(0, n - side + 1) for n in self.pixels.shape[:2])
            down, across = -(-rows // stride), -(-columns // stride)
            channels = self.pixels.shape[2]
            found = np.zeros((channels, stride, stride, down, across), np.uint8)
            means = np.zeros((down * stride, across * stride), np.uint8)
            for channel in range(channels):  # one at a time: samples may be of 12 megapixels
                means[:rows, :columns] = _block_means(self.pixels[..., channel], side)
                blocks = means.reshape(down, stride, across, stride)
                found[channel] = blocks.transpose(1, 3, 0, 2)
            self._nodes[side, stride] = found
        return self._nodes[side, stride]

    def windows(
        self, blocks: NDArray[np.int32], side: int, stride: int, rows: int, columns: int
    ) -> NDArray[np.uint8]:
        """Return (blocks * channels, rows * columns): every window's blocks in the kernel's order.

        `rows` and `columns` count windows, `stride` pixels apart.
        """
        nodes = self.nodes(side, stride)
        found = np.empty((len(blocks), nodes.shape[0], rows, columns), np.uint8)
        for k, (v, u) in enumerate(blocks.tolist()):
            i, j = v // stride, u // stride
            found[k] = nodes[:, v % stride, u % stride, i : i + rows, j : j + columns]
        return found.reshape(-1, rows * columns)


class ZoneSearch:
    """The windows of a sample, arranged to be searched by one boundary zone.

    `usable` (rows, columns) is 1 at the upper left corners of usable windows, `positions` (n,)
    their numbers row by row. `candidates` is m of section 3.2; `often` repays an analysis.
    """

    def __init__(
        self,
        zone: BoundaryZone,
        pyramid: QuadtreePyramid,
        usable: NDArray[np.uint8],
        positions: NDArray[np.int32],
        *,
        search: str,
        candidates: int,
        often: bool,
    ) -> None:
        self.zone, self.usable, self.positions = zone, usable, positions
        self.stride, self.wanted = 1, candidates
        self.pca: ZonePCA | None = None  # by which candidates are found (section 3.3)
        self.tree: Any = None  # the kd-tree that finds the candidates of section 3.1
        if zone.area == 0:
            search = "exhaustive"
        if search == "pca" and not (self._thin_out() and often):
            search = "quadtree"
        self.source = _ALL if search == "exhaustive" else _BLOCKS
        if search not in ("exhaustive", "quadtree"):
            self.positions, windows = self._low_resolution(pyramid)
            points: NDArray[np.integer] = windows
            if "pca" in search:
                self.pca = fit_pca(windows)
                self.source, points = _COMPONENTS, self.pca.features
            if "kdtree" in search:
                self.source, self.tree = _TREE, kd_tree(points.T)
        self.nodes = pyramid.nodes(zone.side, self.stride)

    def _thin_out(self) -> bool:
        """Choose the stride between the windows to compare; False if a mask hides all of them."""
        stride, count = 1, len(self.positions)
        while stride * 2 <= self.zone.side and count > _MOST_POSITIONS * stride**2:
            stride *= 2
        there = bool(self.usable[::stride, ::stride].any())
        self.stride = stride if there else 1
        return there

    def _low_resolution(
        self, pyramid: QuadtreePyramid
    ) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
        """Return the numbers of the windows at the stride, and the means of their zones' blocks."""
        zone, stride = self.zone, self.stride
        coarse = self.usable[::stride, ::stride]
        take = np.flatnonzero(coarse)
        windows = pyramid.windows(zone.blocks, zone.side, stride, *coarse.shape)
        windows = windows if len(take) == coarse.size else windows[:, take]
        y, x = np.divmod(take, coarse.shape[1])
        return (y * stride * self.usable.shape[1] + x * stride).astype(np.int32), windows

    @cached_property
    def kernel(self) -> ZoneWindows:
        """What kernels search."""
        return ZoneWindows(
            self.source, self.usable, self.positions, self.zone, self.nodes, self.pca or _NO_PCA
        )

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "kernel"}

    def nearest_in_tree(self, canvas: NDArray[np.uint8], y: int, x: int) -> NDArray[np.int32]:
        """Return the windows that the kd-tree finds for the zone at (y, x) of the canvas."""
        query = np.empty(len(self.zone.blocks) * canvas.shape[2], np.int32)
        zone_kernels.block_means(canvas, y, x, self.zone.blocks, self.zone.side, query)
        if self.pca is not None:
            pca, means, query = self.pca, query, np.empty(len(self.pca.basis), np.int16)
            zone_kernels.project(pca.basis, pca.offset, pca.shift, means, query)
        wanted = min(self.wanted, len(self.positions))
        found = self.tree.query(query, k=wanted, eps=_TREE_ERROR, workers=1)[1]
        nearest: NDArray[np.int32] = self.positions[np.atleast_1d(found)]
        return nearest


def kd_tree(points: NDArray[np.integer]) -> Any:
    """Return the kd-tree of section 3.1 over points (n, K), as SciPy has it.

    Without balancing, SciPy splits by the sliding midpoint rule, as the paper wants.
    """
    try:
        from scipy.spatial import cKDTree
    except ImportError:
        raise missing_packages("kd-trees need SciPy", "kdtree") from None
    return cKDTree(points, leafsize=8, balanced_tree=False, compact_nodes=False)


def _block_means(level: NDArray[np.uint8], side: int) -> NDArray[Any]:
    """Means over blocks, rounded, in numbers that hold their sums."""
    total: NDArray[Any] = level.astype(np.uint16 if side <= 16 else np.uint32)
    step = 1
    while step < side:
        total = total[:-step] + total[step:]
        total = total[:, :-step] + total[:, step:]
        step *= 2
    total += total.dtype.type(side * side // 2)
    total >>= total.dtype.type(2 * (side.bit_length() - 1))
    return total
