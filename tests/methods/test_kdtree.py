"""The approximate kd-tree of section 3.1."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from weftex.errors import UnsupportedError
from weftex.methods.patches.zone_search import KDTree


def distances(points, query):
    return ((points.astype(int) - query.astype(int)) ** 2).sum(axis=1)


@given(
    st.integers(0, 10**6), st.integers(1, 300), st.integers(1, 12), st.integers(1, 50),
    st.sampled_from([0.0, 0.5]),
)  # fmt: skip
def test_neighbors_are_within_the_allowed_error(seed, count, dimensions, wanted, error):
    rng = np.random.default_rng(seed)
    points = rng.integers(-50, 50, (count, dimensions)).astype(np.int16)
    places = rng.permutation(1000)[:count].astype(np.int32)
    query = rng.integers(-50, 50, dimensions).astype(np.int16)
    found = KDTree(points, places, error).nearest(query, wanted)
    assert len(found) == len(set(found.tolist())) == min(wanted, count)
    assert set(found.tolist()) <= set(places.tolist())
    row = {int(p): n for n, p in enumerate(places)}
    got = np.sort(distances(points, query)[[row[p] for p in found.tolist()]]) ** 0.5
    true = np.sort(distances(points, query))[: len(found)] ** 0.5
    assert (got <= (1 + error) * true + 1e-9).all()


def test_equal_points_make_a_tree():
    """Sliding midpoint splits cannot part them; the tree must still end."""
    tree = KDTree(np.zeros((500, 7), np.int16), np.arange(500, dtype=np.int32), 0.5)
    assert len(set(tree.nearest(np.ones(7, np.int16), 40).tolist())) == 40


def test_without_scipy_the_error_says_what_to_install(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    with pytest.raises(UnsupportedError, match="pip install 'scipy>=1.13'"):
        KDTree(np.zeros((1, 1), np.int16), np.zeros(1, np.int32), 0.5)
