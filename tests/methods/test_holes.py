"""What fills holes; see `brute_force` for each patch and pixel."""

import pickle

import numpy as np
import pytest

import weftex
from families import SEARCHES, noise


@pytest.mark.parametrize("search", SEARCHES)
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


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        ("exact-matching", {}),
        ("exact-matching", {"window_width": 5}),
        ("refinement", {"window_width": 13}),
        ("refinement", {"window_width": 13, "init": "seeds"}),
        ("refinement", {"window_width": 13, "search": "nearest"}),
        ("wei-levoy", {}),
    ],
)
def test_a_texture_that_repeats_goes_on_in_a_hole(method, parameters):
    photo = np.tile(noise((8, 9, 3)), (8, 8, 1))
    hole = np.zeros(photo.shape[:2], bool)
    hole[20:40, 25:44] = True
    broken = np.where(hole[..., None], 0, photo).astype(np.uint8)
    assert (weftex.fill(broken, hole, method=method, seed=1, **parameters).image == photo).all()
