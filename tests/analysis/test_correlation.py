"""Normalized correlation: what does not count, and rounding."""

import numpy as np
import pytest

from twins.lattice import normalized_correlation
from weftex.analysis.correlation import correlate, correlation_and_power
from weftex.raster.arrays import fast_size


@pytest.mark.parametrize("shape", [(11, 8), (6, 13), (1, 9)])
def test_the_power_is_that_of_the_levels(shape, rng):
    levels = rng.normal(size=(3, *shape)) + 7
    found, power = correlation_and_power(levels)
    np.testing.assert_allclose(found, correlate(levels), atol=1e-12)
    around = levels - levels.mean(axis=(1, 2), keepdims=True)
    products = np.fft.irfft2(power, [fast_size(2 * side - 1) for side in shape])
    for dy, dx in ((0, 0), (0, 5), (shape[0] - 1, 2)):
        height, width = shape[0] - dy, shape[1] - dx
        expected = (around[:, :height, :width] * around[:, dy:, dx:]).sum()
        assert products[dy, dx] == pytest.approx(expected)


def test_a_constant_channel_does_not_count(rng):
    f = rng.integers(0, 256, (1, 9, 7)).astype(np.float64)
    alone, flat = correlate(f), np.full_like(f, 37)
    np.testing.assert_allclose(correlate(np.concatenate([f, flat])), alone)
    faint = rng.normal(0, 1e-4, f.shape)
    with_faint = correlate(np.concatenate([f, faint]))
    assert abs(with_faint - alone)[2:-2, 2:-2].max() < 1e-4
    assert not correlate(flat).any() and not correlate(f, np.zeros((9, 7), bool)).any()


@pytest.mark.parametrize("offset, scale", [(0, 1), (1e4, 1), (0, 1e-6), (-3, 1e6)])
def test_brightness_and_contrast_do_not_count(offset, scale, rng):
    f = rng.normal(size=(3, 20, 24))
    np.testing.assert_allclose(correlate(f * scale + offset), correlate(f), atol=1e-6)


def test_borders_are_sound():
    """A bright spot far off must not leave its rounding in overlaps that it is not part of."""
    f = np.zeros((1, 40, 40))
    f[0, 20, 20] = 1e4
    f[0, 0, :4] = f[0, -1, -4:] = [0, 3, 1, 2]
    found = correlate(f)
    assert abs(found).max() <= 1
    np.testing.assert_allclose(found, normalized_correlation(f[0]), atol=1e-4)
    f[0, 20, 20] = 0
    np.testing.assert_allclose(correlate(f), normalized_correlation(f[0]), atol=1e-9)
