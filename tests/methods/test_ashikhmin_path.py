"""Paths of least cost: the slow twins' own, open and closed."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from twins import seams as reference
from weftex.methods.ashikhmin.choice import least_path


def costs(data, rows, columns, most):
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    shape = data.draw(st.integers(1, rows)), data.draw(st.integers(1, columns))
    return rng.integers(0, data.draw(st.sampled_from([1, 3, most])), shape)


@given(st.data(), st.booleans())
def test_paths_are_the_slow_twin(data, closed):
    cost = costs(data, 30, 12, 2**40)
    assert least_path(cost, closed=closed).tolist() == list(reference.path_around(cost, closed))


@pytest.mark.parametrize("turn", range(7))
def test_a_closed_valley_is_followed_wherever_it_is_cut(turn):
    valley = [2, 3, 3, 2, 1, 1, 2]
    cost = np.full((7, 6), 100)
    for row, column in enumerate(valley):
        cost[row, column] = 0
    cost = np.roll(cost, turn, axis=0)
    assert least_path(cost, closed=True).tolist() == np.roll(valley, turn).tolist()
    assert all(abs(a - b) <= 1 for a, b in itertools.pairwise(valley))
