"""From a color to the places of a sample that have it, or one that is near it.

The kd-tree over the distinct colors is that of Sabha, Peers and Dutré (2007), Texture synthesis
using exact neighborhood matching, section 4: each color once, with the places where it is.
Colors of one node have consecutive numbers, so a whole node of near colors is one interval.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from weftex.methods.exact_matching import color_kernels as kernels
from weftex.raster.arrays import Bytes, Indices, Ints

_COLORS_OF_A_LEAF = 8  # about; they are compared one by one


class ColorIndex:
    """A kd-tree of the colors at the centers of listed windows and beside them.

    `usable` is 1 at the centers of the windows to list. Distances are sums of squared differences
    of bytes.
    """

    def __init__(self, pixels: Bytes, usable: Bytes) -> None:
        self.usable = usable
        height, width = usable.shape
        padded = np.pad(usable, 1)
        near = [padded[v : v + height, u : u + width] for v in (0, 1, 2) for u in (0, 1, 2)]
        counts = np.logical_or.reduce(near)
        counted = pixels[counts]
        order = np.lexsort(counted.T[::-1])
        new = np.ones(len(order), bool)
        new[1:] = (counted[order[1:]] != counted[order[:-1]]).any(axis=1)
        number = np.empty(len(order), np.int32)
        number[order] = np.cumsum(new) - 1
        colors = counted[order[new]]
        # children of node i are 2 i and 2 i + 1; 2**depth is the first leaf
        self.depth = max(0, (len(colors) // _COLORS_OF_A_LEAF).bit_length() - 1)
        # low and high (2**(depth + 1), K): smallest and largest bytes in each node
        leaves, self.low, self.high = _split(colors, self.depth)
        # (C, K): distinct colors in the order of the leaves; a color's number is its row
        self.colors = np.ascontiguousarray(colors[leaves])
        # (C,): place in byte order; of equally near colors the lowest rank is nearest
        self.rank = leaves.astype(np.int32)
        # (H, W): color number of each pixel, or of the nearest color in the index
        self.number = np.empty((height, width), np.int32)
        self.number[counts] = np.argsort(leaves).astype(np.int32)[number]
        self.number[~counts] = self.nearest(pixels[~counts])

    def tree(self) -> kernels.ColorTree:
        """Return the tree for kernels; it cannot be pickled."""
        return kernels.ColorTree(self.colors, self.low, self.high, self.rank, self.depth)

    def nearest(self, pixels: Bytes) -> Indices:
        """Return the numbers of the colors nearest to `pixels` (n, K)."""
        found = np.empty(len(pixels), np.int32)
        key = np.empty(1, np.int64)
        kernels.nearest_each(self.tree(), np.ascontiguousarray(pixels), key, found)
        return found

    def reach(self, count: int) -> Ints:
        """Return, for each color, the squared distance of its `count`-th nearest, itself first."""
        found = np.zeros(len(self.colors), np.int64)
        if 1 < count < len(found):
            keys, places = np.empty(count, np.int64), np.empty(count, np.int32)
            kernels.reach_each(self.tree(), keys, places, found)
        elif count > 1:
            found[:] = self.span
        return found

    @property
    def span(self) -> int:
        """The squared distance of the smallest and the largest bytes; colors differ by no more."""
        low, high = self.low[1].astype(np.int64), self.high[1].astype(np.int64)
        return int(((high - low) ** 2).sum())

    def centers_beside(self, offsets: Indices) -> tuple[Indices, Indices]:
        """Return starts (d, C + 1) and places: the centers of windows by the color beside them.

        Those of color c at `offsets[d]` (dy, dx) are `places[starts[d, c] : starts[d, c + 1]]`,
        flat indices in scan order (section 4.2).
        """
        centers = np.flatnonzero(self.usable).astype(np.int32)
        y, x = np.divmod(centers, np.int32(self.usable.shape[1]))
        starts = np.zeros((len(offsets), len(self.colors) + 1), np.int32)
        lists, total = [], 0
        height, width = self.usable.shape
        for d, (dy, dx) in enumerate(offsets.tolist()):
            v, u = y + dy, x + dx
            inside = (v >= 0) & (u >= 0) & (v < height) & (u < width)
            beside = self.number[v[inside], u[inside]]
            lists.append(centers[inside][np.argsort(beside, kind="stable")])
            starts[d, 1:] = np.cumsum(np.bincount(beside, minlength=len(self.colors)))
            starts[d] += total
            total += len(beside)
        return starts, np.concatenate(lists)


def _split(colors: Bytes, depth: int) -> tuple[NDArray[np.intp], Bytes, Bytes]:
    """Return the order of the colors, and the lowest and highest bytes of each node.

    Each node is halved along its widest channel, level by level.
    """
    count = len(colors)
    order = np.arange(count)
    low = np.zeros((2 << depth, colors.shape[1]), np.uint8)
    high = np.zeros_like(low)
    for level in range(depth + 1):
        starts = np.arange(1 << level) * count >> level
        nodes = slice(1 << level, 2 << level)
        low[nodes] = np.minimum.reduceat(colors[order], starts)
        high[nodes] = np.maximum.reduceat(colors[order], starts)
        if level < depth:
            widest = (high[nodes] - low[nodes]).argmax(axis=1)
            node = np.repeat(np.arange(1 << level), np.diff(starts, append=count))
            key = node * 256 + colors[order, widest[node]]
            order = order[np.argsort(key, kind="stable")]
    return order, low, high
