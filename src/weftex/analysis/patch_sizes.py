"""Patch sizes that suit a sample, or a hole in it."""

from __future__ import annotations

import numpy as np

from weftex.analysis.relief import LOOK, smaller_copy
from weftex.analysis.scale import structure_scale
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Mask
from weftex.raster.boxes import whole_windows

#: Side of a patch of graph cut, of the sample's shorter side.
PATCH_SHARE = 0.45
_THIN = 4  # pixels a side; smaller patches are shares of both sides, not squares
#: A patch is a share of the sample's shorter side, but of no more than so many times the scale of
#: its structure: patches of large samples would copy crowds.
_SCALES = 36
_SMALL = 512  # pixels a side, of which a share is a patch whatever the scale and the output

#: Patch sizes; a hole gets the largest of which it holds a square `_LEAP` times as wide.
_SIZES = (128, 96, 64, 48)
_LEAP = 2.5
HOLE_PATCHES = "from the width of the hole: 48 to 128 px, less in small photos"


def patch_size_of(exemplar: Exemplar, share: float) -> int:
    """Return the side of patches for a sample in pixels: a `share` of its shorter side.

    Of more than 512 pixels, at most 36 times the scale of the structure counts, but at least 512.
    """
    side = min(exemplar.shape)
    if side > _SMALL:
        small, step = smaller_copy(exemplar, LOOK)
        side = min(side, max(_SMALL, round(_SCALES * structure_scale(small).scale * step)))
    return max(1, round(share * side))


def check_boundary(side: int, boundary: int) -> None:
    """Refuse a boundary that takes half of a patch."""
    if boundary > (side - 1) // 2:
        raise InvalidInputError(
            f"boundary_width is {boundary}; it must be less than half of the patch, at most "
            f"{(side - 1) // 2}"
        )


def patch_shape_for(exemplar: Exemplar, given: int | None) -> tuple[int, int]:
    """A square of the given side, or of the default one made smaller until it fits.

    Squares of one pixel would take as many cuts as the canvas has pixels, so patches of a thin
    sample are a share of either side.
    """
    height, width = exemplar.shape
    if given is not None:
        if given > min(height, width):
            raise InvalidInputError(
                f"patch_size is {given}; {exemplar.name} is {width}x{height}, so it may be "
                f"at most {min(height, width)}"
            )
        if not _fits(exemplar, given, given):
            raise InvalidInputError(
                f"patch_size is {given}; no patch that large lies on usable pixels of "
                f"{exemplar.name}, make it smaller"
            )
        return given, given
    side = patch_size_of(exemplar, PATCH_SHARE)
    while not _fits(exemplar, side, side):
        side = side * 3 // 4
    if side < _THIN:
        rows, columns = (max(1, round(PATCH_SHARE * n)) for n in exemplar.shape)
        if _fits(exemplar, rows, columns):
            return rows, columns
    return side, side


def _fits(exemplar: Exemplar, rows: int, columns: int) -> bool:
    usable = exemplar.usable
    if exemplar.tileable:
        usable = np.pad(usable, ((0, rows - 1), (0, columns - 1)), mode="wrap")
    return bool(whole_windows(usable, (0, rows - 1, 0, columns - 1)).any())


def patch_size_on(canvas: Canvas, share: float) -> int:
    """Return the largest side of patches for an output in pixels: a `share` of its shorter side.

    The side counts as at least 512 pixels. Larger patches would make it out of a few whole pieces.
    """
    return round(share * max(_SMALL, min(canvas.shape)))


def patch_size_for(hole: Mask, usable: Mask, least: int) -> int:
    """Return the side of patches for a hole (H, W) in pixels, at least `least`.

    It is 1 only where no 2x2 pixels of the sample are `usable`.
    """
    fits = (s for s in _SIZES if s == _SIZES[-1] or _windows(hole, round(_LEAP * s)))
    size: int = max(min(next(fits), min(*hole.shape, *usable.shape) // 5), 2, least)
    enough = np.count_nonzero(usable) // 4
    while size > least:
        # With few windows to choose from none of them matches.
        if _windows(usable, size) > (enough if size > 8 else 0):
            break
        size = max(size * 3 // 4, least)
    return size


def _windows(mask: Mask, side: int) -> int:
    """Count the square windows that are True all over."""
    return int(np.count_nonzero(whole_windows(mask, (0, side - 1, 0, side - 1))))
