"""Warps of near-regular gaps: their pieces bent so that they meet the blocks around them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.near_regular import warp_kernels as kernels
from weftex.results import warp_kernels as _warp_kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.near_regular.blocks import Blocks

_SPACING = 10  # px between the places of a side that are shifted, about
_MOST = 8  # of them, and 1
_HALF = 8  # px around such a place that count
_AROUND = 4  # px that a pixel's surroundings reach
_PIECE = 16  # gaps that a thread looks at at a time


class Warps:
    """How the gaps of one output are warped.

    Attributes
    ----------
    nodes : int16 array (rows, columns, n, n, 2)
        Shifts of each block, see `weftex.results.warp_kernels`.
    """

    def __init__(self, blocks: Blocks, map_: Callable[..., Iterable[Any]]) -> None:
        self._blocks, sample, method = blocks, blocks.sample, blocks.method
        limit, size = method.warp, method.block_size or 1
        last = min(max(size // _SPACING, 1), _MOST)
        self.nodes = np.zeros((*blocks.place.shape, last + 1, last + 1, 2), np.int16)
        shown = np.zeros(blocks.gap.shape, bool)
        shown[blocks.rows.shown, blocks.columns.shown] = True
        self._warped = shown & blocks.gap & blocks.laid & (blocks.place >= 0)
        half = min(_HALF, blocks.reach)
        if half == 0:
            return
        steps = range(-limit, limit + 1)
        shifts = np.array(
            sorted(
                ((a, b) for a in steps for b in steps), key=lambda s: (s[0] ** 2 + s[1] ** 2, s)
            ),
            np.int32,
        )
        edges = without_tone(sample.pixels)
        cells = np.ascontiguousarray(np.argwhere(self._warped), np.int32)

        def estimate(k: int) -> None:
            kernels.estimate(
                edges, cells[k : k + _PIECE], blocks.rows.edges, blocks.columns.edges,
                blocks.wrap, blocks.place, sample.margin, half, shifts, limit,
                np.empty(sample.side, np.int64),
                np.empty((last + 1, len(steps), len(steps)), np.int64),
                np.empty((4, last + 1, 2), np.int64),
                np.empty((4, last + 1, 2), np.int64),
                self.nodes,
            )  # fmt: skip

        list(map_(estimate, range(0, len(cells), _PIECE)))

    def shown(
        self, rows: list[int]
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint16], NDArray[np.int32]]:
        """What seams look at: the sample with the warped pieces of these rows of blocks below it.

        Returns
        -------
        pixels : uint8 array (rows, columns, K)
        visibility : uint16 array (rows, columns)
            Of warped pieces as if they were not.
        place : int32 array
            Places of all blocks, in these pixels.
        """
        blocks, sample = self._blocks, self._blocks.sample
        place = blocks.place.copy()
        height, width, channels = sample.pixels.shape
        cells = [(i, int(j)) for i in rows for j in np.flatnonzero(self._warped[i])]
        side = sample.side
        pixels = np.empty((height + side * len(cells), width, channels), np.uint8)
        pixels[:height] = sample.pixels
        visibility = np.ones(pixels.shape[:2], np.uint16)
        visibility[:height] = sample.visibility
        for k, (i, j) in enumerate(cells):
            piece = pixels[height + side * k : height + side * (k + 1)]
            y, x = divmod(int(place[i, j]), width)
            sizes = blocks.rows.sizes[i], blocks.columns.sizes[j]
            about = np.array([(0, 0, *sizes, sample.margin)], np.int32)
            _warp_kernels.warp_into(
                piece, sample.pixels, y, x, side, self.nodes[i, j][None], about, 0, 1, False
            )
            visibility[height + side * k :, :side][:side] = sample.visibility[
                y : y + side, x : x + side
            ]
            place[i, j] = (height + side * k) * width
        return pixels, visibility, place

    def of(
        self, order: NDArray[np.int64], row: NDArray[Any], column: NDArray[Any]
    ) -> tuple[NDArray[np.int16], NDArray[np.int32]]:
        """Warps of the gaps among these patches, and where in their windows those begin.

        Parameters
        ----------
        order : int array (n,)
            Flat indices of blocks among those that show.
        row, column : int array
            For each of those, the first line and column of its window that is laid.
        """
        blocks = self._blocks
        rows, columns = blocks.rows.shown, blocks.columns.shown
        order = order[blocks.gap[rows, columns].ravel()[order]]
        at = np.unravel_index(order, row.shape)
        i, j = at[0] + rows.start, at[1] + columns.start
        sizes = blocks.rows.sizes[i], blocks.columns.sizes[j]
        margin = np.full(len(order), blocks.sample.margin)
        within = np.stack([row[at], column[at], *sizes, margin], axis=1)
        return self.nodes[i, j], np.ascontiguousarray(within, np.int32)


def without_tone(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """What differs from its surroundings: of two tiles of any colours, the joint.

    Parameters
    ----------
    pixels : uint8 array (H, W, K)

    Returns
    -------
    uint8 array (H, W, K)
        128 where a pixel is the mean of those around it.

    Examples
    --------
    >>> without_tone(np.full((2, 3, 1), 200, np.uint8)).ravel()
    array([128, 128, 128, 128, 128, 128], dtype=uint8)
    """
    side = 2 * _AROUND + 1
    levels = pixels.astype(np.int64)
    total = np.pad(levels, ((_AROUND,) * 2, (_AROUND,) * 2, (0, 0)), mode="edge")
    for axis in (0, 1):
        total = np.cumsum(total, axis=axis)
        total = np.insert(total, 0, 0, axis=axis)
        n = pixels.shape[axis]
        total = total.take(range(side, n + side), axis) - total.take(range(n), axis)
    result: NDArray[np.uint8] = np.clip(128 + levels - total // side**2, 0, 255).astype(np.uint8)
    return result
