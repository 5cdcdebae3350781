"""The analysis of the sample that patch methods share (section 3 of Liang et al., 2001)."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.methods.patches.settings import PatchSettings
from weftex.raster.boxes import box_sums
from weftex.raster.levels import tones_of
from weftex.search.boundary_zone import boundary_zone
from weftex.search.quadtree_pyramid import QuadtreePyramid
from weftex.search.zone_search import ZoneSearch

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MOST_NUMBERS = 288  # of the low resolution that describe one zone


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
    ahead : bool
        Most outputs will have patches of this size, so that structures for them are made at once.

    Raises
    ------
    InvalidInputError
        If no window lies in the usable part of the sample.
    """

    def __init__(self, settings: PatchSettings, exemplar: Exemplar, *, ahead: bool = True) -> None:
        self.settings, self.exemplar = settings, exemplar
        self.pixels = exemplar.matching(settings.edge_weight)
        self.mask = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
        side = settings.window_side
        if settings.tone_weight > 0:
            weight, wraps = settings.tone_weight, exemplar.tileable
            tones = tones_of(self.pixels, self.mask, side // 4, weight, wraps=wraps)
            self.pixels = np.concatenate([self.pixels, tones], axis=2)
        if exemplar.tileable:  # edge handling of section 2.4
            beyond = ((0, side - 1), (0, side - 1))
            self.pixels = np.pad(self.pixels, (*beyond, (0, 0)), mode="wrap")
            self.mask = np.pad(self.mask, beyond, mode="wrap")
        self.pixels = np.ascontiguousarray(self.pixels)
        self.turned = np.ascontiguousarray(self.pixels.transpose(1, 0, 2))
        self.pyramid = QuadtreePyramid(self.pixels)
        #: The paper's third level is 4; single pixels need every neighbor.
        self.block_side = 4 if settings.search != "pca" else 1 if settings.pixelwise else 16
        self._structures: dict[tuple[Any, ...], ZoneSearch] = {}
        self._windows: dict[tuple[int, int], tuple[NDArray[np.uint8], NDArray[np.int32]]] = {}
        self._others: dict[PatchSettings, PatchAnalysis] = {}
        self.windows(side, side)
        # A sample with a mask is more likely to fill its own hole.
        if ahead and exemplar.mask is None:
            self._analyze()

    def settled(self, settings: PatchSettings) -> PatchAnalysis:
        """Return the analysis for these settings: this one, or one that is made on first use."""
        if settings == self.settings:
            return self
        if settings not in self._others:
            if self.exemplar.tileable:  # the padding is as wide as patches
                other = PatchAnalysis(settings, self.exemplar)
            else:
                other = copy(self)
                other.settings, other._structures, other._windows = settings, {}, {}
            self._others[settings] = other
        return self._others[settings]

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

    def windows(self, rows: int, columns: int) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
        """Mark and number the upper left corners of windows in the usable part of the sample."""
        if (rows, columns) not in self._windows:
            height, width = self.exemplar.shape
            if self.mask.all():
                sides = (
                    max(0, n - k + 1) for n, k in zip(self.mask.shape, (rows, columns), strict=True)
                )
                usable = np.ones((*sides,), np.uint8)
            else:
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
        settings = self.settings
        if settings.pixelwise and widest >= 3:
            now = settings.boundary_width
            return f"boundary_width may be at most {(widest - 1) // 2} (now {now})"
        if widest >= 2 and not settings.pixelwise:
            return f"patch_size may be at most {widest} (now {settings.patch_size})"
        return f"it has room for {widest}x{widest}; a patch takes 2x2, a pixel and its zone 3x3"

    def structure(
        self,
        known: NDArray[np.bool_],
        frozen: NDArray[np.bool_] | None = None,
        *,
        width: int,
        often: bool = False,
    ) -> ZoneSearch:
        """Return the search structure for one configuration, made on first use.

        Parameters
        ----------
        known : bool array (rows, columns)
            Pixels of the window that are on the canvas already.
        frozen : bool array (rows, columns), optional
            Known pixels which must stay: around a hole, where structures are each asked once and
            not kept, or a part of those that lie along the window's sides.
        width : int
            Boundary width w_E.
        often : bool
            Many patches will ask, so that an analysis pays.
        """
        of_hole = frozen is not None and not often
        stays = b"" if frozen is None else frozen.tobytes()
        key = (known.shape, known.tobytes(), width, often, stays)
        if not of_hole and key in self._structures:
            return self._structures[key]
        settings = self.settings
        zone = boundary_zone(
            known,
            width,
            frozen=frozen,
            outlines=of_hole,
            block_side=self.block_side,
            most_blocks=max(16, _MOST_NUMBERS // self.pixels.shape[2]),
            paste=settings.blend == "none",
            core=(settings.boundary_width,) * 2 if settings.pixelwise else None,
        )
        structure = ZoneSearch(
            zone,
            self.pyramid,
            *self.windows(*zone.weight.shape),
            search="exhaustive" if settings.anything else settings.search,
            candidates=settings.candidates,
            variance=settings.variance,
            often=often,
        )
        if not of_hole:
            self._structures[key] = structure
        return structure

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_structures": {}, "_windows": {}, "_others": {}}


class Zones:
    """The boundary zones of one output, numbered in the order in which patches meet them.

    Parameters
    ----------
    analysis : PatchAnalysis
        Of the sample.
    boundary_width : int
        Width w_E on this canvas.
    """

    def __init__(self, analysis: PatchAnalysis, boundary_width: int) -> None:
        self._analysis, self._width = analysis, boundary_width
        self._numbers: dict[tuple[bytes, bytes], int] = {}
        #: The sample's windows, arranged to be searched by each zone.
        self.searches: list[ZoneSearch] = []
        #: (1, rows, columns): the weights that a patch is laid with while others are still chosen.
        self.laid_with: list[NDArray[np.uint16]] = []

    def number(
        self,
        known: NDArray[np.bool_],
        frozen: NDArray[np.bool_] | None = None,
        often: bool = False,
    ) -> int:
        """Return the number of the zone of a window, see `PatchAnalysis.structure`."""
        key = known.tobytes(), b"" if frozen is None else frozen.tobytes()
        if key not in self._numbers:
            search = self._analysis.structure(known, frozen, width=self._width, often=often)
            weight = search.zone.weight
            if self._analysis.settings.blend == "feather-at-end":
                weight = np.where(weight > 0, 256, 0).astype(np.uint16)
            self._numbers[key] = len(self.searches)
            self.searches.append(search)
            self.laid_with.append(weight[None])
        return self._numbers[key]
