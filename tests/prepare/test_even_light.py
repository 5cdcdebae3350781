"""Light that falls off is divided away; what a material shows by itself stays."""

import numpy as np
import pytest

import weftex
from weftex.analysis.properties import evenness
from weftex.prepare import even_light, lighting
from weftex.prepare.lighting import _linear, _stored

NAMES = ("pebbles", "bricks", "weave", "grass", "leaves")


def lit(exemplar, light):
    """The photo of the same material in another light."""
    pixels = exemplar.pixels.reshape(*exemplar.shape, -1)
    planes = [_stored(_linear(plane) * light, pixels.dtype) for plane in np.moveaxis(pixels, 2, 0)]
    return exemplar.changed(pixels=np.stack(planes, axis=2).reshape(exemplar.pixels.shape))


def lamp(shape):
    """Brightest at the lower right, dark corners."""
    y, x = (np.linspace(-1, 1, side) for side in shape)
    light = np.exp(0.4 * x - 0.3 * x**2 + 0.3 * y[:, None] - 0.3 * y[:, None] ** 2)
    return light / light.max()


@pytest.mark.parametrize("name", NAMES)
def test_the_light_is_gone_and_the_material_is_as_before(name):
    sample = weftex.load_exemplar(f"sample:{name}")
    dark = lit(sample, lamp(sample.shape))
    assert evenness(dark).light > 2 * evenness(sample).light + 0.05
    assert evenness(even_light(dark)).light <= 0.01
    # Both become the same, up to rounding of dark pixels and how bright the whole is.
    own, other = (even_light(one).pixels.astype(float) for one in (sample, dark))
    one = np.corrcoef(own.ravel(), other.ravel())[0, 1]
    assert one > 0.998


def shaded(exemplar, light):
    """With the shadow of a pole, whose border is soft, lit by a sky of this color."""
    height, width = exemplar.shape
    y, x = np.mgrid[:height, :width] / max(exemplar.shape)
    away = np.abs(x - 0.3 - 0.3 * y) - 0.12
    share = 1 / (1 + np.exp(away / 0.02))
    planes = np.moveaxis(exemplar.pixels, 2, 0)
    planes = [
        _stored(_linear(plane) * (1 - share * (1 - one)), plane.dtype)
        for plane, one in zip(planes, light, strict=True)
    ]
    return exemplar.changed(pixels=np.stack(planes, axis=2))


def unevenness(found, truth):
    """How far the light differs from a uniform one."""
    return np.std(np.log(_linear(found.pixels) + 0.01) - np.log(_linear(truth.pixels) + 0.01))


@pytest.mark.parametrize("name", ["bricks", "tiles", "weave"])
def test_a_soft_shadow_is_removed(name):
    sample = weftex.load_exemplar(f"sample:{name}")
    dark = shaded(sample, (0.38, 0.42, 0.5))
    assert unevenness(even_light(dark), sample) < unevenness(dark, sample) / 2
    stone = shaded(sample, (0.5, 0.42, 0.38))  # redder, so it is a part of the material
    polynomial = lighting._light(_linear(stone.pixels[..., 0]), np.ones(sample.shape, bool), 2)
    own = _stored(_linear(stone.pixels[..., 0]) / polynomial, sample.pixels.dtype)
    assert np.array_equal(even_light(stone).pixels[..., 0], own)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_every_type_alike(dtype):
    sample = weftex.load_exemplar("sample:pebbles")
    dark = lit(sample, lamp(sample.shape))
    if np.dtype(dtype).kind == "u":
        pixels = (dark.pixels.astype(dtype) * (np.iinfo(dtype).max // 255)).astype(dtype)
        found = _linear(even_light(pixels).pixels)
    else:
        found = even_light(_linear(dark.pixels).astype(dtype)).pixels
        assert found.dtype == dtype
    wanted = _linear(even_light(dark).pixels)
    assert abs(found - wanted).mean() < 0.003 and abs(found.mean() - wanted.mean()) < 0.001


def test_what_does_not_show_says_nothing_of_the_light():
    rng = np.random.default_rng(1)
    pixels = rng.integers(100, 140, (60, 80, 4), np.uint8)
    pixels[..., 3] = 255
    pixels[:30, :20] = 0  # clear, and black
    sample = weftex.Exemplar(pixels, maps={"height": pixels[..., 0]})
    even = even_light(sample)
    assert abs(even.pixels.astype(int) - pixels)[30:].max() <= 3
    assert np.array_equal(even.pixels[..., 3], pixels[..., 3])
    assert np.array_equal(even.maps["height"], sample.maps["height"])
    mask = np.ones((60, 80), bool)
    mask[:30, :20] = False
    masked = weftex.Exemplar(pixels[..., :3].copy(), mask=mask)
    assert abs(even_light(masked).pixels.astype(int) - pixels[..., :3])[30:].max() <= 3


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (3, 2), (2, 2, 3)])
@pytest.mark.parametrize("value", [0, 7, 255])
def test_tiny_and_flat_ones_stay(shape, value):
    pixels = np.full(shape, value, np.uint8)
    assert np.array_equal(even_light(pixels, 8).pixels, pixels)


@pytest.mark.parametrize("value", [np.finfo(np.float32).max, -1.0, 1e-40])
def test_numbers_of_every_size_stay_numbers(value):
    pixels = np.random.default_rng(0).choice([0, value, value / 3], (30, 30)).astype(np.float32)
    assert np.isfinite(even_light(pixels).pixels).all()


@pytest.mark.parametrize("degree", [0, 9, 1.5, True, None, "2"])
def test_degrees_out_of_range_are_refused(degree):
    with pytest.raises(weftex.InvalidInputError, match="degree is"):
        even_light(np.zeros((9, 9), np.uint8), degree)
