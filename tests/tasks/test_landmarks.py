"""Landmarks: what is found, what fills them, and how often outputs show them."""

import numpy as np
import pytest

import weftex
from weftex.prepare.landmarks import find_landmarks, has_joint_network, landmarks_shown_again
from weftex.tasks.landmarks import _Spacing, plain_sample, remove_landmarks

SIDE, AT = 128, (40, 70)
RED = [200, 40, 30]


def noise(side=SIDE, seed=0):
    """Brown grain without a lattice."""
    grain = np.random.default_rng(seed).normal(0, 1, (side + 8, side + 8))
    for axis in (0, 1):
        grain = sum(np.roll(grain, k, axis) for k in range(5))
    tone = 110 + 6 * np.clip(grain[:side, :side], -8, 8)  # without extremes, which are landmarks
    return np.clip(tone[..., None] * [1, 0.9, 0.75], 0, 255).astype(np.uint8)


def coarse(seed):
    """Grain of a seventh of the side; that of seed 0 looks the same from all sides."""
    return noise(70, seed).repeat(2, 0).repeat(2, 1)[:SIDE, :SIDE]


def with_spot(pixels=None, radius=7, color=RED):
    pixels = noise() if pixels is None else pixels
    y, x = np.indices(pixels.shape[:2])
    spot = (y - AT[0]) ** 2 + (x - AT[1]) ** 2 <= radius**2
    pixels = pixels.copy()
    pixels[spot] = color
    return pixels, spot


@pytest.fixture(scope="module")
def spotted():
    return weftex.Exemplar(with_spot()[0])


@pytest.fixture(scope="module")
def thinned(spotted):
    size = (3 * SIDE, 3 * SIDE)
    return weftex.synthesize(spotted, size, seed=1, tileable=True, landmarks="thin")


def red(pixels):
    """Where pixels are as red as the spot, whatever the tone correction did to them."""
    pixels = pixels.astype(int)
    return pixels[..., 0] - pixels[..., 1] > 80


def corners_of_spots(made):
    """Where outputs show the middle of the spot."""
    return np.argwhere((made.source == AT).all(axis=2))


@pytest.mark.parametrize("radius", [3, 6, 10])
def test_landmarks_of_any_size_are_found(radius):
    pixels, spot = with_spot(radius=radius)
    masks, rare = find_landmarks(weftex.Exemplar(pixels), others=False)
    assert rare == len(masks) == 1
    assert masks[0][spot].mean() > 0.9


def test_grain_lines_and_masked_pixels_are_no_rare_landmarks():
    line, (pixels, spot) = noise(), with_spot()
    line[60:64, 10:118] = RED
    for sample, mask in ((noise(), None), (line, None), (pixels, ~spot)):
        assert find_landmarks(weftex.Exemplar(sample, mask=mask))[1] == 0


def test_a_large_region_is_no_landmark():
    pixels, _ = with_spot(radius=20)
    masks, rare = find_landmarks(weftex.Exemplar(pixels))
    assert not any(mask[AT] for mask in masks[:rare])


