"""Patch methods without options beyond the paper make the bytes of the references."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import weftex
from families import refused
from twins.seams import path_by_exhaustion
from weftex import reference
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.reference.image_quilting import minimum_error_boundary

SAMPLE = weftex.load_exemplar("sample:pebbles").pixels[:48, :46]
PAPERS = {"patch_size": 16, "boundary_width": 4, "search": "exhaustive", "repeat_distance": 0}


@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("epsilon", [0.0, 0.2])
@pytest.mark.parametrize(("size", "tileable"), [((40, 52), False), ((36, 48), True)])
def test_patch_based_sampling(size, tileable, epsilon, seed):
    expected = reference.patch_based_sampling(SAMPLE, size, 16, 4, epsilon, tileable, seed)
    model = weftex.PatchSampling(epsilon=epsilon, **PAPERS).fit(weftex.Exemplar(SAMPLE))
    result = model.sample(Canvas(*size, (tileable, tileable)), seed=seed)
    assert np.array_equal(result.image, expected.image)


def test_a_feathered_pixel_comes_from_the_larger_share():
    made = reference.patch_based_sampling(SAMPLE, (40, 52), 16, 4, seed=1)
    exact = (made.image == SAMPLE[tuple(np.moveaxis(made.sources, 2, 0))]).all(axis=2)
    inside = np.arange(52) % 12 >= 4
    assert exact[np.ix_(inside[:40], inside)].all()


@pytest.mark.parametrize("seed", range(12))
def test_image_quilting(seed):
    """On plain canvases that whole blocks cover, of random crops, sizes and tolerances."""
    rng = np.random.default_rng(seed)
    name = rng.choice(["bricks", "grass", "pebbles", "weave", "wood"])
    y, x = rng.integers(0, 100, 2)
    sample = weftex.load_exemplar(f"sample:{name}").pixels[y : y + 40, x : x + 44]
    block = int(rng.integers(6, 20))
    overlap = int(rng.integers(1, block // 2 + 1))
    tolerance = float(rng.choice([0.0, 0.1, 1.0]))
    size = [int(n) * (block - overlap) + overlap for n in rng.integers(1, 5, 2)]
    expected = reference.image_quilting(sample, size, block, overlap, tolerance, seed)
    parameters = PAPERS | {"patch_size": block, "boundary_width": overlap, "tolerance": tolerance}
    result = weftex.Quilting(**parameters).fit(weftex.Exemplar(sample)).sample(size, seed=seed)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, expected.sources)


@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.parametrize("gradients", [False, True])
def test_graphcut(gradients, seed):
    """By gradients with seeds whose costs are a metric: other cuts differ a little, see there."""
    sample, size = SAMPLE[:40, :44], (34, 38)
    expected = reference.graphcut(sample, size, 16, 5, gradients=gradients, seed=seed)
    method = weftex.GraphCut(
        patch_size=16,
        boundary_width=5,
        tolerance=0.003,
        candidates=1,
        halvings=0,
        variety=0,
        tone_reach=0,
        seam_cost="gradient" if gradients else "difference",
    )
    result = method.fit(weftex.Exemplar(sample)).sample(Canvas(*size), seed=seed)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, expected.sources)


@given(arrays(int, st.tuples(st.integers(1, 6), st.integers(1, 4)), elements=st.integers(0, 5)))
def test_a_boundary_is_the_cheapest_path(cost):
    assert minimum_error_boundary(cost).tolist() == path_by_exhaustion(cost)


def test_sizes_that_do_not_fit_are_refused():
    with pytest.raises(InvalidInputError, match="boundary is 9; it must be from 1 to 8"):
        reference.patch_based_sampling(SAMPLE, 40, 16, 9)
    with pytest.raises(InvalidInputError, match="size is 40; tileable sides must be"):
        reference.patch_based_sampling(SAMPLE, 40, 16, 4, tileable=True)
    refused("overlap is 16; it must be from 1 to 15", reference.image_quilting, SAMPLE, 40, 16, 16)
    refused("block is 47; it must be from 1 to 46", reference.image_quilting, SAMPLE, 40, 47, 16)
