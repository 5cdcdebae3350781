"""How a picture is divided: levels, blocks and tiles.

Level 0 is the picture; each further level has half as many pixels along both sides. A level is
divided into square blocks, which one writer writes at once, and a block into tiles, which a reader
reads at once. All maps of a set have the same blocks, of more or fewer pixels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from weftex.errors import wrong_value

#: (level, row, column) of a block.
Place = tuple[int, int, int]
#: (top, left, height, width) in pixels of a level.
Window = tuple[int, int, int, int]

TILE = 512
SMALLEST_BLOCK, LARGEST_BLOCK = 64, 4096


@dataclass(frozen=True)
class Layout:
    """Sizes of a picture in pixels of level 0, and what its pixels are."""

    height: int
    width: int
    block: int
    dtype: str = "uint8"
    channels: int = 0  # 0 for a picture without a third axis
    alpha: bool = False  # whether the last channel is straight alpha
    mixing: Any = None  # makes pixels of the level above; see `Exemplar.mixing`
    icc: bytes | None = None  # color profile
    density: float | None = None  # pixels per meter

    @property
    def tile(self) -> int:
        """Side of a tile."""
        return min(TILE, self.block)

    @property
    def pixel_bytes(self) -> int:
        """Bytes of a pixel."""
        return np.dtype(self.dtype).itemsize * max(self.channels, 1)

    def shape(self, level: int) -> tuple[int, int]:
        """Height and width of a level."""
        return -(-self.height >> level), -(-self.width >> level)

    def grid(self, level: int) -> tuple[int, int]:
        """Rows and columns of blocks of a level."""
        height, width = self.shape(level)
        return -(-height // self.block), -(-width // self.block)

    def levels(self, smallest: int) -> int:
        """The number of levels, the last of which has at most `smallest` pixels a side."""
        longest = max(self.height, self.width)
        return 1 + max(0, -(-longest // smallest) - 1).bit_length()

    def window(self, place: Place) -> Window:
        """Where a block lies in its level."""
        level, row, column = place
        (height, width), side = self.shape(level), self.block
        top, left = row * side, column * side
        return top, left, min(side, height - top), min(side, width - left)

    def count(self, levels: int) -> int:
        """The number of blocks of the first `levels` levels."""
        return sum(rows * columns for rows, columns in map(self.grid, range(levels)))

    def numbers(self, level: int, part: tuple[int, int] | None) -> range:
        """The blocks of a level, or of part K of N of level 0, counted row by row."""
        rows, columns = self.grid(level)
        number, of = part or (1, 1)
        return range(rows * columns * (number - 1) // of, rows * columns * number // of)

    def places(self, level: int, part: tuple[int, int] | None = None) -> Iterator[Place]:
        """The blocks of a level, or of a part of level 0, row by row."""
        columns = self.grid(level)[1]
        return ((level, *divmod(number, columns)) for number in self.numbers(level, part))

    def below(self, place: Place) -> list[Place]:
        """The blocks of the level below that a block is made of."""
        level, row, column = place
        rows, columns = self.grid(level - 1)
        return [
            (level - 1, y, x)
            for y in range(2 * row, min(2 * row + 2, rows))
            for x in range(2 * column, min(2 * column + 2, columns))
        ]

    def window_below(self, place: Place) -> Window:
        """The window of the level below that becomes a block."""
        top, left, height, width = (2 * k for k in self.window(place))
        below = self.shape(place[0] - 1)
        return top, left, min(height, below[0] - top), min(width, below[1] - left)


def named(place: Place) -> str:
    """What errors call a block."""
    return "the block level {}, row {}, column {}".format(*place)


def check_block(block: object) -> None:
    """Raise `InvalidInputError` unless the side of blocks is a power of two in its bounds."""
    bounds = range(SMALLEST_BLOCK, LARGEST_BLOCK + 1)
    if type(block) is not int or block not in bounds or block.bit_count() != 1:
        wanted = f"a power of two from {SMALLEST_BLOCK} to {LARGEST_BLOCK}"
        raise wrong_value("block", block, wanted)
