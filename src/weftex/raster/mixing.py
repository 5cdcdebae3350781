"""How the values of two patches are mixed where both show, by what a picture stores."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weftex.raster.vectors import middle_of, vectors_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SEEN = 4096  # pixels that say whether a picture stores vectors
_OFF = 0.25  # that the lengths of a normal map's are off 1
_MOST = 0.8  # of its pixels, at least


class Kind(IntEnum):
    """What becomes of two pixels of which one has a share."""

    MEAN = 0
    """Their mean."""
    ALPHA = 1
    """Their mean, in which the last channel, straight alpha, says how much each counts."""
    VECTORS = 2
    """The direction between two, and the length: the first three channels are a normal."""
    LABELS = 3
    """The one with the larger share: there is nothing between two labels."""


class Mixing(NamedTuple):
    """How to mix the pixels of a picture."""

    kind: Kind
    middle: float = 0.0
    """What stands for 0 in vectors that are stored in floats."""


def mixing_of(pixels: NDArray[Any], shows: str, alpha: bool) -> Mixing:
    """How to mix the pixels (H, W[, C]) of a picture whose kind is `shows`.

    A normal map is mixed as vectors only if it has three channels and mostly unit vectors.
    """
    if shows == "labels":
        return Mixing(Kind.LABELS)
    if shows == "normal" and _is_of_units(pixels):
        return Mixing(Kind.VECTORS, middle_of(pixels))
    return Mixing(Kind.ALPHA if alpha else Kind.MEAN)


def _is_of_units(pixels: NDArray[Any]) -> bool:
    if pixels.ndim < 3 or pixels.shape[2] < 3:
        return False
    some = pixels.reshape(-1, pixels.shape[2])[
        :: max(1, pixels.shape[0] * pixels.shape[1] // _SEEN)
    ]
    with np.errstate(over="ignore"):  # of numbers that floats just hold
        lengths = np.linalg.norm(vectors_of(some[:, :3], middle_of(pixels)), axis=1)
    return bool(np.mean(abs(lengths - 1) < _OFF) > _MOST)
