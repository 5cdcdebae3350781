"""The sizes of patches and boundaries, and what is refused."""

import itertools
import re
from functools import partial

import numpy as np
import pytest

import weftex
from families import every, noise, refused


@every("method", family="patch")
def test_what_has_no_effect_is_refused(method):
    kind, exemplar = weftex.METHODS[method], weftex.Exemplar(np.zeros((60, 100), np.uint8))
    for one in ({"blend": "feather-at-end"}, {"repeat_distance": 1.5}):
        refused("no effect on patches of one pixel", kind(**one, patch_size=1).fit, exemplar)
    for done in ({}, {"blend": "none"}, {"repeat_distance": 0.0}):
        assert kind(patch_size=1, **done).fit(exemplar).method.patch_size == 1


def chessboard(period, shape):
    y, x = np.indices(shape)
    levels = 100 * (x % period < period // 2) + 100 * (y % period < period // 2)
    return weftex.Exemplar(levels.astype(np.uint8))


SHARES = [(weftex.PatchSampling, 0.3), (weftex.Quilting, 0.3), (weftex.GraphCut, 0.45)]


@pytest.mark.parametrize("kind, share", SHARES)
def test_patches_of_large_samples_follow_the_scale_of_their_things(kind, share):
    """A large sample of small things has patches of few things; one of large things, as ever."""

    def size(period, side=700):
        return kind().fit(chessboard(period, (side, 800))).method.patch_size

    assert size(12) == round(share * 512)
    assert share * 16.5 * 36 < size(17) < share * 17.5 * 36
    assert size(60) == round(share * 700)
    assert size(12, side=512) == round(share * 512)


@pytest.mark.parametrize("kind, share", SHARES)
def test_patches_are_no_larger_a_share_of_the_output_than_of_the_sample(kind, share):
    """Patches that suit a large sample would make a smaller picture of a few whole pieces of it."""
    exemplar = chessboard(60, (700, 800))
    model = kind().fit(exemplar)

    def told(model, *shape):
        return model.sample(shape, seed=1).provenance

    assert told(model, 700, 700)["patch_size"] == model.method.patch_size == round(share * 700)
    small = model.sample((600, 640), seed=1)
    sizes = {name: small.provenance[name] for name in ("patch_size", "boundary_width")}
    assert sizes["patch_size"] == round(share * 600)
    again = kind(**sizes).fit(exemplar).sample((600, 640), seed=1)
    assert np.array_equal(again.image, small.image)
    assert told(model, 100, 100)["patch_size"] == round(share * 512)
    # A size that is given stays, and so does a boundary: it takes half of a patch at most.
    assert told(kind(patch_size=300).fit(exemplar), 100, 100)["patch_size"] == 300
    wide = told(kind(boundary_width=100).fit(exemplar), 512, 90)
    assert wide["boundary_width"] == 100
    assert wide["patch_size"] == max(round(share * 512), 200)


@pytest.mark.parametrize("kind, name", [("PatchSampling", "epsilon"), ("Quilting", "tolerance")])
def test_where_everything_matches_what_matching_needs_is_refused(kind, name):
    kind = partial(getattr(weftex, kind), **{name: float("inf")})
    wrong = [{"search": "exhaustive"}, {"candidates": 9}, {"repeat_distance": 1}]
    if kind().slug == "patch-sampling":
        wrong.append({"choice": "similarity"})
    for given in wrong:
        refused("no effect where every window matches", kind, **given)
    sample = np.arange(3600, dtype=np.uint8).reshape(60, 60)
    hole = np.zeros((60, 60), bool)
    hole[20:40, 20:40] = True
    for done in ({}, {"repeat_distance": 0.0}):
        assert kind(**done).fit(sample).sample(70, seed=1).shape == (70, 70)
        assert weftex.fill(sample, hole, method=kind(**done), seed=1).shape == (60, 60)


@pytest.mark.parametrize("kind", [{"epsilon": 1.0}, {"epsilon": 5.0}, {"epsilon": 1e6}])
def test_a_wide_tolerance_draws_from_all_that_match(rng, kind):
    """Psi_B has nearly all windows then, not the 40 nearest alone."""
    sample = noise((60, 60), rng=rng)
    method = weftex.PatchSampling(patch_size=16, boundary_width=4, **kind)
    model = method.fit(weftex.Exemplar(sample))
    windows = np.lib.stride_tricks.sliding_window_view(sample.astype(int), (16, 4))[:, :45]
    ranks = []
    for seed in range(100):
        made = model.sample((16, 28), seed=seed)
        (y, x), (v, u) = made.placements[:, 2:4].tolist()
        known = sample[y : y + 16, x + 12 : x + 16].astype(int)
        distances = ((windows - known) ** 2).sum(axis=(2, 3))
        ranks.append((distances < distances[v, u]).mean())
    lower, median, upper = np.quantile(ranks, [0.25, 0.5, 0.75])
    assert 0.1 < lower < 0.4 and 0.35 < median < 0.65 and 0.6 < upper < 0.9


def test_a_wide_tolerance_draws_the_farthest_that_match_of_a_large_sample():
    """Of far more windows that match than the longest list of candidates has."""
    pebbles = weftex.load_exemplar("sample:pebbles").pixels[:160, :160].mean(axis=2)
    sample = np.block([[pebbles, pebbles[::-1]], [pebbles[:, ::-1], pebbles.T]]).astype(np.uint8)
    method = weftex.PatchSampling(patch_size=16, boundary_width=2, epsilon=1.0)
    model = method.fit(weftex.Exemplar(sample))
    placements = model.sample((16, 600), seed=1).placements[:, 1:4].tolist()
    windows = np.lib.stride_tricks.sliding_window_view(sample.astype(int), (16, 2))[:, :305]
    ranks = []
    for (before, v, u), (x, chosen_y, chosen_x) in itertools.pairwise(placements):
        known = sample[v : v + 16, u + x - before : u + x - before + 2].astype(int)
        distances = ((windows - known) ** 2).sum(axis=(2, 3))
        matching = distances[distances < (known**2).sum()]
        ranks.append((matching < distances[chosen_y, chosen_x]).mean())
    assert np.mean(np.array(ranks) > 0.75) > 0.1


@every("method", family="patch")
def test_results_say_which_sizes_were_used(method):
    """Settled for the sample, in the model's method and in what the result tells of itself."""
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8))
    for chosen in ({}, {"patch_size": 24}, {"boundary_width": 2}, {"patch_size": 1}):
        model = weftex.METHODS[method](**chosen).fit(exemplar)
        told = model.sample((70, 80), seed=1).provenance
        for name, sizes in (("patch_size", (18, 24, 1)), ("boundary_width", (2, 4))):
            assert told[name] == getattr(model.method, name) == chosen.get(name, told[name])
            assert told[name] in sizes
        again = weftex.METHODS[method](**{k: told[k] for k in ("patch_size", "boundary_width")})
        assert again.fit(exemplar).method == model.method


