"""Patches that fill holes, against the slow twin."""

import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise
from twins.patch_sampling import compare

WRAPS = list(itertools.product([False, True], repeat=2))


def sampling(**more):
    kind = {"patch_size": 7, "boundary_width": 2, "search": "exhaustive"}
    return weftex.PatchSampling(**kind | more)


HOLES = {
    "square": lambda y, x: (y >= 6) & (y < 15) & (x >= 5) & (x < 16),
    "disc": lambda y, x: (y - 10) ** 2 + (x - 11) ** 2 < 40,
    "two": lambda y, x: ((y - 4) ** 2 + (x - 4) ** 2 < 8) | ((y - 15) ** 2 + (x - 16) ** 2 < 8),
    "corner": lambda y, x: y + x < 9,
    "border": lambda y, x: (y > 15) & (x > 3) & (x < 12),
    "stripe": lambda y, x: (x > 8) & (x < 12),
    "dots": lambda y, x: (y % 5 == 2) & (x % 6 == 3),
    "ring": lambda y, x: ((y - 10) ** 2 + (x - 10) ** 2 < 64) & ((y - 10) ** 2 + (x - 10) ** 2 > 9),
    "pixel": lambda y, x: (y == 0) & (x == 0),
    "nearly all": lambda y, x: (y > 0) | (x > 0),
}


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
@pytest.mark.parametrize("shape", HOLES)
@pytest.mark.parametrize(
    "patch_size, blend", [(7, "feather"), (7, "cut"), (7, "none"), (1, "none")]
)
def test_holes(rng, shape, wrap, patch_size, blend):
    hole = HOLES[shape](*np.indices((20, 21)))
    known = noise((20, 21, 3), values=16, rng=rng)
    exemplar = weftex.Exemplar(noise((14, 15, 3), values=16, rng=rng))
    canvas = weftex.Canvas(20, 21, wrap, known=known, hole=hole)
    result = compare(sampling(patch_size=patch_size, blend=blend), exemplar, canvas)
    assert np.array_equal(result.image[~hole], known[~hole])
    assert (result.source[hole] >= 0).all(), "all of the hole is filled"


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
@pytest.mark.parametrize("repeat_distance", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("blend", ["feather", "cut"])
@pytest.mark.parametrize("kind", [weftex.PatchSampling, weftex.Quilting])
def test_large_holes_keep_sources_apart(rng, wrap, repeat_distance, blend, kind):
    """Enough patches that some are further than two windows and more than eleven back."""
    y, x = np.indices((44, 46))
    hole = (y - 22) ** 2 + (x - 23) ** 2 < 400
    known = noise((44, 46), values=4, rng=rng)
    exemplar = weftex.Exemplar(noise((14, 15), values=4, rng=rng))
    loose = {"epsilon": 1.0} if kind is weftex.PatchSampling else {"tolerance": 0.5}
    method = kind(
        patch_size=7, boundary_width=2, search="exhaustive", blend=blend,
        repeat_distance=repeat_distance, **loose,
    )  # fmt: skip
    result = compare(method, exemplar, weftex.Canvas(44, 46, wrap, known=known, hole=hole))
    assert len(result.placements) > 40


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
