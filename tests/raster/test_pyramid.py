"""Gaussian pyramids of bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from twins import pyramids as reference
from weftex.raster.pyramids import gaussian_pyramid, mask_pyramid

WRAPS = [(a, b) for a in (False, True) for b in (False, True)]


@given(
    st.integers(1, 13), st.integers(1, 13), st.integers(1, 4), st.sampled_from(WRAPS),
    st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_levels_follow_the_definition(height, width, channels, wrap, seed):
    rng = np.random.default_rng(seed)
    levels = rng.integers(0, 256, (height, width, channels)).astype(np.uint8)
    mask = rng.random((height, width)) < 0.8
    pyramid, masks = gaussian_pyramid(levels, 3, wrap), mask_pyramid(mask, 3, wrap)
    assert pyramid[0] is levels
    for k in (0, 1):
        assert np.array_equal(pyramid[k + 1], reference.coarser(pyramid[k], wrap))
        assert np.array_equal(masks[k + 1], reference.coarser_mask(masks[k], wrap))
        assert pyramid[k + 1].dtype == np.uint8 and pyramid[k + 1].flags.c_contiguous


@pytest.mark.parametrize("value", [0, 1, 127, 255])
def test_constant_in_constant_out(value):
    for level in gaussian_pyramid(np.full((21, 1, 3), value, np.uint8), 6):
        assert (level == value).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_wrapped_axis_goes_around(axis):
    """Rolling an even side by two pixels rolls the coarser level by one."""
    levels = np.random.default_rng(0).integers(0, 256, (16, 16, 3)).astype(np.uint8)
    plain = gaussian_pyramid(levels, 2, (True, True))[1]
    rolled = gaussian_pyramid(np.roll(levels, 2, axis), 2, (True, True))[1]
    assert np.array_equal(rolled, np.roll(plain, 1, axis))
    wrap = (axis != 0, axis != 1)
    other = gaussian_pyramid(np.roll(levels, 2, axis), 2, wrap)[1]
    assert not np.array_equal(other, np.roll(gaussian_pyramid(levels, 2, wrap)[1], 1, axis))


def test_a_mask_holds_what_nothing_else_changes():
    """Pixels outside the mask have no say in those inside the coarser one."""
    rng = np.random.default_rng(1)
    levels = rng.integers(0, 256, (24, 25, 1)).astype(np.uint8)
    mask = np.ones((24, 25), bool)
    mask[8:13, 9:15] = False
    other = np.where(mask[..., None], levels, 255 - levels)
    for k in (1, 2):
        inside = mask_pyramid(mask, 3)[k]
        one, two = gaussian_pyramid(levels, 3)[k], gaussian_pyramid(other, 3)[k]
        assert inside.any() and np.array_equal(one[inside], two[inside])
        assert (one[~inside] != two[~inside]).any()
