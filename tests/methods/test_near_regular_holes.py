"""Near-regular synthesis in holes."""

import numpy as np
import pytest

import weftex
from families import noise
from materials import ellipse, wall
from twins.near_regular import usable_of
from twins.near_regular_holes import NearRegularHoleTwin
from weftex.methods.lattices.model import origin_of


@pytest.mark.parametrize(
    "inside, radius, parameters",
    [
        (True, (17, 15), {}),
        (True, (19, 16), {"variety": 0.0}),
        (False, (26, 30), {"variety": 3.0}),
        (False, (9, 6), {"lattice": (8.0, 12.25, -16.5, 0.3), "tolerance": 0}),
        (True, (3, 11), {"lattice": (1.0, 0.0, 0.0, 1.0)}),
    ],
)
def test_holes_are_filled_like_the_twin_does(inside, radius, parameters):
    pixels = noise((80, 84, 3)) // 2 + wall(80, 84) // 2
    settings = {
        "lattice": (16.0, 0.0, 8.0, 12.0),
        "block_size": 9,
        "border_width": 6,
        "tolerance": 1,
        "candidates": 3,
        "rectify": 0,
    } | parameters
    if inside:
        hole = ellipse((80, 84), (41, 44), radius)
        mask = ~hole
        mask[28 if "lattice" in parameters else 80 :] = False
        exemplar = weftex.Exemplar(pixels, mask=mask)
        canvas = weftex.Canvas(80, 84, known=pixels, hole=hole, known_from=(0, 0))
    else:
        other = noise((60, 64, 3), seed=5) // 2 + wall(67, 69, seed=2)[7:, 5:] // 2
        hole = ellipse((60, 64), (33, 34), radius)
        exemplar = weftex.Exemplar(pixels)
        canvas = weftex.Canvas(60, 64, known=other, hole=hole)
    model = weftex.NearRegular(**settings).fit(exemplar)
    origin = origin_of(canvas, exemplar, model.vectors) if model.vectors else (0, 0)
    twin = NearRegularHoleTwin(pixels, usable_of(model), model.method, 7, canvas, origin)
    result = model.sample(canvas, seed=7)
    assert np.array_equal(result.source[hole], twin.source(canvas, origin)[hole])


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
