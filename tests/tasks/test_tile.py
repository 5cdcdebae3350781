"""Photos made tileable."""

import numpy as np
import pytest

import weftex
from materials import wall


def photo():
    return weftex.load_exemplar("sample:pebbles").pixels[:160, :200]


def jump(pixels, axis):
    """Mean step across the border over the mean step elsewhere."""
    around = np.concatenate([pixels, pixels.take([0], axis)], axis)
    steps = abs(np.diff(around.astype(int), axis=axis))
    means = steps.mean(axis=tuple(k for k in range(steps.ndim) if k != axis))
    return means[-1] / means[:-1].mean()


@pytest.mark.parametrize("method", ["auto", "patch-sampling", "quilting", "graphcut"])
def test_the_middle_stays_and_the_border_fits(method):
    pixels = photo()
    result = weftex.tile(pixels, seed=1, method=method)
    made = result.image
    assert made.shape == pixels.shape
    assert np.array_equal(made[20:-20, 20:-20], pixels[20:-20, 20:-20])
    for axis in (0, 1):
        assert jump(made, axis) < 1.3 < 1.5 < jump(pixels, axis)
    if method == "graphcut":  # cuts run anywhere in the border, not along one of its edges
        for columns, most in ((slice(18, 20), 0.25), (slice(2, 8), 0.9)):
            assert result.canvas.hole[:, columns].mean() < most


@pytest.mark.parametrize("axes, axis", [("y", 0), ("x", 1)])
def test_one_axis(axes, axis):
    pixels = photo()
    result = weftex.tile(pixels, axes=axes, border=24, seed=1)
    assert result.canvas.hole.take(range(-8, 8), axis).all()
    keep = tuple(slice(24, -24) if k == axis else slice(None) for k in (0, 1))
    assert np.array_equal(result.image[keep], pixels[keep])
    assert jump(result.image, axis) < 1.3 < jump(result.image, 1 - axis)


def test_maps_come_along():
    sample = weftex.load_exemplar("sample:stone_wall")
    for name, map_ in weftex.tile(sample, seed=2).maps.items():
        border = min(sample.shape) // 8
        inside = slice(border, -border), slice(border, -border)
        assert np.array_equal(map_[inside], sample.maps[name][inside])


def test_a_size_that_whole_tiles_fit_into_is_named():
    warnings = weftex.tile(wall(160, 200), seed=1).provenance["warnings"]
    assert any("crop the photo first" in w for w in warnings)
    whole = weftex.tile(wall(144, 192), seed=1)
    assert not any("crop" in w for w in whole.provenance.get("warnings", ()))


@pytest.mark.parametrize(
    "how, message",
    [
        ({"border": 0}, "border is 0; for 192x160 it must be from 1 to 53"),
        ({"border": 54}, "from 1 to 53"),
        ({"border": 2.5}, "a whole number of pixels"),
        ({"border": True}, "a whole number of pixels"),
        ({"axes": False}, "axes is False; it must be True, 'x' or 'y'"),
        ({"axes": "z"}, "'z'"),
        ({"method": "best-til"}, "best-til"),
    ],
)
def test_bad_input(how, message):
    with pytest.raises(weftex.InvalidInputError, match=message):
        weftex.tile(photo(), **how)


@pytest.mark.parametrize("shape", [(3, 3), (9, 40), (1, 1)])
def test_tiny_photos_are_tiled_or_refused(rng, shape):
    pixels = rng.integers(0, 256, shape).astype(np.uint8)
    try:
        made = weftex.tile(pixels, seed=1).image
    except weftex.WeftexError as error:
        assert "\n" not in str(error)
    else:
        assert made.shape == shape
