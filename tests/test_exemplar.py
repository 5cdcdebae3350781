"""The sample: what is accepted, and the bytes that distances are taken on."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import weftex
from families import refused
from weftex import Exemplar

GRAY = np.arange(64, dtype=np.uint8).reshape(8, 8)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("channels", [None, 1, 2, 3, 4, 5])
def test_pixels_are_kept_as_they_are(rng, dtype, channels):
    shape = (5, 7) if channels is None else (5, 7, channels)
    pixels = (rng.random(shape) * 200).astype(dtype)
    exemplar = Exemplar(pixels)
    assert exemplar.pixels.dtype == dtype and np.array_equal(exemplar.pixels, pixels)
    assert exemplar.shape == (5, 7)
    assert exemplar.channels == (channels or 1)
    assert exemplar.alpha == (channels in (2, 4))
    matching = exemplar.matching()
    assert matching.shape == (5, 7, channels or 1)
    assert matching.dtype == np.uint8 and matching.flags.c_contiguous


@pytest.mark.parametrize(
    "pixels, says",
    [
        (np.zeros((4, 4), bool), "boolean; multiply by 255"),
        (np.zeros((4, 4), np.int64), "int64; supported: uint8"),
        (np.zeros(4, np.uint8), "1 dimensions"),
        (np.zeros((2, 2, 2, 2), np.uint8), "4 dimensions"),
        (np.zeros((0, 4), np.uint8), "empty"),
        (np.full((4, 4), np.nan, np.float32), "NaN or infinity"),
        (np.full((4, 4), -np.inf), "NaN or infinity"),
    ],
)
def test_bad_pixels_are_refused(pixels, says):
    refused(says, Exemplar, pixels)


def test_bad_companions_are_refused():
    refused("mask is 4x8", Exemplar, GRAY, mask=np.ones((8, 4), bool))
    refused("no usable pixel", Exemplar, GRAY, mask=np.zeros((8, 8), bool))
    refused("map 'normal' is 8x4", Exemplar, GRAY, maps={"normal": np.zeros((4, 8, 3), np.uint8)})
    refused("height contains NaN", Exemplar, GRAY, maps={"height": np.full((8, 8), np.nan)})
    refused("one channel", Exemplar, GRAY, alpha=True)


def wide(rng, channels=3):
    """A picture whose bytes span the range, as photos do."""
    pixels = rng.integers(0, 256, (12, 12, channels)).astype(np.uint8)
    pixels[0, 0], pixels[0, 1] = 0, 255
    return pixels


PICTURES = {
    "wide": lambda p: p,
    "dark": lambda p: p // 4,
    "bright": lambda p: 200 + p // 5,
    "an eighth": lambda p: 100 + p // 7,
}


FAINT = {
    "narrow": lambda p: 200 + p // 16,
    "nearly black": lambda p: p // 64,
    "two levels": lambda p: 90 + p // 128,
}


# The bytes of all depths are the same for pictures whose values span an eighth of the range or
# more. Narrower ones are stretched where the depth can tell more than 8 bits do.


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("kind", PICTURES)
def test_every_depth_matches_as_eight_bits(rng, kind, channels):
    pixels = PICTURES[kind](wide(rng, channels)).astype(np.uint8)
    eight = Exemplar(pixels).matching()
    for deep in (pixels.astype(np.uint16) * 257, pixels / 255, (pixels / 255).astype(np.float32)):
        assert np.array_equal(Exemplar(deep).matching(), eight)


@pytest.mark.parametrize("kind", FAINT)
@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64])
def test_faint_pictures_are_stretched(rng, kind, dtype):
    """What 16 bits tell apart there, 8 bits could not."""
    faint = FAINT[kind](wide(rng)).astype(np.uint8)
    deep = faint.astype(np.uint16) * 257 if dtype == np.uint16 else (faint / 255).astype(dtype)
    matching = Exemplar(deep).matching()
    order = np.argsort(faint, axis=None, kind="stable")
    assert (np.diff(matching.ravel()[order].astype(int)) >= 0).all()
    assert np.ptp(matching) >= 4 * np.ptp(faint) and matching.max() > 200


def test_the_color_of_clear_pixels_does_not_count(rng):
    pixels = wide(rng, 4)
    pixels[3:6, :, 3] = 0
    other = pixels.copy()
    other[3:6, :, :3] = 255 - other[3:6, :, :3]
    assert np.array_equal(Exemplar(pixels).matching(), Exemplar(other).matching())
    other[0, 5, 3] ^= 255
    assert not np.array_equal(Exemplar(pixels).matching(), Exemplar(other).matching())
    over = np.where(np.arange(4) == 3, 1.75, pixels / 255)  # floats may hold anything
    assert np.array_equal(Exemplar(over).matching(), Exemplar(np.minimum(over, 1)).matching())


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.integers(0, 99))
@example(0.0, 0.1875, 0)
def test_any_float_range_is_ordered_bytes(offset, spread, seed):
    """Brighter stays brighter or equal, and the range is used."""
    values = np.random.default_rng(seed).random((10, 10)) * spread + offset
    matching = Exemplar(values).matching()[..., 0]
    order = np.argsort(values, axis=None)
    assert (np.diff(matching.ravel()[order].astype(int)) >= 0).all()
    # From an eighth of 0 to 1 on, pictures within it get the bytes of their 8-bit version.
    plain = values.min() >= 0 and values.max() <= 1
    assert int(matching.max()) - int(matching.min()) >= (255 // 8 if plain else 60)


def test_brightness_ratios_survive_depth(rng):
    """A tolerance relative to the canvas means the same: no offset is taken off."""
    pixels = rng.random((20, 20)) * 8 + 1  # linear light, nothing near black
    matching = Exemplar(pixels).matching()[..., 0].astype(float)
    ratio = matching / pixels
    assert np.abs(ratio / ratio.mean() - 1).max() < 0.05


def test_maps_take_part_and_weigh_as_much_as_the_picture(rng):
    pixels = wide(rng)
    height = rng.integers(0, 256, (12, 12)).astype(np.uint8)
    one = Exemplar(pixels, maps={"height": height}).matching()
    assert one.shape == (12, 12, 4)
    assert np.array_equal(one[..., :3], pixels)
    assert np.array_equal(one[..., 3], np.minimum(np.rint(height * 3**0.5), 255))
    deep = Exemplar(pixels, maps={"height": height.astype(np.uint16) * 257})
    assert np.array_equal(deep.matching(), one)
    two = Exemplar(pixels, maps={"a": height, "b": height}).matching()
    assert np.array_equal(two[..., 3], np.minimum(np.rint(height * (3 / 2) ** 0.5), 255))


def test_known_pixels_are_mapped_as_the_samples_own(rng):
    for pixels in (wide(rng), wide(rng, 4), rng.random((12, 12)) * 3):
        exemplar = Exemplar(pixels)
        assert np.array_equal(exemplar.as_matching(pixels), exemplar.matching())
        assert np.array_equal(exemplar.as_matching(pixels[3:7]), exemplar.matching()[3:7])


@pytest.mark.parametrize("dtype", [">u2", ">f4", ">f8"])
def test_either_byte_order(rng, dtype):
    """Files of other machines arrive as arrays of the other byte order."""
    pixels = (rng.random((24, 24)) * 60000).astype(dtype)
    native = pixels.astype(pixels.dtype.newbyteorder("="))
    one = weftex.synthesize(pixels, 40, seed=1, method="patch-sampling", patch_size=8)
    other = weftex.synthesize(native, 40, seed=1, method="patch-sampling", patch_size=8)
    assert np.array_equal(one.image, other.image)


def test_weights_of_maps(rng):
    pixels = rng.integers(0, 256, (12, 14, 3)).astype(np.uint8)
    maps = {"height": rng.random((12, 14)), "ao": rng.random((12, 14))}
    plain = weftex.Exemplar(pixels, maps=maps)
    assert plain.weights == {"height": 1, "ao": 1}
    same = weftex.Exemplar(pixels, maps=maps, weights={"ao": 1})
    assert np.array_equal(same.matching(), plain.matching())
    without = weftex.Exemplar(pixels, maps=maps, weights={"ao": 0})
    assert np.array_equal(without.matching(), plain.matching()[..., :4])
    # Four times the weight is twice the values; where they would not fit, all others have less.
    heavy = weftex.Exemplar(pixels, maps=maps, weights={"height": 4}).matching().astype(float)
    spread = heavy.reshape(-1, 5).std(axis=0) / plain.matching().reshape(-1, 5).std(axis=0)
    assert np.allclose(spread[3] / spread[[0, 1, 2, 4]], 2, rtol=0.1)  # some were cut off
    assert heavy.max() <= 255
    kept = without.changed(maps={"ao": maps["ao"]})
    assert kept.weights == {"ao": 0}


@pytest.mark.parametrize(
    "weights, message",
    [
        ({"hieght": 1}, "did you mean 'height'"),
        ({"height": -1}, "the weight of height is -1; it must be from 0 to 100"),
        ({"height": float("nan")}, "from 0 to 100"),
        ({"height": True}, "from 0 to 100"),
        ({"height": "2"}, "from 0 to 100"),
        ([1], "must be numbers by maps' names"),
    ],
)
def test_weights_that_are_none(weights, message):
    pixels = np.zeros((4, 4), np.uint8)
    refused(message, weftex.Exemplar, pixels, maps={"height": pixels}, weights=weights)
