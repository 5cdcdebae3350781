"""The slow, obvious twin of `weftex.repeats.repeat_kernels.sum_copies`."""

import numpy as np


def sum_copies(
    shown, counts, salience, weights, mirrored, near, close, cells, copy, missing, places
):
    """See the kernel; `shown` is a list of (cell, row, column, copy), the pixel being (0, 0)."""
    sums = np.zeros((*places.shape, 6), np.int64)
    up, left = (n // 2 for n in missing.shape)
    middle = [n // 2 for n in weights.shape]
    for y, x in np.argwhere(places):
        for (i, j), cell in np.ndenumerate(cells):
            down, along = i - y, j - x
            if not (0 <= down + up < missing.shape[0] and 0 <= along + left < missing.shape[1]):
                continue
            new = missing[down + up, along + left]
            if new:
                sums[y, x] += [0, salience[cell], counts[cell], 0, 1, 0]
            for other, row, column, of in shown:
                if other != cell:
                    continue
                v, u = row - down, column - along
                sums[y, x, 5] += mirrored[of] != mirrored[copy] and v * v + u * u <= close
                sums[y, x, 3] += bool(new) and of != copy and v * v + u * u <= near
                if new and abs(v) <= middle[0] and abs(u) <= middle[1]:
                    sums[y, x, 0] += weights[v + middle[0], u + middle[1]] * salience[cell]
    return sums
