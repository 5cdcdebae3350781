"""Paths of least cost: the slow twins' own, open and closed."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from twins import seams as reference
from weftex.methods.ashikhmin import least_path


def costs(data, rows, columns, most):
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    shape = data.draw(st.integers(1, rows)), data.draw(st.integers(1, columns))
    return rng.integers(0, data.draw(st.sampled_from([1, 3, most])), shape)


@given(st.data(), st.booleans())
def test_paths_are_the_slow_twin(data, closed):
    cost = costs(data, 30, 12, 2**40)
    assert least_path(cost, closed=closed).tolist() == list(reference.path_around(cost, closed))
