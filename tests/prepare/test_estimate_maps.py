"""Height and normals of a photo that has none."""

import numpy as np
import pytest

import weftex
from families import noise, refused
from weftex.prepare.estimating import estimate_maps


def hills():
    y, x = np.mgrid[:96, :96]
    return 0.5 + 0.2 * np.sin(2 * np.pi * x / 24) + 0.2 * np.cos(2 * np.pi * y / 32)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_brightness_is_height_and_normals_are_its(dtype):
    full = np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1
    sample = weftex.Exemplar((hills() * full).astype(dtype), tileable=True)
    maps = estimate_maps(sample, relief=10).maps
    height = maps["height"] / 65535
    assert np.corrcoef(height.ravel(), hills().ravel())[0, 1] > 0.99
    assert height.min() == 0 and height.max() == 1
    inverted = estimate_maps(sample, relief=10, invert=True).maps["height"] / 65535
    assert abs(height + inverted - 1).max() < 2e-5
    down, right = np.gradient(np.pad(10 * height, 1, "wrap"))
    expected = np.dstack([-right, down, np.ones(down.shape)])[1:-1, 1:-1]
    expected /= np.linalg.norm(expected, axis=2, keepdims=True)
    assert abs(maps["normal_gl"] / 127.5 - 1 - expected).max() < 0.02


def test_maps_of_a_set_follow_from_its_height_or_normals():
    stones = weftex.load_exemplar("sample:stone_wall")
    few = stones.changed(maps={"height": stones.map("height")})
    maps = estimate_maps(few, maps=["normal_dx", "ao"], relief=20, radius=9).maps
    high = stones.maps["height"]
    high = high if high.ndim == 2 else high[..., 0]
    normals = weftex.prepare.normals_from_height(high, 20, y_up=False)
    assert abs(maps["normal_dx"].astype(int) - normals).max() <= 1
    real = stones.maps["ao"].reshape(*stones.shape, -1)[..., 0]
    assert np.corrcoef(maps["ao"].ravel(), real.ravel())[0, 1] > 0.9
    few = stones.changed(maps={"normal_gl": stones.maps["normal"]})
    made = estimate_maps(few)
    assert sorted(made.maps) == ["ao", "height", "normal_gl", "roughness"]
    found, plain = (
        np.corrcoef(one.maps["height"].ravel(), high.ravel())[0, 1]
        for one in (made, estimate_maps(stones.pixels))
    )
    assert found > 0.7 > plain
    single = estimate_maps(stones.map("normal").changed(role="normal_gl"), maps=["height"])
    assert np.array_equal(single.maps["height"], made.maps["height"])


def test_maps_of_a_tile_wrap_around():
    tile = weftex.Exemplar((hills() * 255 + noise((96, 96)) / 9).astype(np.uint8), tileable=True)
    moved = tile.changed(pixels=np.roll(tile.pixels, (30, 50), (0, 1)))
    one, other = estimate_maps(tile).maps, estimate_maps(moved).maps
    assert sorted(one) == ["ao", "height", "normal_gl", "roughness"]
    for name, pixels in one.items():
        there = np.roll(pixels, (30, 50), (0, 1)).astype(int)
        assert abs(there - other[name]).max() <= (2 if name == "height" else 1), name


def test_light_joints_are_noticed():
    assert weftex.prepare.light_joints("sample:bricks")
    dark = weftex.load_exemplar("sample:bricks")
    assert not weftex.prepare.light_joints(dark.changed(pixels=255 - dark.pixels))
    for name in ("tiles", "weave", "pebbles"):
        assert not weftex.prepare.light_joints(f"sample:{name}")


def test_light_is_no_height():
    lit = hills() + np.linspace(0, 3, 96)
    found, plain = (estimate_maps(pixels).maps["height"] for pixels in (lit, hills()))
    inside = slice(16, -16), slice(16, -16)
    assert np.corrcoef(found[inside].ravel(), plain[inside].ravel())[0, 1] > 0.95


def test_a_flat_photo_is_flat():
    maps = estimate_maps(np.full((20, 30, 3), 90, np.uint8)).maps
    assert len(np.unique(maps["ao"])) == len(np.unique(maps["roughness"])) == 1
    assert len(np.unique(maps["height"])) == 1
    assert np.unique(maps["normal_gl"].reshape(-1, 3), axis=0).tolist() == [[128, 128, 255]]


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (3, 2, 4)])
def test_small_photos(shape):
    maps = estimate_maps(noise(shape)).maps
    assert maps["height"].shape == shape[:2]


@pytest.mark.parametrize(
    "sample, how, message",
    [
        (hills(), {"relief": 0}, "relief is 0; it must be above 0"),
        (hills(), {"relief": float("nan")}, "it must be above 0"),
        (hills(), {"relief": "6"}, "it must be above 0"),
        (hills(), {"invert": 1}, "invert is 1; it must be True or False"),
        (hills(), {"maps": ["hight"]}, "maps has 'hight'; did you mean 'height'"),
        (hills(), {"maps": ["ao"], "radius": 0.5}, "radius is 0.5; it must be 1 or more"),
        ("sample:stone_wall", {"maps": ["ao"]}, "has ao; leave ao out"),
        ("sample:stone_wall/normal", {"maps": ["roughness"]}, "no color to estimate roughness"),
        ("sample:stone_wall", {}, "already has color, ao, height, normal, roughness"),
    ],
)
def test_bad_input(sample, how, message):
    refused(message, estimate_maps, sample, **how)
