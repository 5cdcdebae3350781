"""The analysis that patch methods share (section 3 of Liang et al., 2001)."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.method import Method, parameter
from weftex.methods.patches.hole_sizes import patch_size_for
from weftex.raster.boxes import box_sums
from weftex.search import zone_kernels as _kernels
from weftex.search.boundary_zone import BoundaryZone, boundary_zone
from weftex.search.pca import ZonePCA, fit_pca
from weftex.search.quadtree_pyramid import QuadtreePyramid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.patch_sampling import PatchModel
    from weftex.search.kdtree import KDTree

#: How candidates are found, and the kernel's number for it.
SEARCHES = {"exhaustive": 0, "quadtree": 1, "pca": 2, "kdtree": 3, "kdtree-pca": 3}
_HOLE_ZONE, _HOLE_CANDIDATES = 4, 400  # boundary width in px and candidates for holes
_TREE_ERROR = 0.5  # of the approximate kd-tree search
_POSITIONS = 16384  # windows that the default search looks at; more are thinned out first
_MOST_NUMBERS = 288  # of the low resolution that describe one zone
_NO_PCA = (np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0, np.zeros((1, 1), np.int16))


@dataclass(frozen=True)
class PatchMethod(Method):
    """What patch-based sampling and image quilting have in common."""

    supports: ClassVar[frozenset[str]] = frozenset({"wrap", "known"})
    #: Boundary width over patch size, where none is given.
    zone_share: ClassVar[float] = 0.1

    patch_size: int | None = parameter(
        None,
        "side w_B of the square patches; 1 samples single pixels (section 2.5)",
        low=1,
        unit="px",
        default_text="randomness x the sample's shorter side",
    )
    randomness: float = parameter(
        0.3, "lambda: patch size over the sample's shorter side", low=0.001, high=1.0
    )
    boundary_width: int | None = parameter(
        None,
        "width w_E of the boundary zone that must match",
        low=1,
        unit="px",
        default_text="a tenth of the patch, 4 or more",
    )
    search: str = parameter(
        "pca",
        "how candidates are found: the default, or one of the paper's (Table I)",
        choices=tuple(SEARCHES),
    )
    candidates: int = parameter(
        40,
        "m: windows from the low resolution that are compared at the full one",
        low=1,
        high=10000,
        needs=("search", ("quadtree", "pca", "kdtree", "kdtree-pca")),
    )
    variance: float = parameter(
        0.97,
        "share of the variance that the principal components keep",
        low=0.01,
        high=1.0,
        needs=("search", ("pca", "kdtree-pca")),
    )
    edge_weight: float = parameter(
        0.0,
        "how much outlines count beside colour when zones are compared; 0 is the paper's metric",
        low=0.0,
        high=10.0,
    )

    repeat_distance: float = parameter(
        0.5,
        "sources of patches near each other keep this far apart, in patches; 0 is the papers' way",
        low=0.0,
        high=10.0,
    )

    def for_part(self, whole: Exemplar) -> Self:
        """See `Method.for_part`: a share that was asked for is one of the whole."""
        share = {field.name: field.default for field in fields(self)}["randomness"]
        if self.patch_size is not None or self.randomness == share:
            return self
        return replace(self, patch_size=max(1, round(self.randomness * min(whole.shape))))

    @property
    def hole_reach(self) -> int:
        """See `Method.hole_reach`."""
        return 2 * (self.patch_size or 0)

    def for_hole(
        self, hole: NDArray[np.bool_], usable: NDArray[np.bool_], given: frozenset[str] | None
    ) -> Self:
        """See `Method.for_hole`.

        Known pixels cannot be blended, so the best match is taken; and the wider a zone of an
        irregular material, the more its best match is a dull, blurred place. As holes take few
        patches, more candidates cost little. All chosen by eye on bricks, tiles, boards, pebbles,
        leaves and lawn.
        """
        size = self.patch_size or patch_size_for(hole, usable, 2 * (self.boundary_width or 1))
        suits: dict[str, Any] = {"patch_size": size}
        if self.boundary_width is None and size > 1:
            suits["boundary_width"] = min(_HOLE_ZONE, size // 2)
        # An exhaustive search takes no number of candidates.
        if given is not None and not given & {"candidates", "search"}:
            suits["candidates"] = _HOLE_CANDIDATES
        return replace(self, **suits)

    def rule(self) -> tuple[float, bool, bool]:
        """Tolerance, whether it is relative to the best candidate, whether similarity weighs."""
        raise TypeError(f"{type(self).__name__} does not define rule")

    @property
    def seam(self) -> str:
        """How patches are joined: the field `blend`."""
        return str(getattr(self, "blend"))  # noqa: B009  (declared by the subclasses)

    def fit(self, exemplar: Exemplar) -> PatchModel:
        """Analyse a sample (section 3): see `PatchModel`."""
        from weftex.methods.patch_sampling import PatchModel

        return PatchModel(self, exemplar)


class PatchAnalysis:
    """A sample prepared for patch-based sampling.

    The windows of the sample are found once, their low-resolution blocks sorted into a quadtree
    pyramid, and the boundary zones of the paper's three configurations (Fig. 3 b to d) put into
    the search structure.

    Parameters
    ----------
    method : PatchMethod
        Parameters.
    exemplar : Exemplar
        The sample; it must hold at least one whole patch.

    Raises
    ------
    InvalidInputError
        If the sample is smaller than the patch; the largest patch that fits is named.
    """

    def __init__(self, method: PatchMethod, exemplar: Exemplar) -> None:
        self.method, self.exemplar = method, exemplar
        shorter = min(exemplar.shape)
        self.patch_size = method.patch_size or max(1, round(method.randomness * shorter))
        self.pixelwise = self.patch_size == 1
        if self.pixelwise:
            width = max(1, min(4, (shorter - 1) // 2))
        else:
            width = max(4, round(method.zone_share * self.patch_size))
            width = min(width, self.patch_size // 2)
        self.boundary_width = method.boundary_width or width
        self.window_side = 2 * self.boundary_width + 1 if self.pixelwise else self.patch_size
        if not self.pixelwise and self.boundary_width > self.patch_size // 2:
            raise InvalidInputError(
                f"boundary_width is {self.boundary_width}; it must be at most half of the patch, "
                f"{self.patch_size // 2}"
            )
        if self.window_side > shorter:
            raise InvalidInputError(
                f"{exemplar.name} is {exemplar.shape[1]}x{exemplar.shape[0]}, smaller than the "
                f"window of {self.window_side}; the largest that fits is {shorter}"
            )
        self.pixels = exemplar.matching(method.edge_weight)
        mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
        if exemplar.tileable:  # edge handling of section 2.4
            beyond = ((0, self.window_side - 1), (0, self.window_side - 1))
            self.pixels = np.pad(self.pixels, (*beyond, (0, 0)), mode="wrap")
            mask = np.pad(mask, beyond, mode="wrap")
        self.pixels = np.ascontiguousarray(self.pixels)
        self.turned = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        self.mask = mask
        self.pyramid = QuadtreePyramid(self.pixels)
        #: The paper's third level is 4; single pixels need every neighbor.
        self.block_side = 4 if method.search != "pca" else 1 if self.pixelwise else 16
        self._structures: dict[tuple[Any, ...], SearchStructure] = {}
        self._usable: dict[tuple[int, int], NDArray[np.uint8]] = {}
        self._positions: dict[tuple[int, int], NDArray[np.int32]] = {}
        self.usable(self.window_side, self.window_side)
        if exemplar.mask is None:  # a sample with a mask is more likely to fill its own hole
            self._analyse()

    def _analyse(self) -> None:
        """Make the structures that most patches of a new picture will ask."""
        known = np.zeros((self.window_side, self.window_side), bool)
        if self.pixelwise:
            known.ravel()[: known.size // 2] = True
            self.structure(known.copy(), often=True)
            return
        for left, top in ((True, False), (False, True), (True, True)):
            known[:] = False
            known[:, : self.boundary_width] |= left
            known[: self.boundary_width] |= top
            self.structure(known.copy(), often=True)

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
                f"use a smaller patch_size (now {self.patch_size})"
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
        width: int | None = None,
        often: bool = False,
    ) -> SearchStructure:
        """Return the search structure for a window of which this is known, made on first use.

        `often` says that many patches will ask, so that an analysis pays; structures for holes,
        with `frozen` pixels, are each asked once and not kept.
        """
        key = (known.shape, known.tobytes(), width, often)
        if frozen is None and key in self._structures:
            return self._structures[key]
        zone = boundary_zone(
            known,
            width or self.boundary_width,
            frozen=frozen,
            block_side=self.block_side,
            most_blocks=max(16, _MOST_NUMBERS // self.pixels.shape[2]),
            paste=self.method.seam == "none",
            core=(self.boundary_width, self.boundary_width) if self.pixelwise else None,
        )
        structure = SearchStructure(self, zone, self.usable(*known.shape), often)
        if frozen is None:
            self._structures[key] = structure
        return structure

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_structures": {}, "_usable": {}, "_positions": {}}


class SearchStructure:
    """Everything the kernel needs to search for one zone."""

    def __init__(
        self, model: PatchAnalysis, zone: BoundaryZone, usable: NDArray[np.uint8], often: bool
    ) -> None:
        method = model.method
        search = method.search
        self.zone, self.usable = zone, usable
        self.positions = model.positions(*zone.weight.shape)
        self.stride, self.search = 1, SEARCHES[search]
        self.pca = ZonePCA(*_NO_PCA)
        self.tree: KDTree | None = None
        self.projected = "pca" in search
        if zone.area == 0 or method.rule()[0] == float("inf"):  # chaos mosaic needs no search
            self.search = SEARCHES["exhaustive"]
        elif search == "pca":
            while (
                self.stride * 2 <= zone.side and len(self.positions) > _POSITIONS * self.stride**2
            ):
                self.stride *= 2
        self.nodes = model.pyramid.nodes(zone.side, self.stride)
        if self.search in (SEARCHES["exhaustive"], SEARCHES["quadtree"]):
            return
        if search == "pca" and not often:
            self.search = SEARCHES["quadtree"]  # one query does not repay an analysis
            return
        coarse = usable[:: self.stride, :: self.stride]
        take = np.flatnonzero(coarse)
        if len(take) == 0:
            self.search, self.stride = SEARCHES["quadtree"], 1
            self.nodes = model.pyramid.nodes(zone.side, 1)
            return
        windows = model.pyramid.windows(zone.blocks, zone.side, self.stride, *coarse.shape)
        windows = windows if len(take) == coarse.size else windows[:, take]
        y, x = np.divmod(take, coarse.shape[1])
        places = (y * self.stride * usable.shape[1] + x * self.stride).astype(np.int32)
        if "pca" in search:
            self.pca = fit_pca(windows, method.variance)
            self.positions = places
        if "kdtree" in search:
            from weftex.search.kdtree import KDTree

            points = self.pca.features.T if "pca" in search else windows.T
            self.tree = KDTree(points, places, _TREE_ERROR)

    def tree_candidates(
        self, buffer: NDArray[np.uint8], y: int, x: int, wanted: int
    ) -> NDArray[np.int32]:
        """Ask the kd-tree for windows like the one at (y, x) of the buffer."""
        assert self.tree is not None
        query = np.empty(len(self.zone.blocks) * buffer.shape[2], np.int32)
        _kernels.zone_means(buffer, y, x, self.zone.blocks, self.zone.side, query)
        if self.projected:
            means, query = query, np.empty(len(self.pca.basis), np.int16)
            _kernels.coordinates(self.pca.basis, self.pca.offset, self.pca.shift, means, query)
        return self.tree.nearest(query, wanted)
