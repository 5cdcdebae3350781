"""Pictures of how a result was put together, from the source of each of its pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.raster.levels import tamed

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar

    #: Row and column in the sample of the pixels of some rows: (rows, W, 2), -1 for no source.
    SourceOf = Callable[[slice], NDArray[np.int64]]

__all__ = ["DRAWINGS"]

#: What `Synthesis.draw` draws.
DRAWINGS = ("sources", "seams", "patches", "uncertainty")
_REACH = 2  # pixels around one whose surroundings are compared
_BAND = 256  # rows


def draw_sources(source: NDArray[np.int32], sample_shape: tuple[int, int]) -> NDArray[np.uint8]:
    """False colors by position in the sample: red to the right, green downwards."""
    scale = 255 / np.maximum(np.array(sample_shape) - 1, 1)
    picture = np.full((*source.shape[:2], 3), 96, np.uint8)
    picture[..., 1::-1] = np.rint(np.maximum(source, 0) * scale)
    picture[source[..., 0] < 0] = 0
    return picture


def draw_seams(
    gray: NDArray[np.uint8], source: NDArray[np.int32], sample_shape: tuple[int, int]
) -> NDArray[np.uint8]:
    """A gray picture, and in red the pixels whose source does not continue the one before."""
    y, x = np.indices(source.shape[:2])
    shift = (source - np.stack([y, x], axis=-1)) % sample_shape
    seam = np.zeros(source.shape[:2], bool)
    seam[1:] |= (shift[1:] != shift[:-1]).any(axis=-1)
    seam[:, 1:] |= (shift[:, 1:] != shift[:, :-1]).any(axis=-1)
    picture = np.repeat(gray[..., None], 3, axis=2)
    picture[seam] = (255, 0, 0)
    return picture


def draw_pieces(
    source_of: SourceOf, shape: tuple[int, int], sample_shape: tuple[int, int]
) -> NDArray[np.uint8]:
    """Picture (H, W, 3) with a color per copied piece; known pixels from elsewhere are black."""
    picture = np.zeros((*shape, 3), np.uint8)
    for rows in bands(shape[0]):
        source = source_of(rows)
        y, x = np.indices(source.shape[:2])
        shift = (source - np.stack([y + rows.start, x], axis=-1)) % sample_shape
        name = shift[..., 0] * sample_shape[1] + shift[..., 1]
        mixed = name.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)  # Fibonacci hashing
        for k in range(3):
            picture[rows][..., k] = 64 + (mixed >> np.uint64(40 + 8 * k)) % np.uint64(192)
        picture[rows][source[..., 0] < 0] = 0
    return picture


def uncertainty_of(
    image: NDArray[Any], source_of: SourceOf, exemplar: Exemplar, wrap: tuple[bool, bool]
) -> NDArray[np.float64]:
    """Mismatch (H, W) between the surroundings of each pixel and those of its source.

    The mean squared difference over 5 x 5 pixels, divided by that of two random sample pixels: 0
    inside a copied piece, about 1 for a random source, 0 for known pixels from elsewhere.
    """
    features = exemplar.matching()
    made = exemplar.as_matching(image)
    depth = min(made.shape[2], features.shape[2])  # maps that only the sample has do not count
    made = made[..., :depth]
    random = 2 * float(features[..., :depth].reshape(-1, depth).var(axis=0).mean())
    found = np.zeros(image.shape[:2])
    height, width = exemplar.shape
    for rows in bands(image.shape[0]):
        source = source_of(rows)
        total, count = np.zeros(source.shape[:2]), np.zeros(source.shape[:2])
        for dy in range(-_REACH, _REACH + 1):
            for dx in range(-_REACH, _REACH + 1):
                y, x = np.arange(rows.start, rows.stop) + dy, np.arange(image.shape[1]) + dx
                there = np.ones(source.shape[:2], bool)
                if not wrap[0]:
                    there &= ((y >= 0) & (y < image.shape[0]))[:, None]
                if not wrap[1]:
                    there &= ((x >= 0) & (x < image.shape[1]))[None]
                v, u = source[..., 0] + dy, source[..., 1] + dx
                if not exemplar.tileable:
                    there &= (v >= 0) & (v < height) & (u >= 0) & (u < width)
                around = made[y[:, None] % image.shape[0], x[None] % image.shape[1]]
                apart = around.astype(np.int32) - features[v % height, u % width, :depth]
                total += there * (apart**2).mean(axis=2)
                count += there
        found[rows] = np.where(source[..., 0] < 0, 0, total / np.maximum(count, 1))
    return found / random if random > 0 else found


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


def bands(height: int) -> list[slice]:
    """Return slices of rows that are looked at together."""
    return [slice(top, min(top + _BAND, height)) for top in range(0, height, _BAND)]
