"""Height and normals of a photo that has none."""

import numpy as np
import pytest

import weftex
from families import noise
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


def test_light_is_no_height():
    lit = hills() + np.linspace(0, 3, 96)
    found, plain = (estimate_maps(pixels).maps["height"] for pixels in (lit, hills()))
    inside = slice(16, -16), slice(16, -16)
    assert np.corrcoef(found[inside].ravel(), plain[inside].ravel())[0, 1] > 0.95


def test_a_flat_photo_is_flat():
    maps = estimate_maps(np.full((20, 30, 3), 90, np.uint8)).maps
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
        ("sample:stone_wall", {}, "has height and normal; nothing"),
    ],
)
def test_bad_input(sample, how, message):
    with pytest.raises(weftex.InvalidInputError, match=message):
        estimate_maps(sample, **how)
