"""Parallelograms as runs of pixels, and sums over them at every place of a picture at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def runs_of(
    first: NDArray[np.float64], second: NDArray[np.float64], reach: int
) -> NDArray[np.int64]:
    """Runs of pixels within `reach` of a parallelogram or, with a zero side, of a segment.

    Rows of (n, 3): row, first column and the column after the last, counted from its corner.
    """
    corners = np.stack([0 * first, first, first + second, second])
    low = np.ceil(corners[:, 0].min()).astype(int) - reach
    high = max(np.ceil(corners[:, 0].max()).astype(int) + reach, low + 1)
    runs = []
    for row in range(low, high):
        # The parallelogram's part within reach of this row lies between its sides there.
        near = np.clip([row - reach, row + reach], corners[:, 0].min(), corners[:, 0].max())
        crossed = []
        for k in range(4):
            (y, x), (v, u) = corners[k], corners[(k + 1) % 4]
            crossed += [x] if near[0] <= y <= near[1] else []
            for at in near:
                if min(y, v) <= at <= max(y, v) and y != v:
                    crossed.append(x + (at - y) / (v - y) * (u - x))
        left = int(np.ceil(min(crossed))) - reach
        runs.append((row, left, max(int(np.ceil(max(crossed))) + reach, left + 1)))
    return np.array(runs, np.int64).reshape(-1, 3)


def integrated(
    values: NDArray[np.int64], runs: NDArray[np.int64], outside: int
) -> NDArray[np.int64]:
    """Sum over the runs at every place; `outside` is the value of pixels that are not there."""
    height, width = values.shape
    low = min(0, int(runs[:, 0].min())), min(0, int(runs[:, 1].min()))
    high = max(0, int(runs[:, 0].max())), max(0, int(runs[:, 2].max()))
    pads = ((-low[0], high[0]), (-low[1], high[1]))
    wide = np.pad(values, pads, constant_values=outside)
    sums = np.zeros((wide.shape[0], wide.shape[1] + 1), np.int64)
    np.cumsum(wide, axis=1, out=sums[:, 1:])
    total = np.zeros((height, width), np.int64)
    for row, left, right in runs.tolist():
        lines = sums[row - low[0] : row - low[0] + height]
        total += lines[:, right - low[1] : right - low[1] + width]
        total -= lines[:, left - low[1] : left - low[1] + width]
    return total
