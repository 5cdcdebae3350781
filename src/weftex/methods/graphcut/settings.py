"""The parameters of graph-cut textures, settled for one sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from weftex.analysis.canvas_lattice import check_lattice
from weftex.errors import InvalidInputError
from weftex.methods.patches.sizes import patch_size_of, patch_size_on
from weftex.search.windows import windows_of
from weftex.turns import copies_in

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas
    from weftex.exemplar import Exemplar
    from weftex.search.windows import Windows

_PATCH_SHARE = 0.45  # side of a patch, of the sample's shorter side
_HALVINGS = 4  # at most, of the copies that matches and cuts begin on
_LEAST = 24  # pixels a side that a patch has on those
_THIN = 4  # pixels a side; a sample has thin patches rather than smaller squares


@dataclass(frozen=True)
class Settings:
    """A sample prepared for graph-cut textures, with every parameter settled."""

    exemplar: Exemplar
    windows: Windows  # the sample's single pixels
    placement: str  # "subpatch", "entire" or "random"
    patch_shape: tuple[
        int, int
    ]  # height and width in pixels, see _patch_shape; or the entire sample
    boundary_width: int  # reach of a patch over the pixels before it; 0 for the entire sample
    tolerance: float  # k in the chances of a place
    candidates: int  # places that are cut, to keep the one with the cheapest seam
    by_gradients: bool  # the cost of a seam is divided by the gradients across it
    refinements: float  # patches over the worst seams, for each that covered the canvas
    variety: float  # the cost of showing a place again
    tone_reach: float  # pixels in which steps of tone across seams are spread
    lattice: tuple[float, ...]  # x1, y1, x2, y2, of which entire patches are shifted by multiples
    halvings: int  # at most, of the copies that matches and cuts begin on
    least: int  # pixels a side that a patch has on those
    size_given: bool  # patch_shape was chosen by the caller
    boundary_given: bool  # likewise

    @property
    def whole(self) -> bool:
        """Whether all pixels are usable that patches show."""
        usable = self.windows.usable
        if self.placement == "entire" and self.exemplar.turn is not None:
            parts = copies_in(self.exemplar)  # there is a line between any two
            return all(usable[y : y + h, x : x + w].all() for y, x, h, w in parts)
        return bool(usable.all())

    def on(self, canvas: Canvas) -> Settings:
        """Settle for one output, of which patches take no larger share than of the sample."""
        if self.placement != "subpatch" or self.size_given:
            return self
        most = patch_size_on(canvas, _PATCH_SHARE)
        if self.boundary_given:
            most = max(most, 2 * self.boundary_width + 1)
        if max(self.patch_shape) <= most:
            return self
        height, width = (min(side, most) for side in self.patch_shape)
        boundary = self.boundary_width if self.boundary_given else max(height, width) // 3
        return replace(self, patch_shape=(height, width), boundary_width=boundary)

    def reduction_of(self, size: tuple[int, int], places: NDArray[np.uint8]) -> int:
        """How many times smaller the copies are that a patch begins on, a power of 2.

        Parameters
        ----------
        size : (int, int)
            Height and width of the patch, in pixels.
        places : uint8 array (H, W)
            1 where it may lie in the sample; the copies have some of these.
        """
        reduction = 1
        while (
            2 * reduction <= 1 << self.halvings
            and 2 * reduction * self.least <= min(size)
            and places[:: 2 * reduction, :: 2 * reduction].any()
        ):
            reduction *= 2
        return reduction

    def sizes(self) -> dict[str, int]:
        """`patch_size` and `boundary_width` as settled; patches of a thin sample are no squares."""
        rows, columns = self.patch_shape
        size = {"patch_size": rows} if rows == columns else {}
        return size | {"boundary_width": self.boundary_width}


def check_boundary(side: int, boundary: int) -> None:
    """Refuse a boundary that takes half of a patch."""
    if boundary > (side - 1) // 2:
        raise InvalidInputError(
            f"boundary_width is {boundary}; it must be less than half of the patch, at most "
            f"{(side - 1) // 2}"
        )


def settle(
    exemplar: Exemplar,
    placement: str,
    patch_size: int | None,
    boundary_width: int | None,
    tolerance: float | None,
    candidates: int | None,
    seam_cost: str,
    refinements: float | None,
    variety: float,
    halvings: int | None,
    tone_reach: float,
    lattice: tuple[float, ...] | None,
) -> Settings:
    """Settle the parameters of `GraphCut` for a sample.

    Raises
    ------
    InvalidInputError
        If a patch of the given size does not fit on usable pixels, or the boundary takes more
        than half of a patch.
    """
    windows = windows_of(exemplar, (0, 0, 0, 0))
    if lattice is not None:
        check_lattice(lattice, exemplar)
    if tolerance is None:
        tolerance = 0.0 if placement == "entire" else 0.003
    if candidates is None:
        candidates = 24 if placement == "entire" else 4
    if refinements is None:
        refinements = 1.0 if placement == "random" else 0.0
    shape, boundary = exemplar.shape, 0
    if placement == "subpatch":
        shape = _patch_shape(exemplar, patch_size)
        side = max(shape)
        boundary = side // 3 if boundary_width is None else boundary_width
        check_boundary(side, boundary)
    return Settings(
        exemplar,
        windows,
        placement,
        shape,
        boundary,
        tolerance=tolerance,
        candidates=candidates,
        by_gradients=seam_cost == "gradient",
        refinements=refinements,
        variety=variety,
        tone_reach=tone_reach,
        lattice=lattice or (),
        halvings=_HALVINGS if halvings is None else halvings,
        least=_LEAST if halvings is None else 1,
        size_given=patch_size is not None,
        boundary_given=boundary_width is not None,
    )


def _patch_shape(exemplar: Exemplar, given: int | None) -> tuple[int, int]:
    """A square; of a thin sample, which has squares of a few pixels only, a share of either side.

    Squares of one pixel would take as many cuts as the canvas has pixels.
    """
    side = _patch_size(exemplar, given)
    if given is None and side < _THIN:
        rows, columns = (max(1, round(_PATCH_SHARE * n)) for n in exemplar.shape)
        if _has_room(exemplar, rows, columns):
            return rows, columns
    return side, side


def _patch_size(exemplar: Exemplar, given: int | None) -> int:
    """Return the given side, or the default one, made smaller until it fits."""
    height, width = exemplar.shape
    if given is not None and given > min(height, width):
        raise InvalidInputError(
            f"patch_size is {given}; {exemplar.name} is {width}x{height}, which has room for "
            f"{min(height, width)}"
        )
    side = given or patch_size_of(exemplar, _PATCH_SHARE)
    while not _has_room(exemplar, side, side):
        if given is not None:
            raise InvalidInputError(
                f"patch_size is {given}; no patch that large lies on usable pixels of "
                f"{exemplar.name}, make it smaller"
            )
        side = side * 3 // 4
    return side


def _has_room(exemplar: Exemplar, rows: int, columns: int) -> bool:
    try:
        windows_of(exemplar, (0, rows - 1, 0, columns - 1))
    except InvalidInputError:
        return False
    return True
