"""Stacks: coarser levels with a pixel for each of the sample, and how they are laid out."""

import numpy as np
import pytest

from families import noise
from twins import refinement as reference
from weftex.methods.refinement.stack import Layout
from weftex.raster.pyramids import gaussian_pyramid, gaussian_stack, mask_pyramid, mask_stack


@pytest.mark.parametrize("tileable", [False, True])
@pytest.mark.parametrize("shape", [(16, 36), (15, 35)])
def test_places_of_a_level_are_places_of_the_sample(shape, tileable):
    """Laid out, each window is what the definition finds around its place, also over borders."""
    pixels, mask = noise((*shape, 2)), np.ones(shape, bool)
    mask[0, 3] = False
    tiles = (tileable, tileable)
    pictures, masks = gaussian_stack(pixels, 3, tiles), mask_stack(mask, 3, tiles)
    for number in range(3):
        assert np.array_equal(pictures[number][0], gaussian_pyramid(pixels, 3, tiles)[number])
        assert np.array_equal(masks[number][0], mask_pyramid(mask, 3, tiles)[number])
        layout = Layout(shape, number, 1, tileable)
        laid, usable = layout.arranged(pictures[number]), layout.usable(masks[number])
        level = reference.RefinedLevel(
            reference.stacked(pixels, number, tiles),
            reference.stacked(mask, number, tiles, reference.coarser_mask),
            tileable, number, 1, 4,
        )  # fmt: skip
        assert laid.shape[:2] == usable.shape == layout.places.shape
        at = layout.index.reshape(shape)
        assert np.array_equal(layout.places.ravel()[at].ravel(), np.arange(at.size))
        inside = usable.ravel()[at] > 0
        assert {tuple(k) for k in np.argwhere(inside).tolist()} == level.center_set
        for place in level.centers:
            y, x = divmod(int(at[place]), laid.shape[1])
            for dy, dx in np.ndindex(3, 3):
                expected = level.pixels[level.at(place, dy - 1, dx - 1)]
                assert np.array_equal(laid[y + dy - 1, x + dx - 1], expected)
        beyond = np.setdiff1d(np.flatnonzero(usable), at)
        # A step off a border of a sample that tiles finds its other side.
        assert level.centers and bool(beyond.size) == tileable
