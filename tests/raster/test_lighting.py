"""A material in light from the side."""

import numpy as np
import pytest

import weftex
from materials import normal_map
from weftex.raster.lighting import lit


def test_what_faces_the_light_is_as_bright_as_the_color():
    color = np.random.default_rng(1).integers(0, 256, (6, 7, 3)).astype(np.uint8)
    flat = np.broadcast_to(np.array([0.5, 0.5, 1.0]), (6, 7, 3))
    assert abs(lit(color, normal=flat, light=(0, 0, 2)).astype(int) - color).max() <= 1
    assert lit(color, normal=flat, light=(1, 0, 0)).max() == 0
    # Lambert: in linear light half as much at 60 degrees.
    gray = np.full((2, 2), 255, np.uint8)
    half = lit(gray, normal=flat[:2, :2], light=(np.sqrt(3), 0, 1))
    assert abs(((half / 255 + 0.055) / 1.055) ** 2.4 - 0.5).max() < 0.01


def test_heights_and_their_normals_are_lit_alike(rng):
    y, x = np.mgrid[:40, :40]
    height = 0.5 + 0.4 * np.sin(x / 5) * np.cos(y / 7)
    down, across = np.gradient(16 * height)
    vectors = np.dstack([-across, down, np.ones(down.shape)])
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    gray = np.full((40, 40), 200, np.uint8)
    by_height, by_normal = lit(gray, height=height), lit(gray, normal=(vectors + 1) / 2)
    assert abs(by_height.astype(int) - by_normal).max() <= 1
    vectors[..., 1] *= -1
    assert np.array_equal(lit(gray, normal=(vectors + 1) / 2, directx=True), by_normal)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_types(rng, dtype):
    top = np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1
    made = lit((rng.random((5, 6, 4)) * top).astype(dtype), normal=normal_map(rng, (5, 6)))
    assert made.shape == (5, 6, 3) and made.dtype == np.uint8


def test_bad_input():
    gray = np.zeros((4, 4), np.uint8)
    with pytest.raises(weftex.InvalidInputError, match="give normal or height"):
        lit(gray)
    with pytest.raises(weftex.InvalidInputError, match="the map is 5x4, the color 4x4"):
        lit(gray, height=np.zeros((4, 5)))
