"""Patches that fill holes; see `brute_force` for each patch."""

import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise

WRAPS = list(itertools.product([False, True], repeat=2))


@given(st.data())
def test_random_holes_are_filled_and_nothing_else(data):
    rng = np.random.default_rng(data.draw(st.integers(0, 2**30)))
    size = data.draw(st.tuples(st.integers(8, 30), st.integers(8, 30)))
    hole = rng.random(size) < data.draw(st.sampled_from([0.01, 0.2, 0.9]))
    hole.ravel()[int(rng.integers(hole.size))] = True
    hole.ravel()[int(rng.integers(hole.size))] = False
    wrap = data.draw(st.sampled_from(WRAPS))
    patch_size = data.draw(st.sampled_from([1, 6, 8]))
    known = noise((*size, 3), rng=rng)
    exemplar = weftex.Exemplar(noise((12, 13, 3), rng=rng))
    canvas = weftex.Canvas(*size, wrap, known=known, hole=hole)
    method = weftex.PatchSampling(patch_size=patch_size, boundary_width=2)
    result = method.fit(exemplar).sample(canvas, seed=1)
    assert np.array_equal(result.image[~hole], known[~hole])
    assert (result.source[hole] >= 0).all()


@pytest.mark.parametrize("search", ["exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca"])
def test_structures_for_holes_are_not_kept(rng, search):
    """Each hole has its own; a model that fills many must not grow."""
    exemplar = weftex.Exemplar(noise((24, 25), rng=rng))
    model = weftex.PatchSampling(patch_size=8, boundary_width=2, search=search).fit(exemplar)
    model.sample((40, 40), seed=1)
    model.sample((40, 40), seed=1, tileable=True)
    kept = len(model.analysis._searches)
    assert len(pickle.dumps(model)) < 40000
    for seed in range(3):
        hole = rng.random((40, 41)) < 0.1
        canvas = weftex.Canvas(40, 41, known=noise((40, 41), rng=rng), hole=hole)
        model.sample(canvas, seed=seed)
    assert len(model.analysis._searches) == kept