@pytest.mark.parametrize("seed", range(3))
def test_joints_of_drawn_stones_are_a_network(seed):
    """Dark or bright ones on grain that is weaker than they; grain alone is none."""
    middles = np.random.default_rng(seed).uniform(0, SIDE, (20, 2))
    at = np.stack(np.indices((SIDE, SIDE)), axis=2)[..., None, :]
    near = np.sort(np.hypot(*np.moveaxis(at - middles, 3, 0)), axis=2)
    joint = near[..., 1] - near[..., 0] < 3
    for tone in (-60, 60):
        drawn = (noise(seed=seed) / 2 + 60 + tone * joint[..., None]).astype(np.uint8)
        assert has_joint_network(weftex.Exemplar(drawn))
    assert not has_joint_network(weftex.Exemplar(noise(seed=seed)))
    only = np.ones((SIDE, SIDE), bool)
    only[:, SIDE // 2 :] = False
    assert not has_joint_network(weftex.Exemplar(drawn, mask=only))


def test_together_landmarks_cover_a_limited_share():
    pixels = noise()
    for y in range(12, SIDE, 18):
        for x in range(12 + y % 7, SIDE, 18):
            pixels[y : y + 8, x : x + 8] = RED if (x + y) % 3 else [20, 30, 160]
    masks, rare = find_landmarks(weftex.Exemplar(pixels))
    assert sum(mask.sum() for mask in masks[:rare]) <= 0.10 * SIDE**2
    assert sum(mask.sum() for mask in masks) <= 0.27 * SIDE**2
    assert np.sum(masks, axis=0).max() <= 1 if masks else True


def test_a_large_sample_is_looked_at_in_a_smaller_copy():
    pixels, spot = with_spot()
    large = weftex.Exemplar(pixels.repeat(6, 0).repeat(6, 1)[:-3, :-5])
    masks, rare = find_landmarks(large, others=False)
    assert rare == 1 and masks[0].shape == large.shape
    assert masks[0][spot.repeat(6, 0).repeat(6, 1)[:-3, :-5]].mean() > 0.9


def test_removal_fills_the_spot_with_pixels_of_the_sample(spotted):
    plain = remove_landmarks(spotted)
    assert red(spotted.pixels).any() and not red(plain.pixels).any()
    same = (plain.pixels == spotted.pixels).all(axis=2)
    assert same.mean() > 0.9
    rows = {tuple(p) for p in spotted.pixels.reshape(-1, 3).tolist()}
    assert {tuple(p) for p in plain.pixels[~same].tolist()} <= rows


def test_removal_fills_maps_of_any_size_alike():
    pixels, spot = with_spot()
    occlusion = spot.repeat(2, 0).repeat(2, 1) * np.uint8(9)
    maps = {"height": spot.astype(np.uint16) * 900, "ao": occlusion}
    plain = remove_landmarks(weftex.Exemplar(pixels, maps=maps))
    assert not any(one.any() for one in plain.maps.values())
    assert plain.maps["ao"].shape == (2 * SIDE, 2 * SIDE)


def test_removed_landmarks_are_never_shown(spotted):
    made = weftex.synthesize(spotted, 2 * SIDE, seed=1, landmarks="remove")
    assert not red(made.image).any()
    assert made.provenance["landmarks"] == {"found": 1, "rare": 1, "shown": 0}


def test_a_thinned_landmark_is_shown_rarely_and_whole(thinned):
    shown = corners_of_spots(thinned)
    assert 1 <= len(shown) <= 9 // 4
    apart = np.abs(shown[:, None] - shown[None])
    apart = np.minimum(apart, 3 * SIDE - apart)
    far = np.hypot(*np.moveaxis(apart, 2, 0))
    assert (far[~np.eye(len(shown), dtype=bool)] >= SIDE).all()
    _, spot = with_spot()
    assert red(thinned.image).sum() == pytest.approx(len(shown) * spot.sum(), rel=0.1)


def test_kept_landmarks_are_shown_more_often(spotted, thinned):
    how = {"tileable": True, "landmarks": "keep"}
    kept = weftex.synthesize(spotted, (3 * SIDE, 3 * SIDE), seed=1, **how)
    assert len(corners_of_spots(kept)) > 2 * len(corners_of_spots(thinned))
    assert "landmarks" not in kept.provenance


@pytest.mark.parametrize("landmarks", ["thin", "remove"])
def test_sources_are_those_of_the_original_and_of_its_maps(landmarks):
    labels = np.arange(SIDE * SIDE, dtype=np.int32).reshape(SIDE, SIDE)
    ids = (labels % 251).astype(np.uint8)
    sample = weftex.Exemplar(with_spot()[0], maps={"id": ids}, weights={"id": 0})
    made = weftex.synthesize(sample, 200, seed=3, landmarks=landmarks, method="graphcut")
    y, x = np.moveaxis(made.source, 2, 0)
    assert (made.maps["id"] == ids[y, x]).all()


def test_half_turns_keep_sources_in_the_original():
    sample, spot = with_spot()
    method = weftex.GraphCut(placement="entire", orientations="half-turns", tone_reach=0)
    made = weftex.synthesize(sample, 300, seed=2, landmarks="thin", method=method)
    assert made.turn == "half" and made.provenance["landmarks"]["found"] >= 1
    y, x = np.moveaxis(made.source, 2, 0)
    assert (made.image == sample[y, x]).all()
    assert red(made.image).sum() in (spot.sum() * k for k in range(2))


@pytest.mark.parametrize("kind", ["gray", "float", "uint16", "alpha"])
def test_any_kind_of_pixels(kind):
    pixels, _ = with_spot()
    alpha = np.full((SIDE, SIDE, 1), 255, np.uint8)
    sample = {
        "gray": pixels[..., 1],
        "float": (pixels / 255).astype(np.float32),
        "uint16": pixels.astype(np.uint16) * 257,
        "alpha": np.concatenate([pixels, alpha], axis=2),
    }[kind]
    plain = remove_landmarks(weftex.load_exemplar(sample))
    assert plain.pixels.dtype == sample.dtype and plain.pixels.shape == sample.shape
    assert (plain.pixels[AT] != sample[AT]).any()


def test_threads_do_not_matter(spotted):
    one, three = (
        weftex.synthesize(spotted, 200, seed=4, landmarks="thin", threads=n).image for n in (1, 3)
    )
    assert (one == three).all()


def test_the_method_is_that_of_the_original(spotted):
    plain = plain_sample(spotted, "thin")
    model = weftex.Auto().fit(plain.exemplar)
    plain.inform(model)
    assert model.choose(256) == weftex.Auto().fit(spotted).choose(256)


def test_auto_thins_in_large_outputs_and_says_why(spotted, thinned):
    made = weftex.synthesize(spotted, (3 * SIDE, 3 * SIDE), seed=1, tileable=True)
    assert (made.image == thinned.image).all()
    assert made.provenance["reason"].endswith(
        "; landmarks are thinned, because the output has 9 times the sample's area"
    )


def test_in_smaller_outputs_only_rare_landmarks_are_thinned(spotted):
    made = weftex.synthesize(spotted, 2 * SIDE, seed=1).provenance
    assert "landmarks are thinned" in made["reason"]
    assert made["landmarks"]["found"] == made["landmarks"]["rare"] == 1


def test_auto_thins_what_is_coarser_if_it_looks_the_same_from_all_sides():
    reason = weftex.synthesize(with_spot(coarse(0))[0], 3 * SIDE, seed=1).provenance["reason"]
    assert "all sides; landmarks are thinned" in reason


@pytest.mark.parametrize(
    ("sample", "size", "how"),
    [
        (with_spot()[0], SIDE + 8, {}),
        (with_spot()[0], 3 * SIDE, {"method": "graphcut"}),
        (with_spot(noise(256) & 128)[0], 6 * SIDE, {}),  # quilting, as it has few colors
        (with_spot(coarse(1))[0], 3 * SIDE, {}),
    ],
)
def test_auto_keeps_landmarks_elsewhere(sample, size, how):
    made = weftex.synthesize(sample, size, seed=1, **how)
    assert "landmarks" not in made.provenance and "thinned" not in str(made.provenance)


def test_a_filling_shows_no_landmark_again(spotted):
    """But if the hole touches it, it may."""
    hole = np.pad(np.ones((40, 40), bool), ((20, SIDE - 60), (8, SIDE - 48)))
    for how, shows in (({"method": "graphcut", "placement": "entire"}, True), ({}, False)):
        assert red(weftex.fill(spotted, hole, seed=1, **how).image)[hole].any() == shows
    shifted = np.roll(np.arange(SIDE**2).reshape(SIDE, SIDE), -40, axis=1)
    asked = ((spotted, one, shifted, (False, False)) for one in (hole, np.roll(hole, 12, axis=1)))
    assert [landmarks_shown_again(*one) is None for one in asked] == [False, True]


def test_a_landmark_is_filled_from_one_whole_part(spotted):
    plain = plain_sample(spotted, "thin")
    for filling in plain.fillings:
        rows, columns = np.divmod(filling, SIDE)
        at = np.nonzero(plain.masks[0])
        shift = rows[at] - at[0], columns[at] - at[1]
        assert (shift[0] == shift[0][0]).all() and (shift[1] == shift[1][0]).all()
        assert not plain.masks[0][rows[at], columns[at]].any()


def test_masked_pixels_fill_no_landmark():
    pixels, _ = with_spot()
    mask = np.ones((SIDE, SIDE), bool)
    mask[:, 90:] = False
    plain = plain_sample(weftex.Exemplar(pixels, mask=mask), "thin")
    for filling in plain.fillings:
        assert (filling % SIDE < 90)[mask].all()


def test_mixed_patches_show_the_plain_sample(spotted):
    made = weftex.synthesize(spotted, 200, seed=1, landmarks="thin", method="patch-sampling")
    assert not red(made.image).any()


@pytest.mark.parametrize("sample", ["sample:tiles", np.full((64, 64, 3), 9, np.uint8)])
def test_lattices_and_flat_samples_stay(sample):
    exemplar = weftex.load_exemplar(sample)
    assert (remove_landmarks(exemplar).pixels == exemplar.pixels).all()


def test_best_of_keeps_thinning(spotted):
    made = weftex.synthesize(spotted, 200, seed=1, landmarks="thin", best_of=2, method="graphcut")
    assert made.provenance["landmarks"]["found"] >= 1
    assert len(made.provenance["best_of"]["scores"]) == 2


def test_pairs_of_neighbors_do_not_repeat_nearby():
    spacing = _Spacing(weftex.Canvas(1000, 1000), 100, 4, 0)
    assert spacing.take(0, 100, 100) and spacing.take(1, 100, 120)
    assert spacing.take(0, 100, 200)  # farther than its own distance
    assert not spacing.take(1, 100, 220)  # the same two, 100 px farther
    assert spacing.take(1, 100, 260)  # alone
    assert spacing.take(0, 400, 100) and spacing.take(1, 400, 120)


def test_distances_wrap_around():
    near = [_Spacing(weftex.Canvas(500, 500, (True, wraps)), 100, 4, 1) for wraps in (True, False)]
    assert all(one.take(0, 10, 5) for one in near)
    assert [one.take(0, 10, 490) for one in near] == [False, True]


def test_what_is_refused(spotted):
    with pytest.raises(weftex.InvalidInputError, match="must be one of auto, keep, thin, remove"):
        weftex.synthesize(spotted, 64, landmarks="some")
    with pytest.raises(weftex.InvalidInputError, match="it must be keep"):
        weftex.synthesize(weftex.prepare.turned(spotted, "half"), 64, landmarks="thin")
