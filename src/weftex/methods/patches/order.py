"""Where patches go and in which order: rows for a new picture, spirals for holes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def patch_starts(length: int, size: int, overlap: int, wrap: bool) -> list[int]:
    """First pixels of patches that cover an axis, evenly spread, overlapping by `overlap` or more.

    Examples
    --------
    >>> patch_starts(100, 40, 10, wrap=False)
    [0, 30, 60]
    >>> patch_starts(100, 40, 10, wrap=True)
    [0, 25, 50, 75]
    """
    step = size - overlap
    if wrap:
        count = max(-(-length // step), 2)
        return [j * length // count for j in range(count)]
    if length <= size:
        return [0]
    count = -(-(length - size) // step)
    return [j * (length - size) // count for j in range(count + 1)]


#: Patches, as (rows up, columns right), that are always laid before a patch and lie around it.
_EARLIER = [(0, -2), (0, -1)] + [(-1, k) for k in (-2, -1, 0, 1)] + [(-2, k) for k in range(-2, 3)]


def patches_around(rows: int, columns: int) -> NDArray[np.int32]:
    """Numbers of the earlier patches around each patch of the grid, -1 for none: (n, 11)."""
    i, j = np.indices((rows, columns)).reshape(2, -1, 1)
    di, dj = np.array(_EARLIER).T
    i, j = i + di, j + dj
    inside = (i >= 0) & (j >= 0) & (j < columns)
    return np.ascontiguousarray(np.where(inside, i * columns + j, -1), np.int32)


def wavefronts(
    rows: int, columns: int, length: int, reach: int = 1
) -> Iterator[list[tuple[int, int, int]]]:
    """Cut the grid of patches into pieces of rows, and group those that do not need each other.

    Each group is a list of (row, first column, last column + 1). A patch needs those to its left,
    and in the row above those up to `reach` columns to its right, which it overlaps. So pieces
    start `reach` patches further left from row to row, and piece c of row i needs piece c - 1 of
    its own row and pieces up to c of the row above.
    """
    pieces = -(-(columns + rows * reach) // length)
    for front in range(rows + pieces):
        group = []
        for row in range(max(0, front - pieces + 1), min(rows, front + 1)):
            first = (front - row) * length - row * reach
            first, last = max(first, 0), min(first + length, columns)
            if first < last:
                group.append((row, first, last))
        if group:
            yield group


def spiral(cells: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Walk each connected group of cells from its border inwards, clockwise.

    Examples
    --------
    >>> import numpy as np
    >>> list(spiral(np.ones((2, 3), bool)))
    [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0)]
    """
    for group in _groups(cells):
        rows, columns = np.nonzero(group)
        top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
        while top <= bottom and left <= right:
            ring = [(top, x) for x in range(left, right + 1)]
            ring += [(y, right) for y in range(top + 1, bottom + 1)]
            if top < bottom:
                ring += [(bottom, x) for x in range(right - 1, left - 1, -1)]
            if left < right:
                ring += [(y, left) for y in range(bottom - 1, top, -1)]
            yield from ((int(y), int(x)) for y, x in ring if group[y, x])
            top, bottom, left, right = top + 1, bottom - 1, left + 1, right - 1


def _groups(cells: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
    left = cells.copy()
    while left.any():
        group = np.zeros_like(left)
        stack = [tuple(int(k) for k in np.argwhere(left)[0])]
        while stack:
            y, x = stack.pop()
            if not (0 <= y < left.shape[0] and 0 <= x < left.shape[1] and left[y, x]):
                continue
            left[y, x], group[y, x] = False, True
            stack += [(y + dy, x + dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
        yield group
