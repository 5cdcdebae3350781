"""The least boundary between the pixels of a band, against every boundary."""

import numpy as np
import pytest

from weftex.seams.boundary_kernels import Band, boundary_through


@pytest.mark.parametrize("seed", range(20))
def test_least_paths(seed):
    """Against every path, by the cost of the pixels beside it and beyond."""
    rng = np.random.default_rng(seed)
    length, depth = 4, 4
    error = rng.integers(0, 1000, (length, depth)).astype(np.int64)
    beyond = rng.integers(-1000, 1000, (length, depth + 1)).astype(np.int64) * (seed % 2)
    begin, end = (int(k) for k in rng.integers(1, depth, 2))
    if abs(begin - end) > length - 1:
        return

    def cost(path):
        total = sum(
            int(error[i, k - 1] + error[i, k] + beyond[i, k]) for i, k in enumerate(path) if i
        )
        for i in range(1, length):
            a, b = sorted(path[i - 1 : i + 1])
            total += int(error[i - 1, a:b].sum() + error[i, a:b].sum())
        return total

    paths = [
        (begin, a, b, end)
        for a in range(1, depth)
        for b in range(1, depth)
        if abs(a - begin) <= 1 and abs(b - begin) <= 2 and abs(b - end) <= 1 and abs(a - end) <= 2
    ]
    found = np.zeros(length, np.int32)
    band = Band(
        error=error,
        beyond=beyond[: length * (seed % 2)],
        total=np.zeros((length, depth + 1), np.int64),
        came=np.zeros((length, depth + 1), np.int32),
        path=found,
    )
    boundary_through(band, begin, end)
    assert tuple(found) in paths and cost(tuple(found)) == min(map(cost, paths))
