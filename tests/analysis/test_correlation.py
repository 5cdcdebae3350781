"""Normalized cross-correlation is its definition, at every shift and for every size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from twins.lattice import normalized_correlation
from weftex.analysis.correlation import correlate, correlation_and_power, wrapped_length
from weftex.errors import InvalidInputError

SIZES = [((8, 9), (8, 9)), ((7, 5), (3, 9)), ((3, 4), (6, 7)), ((1, 6), (4, 2)), ((9, 2), (1, 1))]


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("channels", [(), (1,), (3,)])
@pytest.mark.parametrize("first, second", SIZES)
def test_it_is_its_definition(first, second, channels, masked, rng):
    """Also where equations 3.8 and 3.9 fail as printed: other sizes, the second one larger."""
    f = rng.integers(0, 256, (*first, *channels), np.uint8)
    g = rng.integers(0, 256, (*second, *channels), np.uint8)
    f_mask, g_mask = (rng.random(size) < 0.7 if masked else None for size in (first, second))
    found = correlate(f, g, first_mask=f_mask, second_mask=g_mask)
    expected = normalized_correlation(f, g, f_mask, g_mask)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("shape", [(11, 8), (6, 13, 3), (1, 9), (1, 1)])
@pytest.mark.parametrize("masked", [False, True])
def test_a_picture_with_itself(shape, masked, rng):
    f = rng.integers(0, 256, shape, np.uint8)
    mask = rng.random(shape[:2]) < 0.7 if masked else None
    found = correlate(f, first_mask=mask)
    np.testing.assert_allclose(found, correlate(f, f, first_mask=mask, second_mask=mask))
    np.testing.assert_allclose(found, normalized_correlation(f, None, mask), atol=1e-9)
    np.testing.assert_allclose(found, found[::-1, ::-1], atol=1e-9)
    if min(shape[:2]) > 1:
        assert found[shape[0] - 1, shape[1] - 1] == pytest.approx(1)


@pytest.mark.parametrize("shape", [(11, 8), (6, 13), (1, 9)])
def test_the_power_is_that_of_the_levels(shape, rng):
    levels = rng.normal(size=(3, *shape)) + 7
    found, power = correlation_and_power(levels)
    np.testing.assert_allclose(found, correlate(np.moveaxis(levels, 0, 2)), atol=1e-12)
    around = levels - levels.mean(axis=(1, 2), keepdims=True)
    products = np.fft.irfft2(power, [wrapped_length(2 * side - 1) for side in shape])
    for dy, dx in ((0, 0), (0, 5), (shape[0] - 1, 2)):
        height, width = shape[0] - dy, shape[1] - dx
        expected = (around[:, :height, :width] * around[:, dy:, dx:]).sum()
        assert products[dy, dx] == pytest.approx(expected)


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("first, second", SIZES)
@pytest.mark.parametrize("reach", [(0, 0), (2, 1), (1, 6), (20, 20)])
def test_within_reach_it_is_the_same(first, second, masked, reach, rng):
    f, g = rng.integers(0, 256, first, np.uint8), rng.integers(0, 256, second, np.uint8)
    masks = {"first_mask": rng.random(first) < 0.7} if masked else {}
    whole, part = correlate(f, g, **masks), correlate(f, g, **masks, reach=reach)
    y, x = (side - 1 for side in second)
    rows = slice(max(0, y - reach[0]), y + reach[0] + 1)
    np.testing.assert_allclose(
        part, whole[rows, max(0, x - reach[1]) : x + reach[1] + 1], atol=1e-9
    )


@given(st.data())
def test_any_sizes_and_few_levels(data):
    """Few levels make many overlaps constant."""
    side = st.integers(1, 7)
    sizes = [(data.draw(side), data.draw(side)) for _ in range(2)]
    seed, levels = data.draw(st.integers(0, 2**32)), data.draw(st.integers(1, 3))
    rng = np.random.default_rng(seed)
    f, g = (rng.integers(0, levels, (*size, 2)) * 100 for size in sizes)
    np.testing.assert_allclose(correlate(f, g), normalized_correlation(f, g), atol=1e-9)


def test_a_constant_channel_does_not_count(rng):
    f, g = rng.integers(0, 256, (2, 9, 7)).astype(np.float64)
    alone = correlate(f, g)
    flat = np.full_like(f, 37)
    np.testing.assert_allclose(correlate(np.dstack([f, flat]), np.dstack([g, flat])), alone)
    faint = rng.normal(0, 1e-4, f.shape)
    with_faint = correlate(np.dstack([f, faint]), np.dstack([g, faint]))
    assert abs(with_faint - alone)[2:-2, 2:-2].max() < 1e-4
    assert not correlate(flat).any() and not correlate(flat, g).any()


@pytest.mark.parametrize("offset, scale", [(0, 1), (1e4, 1), (0, 1e-6), (-3, 1e6)])
def test_brightness_and_contrast_do_not_count(offset, scale, rng):
    f, g = rng.normal(size=(2, 20, 24, 3))
    np.testing.assert_allclose(correlate(f * scale + offset, g), correlate(f, g), atol=1e-6)
    assert correlate(f * scale + offset, f)[19, 23] == pytest.approx(1)
    assert correlate(-f, f)[19, 23] == pytest.approx(-1)


def test_borders_are_sound():
    """A bright spot far off must not leave its rounding in overlaps that it is not part of."""
    f = np.zeros((40, 40))
    f[20, 20] = 1e4
    f[0, :4] = f[-1, -4:] = [0, 3, 1, 2]
    found = correlate(f)
    assert abs(found).max() <= 1
    np.testing.assert_allclose(found, normalized_correlation(f), atol=1e-4)
    few = np.zeros((40, 40), np.uint8)
    few[0, :4] = few[-1, -4:] = [0, 3, 1, 2]
    np.testing.assert_allclose(correlate(few), normalized_correlation(few), atol=1e-9)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((np.zeros((3, 3)), np.zeros((3, 3, 2))), "1 channels and second 2"),
        ((np.zeros((3, 0)),), "not empty"),
        ((np.zeros(3),), r"\(H, W\)"),
        ((np.full((2, 2), np.nan),), "NaN"),
        ((np.zeros((2, 2), complex),), "real"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(InvalidInputError, match=message):
        correlate(*arguments)


def test_bad_masks():
    f = np.zeros((3, 4))
    with pytest.raises(InvalidInputError, match="mask of first"):
        correlate(f, first_mask=np.ones((4, 3), bool))
    with pytest.raises(InvalidInputError, match="second_mask"):
        correlate(f, second_mask=np.ones((3, 4), bool))
    assert not correlate(f, first_mask=np.zeros((3, 4), bool)).any()
