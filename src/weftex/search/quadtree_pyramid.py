"""The quadtree pyramid of section 3.2: every window has a counterpart at low resolution.

The paper halves the resolution and keeps all four shifts at each level, so level 3 is 16 small
pictures. They are the pixels of one picture of means, sorted: the mean of the block that starts at
(y, x) belongs to shift (y % 4, x % 4). Any block side and any stride between windows is a sorting
of the same kind, and rows of one shift are contiguous, as the kernel wants them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class QuadtreePyramid:
    """Means over blocks at every pixel of a sample (H, W, C), sorted by shift."""

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        self.pixels = pixels
        self._nodes: dict[tuple[int, int], NDArray[np.uint8]] = {}

    def nodes(self, side: int, stride: int) -> NDArray[np.uint8]:
        """Return (channel, shift y, shift x, row, column): rounded means of side x side blocks.

        `side` is a power of two; the paper's level 3 is 4. Windows are `stride` pixels apart.
        """
        if (side, stride) not in self._nodes:
            rows, columns = (max(0, n - side + 1) for n in self.pixels.shape[:2])
            down, across = -(-rows // stride), -(-columns // stride)
            channels = self.pixels.shape[2]
            found = np.zeros((channels, stride, stride, down, across), np.uint8)
            means = np.zeros((down * stride, across * stride), np.uint8)
            for channel in range(channels):  # one at a time: samples may be of 12 megapixels
                means[:rows, :columns] = _block_means(self.pixels[..., channel], side)
                blocks = means.reshape(down, stride, across, stride)
                found[channel] = blocks.transpose(1, 3, 0, 2)
            self._nodes[side, stride] = found
        return self._nodes[side, stride]

    def windows(
        self, blocks: NDArray[np.int32], side: int, stride: int, rows: int, columns: int
    ) -> NDArray[np.uint8]:
        """Return (blocks * channels, rows * columns): every window's blocks in the kernel's order.

        `rows` and `columns` count windows, `stride` pixels apart.
        """
        nodes = self.nodes(side, stride)
        found = np.empty((len(blocks), nodes.shape[0], rows, columns), np.uint8)
        for k, (v, u) in enumerate(blocks.tolist()):
            i, j = v // stride, u // stride
            found[k] = nodes[:, v % stride, u % stride, i : i + rows, j : j + columns]
        return found.reshape(-1, rows * columns)


def _block_means(level: NDArray[np.uint8], side: int) -> NDArray[Any]:
    """Means over blocks, rounded, in numbers that hold their sums."""
    total: NDArray[Any] = level.astype(np.uint16 if side <= 16 else np.uint32)
    step = 1
    while step < side:
        total = total[:-step] + total[step:]
        total = total[:, :-step] + total[:, step:]
        step *= 2
    total += total.dtype.type(side * side // 2)
    total >>= total.dtype.type(2 * (side.bit_length() - 1))
    return total
