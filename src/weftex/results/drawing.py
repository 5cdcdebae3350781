"""Pictures of how a result was put together, from the source of each of its pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.arrays import Bytes
from weftex.raster.levels import tamed

__all__ = ["DRAWINGS"]

#: What `Synthesis.draw` draws.
DRAWINGS = ("sources", "seams", "patches")


def draw_sources(source: NDArray[np.int32], sample_shape: tuple[int, int]) -> NDArray[np.uint8]:
    """False colors by position in the sample: red to the right, green downwards."""
    scale = 255 / np.maximum(np.array(sample_shape) - 1, 1)
    picture = np.full((*source.shape[:2], 3), 96, np.uint8)
    picture[..., 1::-1] = np.rint(np.maximum(source, 0) * scale)
    picture[source[..., 0] < 0] = 0
    return picture


def draw_seams(gray: Bytes, source: NDArray[np.int32], sample_shape: tuple[int, int]) -> Bytes:
    """A gray picture, and in red the pixels whose source does not continue the one before."""
    shift = _shifts(source, sample_shape)
    seam = np.zeros(source.shape[:2], bool)
    seam[1:] |= (shift[1:] != shift[:-1]).any(axis=-1)
    seam[:, 1:] |= (shift[:, 1:] != shift[:, :-1]).any(axis=-1)
    picture = np.repeat(gray[..., None], 3, axis=2)
    picture[seam] = (255, 0, 0)
    return picture


def draw_pieces(source: NDArray[np.int32], sample_shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Picture (H, W, 3) with a color per copied piece; known pixels from elsewhere are black."""
    name = _shifts(source, sample_shape) @ (sample_shape[1], 1)
    mixed = name.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)  # Fibonacci hashing
    levels = [64 + (mixed >> np.uint64(k)) % np.uint64(192) for k in (40, 48, 56)]
    picture = np.stack(levels, axis=2)
    picture[source[..., 0] < 0] = 0
    return picture.astype(np.uint8)


def _shifts(source: NDArray[np.int32], sample_shape: tuple[int, int]) -> NDArray[np.int64]:
    """How far the source of each pixel is from it, (H, W, 2); equal within a copied piece."""
    y, x = np.indices(source.shape[:2])
    return (source - np.stack([y, x], axis=-1)) % sample_shape


def gray_of(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    """Mean of the color channels as bytes; other depths are stretched."""
    channels = pixels.reshape(*pixels.shape[:2], -1)
    if channels.shape[2] in (2, 4):
        channels = channels[..., :-1]
    gray = (channels if channels.dtype.kind == "u" else tamed(channels)[0]).mean(axis=2)
    if pixels.dtype != np.uint8:
        low, high = float(gray.min()), float(gray.max())
        gray = (gray - low) / ((high - low) or 1) * 255
    result: NDArray[np.uint8] = np.rint(gray).astype(np.uint8)
    return result
