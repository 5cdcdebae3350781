"""Patch-based sampling beside `brute_force`: zones, searches and what they lose."""

import numpy as np
import pytest

import weftex
from families import BLENDS, SEARCHES, WRAPS, noise


@pytest.mark.parametrize("wrap", WRAPS.values(), ids=WRAPS)
@pytest.mark.parametrize(
    "size, width", [(8, 4), (9, 4), (12, 6), (24, 12), (24, 5), (4, 2), (3, 1)]
)
def test_zones_on_either_side_of_a_patch_do_not_meet(rng, size, width, wrap):
    """A wrapped row's last patch has a zone at both ends; new pixels must join them to the rest."""
    exemplar = weftex.Exemplar(noise((size + 3, size + 4), rng=rng))
    method = weftex.PatchSampling(
        patch_size=size, boundary_width=width, epsilon=float("inf"), repeat_distance=0
    )
    model = method.fit(exemplar)
    for length in [*range(size, 2 * size + 2), 5 * size, 7 * size + 1]:
        canvas = weftex.Canvas(length, length + 3, wrap)
        result = model.sample(canvas, seed=1, threads=1)
        used = max(1, min(width, size // 4)) if any(wrap) else width
        for zone in set(result.placements[:, 4].tolist()):
            new = result.weights[zone] == 256
            assert new.any(axis=0).sum() >= used and new.any(axis=1).sum() >= used
            # One block: the zone's own parts are on its outside.
            rows, columns = (np.flatnonzero(new.any(axis=a)) for a in (1, 0))
            assert new[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all()


@pytest.mark.parametrize("search", SEARCHES[1:])
@pytest.mark.parametrize("blend", BLENDS)
def test_other_searches_only_choose_what_exhaustive_search_may(rng, search, blend):
    """With epsilon 0 and all windows as candidates they all take the nearest."""
    exemplar = weftex.Exemplar(noise((24, 25, 3), rng=rng))
    kind = {"patch_size": 8, "boundary_width": 2, "epsilon": 0.0, "blend": blend}
    exact = weftex.PatchSampling(search="exhaustive", **kind).fit(exemplar).sample(60, seed=3)
    model = weftex.PatchSampling(search=search, candidates=17 * 18, **kind).fit(exemplar)
    assert np.array_equal(model.sample(60, seed=3).placements, exact.placements)


def mismatch(result):
    """Mean squared difference, in the sample, of what a patch meets and what would go on."""
    pixels = result.sample.pixels.astype(float)
    meets, goes_on = result.source[:, 1:], result.source[:, :-1] + (0, 1)
    seam = (meets != goes_on).any(axis=2) & (goes_on[..., 1] < pixels.shape[1])
    found, usual = (pixels[at[seam][:, 0], at[seam][:, 1]] for at in (meets, goes_on))
    return ((found - usual) ** 2).mean()


def error(exemplar, size, **how):
    result = weftex.PatchSampling(repeat_distance=0.0, **how).fit(exemplar).sample(size, seed=1)
    return mismatch(result)


@pytest.mark.parametrize("search", SEARCHES[1:])
def test_other_searches_on_real_samples_lose_little(search):
    """Boundaries match nearly as well as exhaustive search makes them."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:96, :96])
    of = {"exemplar": exemplar, "size": 240, "patch_size": 24, "boundary_width": 4}
    best, worst = error(**of, epsilon=0.0, search="exhaustive"), error(**of, epsilon=float("inf"))
    assert error(**of, epsilon=0.0, search=search) - best < 0.25 * (worst - best)


@pytest.mark.pictures
def test_thinned_out_windows_lose_little(rng):
    """A large sample is looked at on a grid and then climbed; boundaries still match."""
    pebbles = weftex.load_exemplar("sample:pebbles").pixels
    exemplar = weftex.Exemplar(np.concatenate([pebbles, pebbles[::-1]])[:, :256])
    kind = {"patch_size": 32, "boundary_width": 8}
    model = weftex.PatchSampling(epsilon=0.0, repeat_distance=0.0, **kind).fit(exemplar)
    known = np.zeros((32, 32), bool)
    known[:8] = known[:, :8] = True
    assert model.analysis.zone_search(known, width=8).stride > 1
    of = {"exemplar": exemplar, "size": 300, **kind}
    best, worst = error(**of, epsilon=0.0, search="exhaustive"), error(**of, epsilon=float("inf"))
    assert error(**of, epsilon=0.0) - best < 0.25 * (worst - best)


def test_masks_that_leave_no_window_on_the_coarse_grid(rng):
    """Lines through the sample leave windows at odd rows only, which a coarse grid skips."""
    mask = np.ones((340, 340), bool)
    mask[::6] = False
    exemplar = weftex.Exemplar(noise((340, 340), rng=rng), mask=mask)
    model = weftex.PatchSampling(patch_size=5, boundary_width=2).fit(exemplar)
    result = model.sample(40, seed=1)
    assert mask[result.source[..., 0], result.source[..., 1]].all()


def test_sources_nearby_keep_their_distance(rng):
    """repeat_distance: what lies within two patches does not show the same thing again."""
    exemplar = weftex.load_exemplar("sample:pebbles")

    def repeats(distance):
        method = weftex.PatchSampling(patch_size=24, repeat_distance=distance)
        placements = method.fit(exemplar).sample((400, 400), seed=2).placements
        at, source = placements[:, :2], placements[:, 2:4]
        count = total = 0
        for k in range(1, len(at)):
            near = np.flatnonzero((np.abs(at[:k] - at[k]) < 44).all(axis=1))
            offset = source[near] - source[k]
            goes_on = (offset == at[near] - at[k]).all(axis=1)
            count += int(((np.abs(offset) < 12).all(axis=1) & ~goes_on).sum())
            total += len(near)
        return count / total

    assert repeats(0.5) < 0.2 * repeats(0.0)
