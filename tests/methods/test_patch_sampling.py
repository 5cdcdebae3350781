"""Patch-based sampling against a slow twin of the whole paper, and step by step."""

import itertools

import numpy as np
import pytest

import weftex
from families import noise
from twins import patch_sampling as reference
from twins.patch_sampling import compare
from weftex.random import draw

BLENDS = ("feather", "feather-at-end", "cut", "none")
WRAPS = list(itertools.product([False, True], repeat=2))


def sampling(**more):
    kind = {"patch_size": 7, "boundary_width": 2, "search": "exhaustive"}
    return weftex.PatchSampling(**kind | more)


def mosaic():
    """Every window matches."""
    return weftex.PatchSampling(patch_size=7, boundary_width=2, epsilon=float("inf"))


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("choice", ["uniform", "similarity"])
@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("repeat_distance", [0.0, 0.5, 1.5])
def test_it_is_the_slow_twin(rng, wrap, choice, blend, repeat_distance):
    levels = 3 if repeat_distance else 256
    exemplar = weftex.Exemplar(noise((14, 15, 3), values=levels, rng=rng))
    method = sampling(blend=blend, choice=choice, repeat_distance=repeat_distance, epsilon=0.5)
    compare(method, exemplar, weftex.Canvas(19, 22, wrap))


@pytest.mark.parametrize("epsilon", [0.0, 0.05, 0.2, 1.0, 10.0])
@pytest.mark.parametrize("choice", ["uniform", "similarity"])
def test_every_tolerance(rng, epsilon, choice):
    exemplar = weftex.Exemplar(noise((14, 15), values=8, rng=rng))
    compare(sampling(epsilon=epsilon, choice=choice), exemplar, weftex.Canvas(19, 22))


def test_chaos_mosaic(rng):
    exemplar = weftex.Exemplar(noise((14, 15), values=8, rng=rng))
    compare(mosaic(), exemplar, weftex.Canvas(19, 22))


@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_every_depth(rng, dtype, channels):
    pixels = noise((14, 15, channels), rng=rng)
    pixels = pixels.astype(np.uint16) * 257 if dtype == np.uint16 else (pixels / 255).astype(dtype)
    exact = dtype != np.float32 or channels != 4  # the kernel weighs alpha in float32
    compare(sampling(), weftex.Exemplar(pixels), weftex.Canvas(19, 22), exact=exact)


def test_edges_maps_and_masks(rng):
    mask = np.ones((16, 17), bool)
    mask[9, 10] = False
    exemplar = weftex.Exemplar(
        noise((16, 17, 3), rng=rng), maps={"height": noise((16, 17), rng=rng)}, mask=mask
    )
    result = compare(sampling(edge_weight=1.0), exemplar, weftex.Canvas(19, 22))
    assert not (result.source == (9, 10)).all(axis=2).any()


@pytest.mark.parametrize("wrap", WRAPS)
def test_samples_that_tile(rng, wrap):
    exemplar = weftex.Exemplar(noise((9, 10, 3), rng=rng), tileable=True)
    result = compare(sampling(), exemplar, weftex.Canvas(30, 32, wrap))
    assert (result.placements[:, 2] > 2).any()  # windows hang over the border


def test_samples_that_tile_offer_each_window_once(rng):
    """B(x, y) for every (x, y) of the sample (section 2.4), on small canvases too."""
    exemplar = weftex.Exemplar(noise((9, 10), rng=rng), tileable=True)
    for seed in range(20):
        compare(mosaic(), exemplar, weftex.Canvas(5, 20), seed)


@pytest.mark.parametrize("size", [(7, 7), (8, 7), (3, 30), (30, 3), (1, 9), (2, 2), (12, 13)])
@pytest.mark.parametrize("wrap", WRAPS)
def test_small_canvases(rng, size, wrap):
    compare(sampling(), weftex.Exemplar(noise((14, 15), rng=rng)), weftex.Canvas(*size, wrap))


@pytest.mark.parametrize("size, width", [(8, 4), (8, 3), (9, 4), (4, 2), (2, 1), (3, 1)])
@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
@pytest.mark.parametrize("shape", [(9, 13), (17, 11), (25, 20)])
def test_wide_boundaries(rng, size, width, wrap, shape):
    """Up to half of the patch, where three patches may overlap."""
    method = sampling(patch_size=size, boundary_width=width)
    compare(method, weftex.Exemplar(noise((14, 15), rng=rng)), weftex.Canvas(*shape, wrap))


