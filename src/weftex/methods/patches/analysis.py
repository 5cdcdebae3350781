"""The analysis of the sample that patch methods share (section 3 of Liang et al., 2001)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.patches import patch_kernels as _kernels
from weftex.methods.patches.settings import SEARCHES, PatchSettings
from weftex.raster.boxes import box_sums
from weftex.search import zone_kernels as _zone_kernels
from weftex.search.boundary_zone import BoundaryZone, boundary_zone
from weftex.search.pca import ZonePCA, fit_pca
from weftex.search.quadtree_pyramid import QuadtreePyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.search.kdtree import KDTree

_TREE_ERROR = 0.5  # of the approximate kd-tree search
_MOST_POSITIONS = 16384  # windows that the default search looks at; more are thinned out first
_MOST_NUMBERS = 288  # of the low resolution that describe one zone
_NO_PCA = (np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0, np.zeros((1, 1), np.int16))


class PatchAnalysis:
    """The windows of a sample and the search structures for boundary zones.

    The windows are found once, their low-resolution blocks sorted into a quadtree pyramid, and the
    boundary zones of the paper's three configurations (Fig. 3 b to d) put into search structures.

    Parameters
    ----------
    settings : PatchSettings
        Settled for this sample.
    exemplar : Exemplar
        The sample.

    Raises
    ------
    InvalidInputError
        If no window lies in the usable part of the sample.
    """

    def __init__(self, settings: PatchSettings, exemplar: Exemplar) -> None:
        self.settings, self.exemplar = settings, exemplar
        self.pixels = exemplar.matching(settings.edge_weight)
        self.mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
        side = settings.window_side
        if exemplar.tileable:  # edge handling of section 2.4
            beyond = ((0, side - 1), (0, side - 1))
            self.pixels = np.pad(self.pixels, (*beyond, (0, 0)), mode="wrap")
            self.mask = np.pad(self.mask, beyond, mode="wrap")
        self.pixels = np.ascontiguousarray(self.pixels)
        self.turned = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        self.pyramid = QuadtreePyramid(self.pixels)
        #: The paper's third level is 4; single pixels need every neighbor.
        self.block_side = 4 if settings.search != "pca" else 1 if settings.pixelwise else 16
        self._structures: dict[tuple[Any, ...], SearchStructure] = {}
        self._usable: dict[tuple[int, int], NDArray[np.uint8]] = {}
        self._positions: dict[tuple[int, int], NDArray[np.int32]] = {}
        self.usable(side, side)
        if exemplar.mask is None:  # a sample with a mask is more likely to fill its own hole
            self._analyze()

    def _analyze(self) -> None:
        """Make the structures that most patches of a new picture will ask."""
        side, width = self.settings.window_side, self.settings.boundary_width
        known = np.zeros((side, side), bool)
        if self.settings.pixelwise:
            known.ravel()[: known.size // 2] = True
            self.structure(known, width=width, often=True)
            return
        for left, top in ((True, False), (False, True), (True, True)):
            known[:] = False
            known[:, :width] |= left
            known[:width] |= top
            self.structure(known, width=width, often=True)

    def usable(self, rows: int, columns: int) -> NDArray[np.uint8]:
        """Mark the upper left corners of windows that lie in the usable part of the sample."""
        if (rows, columns) in self._usable:
            return self._usable[rows, columns]
        height, width = self.exemplar.shape
        bad = box_sums(~self.mask, rows, columns)
        # A sample that tiles is padded: beyond its own size windows come a second time.
        usable = np.ascontiguousarray(bad[:height, :width] == 0, np.uint8)
        if not usable.any():
            raise InvalidInputError(
                f"no {columns}x{rows} window lies in the usable part of {self.exemplar.name}; "
                f"use a smaller patch_size (now {self.settings.patch_size})"
            )
        self._usable[rows, columns] = usable
        return usable

    def positions(self, rows: int, columns: int) -> NDArray[np.int32]:
        """Return the usable windows' numbers."""
        if (rows, columns) not in self._positions:
            usable = self.usable(rows, columns)
            self._positions[rows, columns] = np.flatnonzero(usable).astype(np.int32)
        return self._positions[rows, columns]

    def structure(
        self,
        known: NDArray[np.bool_],
        frozen: NDArray[np.bool_] | None = None,
        *,
        width: int,
        often: bool = False,
    ) -> SearchStructure:
        """Return the search structure for one configuration, made on first use.

        Parameters
        ----------
        known : bool array (rows, columns)
            Pixels of the window that are on the canvas already.
        frozen : bool array (rows, columns), optional
            Known pixels around a hole, which must stay. Such structures are each asked once and
            not kept.
        width : int
            Boundary width w_E.
        often : bool
            Many patches will ask, so that an analysis pays.
        """
        key = (known.shape, known.tobytes(), width, often)
        if frozen is None and key in self._structures:
            return self._structures[key]
        settings = self.settings
        zone = boundary_zone(
            known,
            width,
            frozen=frozen,
            block_side=self.block_side,
            most_blocks=max(16, _MOST_NUMBERS // self.pixels.shape[2]),
            paste=settings.blend == "none",
            core=(settings.boundary_width,) * 2 if settings.pixelwise else None,
        )
        shape = known.shape[0], known.shape[1]
        structure = SearchStructure(
            settings, zone, self.pyramid, self.usable(*shape), self.positions(*shape), often
        )
        if frozen is None:
            self._structures[key] = structure
        return structure

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_structures": {}, "_usable": {}, "_positions": {}}


class SearchStructure:
    """The windows of a sample, arranged to be searched by one boundary zone.

    Parameters
    ----------
    settings : PatchSettings
        Which search, and how many candidates.
    zone : BoundaryZone
        By which windows are searched.
    pyramid : QuadtreePyramid
        Of the sample.
    usable : uint8 array (rows, columns)
        1 at the upper left corners of usable windows.
    positions : int32 array (n,)
        Their numbers.
    often : bool
        Many patches will ask, so that an analysis pays.

    Attributes
    ----------
    weight : uint16 array (1, rows, columns)
        What a chosen patch is laid with while others are still to be chosen.
    tree : KDTree or None
        That finds the candidates of section 3.1.
    """

    def __init__(
        self,
        settings: PatchSettings,
        zone: BoundaryZone,
        pyramid: QuadtreePyramid,
        usable: NDArray[np.uint8],
        positions: NDArray[np.int32],
        often: bool,
    ) -> None:
        search = settings.search
        self.zone, self.usable, self.positions = zone, usable, positions
        self.stride, self.source = 1, SEARCHES[search]
        self.pca = ZonePCA(*_NO_PCA)
        self.tree: KDTree | None = None
        self.projected = "pca" in search
        self.wanted = settings.candidates
        if zone.area == 0 or settings.anything:  # chaos mosaic needs no search
            self.source = SEARCHES["exhaustive"]
        elif search == "pca":
            most = _MOST_POSITIONS
            while self.stride * 2 <= zone.side and len(positions) > most * self.stride**2:
                self.stride *= 2
        if search == "pca" and self.source == SEARCHES["pca"] and not often:
            self.source = SEARCHES["quadtree"]  # one query does not repay an analysis
        if self.source not in (SEARCHES["exhaustive"], SEARCHES["quadtree"]):
            self._analyze(settings, pyramid)
        weight = zone.weight
        if settings.blend == "feather-at-end":
            weight = np.where(weight > 0, 256, 0).astype(np.uint16)
        self.weight = weight[None]
        nodes = pyramid.nodes(zone.side, self.stride)
        self.kernel_zone = _kernels.Zone(zone.area, zone.runs, zone.blocks, zone.side, zone.bands)
        self.kernel_search = _kernels.Search(
            self.source, self.wanted, usable, self.positions, nodes, self.pca
        )

    def _analyze(self, settings: PatchSettings, pyramid: QuadtreePyramid) -> None:
        """Find the windows' principal components (section 3.3) or put them into a kd-tree."""
        zone, stride = self.zone, self.stride
        coarse = self.usable[::stride, ::stride]
        take = np.flatnonzero(coarse)
        if len(take) == 0:
            self.source, self.stride = SEARCHES["quadtree"], 1
            return
        windows = pyramid.windows(zone.blocks, zone.side, stride, *coarse.shape)
        windows = windows if len(take) == coarse.size else windows[:, take]
        y, x = np.divmod(take, coarse.shape[1])
        places = (y * stride * self.usable.shape[1] + x * stride).astype(np.int32)
        if self.projected:
            self.pca = fit_pca(windows, settings.variance)
            self.positions = places
        if "kdtree" in settings.search:
            from weftex.search.kdtree import KDTree

            points = self.pca.features.T if self.projected else windows.T
            self.tree = KDTree(points, places, _TREE_ERROR)

    def ask_tree(
        self, tree: KDTree, canvas: NDArray[np.uint8], y: int, x: int
    ) -> NDArray[np.int32]:
        """Ask the kd-tree for windows like the one at (y, x) of the canvas."""
        query = np.empty(len(self.zone.blocks) * canvas.shape[2], np.int32)
        _zone_kernels.zone_means(canvas, y, x, self.zone.blocks, self.zone.side, query)
        if self.projected:
            pca, means, query = self.pca, query, np.empty(len(self.pca.basis), np.int16)
            _zone_kernels.coordinates(pca.basis, pca.offset, pca.shift, means, query)
        return tree.nearest(query, self.wanted)

    def scratch(self, channels: int) -> Any:
        """Return the room that the kernel needs to search for one patch."""
        zone, columns = self.zone, self.usable.shape[1]
        room = len(self.positions)
        if self.source != SEARCHES["exhaustive"]:
            room = self.wanted + 54 * self.stride  # and what is climbed to from a coarse grid
        return _kernels.Scratch(
            wanted=self.wanted,
            keys=np.empty(room, np.int64),
            places=np.empty(room, np.int32),
            partial=np.empty(columns, np.int32),
            total=np.empty(columns, np.int64),
            query=np.empty(zone.area * channels, np.uint8),
            means=np.empty(len(zone.blocks) * channels, np.int32),
            coordinates=np.empty(len(self.pca.basis), np.int16),
            barred=np.empty(room, np.uint8),
            cost=np.empty((max(zone.weight.shape), int(zone.bands[0])), np.int64),
        )
