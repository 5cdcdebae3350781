"""Iterative refinement, fusion, and histograms of a pyramid."""

import numpy as np
import pytest

import weftex
from weftex import reference
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.reference.fusion import merged
from weftex.reference.heeger_bergen import collapse_pyramid, make_pyramid, pyramid_masks
from weftex.reference.iterative_refinement import dominant_scale

SAMPLE = weftex.load_exemplar("sample:pebbles").pixels[:24, :26]


@pytest.mark.parametrize("seed", [0, 2**64 - 1])
@pytest.mark.parametrize("size", [(1, 1), (8, 3), (9, 17)])
@pytest.mark.parametrize(("scale", "iterations"), [(1, 3), (3, 2), (4, 1), (10, 2)])
def test_iterative_refinement(scale, iterations, size, seed):
    """Also without a whole unit tile (10), and of outputs that are smaller than a window."""
    expected = reference.iterative_refinement(SAMPLE, size, scale, 5, iterations, seed=seed)
    method = weftex.Refinement(
        search="nearest", init="seeds", window_width=2 * scale + 1, seed_scale=float(scale),
        iterations=iterations,
    )  # fmt: skip
    result = method.fit(weftex.Exemplar(SAMPLE)).sample(Canvas(*size), seed=seed)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, expected.sources)


def test_refinement_stops_when_little_changes():
    once = reference.iterative_refinement(SAMPLE, (7, 8), 3, iterations=2)
    loose = reference.iterative_refinement(SAMPLE, (7, 8), 3, iterations=9, threshold=1e9)
    assert np.array_equal(once.image, loose.image)
    assert np.array_equal(once.image, SAMPLE[tuple(np.moveaxis(once.sources, 2, 0))])


@pytest.mark.parametrize("period", [4, 8, 16])
def test_the_scale_of_waves_is_their_period(period):
    waves = 127 + 100 * np.sin(np.arange(64) * 2 * np.pi / period)
    bright = np.tile(waves, (64, 1)).astype(np.uint8)
    for pixels in (bright, np.stack([bright, 255 - bright], axis=2)):  # of light, of hue alone
        assert dominant_scale(pixels) == pytest.approx(period, 0.02)


def test_fusion_makes_each_region_of_its_sample():
    dark, light = SAMPLE // 4, 190 + SAMPLE // 4
    labels = np.repeat([[0] * 12 + [1] * 12], 6, axis=0)
    made = reference.fusion([dark, light], labels, [4, 3], seed=2)
    stacked = np.concatenate([dark, light])
    assert np.array_equal(made.image, stacked[tuple(np.moveaxis(made.sources, 2, 0))])
    assert (made.sources[:, :10, 0] < 24).all() and (made.sources[:, 14:, 0] >= 24).all()


def test_a_merged_texture_shows_the_second_in_the_first():
    a, b = np.full((12, 13, 1), 10), np.full((13, 12, 1), 90)
    b[3:9, 3:9] = 10  # where the boundary costs nothing, next to the middle
    inside, shape = merged(a, b)
    assert shape == (12, 12) and inside[4:8, 4:8].all() and inside.sum() == 16


def test_a_map_without_a_sample_is_refused():
    with pytest.raises(InvalidInputError, match="numbers from 0 to 2 for 2 samples"):
        reference.fusion([SAMPLE, SAMPLE], np.array([[0, 2]]), [3, 3])


@pytest.mark.parametrize("shape", [(16, 16), (21, 32)])
@pytest.mark.parametrize("orientations", [1, 2, 4])
def test_a_pyramid_collapses_to_its_image(shape, orientations, rng):
    image, masks = rng.random(shape), pyramid_masks(shape, 3, orientations)
    assert sum(abs(mask) ** 2 for mask in masks) == pytest.approx(np.ones(shape))
    assert np.allclose(collapse_pyramid(make_pyramid(image, masks), masks), image)


def test_heeger_bergen_matches_the_histogram_and_the_bands():
    gray = weftex.load_exemplar("sample:weave").pixels[:48, :48, 0]
    made = reference.heeger_bergen(gray, 48, levels=3, seed=3).image
    assert np.array_equal(np.sort(made, axis=None), np.sort(gray, axis=None))
    masks = pyramid_masks((48, 48), 3, 4)
    noise = np.random.default_rng(0).permutation(gray.ravel()).reshape(48, 48)
    spread = [[band.std() for band in make_pyramid(of, masks)[1:-1]] for of in (gray, made, noise)]
    apart = [np.abs(np.log(np.divide(of, spread[0]))).max() for of in spread[1:]]
    assert apart[0] < 0.2 < 0.7 < apart[1]


def test_heeger_bergen_keeps_colors():
    made = reference.heeger_bergen(SAMPLE, (20, 30), levels=2, seed=1)
    assert (made.sources == -1).all() and made.image.shape == (20, 30, 3)
    assert np.allclose(made.image.mean(axis=(0, 1)), SAMPLE.mean(axis=(0, 1)), atol=4)
