"""Patch-based sampling against a slow twin of the whole paper, and step by step."""

import itertools
import os
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
import weftex.methods.patches.scan_order
from families import every, noise
from twins import patch_sampling as reference
from weftex.methods.patches.scan_order import patch_starts, patches_around, wavefronts
from weftex.methods.patches.spiral_order import spiral
from weftex.random import draw

BLENDS = ("feather", "feather-at-end", "cut", "none")
WRAPS = list(itertools.product([False, True], repeat=2))


def compare(method, exemplar, canvas, seed=5, exact=True):
    result = method.fit(exemplar).sample(canvas, seed=seed)
    corners = None
    if canvas.hole is not None:
        reach = method.boundary_width if method.patch_size == 1 else 0
        corners = (result.placements[:, :2] - reach).tolist()
    placements, picture = reference.sample_exhaustive(
        exemplar, method, canvas, seed, corners=corners
    )
    assert [tuple(p) for p in result.placements[:, :4].tolist()] == placements
    if exact:
        assert np.array_equal(result.image, picture)
        assert np.array_equal(result.render(), picture)
    else:
        assert np.allclose(result.image, picture, rtol=1e-5)
    return result


def sampling(**more):
    kind = {"patch_size": 7, "boundary_width": 2, "search": "exhaustive"}
    return weftex.PatchSampling(**kind | more)


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("choice", ["uniform", "similarity"])
@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("repeat_distance", [0.0, 0.5, 1.5])
def test_it_is_the_slow_twin(rng, wrap, choice, blend, repeat_distance):
    levels = 3 if repeat_distance else 256
    exemplar = weftex.Exemplar(noise((14, 15, 3), values=levels, rng=rng))
    method = sampling(blend=blend, choice=choice, repeat_distance=repeat_distance, epsilon=0.5)
    compare(method, exemplar, weftex.Canvas(19, 22, wrap))


@pytest.mark.parametrize("epsilon", [0.0, 0.05, 0.2, 1.0, 10.0, float("inf")])
@pytest.mark.parametrize("choice", ["uniform", "similarity"])
def test_every_tolerance(rng, epsilon, choice):
    exemplar = weftex.Exemplar(noise((14, 15), values=8, rng=rng))
    compare(sampling(epsilon=epsilon, choice=choice), exemplar, weftex.Canvas(19, 22))


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
        compare(sampling(epsilon=float("inf")), exemplar, weftex.Canvas(5, 20), seed)


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


def test_a_holes_sources_keep_their_distance():
    exemplar = weftex.load_exemplar("sample:pebbles")
    y, x = np.indices((260, 260))
    hole = np.maximum(abs(y - 130), abs(x - 130)) < 110
    known = np.resize(exemplar.pixels, (260, 260, 3)).copy()

    def repeats(distance):
        method = weftex.PatchSampling(patch_size=24, repeat_distance=distance)
        canvas = weftex.Canvas(260, 260, known=known, hole=hole)
        placements = method.fit(exemplar).sample(canvas, seed=2).placements
        at, source = placements[:, :2], placements[:, 2:4]
        count = 0
        for k in range(1, len(at)):
            near = np.flatnonzero((np.abs(at[:k] - at[k]) < 40).all(axis=1))[-11:]
            offset = source[near] - source[k]
            goes_on = (offset == at[near] - at[k]).all(axis=1)
            count += int(((np.abs(offset) < 12).all(axis=1) & ~goes_on).sum())
        return count

    assert repeats(0.5) < 0.3 * repeats(0.0)


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("size", [(1, 1), (1, 6), (2, 2), (3, 9), (6, 6)])
def test_holes_in_canvases_smaller_than_a_patch(rng, size, wrap):
    hole = np.ones(size, bool)
    hole[0, -1] = size == (1, 1)
    known = noise((*size, 3), rng=rng)
    exemplar = weftex.Exemplar(noise((14, 15, 3), rng=rng))
    canvas = weftex.Canvas(*size, wrap, known=known, hole=hole)
    result = sampling().fit(exemplar).sample(canvas, seed=1)
    assert np.array_equal(result.image[~hole], known[~hole])
    assert (result.source[hole] >= 0).all()


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


# Step by step


def test_the_first_patch_is_any_window(rng):
    """Step 1, over many seeds: every window about equally often (chi-squared, 5 sigma)."""
    exemplar = weftex.Exemplar(noise((11, 12), rng=rng))
    model = sampling().fit(exemplar)
    counts = np.zeros((5, 6))
    for seed in range(1500):
        y, x = model.sample((7, 7), seed=seed).placements[0, 2:4]
        counts[y, x] += 1
    expected = 1500 / 30
    chi = ((counts - expected) ** 2 / expected).sum()
    assert abs(chi - 29) < 5 * (2 * 29) ** 0.5


