"""The windows of a sample, and their search by a boundary zone (Liang et al., 2001, section 3)."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.patches.boundary_zone import BoundaryZone, boundary_zone
from weftex.methods.patches.method import SEARCHES, PatchMethod
from weftex.methods.patches.patch_kernels import WindowSearch
from weftex.raster.arrays import Bytes, Mask
from weftex.raster.boxes import box_sums
from weftex.search.approximate_nearest import Components, QuadtreePyramid, fit_pca, kd_tree
from weftex.search.approximate_nearest_kernels import project, square_means

_MOST_NUMBERS = 288  # of the low resolution that describe one zone
_MOST_WINDOWS = 16384  # that the default search compares; more are thinned out first
_TREE_ERROR = 0.5  # a neighbor that the kd-tree finds may be farther than the true one by this
_NO_PCA = Components(
    np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0, np.zeros((1, 1), np.int16)
)


class PatchAnalysis:
    """The windows of a sample and the search structures for boundary zones.

    `method` is resolved. With `ahead`, the three zones of Liang et al., Fig. 3 (b) to (d), are
    analyzed at once.
    """

    def __init__(self, method: PatchMethod, exemplar: Exemplar, *, ahead: bool = True) -> None:
        self.method, self.exemplar = method, exemplar
        self.pixels = exemplar.matching()
        self.mask = exemplar.usable
        side = method.window_side
        if exemplar.tileable:  # edge handling of Liang et al., section 2.4
            beyond = ((0, side - 1), (0, side - 1))
            self.pixels = np.pad(self.pixels, (*beyond, (0, 0)), mode="wrap")
            self.mask = np.pad(self.mask, beyond, mode="wrap")
        self.pixels = np.ascontiguousarray(self.pixels)
        self.transposed = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        self.pyramid = QuadtreePyramid(self.pixels)
        #: The largest side of the squares of a zone: the third level of Liang et al., section 3.2.
        self.square_side = 4
        if method.search == "pca":  # larger squares lose little; single pixels need each neighbor
            self.square_side = 1 if method.pixelwise else 16
        self._searches: dict[tuple[Any, ...], ZoneSearch] = {}
        self._windows: dict[tuple[int, int], tuple[Bytes, NDArray[np.int32]]] = {}
        self._others: dict[PatchMethod, PatchAnalysis] = {}
        self.windows(side, side)
        # A sample with a mask is more likely to fill its own hole.
        if ahead and exemplar.mask is None:
            self._analyze()

    def for_method(self, method: PatchMethod) -> PatchAnalysis:
        """Return the analysis for other sizes: this one, or one that is made on first use."""
        if method == self.method:
            return self
        if method not in self._others:
            if self.exemplar.tileable:  # the padding is as wide as patches
                other = PatchAnalysis(method, self.exemplar)
            else:
                other = copy(self)
                other.method, other._searches, other._windows = method, {}, {}
            self._others[method] = other
        return self._others[method]

    def _analyze(self) -> None:
        """Make the search structures that most patches of a new picture need."""
        side, width = self.method.window_side, self.method.boundary_width
        assert width
        known = np.zeros((side, side), bool)
        if self.method.pixelwise:
            known.ravel()[: known.size // 2] = True
            self.zone_search(known, width=width, often=True)
            return
        for left, top in ((True, False), (False, True), (True, True)):
            known[:] = False
            known[:, :width] |= left
            known[:width] |= top
            self.zone_search(known, width=width, often=True)

    def windows(self, rows: int, columns: int) -> tuple[Bytes, NDArray[np.int32]]:
        """Mark and number the upper left corners of windows in the usable part of the sample."""
        if (rows, columns) not in self._windows:
            height, width = self.exemplar.shape
            usable = np.asarray(box_sums(~self.mask, rows, columns) == 0, np.uint8)
            # A sample that tiles is padded: beyond its own size windows come a second time.
            usable = np.ascontiguousarray(usable[:height, :width])
            if not usable.any():
                raise InvalidInputError(
                    f"no {columns}x{rows} window lies in the usable part of {self.exemplar.name}; "
                    f"{self._what_fits()}"
                )
            self._windows[rows, columns] = usable, np.flatnonzero(usable).astype(np.int32)
        return self._windows[rows, columns]

    def _what_fits(self) -> str:
        """Name the largest patches, or zones around single pixels, that lie in the usable part."""
        widest, too_wide = 1, min(self.mask.shape) + 1
        while too_wide - widest > 1:
            side = (widest + too_wide) // 2
            fits = (box_sums(~self.mask, side, side) == 0).any()
            widest, too_wide = (side, too_wide) if fits else (widest, side)
        method = self.method
        if method.pixelwise and widest >= 3:
            now = method.boundary_width
            return f"boundary_width may be at most {(widest - 1) // 2} (now {now})"
        if widest >= 2 and not method.pixelwise:
            return f"patch_size may be at most {widest} (now {method.patch_size})"
        return f"it has room for {widest}x{widest}; a patch takes 2x2, a pixel and its zone 3x3"

    def zone_search(
        self, known: Mask, frozen: Mask | None = None, *, width: int, often: bool = False
    ) -> ZoneSearch:
        """Return the sample's windows, arranged for the search by one boundary zone.

        `known` are the window's pixels that are pasted already, `frozen` those that must stay.
        Around a hole each zone is met once: it is not `often` and not kept.
        """
        of_hole = frozen is not None and not often
        stays = b"" if frozen is None else frozen.tobytes()
        key = (known.shape, known.tobytes(), width, often, stays)
        if not of_hole and key in self._searches:
            return self._searches[key]
        method = self.method
        zone = boundary_zone(
            known,
            width,
            frozen=frozen,
            outlines=of_hole,
            square_side=self.square_side,
            most_squares=max(16, _MOST_NUMBERS // self.pixels.shape[2]),
            paste=method.blend == "none",
            core=(width, width) if method.pixelwise else None,
        )
        search = ZoneSearch(
            zone,
            self.pyramid,
            *self.windows(*zone.weight.shape),
            search="exhaustive" if method.accepts_all else method.search,
            often=often,
        )
        if not of_hole:
            self._searches[key] = search
        return search

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_searches": {}, "_windows": {}, "_others": {}}


class ZoneSearch:
    """The windows of a sample, arranged to be searched by one boundary zone.

    `usable` (rows, columns) is 1 at the upper left corners of usable windows, `corners` (n,) their
    numbers row by row. `search` is a key of `SEARCHES`; a zone met `often` repays an analysis.
    """

    tree: Any  # the kd-tree that is asked for candidates, if there is one

    def __init__(
        self,
        zone: BoundaryZone,
        pyramid: QuadtreePyramid,
        usable: Bytes,
        corners: NDArray[np.int32],
        *,
        search: str,
        often: bool,
    ) -> None:
        self.zone, self._corners, self.stride = zone, corners, 1
        self._pca, self.tree = _NO_PCA, None
        if zone.area == 0:
            search = "exhaustive"
        if search == "pca":
            self.stride = _stride(usable, len(corners), zone.side)
            search = search if often else "quadtree"
        if search not in ("exhaustive", "quadtree"):
            self._describe(pyramid, usable, search)
        #: What kernels search.
        self.kernel = WindowSearch(
            SEARCHES[search], self.stride, usable, self._corners, zone,
            pyramid.nodes(zone.side, self.stride), self._pca,
        )  # fmt: skip

    def _describe(self, pyramid: QuadtreePyramid, usable: Bytes, search: str) -> None:
        """Describe the windows at the stride by block means or components; make a tree of them."""
        coarse = usable[:: self.stride, :: self.stride] > 0
        zone, numbers = self.zone, np.arange(usable.size, dtype=np.int32).reshape(usable.shape)
        self._corners = numbers[:: self.stride, :: self.stride][coarse]
        windows = pyramid.windows(zone.squares, zone.side, self.stride, *coarse.shape)
        points: NDArray[Any] = windows if coarse.all() else windows[:, coarse.ravel()]
        if search != "kdtree":
            self._pca = fit_pca(points)
            points = self._pca.coordinates
        if search != "pca":
            self.tree = kd_tree(points.T)

    def nearest_in_tree(self, canvas: Bytes, y: int, x: int, wanted: int) -> NDArray[np.int32]:
        """Return the windows that the kd-tree finds for the zone at (y, x) of the canvas."""
        query = np.empty(len(self.zone.squares) * canvas.shape[2], np.int32)
        square_means(canvas, y, x, self.zone.squares, self.zone.side, query)
        if self._pca is not _NO_PCA:
            pca, means, query = self._pca, query, np.empty(len(self._pca.basis), np.int16)
            project(pca.basis, pca.offset, pca.shift, means, query)
        wanted = min(wanted, len(self._corners))
        found = self.tree.query(query, k=wanted, eps=_TREE_ERROR, workers=1)[1]
        nearest: NDArray[np.int32] = self._corners[np.atleast_1d(found)]
        return nearest


def _stride(usable: Bytes, count: int, most: int) -> int:
    """Choose the stride between the windows to compare; 1 if a mask hides all windows at it."""
    stride = 1
    while stride * 2 <= most and count > _MOST_WINDOWS * stride**2:
        stride *= 2
    return stride if usable[::stride, ::stride].any() else 1


class Zones:
    """The boundary zones of one output, numbered in the order in which patches meet them."""

    def __init__(self, analysis: PatchAnalysis, boundary_width: int) -> None:
        self._analysis, self._width = analysis, boundary_width
        self._numbers: dict[tuple[bytes, bytes], int] = {}
        #: The sample's windows, arranged to be searched by each zone.
        self.searches: list[ZoneSearch] = []
        #: (1, rows, columns): the weights that a patch is pasted with while others are chosen.
        self.weights: list[NDArray[np.uint16]] = []

    def number(self, known: Mask, frozen: Mask | None = None, often: bool = False) -> int:
        """Return the number of the zone of a window, see `PatchAnalysis.zone_search`."""
        key = known.tobytes(), b"" if frozen is None else frozen.tobytes()
        if key not in self._numbers:
            search = self._analysis.zone_search(known, frozen, width=self._width, often=often)
            weight = search.zone.weight
            if self._analysis.method.blend == "feather-at-end":
                weight = np.where(weight > 0, 256, 0).astype(np.uint16)
            self._numbers[key] = len(self.searches)
            self.searches.append(search)
            self.weights.append(weight[None])
        return self._numbers[key]
