"""Models that fill holes; see `brute_force` for each patch."""

import pickle

import pytest

import weftex
from families import noise


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