def test_samples_that_tile_must_hold_a_window_too():
    exemplar = weftex.Exemplar(np.zeros((9, 20), np.uint8), tileable=True)
    assert weftex.PatchSampling(patch_size=9).fit(exemplar).sample(30, seed=1).shape == (30, 30)
    for kind in ({"patch_size": 10}, {"patch_size": 1, "boundary_width": 5}):
        refused("20x9, smaller than the patch", weftex.PatchSampling(**kind).fit, exemplar)


def test_the_boundary_is_at_most_half_of_the_patch():
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8))
    method = weftex.PatchSampling(patch_size=21, boundary_width=10, candidates=50)
    assert method.fit(exemplar).method == method
    for kind in (weftex.PatchSampling, weftex.Quilting):
        refused("boundary_width is 11; .* 10", kind, patch_size=21, boundary_width=11)
    for size in range(2, 60):
        method = weftex.PatchSampling(patch_size=size).fit(exemplar).method
        assert 1 <= method.boundary_width <= size // 2


@every("method", family="patch")
def test_a_patch_larger_than_the_sample_names_the_largest(method):
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8), name="brick.png")
    with pytest.raises(weftex.InvalidInputError, match=r"brick\.png is 100x60, .* fits is 60"):
        weftex.METHODS[method](patch_size=61).fit(exemplar)
    refused("fits is 60", weftex.METHODS[method](patch_size=1, boundary_width=40).fit, exemplar)


@every("method", family="patch")
@pytest.mark.parametrize(
    ("side", "parameters", "said"),
    [
        (9, {}, "patch_size may be at most 9 (now 18)"),
        (2, {"patch_size": 3}, "patch_size may be at most 2 (now 3)"),
        (3, {"patch_size": 1}, "boundary_width may be at most 1 (now 4)"),
        (1, {"patch_size": 2}, "it has room for 1x1; a patch takes 2x2, a pixel and its zone 3x3"),
        (2, {"patch_size": 1}, "it has room for 2x2; a patch takes 2x2, a pixel and its zone 3x3"),
    ],
)
def test_what_would_fit_under_a_mask_is_named(method, side, parameters, said):
    mask = np.zeros((60, 100), bool)
    mask[5 : 5 + side, 7 : 7 + side] = True
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8), mask=mask)
    refused(re.escape(said), weftex.METHODS[method](**parameters).fit, exemplar)
    fitting = {"patch_size": side} if side > 1 else None
    if fitting and "boundary" not in said:
        weftex.METHODS[method](**fitting).fit(exemplar)
