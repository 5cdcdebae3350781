"""Blend the values of two patches: the rule for each kind of picture.

Normal maps store vectors, whose parts from -1 to 1 are numbers around a middle.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Floats

_STRIP = 256  # rows that are halved at once
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

    def halved(self, pixels: NDArray[Any]) -> NDArray[Any]:
        """Return pixels (H, W[, C]) at half their size, rounded up; an odd border is repeated.

        Examples
        --------
        >>> Mixing(Kind.MEAN).halved(np.array([[1, 2, 9], [4, 5, 9]], np.uint8)).tolist()
        [[3, 9]]
        """
        height, width = pixels.shape[:2]
        out = np.empty((-(-height // 2), -(-width // 2), *pixels.shape[2:]), pixels.dtype)
        for top in range(0, len(out), _STRIP):
            strip = pixels[2 * top : 2 * (top + _STRIP)]
            odd = [(0, side % 2) for side in strip.shape[:2]] + [(0, 0)] * (pixels.ndim - 2)
            strip = np.pad(strip, odd, "edge") if np.any(odd) else strip
            parts = [strip[y::2, x::2] for y in (0, 1) for x in (0, 1)]
            out[top : top + _STRIP] = self._means(parts)
        return out

    def _means(self, parts: list[NDArray[Any]]) -> NDArray[Any]:
        """Mix four pictures of the same size in equal shares."""
        dtype = parts[0].dtype
        if self.kind is Kind.LABELS:
            return parts[0]
        if self.kind is Kind.MEAN and dtype.kind == "u":
            total = sum((part.astype(np.uint32) for part in parts), np.uint32(2))
            return np.asarray(total >> 2, dtype)
        four = np.stack(parts).astype(np.float64)
        mean = four.mean(axis=0)
        if self.kind is Kind.ALPHA:
            cover = four[..., -1:]
            total = cover.sum(axis=0)
            weights = np.where(total > 0, cover, 1) / np.where(total > 0, total, 4)
            mean[..., :-1] = (four[..., :-1] * weights).sum(axis=0)
        if self.kind is Kind.VECTORS:
            middle = np.iinfo(dtype).max / 2 if dtype.kind == "u" else self.middle
            vectors = mean[..., :3] - middle
            length = np.linalg.norm(vectors, axis=-1, keepdims=True)
            mean[..., :3] = middle + vectors * np.where(length > 0, (middle or 1) / length, 1)
        if dtype.kind == "f":
            return np.asarray(mean, dtype)
        return np.asarray(np.clip(np.rint(mean), 0, np.iinfo(dtype).max), dtype)


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
    apart = max(1, pixels.shape[0] * pixels.shape[1] // _SEEN)
    some = pixels.reshape(-1, pixels.shape[2])[::apart]
    with np.errstate(over="ignore"):  # of numbers that floats just hold
        lengths = np.linalg.norm(vectors_of(some[:, :3], middle_of(pixels)), axis=1)
    return bool(np.mean(abs(lengths - 1) < _OFF) > _MOST)


def middle_of(pixels: NDArray[Any]) -> float:
    """Return what stands for 0 in vectors stored in floats: 0.5, unless some are below 0."""
    return 0.5 if pixels.dtype.kind == "f" and pixels.min() >= 0 else 0.0


def opposite(values: NDArray[Any], middle: float) -> NDArray[Any]:
    """Return one part of vectors, in reverse; `middle` is that of floats."""
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
