"""Seed points: the stochastic tiling of section 3."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from families import noise
from twins import seed_points as reference
from weftex.exemplar import Exemplar
from weftex.methods.refinement.seeds import plant_seeds
from weftex.search.windows import windows_of


@given(
    st.tuples(st.integers(1, 12), st.integers(1, 12)),
    st.tuples(st.integers(1, 30), st.integers(1, 30)),
    st.tuples(st.booleans(), st.booleans()),
    st.integers(1, 6),
    st.integers(1, 6),
    st.sampled_from([2, 5, 255]),
    st.booleans(),
    st.integers(0, 2**64 - 1),
)
def test_it_is_the_slow_twin(sample, shape, wrap, spacing, matches, colors, masked, seed):
    pixels = (noise((*sample, 2)) % colors).astype(np.uint8)
    mask = np.ones(sample, bool)
    if masked and sample[1] > 2:
        mask[0, :2] = False
    exemplar = Exemplar(pixels, mask=mask, alpha=False)
    plain = windows_of(exemplar, (0, 0, 0, 0), pixels)
    places, y, x = plant_seeds(plain, shape, wrap, spacing, matches, seed)
    expected = reference.seed_points(pixels, mask, shape, wrap, spacing, matches, seed)
    assert sorted({(int(v), int(u)) for v in y for u in x}) == sorted(expected)
    for i, j in np.ndindex(places.shape):
        assert divmod(int(places[i, j]), sample[1]) == expected[y[i], x[j]]


def test_neighboring_points_are_a_scale_apart_where_all_colors_differ():
    """With k = 1 and no two colors alike, tiles lie beside each other as in the sample."""
    pixels = np.arange(240, dtype=np.uint8).reshape(12, 20)[..., None]
    plain = windows_of(Exemplar(pixels, alpha=False), (0, 0, 0, 0), pixels)
    for seed in range(5):
        places, *_ = plant_seeds(plain, (8, 8), (False, False), 4, 1, seed)
        v, u = np.divmod(places, 20)
        assert (v[0] % 4 == 0).all() and (u[0] % 4 == 0).all()
        inside = u[:, :-1] < 16
        assert (np.diff(u, axis=1)[inside] == 4).all()


@pytest.mark.parametrize("seed", range(3))
def test_one_of_k_best_is_drawn(seed):
    pixels = noise((60, 60, 3))
    plain = windows_of(Exemplar(pixels), (0, 0, 0, 0), pixels)
    one, other = (plant_seeds(plain, (90, 90), (False, False), 6, k, seed)[0] for k in (1, 5))
    assert not np.array_equal(one, other)
    assert np.array_equal(one[0, 0], other[0, 0])  # of all tiles, whatever k
