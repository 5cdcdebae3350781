"""How a picture lies in a store: levels, blocks and tiles.

Level 0 is the picture; each further level has half as many pixels along both sides. A level is
divided into square blocks, which one writer writes at once, and a block into tiles, which a reader
reads at once. All maps of a set have the same blocks, of more or fewer pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.raster.mixing import Kind, Mixing

if TYPE_CHECKING:
    from collections.abc import Iterator
    from fractions import Fraction

    from numpy.typing import NDArray

    #: (level, row, column) of a block.
    Place = tuple[int, int, int]
    #: (top, left, height, width) in pixels of a level.
    Window = tuple[int, int, int, int]

TILE = 512
SMALLEST_BLOCK, LARGEST_BLOCK = 64, 4096
_STRIP = 256  # rows that are halved at once
_MEAN = Mixing(Kind.MEAN)


@dataclass(frozen=True)
class Layout:
    """Sizes of a picture in a store, and what its pixels are.

    Attributes
    ----------
    height, width : int
        Of level 0.
    block : int
        Side of a block in pixels, a power of two.
    dtype : str
        uint8, uint16 or float32.
    channels : int
        0 for a picture of one channel, which has no third axis.
    alpha : bool
        The last channel is straight alpha.
    mixing : Mixing
        How pixels become one of a level above.
    icc : bytes or None
        Color profile.
    """

    height: int
    width: int
    block: int
    dtype: str
    channels: int = 0
    alpha: bool = False
    mixing: Mixing = _MEAN
    icc: bytes | None = None

    @property
    def tile(self) -> int:
        """Side of a tile."""
        return min(TILE, self.block)

    @property
    def bytes(self) -> int:
        """That a pixel takes."""
        return np.dtype(self.dtype).itemsize * max(self.channels, 1)

    def shape(self, level: int) -> tuple[int, int]:
        """Height and width of a level."""
        return -(-self.height >> level), -(-self.width >> level)

    def grid(self, level: int) -> tuple[int, int]:
        """Rows and columns of blocks of a level."""
        height, width = self.shape(level)
        return -(-height // self.block), -(-width // self.block)

    def levels(self, smallest: int) -> int:
        """How many levels there are, if the last is at most so many pixels wide and high."""
        longest = max(self.height, self.width)
        return 1 + max(0, -(-longest // smallest) - 1).bit_length()

    def window(self, place: Place) -> Window:
        """Where a block lies in its level."""
        level, row, column = place
        (height, width), side = self.shape(level), self.block
        top, left = row * side, column * side
        return top, left, min(side, height - top), min(side, width - left)

    def scaled(self, scale: Fraction | int, pixels: dict[str, Any], name: str) -> Layout:
        """Return the layout of a map with `scale` pixels along one of this picture.

        Raises
        ------
        InvalidInputError
            If its blocks would not be of whole tiles.
        """
        block, height, width = (k * scale for k in (self.block, self.height, self.width))
        small = block < 16 or any(k.denominator > 1 for k in (block, height, width))
        if small or int(block) & (int(block) - 1):
            raise InvalidInputError(
                f"map '{name}' has {scale} pixels along one of the sample; maps of a plane have 1, "
                "2, 4 or 1/2, 1/4, 1/8, and its size is a multiple of what one of them covers"
            )
        return Layout(int(height), int(width), int(block), **pixels)

    def describe(self) -> dict[str, Any]:
        """Return what tells it from others, but for the profile, as plain values."""
        names = ("height", "width", "block", "dtype", "channels", "alpha")
        return {name: getattr(self, name) for name in names}


def check_block(block: object) -> int:
    """Return the side of blocks.

    Raises
    ------
    InvalidInputError
        Unless it is a power of two in its bounds.
    """
    whole = isinstance(block, int) and not isinstance(block, bool)
    if not (whole and SMALLEST_BLOCK <= block <= LARGEST_BLOCK and not block & (block - 1)):  # type: ignore[operator]
        raise InvalidInputError(
            f"block is {shown(block)}; it must be a power of two from {SMALLEST_BLOCK} to "
            f"{LARGEST_BLOCK}"
        )
    return block  # type: ignore[return-value]


def places(layout: Layout, levels: int) -> Iterator[Place]:
    """Give all blocks, level by level, so that those below are done first."""
    for level in range(levels):
        yield from places_of(layout, level)


def places_of(layout: Layout, level: int) -> Iterator[Place]:
    """Give the blocks of a level, row by row."""
    rows, columns = layout.grid(level)
    return ((level, row, column) for row in range(rows) for column in range(columns))


def part_range(layout: Layout, number: int, of: int) -> range:
    """Return the blocks of level 0, counted row by row, that are part `number` of `of`."""
    count = blocks_in(layout, 1)
    return range(count * (number - 1) // of, count * number // of)


def part_of(layout: Layout, number: int, of: int) -> Iterator[Place]:
    """Give the blocks of level 0 that are part `number` of `of`: neighbors, in their order."""
    columns = layout.grid(0)[1]
    return ((0, *divmod(k, columns)) for k in part_range(layout, number, of))


def blocks_in(layout: Layout, levels: int) -> int:
    """Return the number of blocks of the first `levels` levels."""
    return sum(rows * columns for rows, columns in map(layout.grid, range(levels)))


def children(layout: Layout, place: Place) -> Window:
    """Return the window of the level below that becomes a block."""
    level, *_ = place
    top, left, height, width = (2 * k for k in layout.window(place))
    below = layout.shape(level - 1)
    return top, left, min(height, below[0] - top), min(width, below[1] - left)


def blocks_below(layout: Layout, place: Place) -> list[Place]:
    """Return the blocks of the level below that become a block."""
    level, row, column = place
    rows, columns = layout.grid(level - 1)
    return [
        (level - 1, y, x)
        for y in range(2 * row, min(2 * row + 2, rows))
        for x in range(2 * column, min(2 * column + 2, columns))
    ]


def halved(pixels: NDArray[Any], mixing: Mixing) -> NDArray[Any]:
    """Return pixels (H, W) or (H, W, C) at half their size, rounded up; an odd border is repeated.

    Examples
    --------
    >>> halved(np.array([[1, 2, 9], [4, 5, 9]], np.uint8), Mixing(Kind.MEAN)).tolist()
    [[3, 9]]
    """
    height, width = pixels.shape[:2]
    out = np.empty((-(-height // 2), -(-width // 2), *pixels.shape[2:]), pixels.dtype)
    for top in range(0, len(out), _STRIP):
        strip = pixels[2 * top : 2 * (top + _STRIP)]
        odd = [(0, side % 2) for side in strip.shape[:2]] + [(0, 0)] * (pixels.ndim - 2)
        if any(sum(pair) for pair in odd):
            strip = np.pad(strip, odd, "edge")
        out[top : top + _STRIP] = _means(strip, mixing)
    return out


def _means(pixels: NDArray[Any], mixing: Mixing) -> NDArray[Any]:
    """Half the size of pixels with even sides."""
    if mixing.kind is Kind.LABELS:
        return pixels[::2, ::2]
    parts = [pixels[y::2, x::2] for y in (0, 1) for x in (0, 1)]
    if mixing.kind is Kind.MEAN and pixels.dtype.kind == "u":
        total = np.add(parts[0], parts[1], dtype=np.uint32)
        for part in parts[2:]:
            total += part
        return np.asarray((total + 2) >> 2, pixels.dtype)
    four = np.stack(parts).astype(np.float64)
    if mixing.kind is Kind.ALPHA:
        cover = four[..., -1:]
        total = cover.sum(axis=0)
        weights = np.where(total > 0, cover, 1) / np.where(total > 0, total, 4)
        mean = np.concatenate([(four[..., :-1] * weights).sum(axis=0), total / 4], axis=-1)
    else:
        mean = four.mean(axis=0)
    if mixing.kind is Kind.VECTORS:
        full = np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 2 * mixing.middle
        middle = full / 2
        vectors = mean[..., :3] - middle
        length = np.linalg.norm(vectors, axis=-1, keepdims=True)
        mean[..., :3] = middle + vectors * np.where(length > 0, (middle or 1) / length, 1)
    if pixels.dtype.kind == "f":
        return np.asarray(mean, pixels.dtype)
    return np.asarray(np.clip(np.rint(mean), 0, np.iinfo(pixels.dtype).max), pixels.dtype)
