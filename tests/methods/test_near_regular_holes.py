"""Near-regular synthesis in holes."""

import numpy as np
import pytest

import weftex
from materials import ellipse, wall


@pytest.mark.parametrize("tileable", [False, True, "x"])
def test_holes_go_on_with_the_surroundings(tileable):
    """Mortar where it was, whether the pixels are part of the sample or of another wall."""
    pixels = wall(120, 128, spread=1)
    hole = ellipse((120, 128), (50, 60), (25, 20)) | ellipse((120, 128), (120, 20), (12, 9))
    hole |= np.roll(hole, 8, axis=0) & (np.indices(hole.shape)[0] < 12)
    blank = np.where(hole[..., None], 255, pixels).astype(np.uint8)
    settings = {"method": "near-regular", "lattice": (16, 0, 8, 12), "seed": 3}
    for sample in (None, wall(90, 100, spread=1)[5:, 3:]):
        result = weftex.fill(blank, hole, sample=sample, tileable=tileable, **settings)
        assert np.array_equal(result.image[~hole], pixels[~hole])
        assert ((result.image[..., 0] > 180) == (pixels[..., 0] > 180)).all()
        if sample is None:
            assert not hole[result.source[..., 0], result.source[..., 1]][hole].any()


def test_holes_that_leave_no_whole_piece():
    pixels = wall(96, 96)
    small = np.zeros((96, 96), bool)
    small[40:50, 40:50] = True
    with pytest.raises(weftex.InvalidInputError, match="make them smaller"):
        weftex.fill(pixels, small, method="near-regular", lattice=(16, 0, 8, 12), block_size=45)
    # Whole windows in one corner alone, and not at all places of the large tile.
    large = np.ones((96, 96), bool)
    large[:40, :40] = False
    with pytest.raises(weftex.InvalidInputError, match="no whole piece of .*give a sample"):
        weftex.fill(pixels, large, method="near-regular", lattice=(32, 0, 0, 48), block_size=24)
