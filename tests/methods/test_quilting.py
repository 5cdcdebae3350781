"""Image quilting against a slow twin, and where it differs from patch-based sampling."""

import itertools

import numpy as np
import pytest

import weftex
from twins import patch_sampling as reference


@pytest.mark.parametrize("blend", ["cut", "feather", "feather-at-end", "none"])
@pytest.mark.parametrize("repeat_distance", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("wrap", list(itertools.product([False, True], repeat=2)))
def test_it_is_the_slow_twin(rng, blend, repeat_distance, wrap):
    levels = 4 if repeat_distance else 256
    sample = (rng.integers(0, levels, (15, 14, 2)) * (255 // levels)).astype(np.uint8)
    method = weftex.Quilting(
        patch_size=7, boundary_width=2, blend=blend, repeat_distance=repeat_distance,
        search="exhaustive",
    )  # fmt: skip
    exemplar, canvas = weftex.Exemplar(sample, alpha=False), weftex.Canvas(22, 19, wrap)
    result = method.fit(exemplar).sample(canvas, seed=5)
    placements, picture = reference.sample_exhaustive(exemplar, method, canvas, 5)
    assert [tuple(p) for p in result.placements[:, :4].tolist()] == placements
    assert np.array_equal(result.image, picture)


@pytest.mark.parametrize("search", ["quadtree", "pca", "kdtree", "kdtree-pca"])
def test_the_tolerance_holds_for_every_search(rng, search):
    """A candidate that was only measured until it was hopeless must not count as a good one.

    Sources that repeat are avoided here, so that the limit can rise after the measuring.
    """
    sample = (rng.integers(0, 256, (40, 40)) // 32 * 32).astype(np.uint8)
    kind = {
        "patch_size": 10,
        "boundary_width": 3,
        "tolerance": 1.0,
        "repeat_distance": 1.0,
        "blend": "none",
    }
    method = weftex.Quilting(search=search, candidates=800, **kind)
    result = method.fit(weftex.Exemplar(sample)).sample((10, 200), seed=1)
    windows = np.lib.stride_tricks.sliding_window_view(sample.astype(int), (10, 10))
    placements = result.placements[:, 1:4].tolist()
    compared = 0
    for n in range(2, len(placements)):
        (x0, y, x), (x1, sy, sx) = placements[n - 1 : n + 1]
        if x1 - x0 != 7:
            continue
        distance = np.sqrt(((windows[..., :3] - windows[y, x][:, 7:]) ** 2).sum(axis=(2, 3)))
        chosen = distance[sy, sx]
        for before, v, u in placements[n - 2 : n]:  # these may be forbidden to go on
            if u + x1 - before < 31:
                distance[v, u + x1 - before] = np.inf
        compared += 1
        # Variety may cost a little over the best, and the tolerance doubles that.
        assert chosen <= 2 * reference.VARIETY**0.5 * distance.min() * (1 + 1e-12)
    assert compared > 5


def test_its_own_defaults():
    method = weftex.Quilting()
    assert method.blend == "cut" and method.tolerance == 0.1
    model = weftex.Quilting(patch_size=36).fit(weftex.Exemplar(np.zeros((60, 60), np.uint8)))
    assert model.method.boundary_width == 6  # a sixth, as Efros and Freeman have it
