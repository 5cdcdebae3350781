"""Image quilting where it differs from patch-based sampling; see `brute_force` for the cut."""

import numpy as np
import pytest

import weftex


@pytest.mark.parametrize("search", ["quadtree", "pca", "kdtree", "kdtree-pca"])
def test_the_tolerance_holds_for_every_search(rng, search):
    """A candidate that was only measured until it was hopeless must not count as a good one.

    Sources that repeat are avoided here, so that the limit can rise after the measuring.
    """
    sample = (rng.integers(0, 256, (40, 40)) // 32 * 32).astype(np.uint8)
    kind = {"patch_size": 10, "boundary_width": 3, "tolerance": 1.0, "repeat_distance": 1.0}
    kind["blend"] = "none"
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
        assert chosen <= 2 * 1.7**0.5 * distance.min() * (1 + 1e-12)
    assert compared > 5


def test_its_own_defaults():
    method = weftex.Quilting()
    assert method.blend == "cut" and method.tolerance == 0.1
    model = weftex.Quilting(patch_size=36).fit(weftex.Exemplar(np.zeros((60, 60), np.uint8)))
    assert model.method.boundary_width == 6  # a sixth, as Efros and Freeman have it
