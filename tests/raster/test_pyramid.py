"""Gaussian pyramids of bytes."""

import numpy as np
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