@given(st.lists(st.floats(0, 10), min_size=1, max_size=20), st.floats(0, 3))
def test_the_set_psi_b(distances, d_max):
    """The twin's own choice among whole numbers agrees with equation (1) in its own terms."""
    area = 7
    keys = [round(area * (10 * d) ** 2) for d in distances]
    energy = area * 100**2
    epsilon = d_max / 10
    exact = [(k / area) ** 0.5 for k in keys]
    limit = epsilon * (energy / area) ** 0.5
    if any(abs(d - limit) < 1e-9 * (1 + limit) for d in exact):
        return
    allowed = set(reference.psi_b(exact, limit))
    marks = [""] * len(keys)
    chosen = {
        reference.choose(keys, marks, energy, draw(n, "x", 0), epsilon=epsilon) for n in range(200)
    }
    assert chosen <= allowed
    if len(allowed) <= 8:
        assert chosen == allowed


@pytest.mark.pictures
def test_similar_patches_are_drawn_more_often():
    """Frequencies of the similarity rule are the alpha_i of section 2.1 (5 sigma)."""
    keys, energy, epsilon = [0, 100, 400, 899, 901, 2500], 900, 1.0
    alpha = reference.similarity_weights([k**0.5 for k in keys[:4]], 30.0)
    count = np.zeros(6)
    for n in range(20000):
        bits = draw(3, "patch", n)
        count[reference.choose(keys, [""] * 6, energy, bits, epsilon=epsilon, similarity=True)] += 1
    assert count[4:].sum() == 0
    spread = np.sqrt(20000 * alpha * (1 - alpha)) + 1e-9
    assert (np.abs(count[:4] - 20000 * alpha) < 5 * spread + 1).all()


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
        return result.draw("error").astype(float).mean()

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
    assert model.analysis.structure(known, width=8).stride > 1

    def error(**more):
        result = (
            weftex.PatchSampling(**kind, **more).fit(weftex.Exemplar(pixels)).sample(300, seed=1)
        )
        return result.draw("error").astype(float).mean()

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


# Parameters


def test_patch_size_follows_the_randomness_parameter():
    """w_B = lambda min(w_in, h_in), section 2.4."""
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8))
    for share in (0.25, 0.5, 1.0):
        method = weftex.PatchSampling(randomness=share).fit(exemplar).method
        assert method.patch_size == round(60 * share)
    method = weftex.PatchSampling(randomness=0.3, patch_size=20).fit(exemplar).method
    assert method.patch_size == 20


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


@pytest.mark.parametrize("threads", [0, -1, 1.0, "2", True, float("nan")])
def test_bad_thread_counts_are_refused(threads):
    model = sampling().fit(weftex.Exemplar(np.zeros((20, 20), np.uint8)))
    with pytest.raises(weftex.InvalidInputError, match="threads is"):
        model.sample((30, 30), seed=1, threads=threads)


def test_samples_that_tile_must_hold_a_window_too():
    exemplar = weftex.Exemplar(np.zeros((9, 20), np.uint8), tileable=True)
    assert sampling(patch_size=9).fit(exemplar).sample(30, seed=1).shape == (30, 30)
    for kind in ({"patch_size": 10}, {"patch_size": 1, "boundary_width": 5}):
        with pytest.raises(weftex.InvalidInputError, match="20x9, smaller than the window"):
            sampling(**kind).fit(exemplar)


@pytest.mark.parametrize("search", ["exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca"])
def test_structures_for_holes_are_not_kept(rng, search):
    """Each hole has its own; a model that fills many must not grow."""
    exemplar = weftex.Exemplar(noise((24, 25), rng=rng))
    model = weftex.PatchSampling(patch_size=8, boundary_width=2, search=search).fit(exemplar)
    model.sample((40, 40), seed=1)
    model.sample((40, 40), seed=1, tileable=True)
    kept = len(model.analysis._structures)
    assert len(pickle.dumps(model)) < 40000
    for seed in range(3):
        hole = rng.random((40, 41)) < 0.1
        canvas = weftex.Canvas(40, 41, known=noise((40, 41), rng=rng), hole=hole)
        model.sample(canvas, seed=seed)
    assert len(model.analysis._structures) == kept


def test_the_boundary_is_at_most_half_of_the_patch():
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8))
    method = weftex.PatchSampling(patch_size=21, boundary_width=10)
    assert method.fit(exemplar).method == method
    with pytest.raises(weftex.InvalidInputError, match="boundary_width is 11; .* 10"):
        weftex.PatchSampling(patch_size=21, boundary_width=11).fit(exemplar)
    for size in range(2, 60):
        method = weftex.PatchSampling(patch_size=size).fit(exemplar).method
        assert 1 <= method.boundary_width <= size // 2


