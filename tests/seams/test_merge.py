"""Two samples merged along a minimum cut."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import maximum_flow

from weftex.seams.merge import _CORE, _RIM, island


def cut_value(side, differ):
    value = 0
    for axis in (0, 1):
        a, b = (np.moveaxis(side, axis, 0)[s] for s in (slice(None, -1), slice(1, None)))
        d = np.moveaxis(differ, axis, 0)
        value += ((d[:-1] + d[1:] + 1) * (a != b)).sum()
    return int(value)


@pytest.mark.parametrize("shape", [(9, 12), (20, 15), (1, 9), (2, 2), (1, 1)])
@pytest.mark.parametrize("seed", range(3))
def test_the_seam_is_a_minimum_cut(shape, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.integers(0, 256, (2, *shape, 3)).astype(np.uint8)
    side = island(a, b)
    height, width = shape
    y, x = (np.abs(np.arange(n) - (n - 1) / 2) / n for n in shape)
    far = np.maximum(y[:, None], x)
    core = (far <= _CORE) | (far == far.min())
    rim = (far >= 0.5 - _RIM) & ~core
    assert side[core].all() and not side[rim].any()
    differ = np.abs(a.astype(int) - b).sum(axis=2)
    # The same graph for scipy: pixels, then the island and the sea.
    number = np.arange(height * width).reshape(shape)
    rows, columns, capacity = [], [], []
    for axis in (0, 1):
        n, d = np.moveaxis(number, axis, 0), np.moveaxis(differ, axis, 0)
        rows += [*n[:-1].ravel(), *n[1:].ravel()]
        columns += [*n[1:].ravel(), *n[:-1].ravel()]
        capacity += [*(d[:-1] + d[1:] + 1).ravel()] * 2
    for terminal, inside in ((height * width, core), (height * width + 1, rim)):
        at = number[inside].tolist()
        rows += [terminal] * len(at) if terminal == height * width else at
        columns += at if terminal == height * width else [terminal] * len(at)
        capacity += [2**28] * len(at)
    size = height * width + 2
    graph = sparse.csr_matrix((capacity, (rows, columns)), (size, size), dtype=np.int32)
    assert cut_value(side, differ) == maximum_flow(graph, size - 2, size - 1).flow_value
