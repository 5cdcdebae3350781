"""Vectors that pictures store: normals, whose parts from -1 to 1 are numbers around a middle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def middle_of(pixels: NDArray[Any]) -> float:
    """Return what stands for 0 in vectors stored in floats: 0.5, unless some are below 0."""
    return 0.5 if pixels.dtype.kind == "f" and pixels.min() >= 0 else 0.0


def opposite(values: NDArray[Any], middle: float) -> NDArray[Any]:
    """Return one part of vectors, the other way around; `middle` is that of floats."""
    if values.dtype.kind == "u":
        return np.iinfo(values.dtype).max - values
    return 2 * middle - values


def vectors_of(pixels: NDArray[Any], middle: float) -> Floats:
    """Vector components from -1 to 1 of stored numbers."""
    if pixels.dtype.kind == "u":
        return pixels / (np.iinfo(pixels.dtype).max / 2) - 1
    return (pixels.astype(np.float64) - middle) / (middle or 1)


def stored(vectors: Floats, dtype: np.dtype[Any], middle: float) -> NDArray[Any]:
    """Stored numbers of vector components from -1 to 1; integers are rounded and clipped."""
    if dtype.kind == "u":
        top = np.iinfo(dtype).max
        return np.clip(np.rint((vectors + 1) * (top / 2)), 0, top).astype(dtype)
    return (vectors * (middle or 1) + middle).astype(dtype)