@every("method", family="patch")
def test_a_patch_larger_than_the_sample_names_the_largest(method):
    exemplar = weftex.Exemplar(np.zeros((60, 100), np.uint8), name="brick.png")
    with pytest.raises(weftex.InvalidInputError, match=r"brick\.png is 100x60, .* fits is 60"):
        weftex.METHODS[method](patch_size=61).fit(exemplar)
    with pytest.raises(weftex.InvalidInputError, match="fits is 60"):
        weftex.METHODS[method](patch_size=1, boundary_width=40).fit(exemplar)


def test_a_mask_without_room_for_a_patch_is_refused():
    mask = np.zeros((60, 100), bool)
    mask[:9, :9] = True
    with pytest.raises(weftex.InvalidInputError, match="no 10x10 window lies in the usable part"):
        weftex.PatchSampling(patch_size=10).fit(
            weftex.Exemplar(np.zeros((60, 100), np.uint8), mask=mask)
        )


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True])
def test_bad_threads_are_refused(threads):
    with pytest.raises(weftex.InvalidInputError, match="threads is"):
        weftex.synthesize(np.zeros((40, 40), np.uint8), 40, seed=1, threads=threads)


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


# Orders


@given(st.integers(1, 300), st.integers(2, 60), st.booleans(), st.data())
def test_patches_cover_an_axis_evenly(length, size, wrap, data):
    size = min(size, length)
    overlap = data.draw(st.integers(0 if size == 1 else 1, max(size // 2, 0)))
    if size - overlap < 1:
        return
    starts = patch_starts(length, size, overlap, wrap)
    assert starts[0] == 0 and starts == sorted(starts)
    if length > 1:
        assert len(set(starts)) == len(starts)
    ends = [*starts[1:], length] if wrap else starts[1:]
    steps = [b - a for a, b in zip(starts, ends, strict=False)]
    assert all(step <= size - overlap for step in steps)  # at least the overlap, so all covered
    assert max(steps, default=0) - min(steps, default=0) <= 1
    if not wrap:
        assert starts[-1] + size == max(length, size)
    if length > 1:
        assert starts == reference.patch_starts(length, size, overlap, wrap)
    fewer = len(starts) - 1
    if wrap and fewer > 1:
        assert fewer * (size - overlap) < length
    elif not wrap and fewer > 0:
        assert (fewer - 1) * (size - overlap) + size < length


@pytest.mark.parametrize("length", [1, 2, 16])
@pytest.mark.parametrize("rows, columns", [(1, 1), (1, 40), (40, 1), (20, 40), (40, 3), (35, 17)])
def test_wavefronts_cover_the_grid_once(rows, columns, length):
    cells = [
        (row, column)
        for group in wavefronts(rows, columns, length)
        for row, first, last in group
        for column in range(first, last)
    ]
    assert sorted(cells) == list(itertools.product(range(rows), range(columns)))


@pytest.mark.parametrize("length", [1, 2, 16])
@pytest.mark.parametrize("rows, columns", [(20, 40), (40, 3), (35, 17), (70, 20)])
def test_wavefronts_keep_the_documented_order(rows, columns, length):
    """Left, upper left, upper and upper right neighbors are in earlier groups or pieces."""
    when, piece = {}, {}
    for n, group in enumerate(wavefronts(rows, columns, length)):
        for row, first, last in group:
            for column in range(first, last):
                when[row, column], piece[row, column] = n, (n, row, first)
    for (i, j), n in when.items():
        for a, b in ((i, j - 1), (i - 1, j - 1), (i - 1, j), (i - 1, j + 1)):
            if (a, b) in when:
                assert when[a, b] < n or piece[a, b] == piece[i, j]


@pytest.mark.parametrize("blend", ["feather", "cut"])
@pytest.mark.parametrize(
    "shape, size, overlap",
    [((203, 203), 8, 4), ((500, 203), 8, 2), ((5000, 45), 24, 4), ((45, 5000), 24, 4),
     ((403, 403), 20, 10), ((1800, 35), 12, 6)],
)  # fmt: skip
def test_threads_never_overtake_a_patch_that_overlaps(
    monkeypatch, rng, shape, size, overlap, blend
):
    """What threads may lay at once shares no pixel, and order is kept where patches do."""
    groups = []

    def note(*args, **more):
        for group in wavefronts(*args, **more):
            groups.append(group)
            yield group

    monkeypatch.setattr(weftex.methods.patches.scan_order, "wavefronts", note)
    method = weftex.PatchSampling(
        patch_size=size, boundary_width=overlap, epsilon=float("inf"), blend=blend
    )
    result = method.fit(weftex.Exemplar(noise((40, 40), rng=rng))).sample(shape, seed=1, threads=2)
    assert groups, "threads were not used"
    at = result.placements[:, :2].astype(int)
    columns = len(np.unique(at[:, 1]))
    when, piece = np.empty(len(at), int), np.empty(len(at), int)
    pieces = [(n, *one) for n, group in enumerate(groups) for one in group]
    for k, (n, row, first, last) in enumerate(pieces):
        when[row * columns + first : row * columns + last] = n
        piece[row * columns + first : row * columns + last] = k
    late = []
    for p in range(len(at)):
        earlier = np.arange(max(0, p - 4 * columns), p)
        touch = earlier[(np.abs(at[earlier] - at[p]) < size).all(axis=1)]
        wrong = (when[touch] > when[p]) | ((when[touch] == when[p]) & (piece[touch] != piece[p]))
        late += [(p, int(q)) for q in touch[wrong]]
    assert late == []


def test_patches_around_are_laid_earlier_under_any_wavefront():
    rows, columns = 20, 21
    around = patches_around(rows, columns)
    assert around.shape[0] == rows * columns
    for n, row in enumerate(around):
        i, j = divmod(n, columns)
        found = [divmod(k, columns) for k in row.tolist() if k >= 0]
        expected = [(i + a, j + b) for a, b in reference.AROUND]
        assert found == [(a, b) for a, b in expected if a >= 0 and 0 <= b < columns]


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**30))
def test_spirals_visit_each_cell_once_from_the_border_inwards(rows, columns, seed):
    cells = np.random.default_rng(seed).random((rows, columns)) < 0.7
    walked = list(spiral(cells))
    assert sorted(walked) == [tuple(c) for c in np.argwhere(cells).tolist()]
    if cells.all():
        depth = [min(y, x, rows - 1 - y, columns - 1 - x) for y, x in walked]
        assert depth == sorted(depth)
        steps = [abs(a - c) + abs(b - d) for (a, b), (c, d) in itertools.pairwise(walked)]
        assert all(step == 1 for step in steps)


# Threads


@pytest.mark.parametrize(
    "kind",
    [
        {"patch_size": 8, "boundary_width": 2},
        {"patch_size": 8, "boundary_width": 4},
        {"patch_size": 12, "boundary_width": 3, "blend": "cut"},
        {"patch_size": 8, "boundary_width": 2, "search": "quadtree", "repeat_distance": 0.0},
    ],
    ids=str,
)
@pytest.mark.parametrize("shape", [(260, 260), (1500, 33), (150, 401)])
@pytest.mark.parametrize("wrap", [(False, False), (True, False), (True, True)])
def test_threads_do_not_change_a_byte(rng, kind, shape, wrap):
    model = weftex.PatchSampling(**kind).fit(weftex.Exemplar(noise((40, 40), rng=rng)))
    one = model.sample(weftex.Canvas(*shape, wrap), seed=1, threads=1)
    assert len(one.placements) >= 300
    for threads in (2, 4):
        other = model.sample(weftex.Canvas(*shape, wrap), seed=1, threads=threads)
        assert np.array_equal(other.placements, one.placements)
        assert np.array_equal(other.image, one.image)


def test_threads_are_really_used(monkeypatch, rng):
    """Or the test above would compare one thread with itself."""
    import concurrent.futures
    import threading

    seen = set()

    class Pool(concurrent.futures.ThreadPoolExecutor):
        def submit(self, work, *args, **more):
            def note(*a, **m):
                seen.add(threading.get_ident())
                return work(*a, **m)

            return super().submit(note, *args, **more)

    monkeypatch.setattr(concurrent.futures, "ThreadPoolExecutor", Pool)
    model = weftex.PatchSampling(patch_size=8, boundary_width=2).fit(
        weftex.Exemplar(noise((40, 40), rng=rng))
    )
    model.sample((500, 500), seed=1, threads=4)
    assert len(seen) > 1
    seen.clear()
    model.sample((500, 500), seed=1, threads=1)
    assert not seen


def test_by_default_there_are_as_many_threads_as_processors():
    assert (os.cpu_count() or 1) >= 1
    sample = np.random.default_rng(0).integers(0, 256, (40, 40)).astype(np.uint8)
    model = weftex.PatchSampling(patch_size=8, boundary_width=2).fit(weftex.Exemplar(sample))
    one = model.sample((200, 200), seed=1, threads=1)
    assert np.array_equal(model.sample((200, 200), seed=1).image, one.image)
