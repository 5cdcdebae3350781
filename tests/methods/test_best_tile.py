"""Best tile repetition: the best tile, repeated as the vectors say."""

import numpy as np
import pytest

import weftex
from families import noise, refused


def model_of(pixels, **parameters):
    return weftex.BestTile(**parameters).fit(weftex.Exemplar(pixels))


def test_fractions_do_not_add_up():
    y, x = np.indices((80, 90))
    waves = np.rint(127 + 60 * np.sin(x * 2 * np.pi / 12.3) + 60 * np.sin(y * 2 * np.pi / 9.7))
    model = model_of(waves.astype(np.uint8), lattice=(12.3, 0, 0, 9.7))
    for corner in ((0, 0), (10**6, -(10**6))):
        far = model.window(*corner, 120, 120).image
        v, u = np.indices(far.shape) + np.reshape(corner, (2, 1, 1))
        ideal = 127 + 60 * np.sin(u * 2 * np.pi / 12.3) + 60 * np.sin(v * 2 * np.pi / 9.7)
        assert np.abs(far - ideal).max() < 60 * 2 * np.pi * (1 / 9.7 + 1 / 12.3)


@pytest.mark.parametrize("tileable", [True, "x", "y"])
def test_it_wraps(tileable):
    model = model_of(noise((60, 64, 3)), lattice=(16, 0, 8, 12))
    result = model.sample((49, 62), seed=1, tileable=tileable)
    assert 0 < result.provenance["strain"] < 0.05
    index, steps = result.index, []
    for axis, name in ((0, "y"), (1, "x")):
        if tileable in (True, name):
            # Across the border sources continue as often as inside.
            step = (np.roll(index, -1, axis) - index) == (64 if axis == 0 else 1)
            step = np.moveaxis(step, axis, 0).mean(axis=1)
            steps.append(step[-1] >= step.min())
    assert all(steps)
    refused("fits", model.sample, (30, 24), tileable=True)


def test_without_a_lattice_it_is_refused():
    stripes = np.repeat(np.uint8([40, 200]), 4)[:, None] * np.ones((1, 60), np.uint8)
    for pixels in (noise((40, 50)), np.tile(stripes, (8, 1))):
        refused("has no lattice", model_of, pixels)


def test_borders_are_as_wide_as_there_is_room_for():
    """The default is narrowed, a given width is refused; either way the resolved one is true."""
    pixels = noise((40, 50))
    model = model_of(pixels, lattice=(20, 0, 0, 35))
    assert 0 < model.method.border_width < 10
    assert model.sample(20).provenance["border_width"] == model.method.border_width
    narrow = model_of(pixels, lattice=(20, 0, 0, 35), border_width=model.method.border_width)
    assert narrow.anchor == model.anchor and narrow.method == model.method
    bare = model_of(pixels, lattice=(49, 0, 0, 20))
    assert bare.method.border_width is None  # the photo ends beside the tile: nothing to compare
    assert bare.method.fit(weftex.Exemplar(pixels)).method == bare.method
    with pytest.raises(weftex.InvalidInputError, match="border_width is 100; .* at most 10"):
        model_of(pixels, lattice=(20, 0, 0, 30), border_width=100)
    assert model_of(pixels, lattice=(20, 0, 0, 30), border_width=10).method.border_width == 10
