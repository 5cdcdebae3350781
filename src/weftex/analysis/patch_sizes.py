"""Patch sizes that suit a sample, or a hole in it."""

from __future__ import annotations

import numpy as np

from weftex.analysis.relief import LOOK, smaller_copy
from weftex.analysis.scale import structure_scale
from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.raster.arrays import Mask
from weftex.raster.boxes import whole_windows

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
        scale = structure_scale(small).scale * step
        side = min(side, max(_SMALL, round(_SCALES * scale)))
    return max(1, round(share * side))


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
