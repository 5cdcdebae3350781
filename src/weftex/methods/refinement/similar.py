"""For each place of a sample the few places that look most like it (k-coherence, Tong et al. 2002).

Refinement searches by them; the lists of exact matching are in `color_index`.

They are found exactly on the coarsest level of a pyramid, and then passed down: the places like a
pixel are looked for around the children of those that its parent is like. On a level of more than
two megapixels, where this would take longest, they are those children.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from weftex.methods.refinement import similar_kernels as kernels
from weftex.progress import counted
from weftex.search.windows import Windows

_SAME_PLACE = 2  # pixels; places that are no farther apart count as one
_AROUND = (-1, 0, 1)
_COARSEST_PAIRS = 2**24  # comparisons on the coarsest level, about so many in all
_MOST_CENTERS = 2**21  # of a level that is searched
_AT_ONCE = 2**16  # centers whose candidates are listed together


def similar_places(
    windows: Windows,
    reach: int,
    count: int,
    coarser: tuple[Windows, NDArray[np.int32]] | None = None,
) -> NDArray[np.int32]:
    """Return (H' * W', count) flat indices of the pixels most similar to each, -1 for none.

    The nearest is first. Windows reach `reach` pixels. `coarser` has the next coarser level and its
    result. A pixel that is no center takes the result of the nearest center.
    """
    centers = windows.centers
    if not count:
        return np.zeros((windows.usable.size, 0), np.int32)
    found = np.full((len(centers), count), -1, np.int32)
    room = np.zeros(count, np.int64)
    if coarser is None:
        step = -(-(len(centers) ** 2) // _COARSEST_PAIRS)
        every = np.ascontiguousarray(centers[None, ::step])
        kernels.nearest_windows(windows.pixels, centers, every, reach, _SAME_PLACE, room, found)
    else:
        searched = len(centers) <= _MOST_CENTERS
        with counted(len(centers), "similar pixels") as advance:
            for first in range(0, len(centers), _AT_ONCE):
                part = slice(first, first + _AT_ONCE)
                near = _children(windows, centers[part], *coarser, _AROUND if searched else (0,))
                if searched:
                    kernels.nearest_windows(
                        windows.pixels, centers[part], near, reach, _SAME_PLACE, room, found[part]
                    )
                else:
                    found[part] = near
                advance(len(centers[part]))
    rank = np.zeros(windows.usable.size, np.int32)
    rank[centers] = np.arange(len(centers), dtype=np.int32)
    return found[rank[nearest_center(windows.usable).ravel()]]


def nearest_center(usable: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Return for each pixel the flat index of a nearby window center, or its own.

    The nearest one along the row, or in the nearest row that has any.
    """
    height, width = usable.shape
    columns = np.arange(width)
    there = usable.astype(bool)
    rows = np.flatnonzero(there.any(axis=1))
    result = np.empty((height, width), np.int32)
    for y in range(height):
        row = rows[np.abs(rows - y).argmin()]
        at = np.flatnonzero(there[row])
        after = np.searchsorted(at, columns).clip(1, max(len(at) - 1, 1))
        before = at[after - 1]
        later = at[np.minimum(after, len(at) - 1)]
        result[y] = row * width + np.where(columns - before <= later - columns, before, later)
    return result


def _children(
    windows: Windows,
    centers: NDArray[np.int32],
    coarser: Windows,
    similar: NDArray[np.int32],
    around: tuple[int, ...],
) -> NDArray[np.int32]:
    """The places around the children of what each center's parent is like."""
    height, width = windows.pixels.shape[:2]
    top, left = (int(n) for n in windows.period[:2])
    coarse_top, coarse_left = (int(n) for n in coarser.period[:2])
    y, x = np.divmod(centers, width)
    y, x = y - top, x - left
    parent = (y // 2 + coarse_top) * coarser.pixels.shape[1] + x // 2 + coarse_left
    steps = list(product(range(similar.shape[1]), around, around))
    result = np.empty((len(y), len(steps)), np.int32)
    for k, (j, dy, dx) in enumerate(steps):
        place = similar[parent, j]
        v, u = np.divmod(place, coarser.pixels.shape[1])
        v = 2 * (v - coarse_top) + y % 2 + dy + top
        u = 2 * (u - coarse_left) + x % 2 + dx + left
        inside = (place >= 0) & (v >= 0) & (u >= 0) & (v < height) & (u < width)
        flat = np.where(inside, v * width + u, 0)
        result[:, k] = np.where(inside & (windows.usable.ravel()[flat] > 0), flat, -1)
    return result
