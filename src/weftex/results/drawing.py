"""Pictures of how a result was put together, from the result alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.results.synthesis import Synthesis

_REACH = 2  # pixels around one whose surroundings are compared
_BAND = 256  # rows that are looked at together


def draw_pieces(result: Synthesis) -> NDArray[np.uint8]:
    """A colour for each piece that was copied as a whole: all pixels moved by one vector.

    Parameters
    ----------
    result : Synthesis
        Known pixels that are not in the sample are black.

    Returns
    -------
    uint8 array (H, W, 3)
    """
    picture = np.zeros((*result.shape, 3), np.uint8)
    for top in range(0, result.shape[0], _BAND):
        rows = slice(top, min(top + _BAND, result.shape[0]))
        source = _source(result, rows)
        y, x = np.indices(source.shape[:2])
        shift = (source - np.stack([y + top, x], axis=-1)) % result.sample_shape
        name = shift[..., 0] * result.sample_shape[1] + shift[..., 1]
        mixed = name.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)  # Fibonacci hashing
        for k in range(3):
            picture[rows][..., k] = 64 + (mixed >> np.uint64(40 + 8 * k)) % np.uint64(192)
        picture[rows][source[..., 0] < 0] = 0
    return picture


def uncertainty(result: Synthesis) -> NDArray[np.float64]:
    """How badly the surroundings of each pixel match those of the place that it comes from.

    Parameters
    ----------
    result : Synthesis
        With its sample.

    Returns
    -------
    float64 array (H, W)
        Mean squared difference of the 5 x 5 pixels around, over that of two pixels of the sample
        at random: 0 inside of what was copied as a whole, 1 where a place drawn at random would
        have done as well. 0 for known pixels that are not in the sample.

    Raises
    ------
    InvalidInputError
        If the result was loaded without its sample.
    """
    exemplar = result.exemplar
    if exemplar is None:
        raise InvalidInputError("this result was loaded without its sample, so nothing is compared")
    levels = exemplar.matching()
    made = exemplar.as_matching(result.image)
    made = made if made.shape[2] == levels.shape[2] else made[..., : levels.shape[2]]
    depth = made.shape[2]  # maps that only the sample has do not count
    random = 2 * float(levels[..., :depth].reshape(-1, depth).var(axis=0).mean())
    found = np.zeros(result.shape)
    height, width = exemplar.shape
    for top in range(0, result.shape[0], _BAND):
        rows = slice(top, min(top + _BAND, result.shape[0]))
        source = _source(result, rows)
        total, count = np.zeros(source.shape[:2]), np.zeros(source.shape[:2])
        for dy in range(-_REACH, _REACH + 1):
            for dx in range(-_REACH, _REACH + 1):
                y, x = np.arange(rows.start, rows.stop) + dy, np.arange(result.shape[1]) + dx
                there = np.ones(source.shape[:2], bool)
                if not result.canvas.wrap[0]:
                    there &= ((y >= 0) & (y < result.shape[0]))[:, None]
                if not result.canvas.wrap[1]:
                    there &= ((x >= 0) & (x < result.shape[1]))[None]
                v, u = source[..., 0] + dy, source[..., 1] + dx
                if not exemplar.tileable:
                    there &= (v >= 0) & (v < height) & (u >= 0) & (u < width)
                around = made[y[:, None] % result.shape[0], x[None] % result.shape[1]]
                apart = around.astype(np.int32) - levels[v % height, u % width, :depth]
                total += there * (apart**2).mean(axis=2)
                count += there
        found[rows] = np.where(source[..., 0] < 0, 0, total / np.maximum(count, 1))
    return found / random if random > 0 else found


def draw_uncertainty(result: Synthesis) -> NDArray[np.uint8]:
    """`uncertainty` as a grey picture, its root so that faint places show; 1 and more is white."""
    strength = np.sqrt(np.clip(uncertainty(result), 0, 1))
    grey = np.rint(255 * strength).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def _source(result: Synthesis, rows: slice) -> NDArray[np.int64]:
    window = (rows.start, 0, rows.stop - rows.start, result.shape[1])
    source: NDArray[np.int64] = result.layers(window)[0][:, :, 0].astype(np.int64)
    return source
