"""The windows of a sample, searched by a boundary zone (section 3 of Liang et al., 2001)."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.search import zone_kernels as _zone_kernels
from weftex.search import zone_search_kernels as _kernels
from weftex.search.boundary_zone import BoundaryZone
from weftex.search.pca import ZonePCA, fit_pca
from weftex.search.quadtree_pyramid import QuadtreePyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.kdtree import KDTree

#: How candidates are found, and the kernel's number for it.
SEARCHES = {"exhaustive": 0, "quadtree": 1, "pca": 2, "kdtree": 3, "kdtree-pca": 3}
_TREE_ERROR = 0.5  # of the approximate kd-tree search
_MOST_POSITIONS = 16384  # windows that the default search looks at; more are thinned out first
_NO_PCA = (np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0, np.zeros((1, 1), np.int16))


class ZoneSearch:
    """The windows of a sample, arranged to be searched by one boundary zone.

    Parameters
    ----------
    zone : BoundaryZone
        By which windows are searched.
    pyramid : QuadtreePyramid
        Of the sample.
    usable : uint8 array (rows, columns)
        1 at the upper left corners of usable windows.
    positions : int32 array (n,)
        Their numbers, row by row.
    search : str
        One of `SEARCHES`.
    candidates : int
        m of section 3.2.
    variance : float
        Share that the principal components keep (section 3.3).
    often : bool
        Many patches will ask, so that an analysis pays.

    Attributes
    ----------
    stride : int
        Pixels between the windows that the low resolution is compared at.
    tree : KDTree or None
        That finds the candidates of section 3.1.
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
        variance: float,
        often: bool,
    ) -> None:
        self.zone, self.usable, self.positions = zone, usable, positions
        self.stride, self.wanted = 1, candidates
        self.pca = ZonePCA(*_NO_PCA)
        self.tree: KDTree | None = None
        self.projected = "pca" in search
        if zone.area == 0:
            search = "exhaustive"
        if search == "pca":
            most = _MOST_POSITIONS
            while self.stride * 2 <= zone.side and len(positions) > most * self.stride**2:
                self.stride *= 2
            if not often:
                search = "quadtree"  # one query does not repay an analysis
        if search not in ("exhaustive", "quadtree") and not self._analyze(
            search, variance, pyramid
        ):
            search, self.stride = "quadtree", 1
        self.source = SEARCHES[search]
        self.nodes = pyramid.nodes(zone.side, self.stride)

    @cached_property
    def kernel_zone(self) -> _kernels.Zone:
        """The zone as kernels take it."""
        zone = self.zone
        return _kernels.Zone(zone.area, zone.runs, zone.blocks, zone.side, zone.bands)

    @cached_property
    def kernel_search(self) -> _kernels.Search:
        """The windows as kernels take them."""
        return _kernels.Search(
            self.source, self.wanted, self.usable, self.positions, self.nodes, self.pca
        )

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if not k.startswith("kernel_")}

    def _analyze(self, search: str, variance: float, pyramid: QuadtreePyramid) -> bool:
        """Find principal components, or grow a kd-tree; False if no window is at the stride."""
        zone, stride = self.zone, self.stride
        coarse = self.usable[::stride, ::stride]
        take = np.flatnonzero(coarse)
        if len(take) == 0:
            return False
        windows = pyramid.windows(zone.blocks, zone.side, stride, *coarse.shape)
        windows = windows if len(take) == coarse.size else windows[:, take]
        y, x = np.divmod(take, coarse.shape[1])
        places = (y * stride * self.usable.shape[1] + x * stride).astype(np.int32)
        if self.projected:
            self.pca = fit_pca(windows, variance)
            self.positions = places
        if "kdtree" in search:
            from weftex.search.kdtree import KDTree

            points = self.pca.features.T if self.projected else windows.T
            self.tree = KDTree(points, places, _TREE_ERROR)
        return True

    def ask_tree(self, canvas: NDArray[np.uint8], y: int, x: int) -> NDArray[np.int32]:
        """Ask the kd-tree for windows like the one at (y, x) of the canvas; none without a tree."""
        if self.tree is None:
            return np.zeros(0, np.int32)
        query = np.empty(len(self.zone.blocks) * canvas.shape[2], np.int32)
        _zone_kernels.zone_means(canvas, y, x, self.zone.blocks, self.zone.side, query)
        if self.projected:
            pca, means, query = self.pca, query, np.empty(len(self.pca.basis), np.int16)
            _zone_kernels.coordinates(pca.basis, pca.offset, pca.shift, means, query)
        return self.tree.nearest(query, self.wanted)
