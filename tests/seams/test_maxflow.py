"""Minimum cuts of grids against SciPy's maximum flow."""

import numpy as np
import pytest

from families import refused
from twins import maxflow as reference
from weftex.seams import LARGEST_CAPACITY, minimum_cut


@pytest.mark.parametrize("shape", [(40, 40), (1, 200), (200, 1), (97, 33)])
@pytest.mark.parametrize("top", [1, 9, 1000])
@pytest.mark.parametrize("terminals", ["borders", "everywhere", "few"])
def test_large_grids(shape, top, terminals):
    rng = np.random.default_rng(top)
    arcs = rng.integers(0, top + 1, (*shape, 4)).astype(np.int32)
    source, sink = np.zeros((2, *shape), np.int32)
    if terminals == "borders":
        source[-1] = source[:, -1] = LARGEST_CAPACITY
        sink[0] = sink[:, 0] = LARGEST_CAPACITY
    else:
        share = 1.0 if terminals == "everywhere" else 0.02
        source = (rng.integers(0, 4 * top, shape) * (rng.random(shape) < share)).astype(np.int32)
        sink = (rng.integers(0, 4 * top, shape) * (rng.random(shape) < share)).astype(np.int32)
    capacities = arcs, source, np.minimum(sink, LARGEST_CAPACITY - source)
    side, value = minimum_cut(*capacities)
    if terminals == "borders":  # SciPy adds capacities up in 32 bits
        capacities = arcs, np.minimum(source, 4 * top), np.minimum(capacities[2], 4 * top)
    assert value == reference.cut_value(side, *capacities)
    if terminals != "borders":
        expected, least = reference.cut_by_scipy(*capacities)
        assert value == least
        assert np.array_equal(side, expected)


def test_nothing_to_cut():
    empty = np.zeros((0, 3), np.int32)
    side, value = minimum_cut(np.zeros((0, 3, 4), np.int32), empty, empty)
    assert side.shape == (0, 3) and value == 0
    blank = np.zeros((4, 3), np.int32)
    side, value = minimum_cut(np.zeros((4, 3, 4), np.int32), blank, blank)
    assert not side.any() and value == 0


def test_the_largest_capacities_do_not_overflow():
    arcs = np.full((5, 6, 4), LARGEST_CAPACITY, np.int32)
    source, sink = np.zeros((2, 5, 6), np.int32)
    source[:, 0] = sink[:, -1] = LARGEST_CAPACITY
    assert minimum_cut(arcs, source, sink)[1] == 5 * LARGEST_CAPACITY


def test_wrong_capacities_are_refused():
    good = np.zeros((2, 3, 4), np.int32), np.zeros((2, 3), np.int32), np.zeros((2, 3), np.int32)
    for at in range(3):
        for value in (-1, LARGEST_CAPACITY + 1):
            wrong = [a.copy() for a in good]
            wrong[at].flat[1] = value
            refused("from 0 to", minimum_cut, *wrong)
    refused(r"\(H, W, 4\)", minimum_cut, good[0][:, :2], good[1], good[2])
