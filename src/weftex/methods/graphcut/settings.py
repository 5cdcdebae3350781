"""The parameters of graph-cut textures, settled for one sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError
from weftex.methods.patches.sizes import patch_size_of
from weftex.search.windows import windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.search.windows import Windows

_PATCH_SHARE = 0.45  # side of a patch, of the sample's shorter side


@dataclass(frozen=True)
class Settings:
    """A sample prepared for graph-cut textures, with every parameter settled."""

    exemplar: Exemplar
    windows: Windows  # the sample's single pixels
    placement: str  # "subpatch", "entire" or "random"
    patch_shape: tuple[int, int]  # height and width in pixels: a square, or the entire sample
    boundary_width: int  # reach of a square over the pixels before it; 0 for the entire sample
    spread: float  # k * sigma**2 in the chances of a place; sigma**2 is the sample's variance
    candidates: int  # places that are cut, to keep the one with the cheapest seam
    by_gradients: bool  # the cost of a seam is divided by the gradients across it
    refinements: float  # patches over the worst seams, for each that covered the canvas
    variety: float  # the cost of showing a place again nearby


def settle(
    exemplar: Exemplar,
    placement: str,
    patch_size: int | None,
    boundary_width: int | None,
    tolerance: float,
    candidates: int,
    seam_cost: str,
    refinements: float,
    variety: float,
) -> Settings:
    """Settle the parameters of `GraphCut` for a sample.

    Raises
    ------
    InvalidInputError
        If a patch of the given size does not fit on usable pixels, or the boundary takes more
        than half of a patch.
    """
    windows = windows_of(exemplar, (0, 0, 0, 0))
    shape, boundary = exemplar.shape, 0
    if placement == "subpatch":
        side = _patch_size(exemplar, patch_size)
        boundary = side // 3 if boundary_width is None else boundary_width
        if boundary > side // 2:
            raise InvalidInputError(
                f"boundary_width is {boundary}; it must be at most half of the patch, {side // 2}"
            )
        shape = (side, side)
    return Settings(
        exemplar,
        windows,
        placement,
        shape,
        boundary,
        spread=tolerance * variance(windows.pixels[windows.usable != 0]),
        candidates=candidates,
        by_gradients=seam_cost == "gradient",
        refinements=refinements,
        variety=variety,
    )


def _patch_size(exemplar: Exemplar, given: int | None) -> int:
    """Return the given side, or the default one, made smaller until it fits."""
    height, width = exemplar.shape
    if given is not None and given > min(height, width):
        raise InvalidInputError(
            f"patch_size is {given}; {exemplar.name} is {width}x{height}, which has room for "
            f"{min(height, width)}"
        )
    side = given or patch_size_of(exemplar, _PATCH_SHARE)
    while not _has_room(exemplar, side):
        if given is not None:
            raise InvalidInputError(
                f"patch_size is {given}; no patch that large lies on usable pixels of "
                f"{exemplar.name}, make it smaller"
            )
        side = side * 3 // 4
    return side


def _has_room(exemplar: Exemplar, side: int) -> bool:
    try:
        windows_of(exemplar, (0, side - 1, 0, side - 1))
    except InvalidInputError:
        return False
    return True


def variance(pixels: NDArray[np.uint8]) -> float:
    """Variance of pixels (N, K), all channels together, from exact sums."""
    total = [int(k) for k in pixels.sum(axis=0, dtype=np.int64)]
    squares = sum(int(np.square(k, dtype=np.int64).sum()) for k in pixels.T)
    count = len(pixels)
    return (count * squares - sum(t * t for t in total)) / (count * count)