@pytest.mark.parametrize("wrap", WRAPS)
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
        used = reference.zone_width(method, canvas)
        assert used == width if not any(wrap) else used == max(1, min(width, size // 4))
        for zone in set(result.placements[:, 4].tolist()):
            new = result.weights[zone] == 256
            assert new.any(axis=0).sum() >= used and new.any(axis=1).sum() >= used
            # One block: the zone's own parts are on its outside.
            rows, columns = (np.flatnonzero(new.any(axis=a)) for a in (1, 0))
            assert new[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all()


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("width", [1, 2, 3])
def test_patches_of_one_pixel(rng, wrap, width):
    """Section 2.5: pixel-based nonparametric sampling with a window of 2 w_E + 1."""
    method = sampling(patch_size=1, boundary_width=width)
    exemplar = weftex.Exemplar(noise((10, 11, 2), values=16, rng=rng), alpha=False)
    result = compare(method, exemplar, weftex.Canvas(9, 8, wrap))
    assert result.placements.shape == (72, 5)
    # Only pixels with a whole window inside the sample.
    assert result.source.min() >= width
    assert (result.source < np.array(exemplar.shape) - width).all()


@pytest.mark.parametrize("canvas", [(2, 3), (4, 4), (1, 5)])
def test_windows_larger_than_a_wrapped_canvas(rng, canvas):
    method = sampling(patch_size=1, boundary_width=3)
    compare(
        method,
        weftex.Exemplar(noise((12, 12), values=16, rng=rng)),
        weftex.Canvas(*canvas, (True, True)),
    )


# Step by step


def test_similar_patches_are_drawn_more_often():
    """Frequencies of the similarity rule are the alpha_i of section 2.1 (5 sigma)."""
    keys, alpha = [0, 100, 400, 899, 901, 2500], 1 - np.sqrt([0, 100, 400, 899]) / 30
    alpha /= alpha.sum()
    how = {"marks": [""] * 6, "energy": 900, "epsilon": 1.0, "similarity": True}
    drawn = [reference.choose(keys, bits=draw(3, "patch", n), **how) for n in range(20000)]
    count = np.bincount(drawn, minlength=6)
    assert count[4:].sum() == 0
    assert (np.abs(count[:4] - 20000 * alpha) < 5 * np.sqrt(20000 * alpha * (1 - alpha)) + 1).all()


@pytest.mark.parametrize("search", ["quadtree", "pca", "kdtree", "kdtree-pca"])
@pytest.mark.parametrize("blend", BLENDS)
def test_other_searches_only_choose_what_exhaustive_search_may(rng, search, blend):
    """With epsilon 0 and all windows as candidates they all take the nearest."""
    exemplar = weftex.Exemplar(noise((24, 25, 3), rng=rng))
    kind = {"patch_size": 8, "boundary_width": 2, "epsilon": 0.0, "blend": blend}
    exact = weftex.PatchSampling(search="exhaustive", **kind).fit(exemplar).sample(60, seed=3)
    model = weftex.PatchSampling(search=search, candidates=17 * 18, **kind).fit(exemplar)
    assert np.array_equal(model.sample(60, seed=3).placements, exact.placements)


@pytest.mark.parametrize("search", ["quadtree", "pca", "kdtree", "kdtree-pca"])
def test_other_searches_on_real_samples_lose_little(search):
    """Boundaries match nearly as well as exhaustive search makes them."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:96, :96])
    kind = {"patch_size": 24, "boundary_width": 4, "repeat_distance": 0.0}

    def error(**more):
        result = weftex.PatchSampling(**kind, **more).fit(exemplar).sample(240, seed=1)
        return result.uncertainty().mean()

    best, worst = error(epsilon=0.0, search="exhaustive"), error(epsilon=float("inf"))
    assert error(epsilon=0.0, search=search) - best < 0.25 * (worst - best)


@pytest.mark.pictures
def test_thinned_out_windows_lose_little(rng):
    """A large sample is looked at on a grid and then climbed; boundaries still match."""
    exemplar = weftex.load_exemplar("sample:pebbles")
    pixels = np.concatenate([exemplar.pixels, exemplar.pixels[::-1]])[:, :256]
    kind = {"patch_size": 32, "boundary_width": 8, "repeat_distance": 0.0}
    model = weftex.PatchSampling(epsilon=0.0, **kind).fit(weftex.Exemplar(pixels))
    known = np.zeros((32, 32), bool)
    known[:8] = known[:, :8] = True
    assert model.analysis.search(known, width=8).stride > 1

    def error(**more):
        result = (
            weftex.PatchSampling(**kind, **more).fit(weftex.Exemplar(pixels)).sample(300, seed=1)
        )
        return result.uncertainty().mean()

    best, worst = error(epsilon=0.0, search="exhaustive"), error(epsilon=float("inf"))
    assert error(epsilon=0.0) - best < 0.25 * (worst - best)


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
