"""Seed points: the stochastic tiling of section 3."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import weftex
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


def test_a_seed_point_of_the_nearest_search_is_the_pixel_that_was_matched(rng):
    """Windows there are whole, so no tile has a corner nearer to the border of the sample."""
    exemplar = Exemplar(noise((40, 44), rng=rng))
    method = weftex.Refinement(search="nearest", init="seeds", window_width=9, seed_scale=6.0)
    level = method.fit(exemplar).prepared.levels[0]
    places, _, _ = plant_seeds(level.pyramid, (60, 60), (False, False), 6, 5, seed=1)
    taken = level.at(*np.divmod(level.pyramid.to_sample(places), 44))
    assert np.array_equal(
        level.pixels.reshape(-1)[taken], exemplar.pixels.ravel()[level.pyramid.to_sample(places)]
    )
