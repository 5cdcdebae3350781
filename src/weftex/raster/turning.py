"""Pictures of copies of a picture, mirrored or turned; see `weftex.prepare.turned`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.mixing import Kind, mixing_of, opposite
from weftex.roles import COLOR, Role

#: How often a copy is turned to the left by a quarter, after it was mirrored or not.
Copy = tuple[int, bool]
#: Top, left, height and width.
Box = tuple[int, int, int, int]

__all__ = ["gap_of"]

#: The copies of each way to turn a sample; those in one row are of one shape.
TURNS: dict[str, list[list[Copy]]] = {
    "flip": [[(0, False), (0, True)]],
    "half": [[(0, False), (2, False)]],
    "4": [[(0, False), (2, False)], [(1, False), (3, False)]],
    "8": [
        [(0, False), (2, False), (0, True), (2, True)],
        [(1, False), (3, False), (1, True), (3, True)],
    ],
}


def turned_pixels(
    pixels: NDArray[Any], turn: str, role: Role = COLOR, *, gap: int = 1, between: Any = None
) -> NDArray[Any]:
    """The picture of all copies of `pixels` (H, W[, C]); vectors of normal maps are turned too.

    Copies lie `gap` pixels apart; `between` fills the gaps, by default with the first pixel so that
    values keep their range.
    """
    mixing = mixing_of(pixels, role.kind, alpha=False)

    def copy(quarters: int, mirrored: bool) -> NDArray[Any]:
        made = pixels[:, ::-1] if mirrored else pixels
        if mixing.kind is Kind.VECTORS:
            made = _turned_vectors(made, quarters, mirrored, role, mixing.middle)
        return np.rot90(made, quarters)

    result = np.empty((*picture_size(pixels.shape, turn, gap), *pixels.shape[2:]), pixels.dtype)
    result[:] = pixels[0, 0] if between is None else between
    for one, (top, left, high, wide) in boxes_of(turn, pixels.shape, gap):
        result[top : top + high, left : left + wide] = copy(*one)
    return result


def boxes_of(turn: str, shape: tuple[int, ...], gap: int = 1) -> list[tuple[Copy, Box]]:
    """Every copy of a sample of this shape, and where it lies."""
    boxes, top = [], 0
    for row in TURNS[turn]:
        high, wide = shape[:2] if row[0][0] % 2 == 0 else shape[1::-1]
        boxes += [(copy, (top, k * (wide + gap), high, wide)) for k, copy in enumerate(row)]
        top += high + gap
    return boxes


def picture_size(shape: tuple[int, ...], turn: str, gap: int) -> tuple[int, int]:
    """Height and width of the picture of copies of one of this shape."""
    boxes = [box for _, box in boxes_of(turn, shape, gap)]
    return max(top + high for top, _, high, _ in boxes), max(left + w for _, left, _, w in boxes)


def gap_of(size: tuple[int, ...], turn: Any, shape: Any) -> int | None:
    """Width of the line between copies in a picture of `size` made from `shape`, or None."""
    sides = shape if isinstance(shape, tuple) and [*map(type, shape)] == [int, int] else (0, 0)
    if not isinstance(turn, str) or turn not in TURNS or min(sides) < 1:
        return None
    count, without = len(TURNS[turn][0]), picture_size(shape, turn, 0)
    gap = (size[1] - without[1]) // (count - 1)
    return gap if gap > 0 and picture_size(shape, turn, gap) == tuple(size[:2]) else None


def in_first_copy(
    coordinates: NDArray[Any], turn: str | None, shape: tuple[int, int] | None
) -> NDArray[Any]:
    """Coordinates (..., 2) in a picture of copies mapped to the sample; negative ones stay."""
    if turn is None or shape is None:
        return coordinates
    found = coordinates.copy()
    y, x = np.moveaxis(coordinates, -1, 0)
    ends = np.array(shape) - 1
    for (quarters, mirrored), (top, left, high, wide) in boxes_of(turn, shape):
        there = (y >= top) & (y < top + high) & (x >= left) & (x < left + wide)
        place = np.stack([y[there] - top, x[there] - left], axis=-1)
        if quarters % 2:  # turned to the left, the first row is the last column
            place = place[:, ::-1]
        flipped = (quarters in (2, 3), (quarters in (1, 2)) != mirrored)
        found[there] = np.where(flipped, ends - place, place)
    return found


def _turned_vectors(
    pixels: NDArray[Any], quarters: int, mirrored: bool, role: Role, middle: float
) -> NDArray[Any]:
    """The vectors of a normal map as they are in a mirrored and turned copy."""
    right, up = pixels[..., 0], pixels[..., 1]
    down = role.name == "normal_dx"
    if mirrored:
        right = opposite(right, middle)
    for _ in range(quarters % 4):
        right, up = (up, opposite(right, middle)) if down else (opposite(up, middle), right)
    return np.concatenate([right[..., None], up[..., None], pixels[..., 2:]], axis=2)
