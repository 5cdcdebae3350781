"""What becomes of two pixels where both show, by what a picture stores."""

import numpy as np
import pytest

import weftex
from materials import normal_map
from weftex.raster.mixing import Kind, mixing_of
from weftex.roles import ROLES


@pytest.mark.parametrize(
    "store",
    [
        lambda v: np.rint((v + 1) * 127.5).astype(np.uint8),
        lambda v: np.rint((v + 1) * 32767.5).astype(np.uint16),
        lambda v: ((v + 1) / 2).astype(np.float32),
        lambda v: v,
    ],
)
def test_normal_maps_are_known_in_every_type(rng, store):
    pixels = store(normal_map(rng, (20, 30)))
    mixing = mixing_of(pixels, "normal", False)
    assert mixing.kind is Kind.VECTORS
    assert mixing.middle == (0.5 if pixels.dtype == np.float32 else 0)
    assert mixing_of(pixels, "color", False).kind is Kind.MEAN


def test_what_is_called_a_normal_map_but_stores_no_vectors_is_mixed_as_ever(rng):
    for shape in ((20, 30), (20, 30, 2), (20, 30, 3)):
        dark = rng.integers(100, 150, shape).astype(np.uint8)
        assert mixing_of(dark, "normal", False).kind is Kind.MEAN
        noise = rng.integers(0, 256, shape).astype(np.uint8)
        assert mixing_of(noise, "normal", False).kind is Kind.MEAN
    assert mixing_of(dark, "color", True).kind is Kind.ALPHA
    assert mixing_of(dark, "labels", False).kind is Kind.LABELS


@pytest.mark.parametrize(
    "method",
    [
        weftex.PatchSampling(patch_size=16, boundary_width=6),
        weftex.PatchSampling(patch_size=16, blend="feather-at-end"),
        weftex.NearRegular(lattice=(16, 0, 0, 16), blend="feather"),
    ],
)
def test_vectors_keep_their_length(rng, method):
    """As a map of a sample, as the sample itself, and replayed by what it shows."""
    pixels = np.rint((normal_map(rng, (64, 64)) + 1) * 127.5).astype(np.uint8)

    def shortest(found):
        return np.linalg.norm(found / 127.5 - 1, axis=2).min()

    color = rng.integers(0, 256, (64, 64, 3)).astype(np.uint8)
    exemplar = weftex.Exemplar(color, maps={"normal": pixels})
    result = method.fit(exemplar).sample(weftex.Canvas(96, 96), seed=1)
    own = method.fit(weftex.Exemplar(pixels, name="wall_nor_gl")).sample(96, seed=1)
    for found in (result.maps["normal"], result.render(pixels, role="normal"), own.image):
        assert shortest(found) > shortest(pixels) - 0.02
    assert np.array_equal(own.image, own.render(pixels, role="normal"))
    assert shortest(result.render(pixels)) < shortest(pixels) - 0.02  # as plain colors


def test_there_is_nothing_between_two_labels(rng):
    pixels = rng.choice([0, 90, 255], (40, 40)).astype(np.uint8)
    method = weftex.PatchSampling(patch_size=12, boundary_width=5)
    sample = weftex.Exemplar(rng.integers(0, 256, (40, 40)).astype(np.uint8), maps={"id": pixels})
    result = method.fit(sample).sample(weftex.Canvas(64, 64), seed=2)
    assert set(np.unique(result.maps["id"])) <= {0, 90, 255}
    assert not set(np.unique(result.render(pixels))) <= {0, 90, 255}


def test_what_a_picture_shows_is_said_once():
    pixels = np.zeros((24, 24), np.uint8)
    result = weftex.synthesize(pixels, (8, 8))
    with pytest.raises(weftex.InvalidInputError, match="role is 'nrml'; did you mean 'normal'"):
        result.render(pixels, role="nrml")
    with pytest.raises(weftex.InvalidInputError, match="role has no effect with an Exemplar"):
        result.render(weftex.Exemplar(pixels), role="height")
    assert weftex.Exemplar(pixels, name="rock_nor_gl_2k").role is ROLES["normal_gl"]
    assert weftex.Exemplar(pixels, name="rock_disp_2k").role is ROLES["color"]
