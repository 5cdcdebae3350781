"""Regularity: high where a sample repeats, low where it does not, whatever else it is."""

from __future__ import annotations

import numpy as np
import pytest

import weftex
from weftex.analysis.properties import autocorrelation, regularity
from weftex.analysis.relief import relief
from weftex.exemplar import Exemplar

#: The samples that ship with weftex.
REAL = {
    "tiles": 0.91, "weave": 0.77, "bricks": 0.61,
    "pebbles": 0.15, "grass": 0.10, "wood": 0.10, "leaves": 0.10,
}  # fmt: skip


def regular(pixels, **options):
    return regularity(Exemplar(np.ascontiguousarray(pixels), **options))


def correlation_by_definition(exemplar):
    """Products of what overlaps over the mean of both parts' energies, shift by shift."""
    flat = relief(exemplar)
    channels, height, width = flat.levels.shape
    result = np.zeros((2 * (height // 2) + 1, 2 * (width // 2) + 1))
    for dy in range(-(height // 2), height // 2 + 1):
        for dx in range(-(width // 2), width // 2 + 1):
            products = energies = 0.0
            for y in range(max(0, -dy), min(height, height - dy)):
                for x in range(max(0, -dx), min(width, width - dx)):
                    if flat.usable[y, x] and flat.usable[y + dy, x + dx]:
                        for k in range(channels):
                            a, b = flat.levels[k, y, x], flat.levels[k, y + dy, x + dx]
                            products += a * b
                            energies += (a * a + b * b) / 2
            if energies:
                result[dy + height // 2, dx + width // 2] = products / energies
    return result


@pytest.mark.parametrize("shape", [(8, 8), (7, 10, 3), (1, 9), (6, 1), (2, 2)])
def test_autocorrelation_is_its_definition(shape, rng):
    exemplar = Exemplar(rng.integers(0, 256, shape, np.uint8))
    expected = correlation_by_definition(exemplar)
    np.testing.assert_allclose(autocorrelation(exemplar), expected, atol=1e-6)


def test_autocorrelation_of_a_masked_sample_is_its_definition(rng):
    mask = rng.random((9, 11)) < 0.7
    exemplar = Exemplar(rng.integers(0, 256, (9, 11), np.uint8), mask=mask)
    expected = correlation_by_definition(exemplar)
    np.testing.assert_allclose(autocorrelation(exemplar), expected, atol=1e-6)


def test_autocorrelation_is_symmetric_and_bounded():
    for name in ("bricks", "grass"):
        found = autocorrelation(weftex.load_exemplar(f"sample:{name}"))
        np.testing.assert_allclose(found, found[::-1, ::-1], atol=1e-9)
        assert abs(found).max() <= 1 + 1e-9
        assert found[found.shape[0] // 2, found.shape[1] // 2] == pytest.approx(1)


@pytest.mark.parametrize("repeats", [(3, 3), (1, 5), (6, 1), (4, 7)])
def test_exact_tilings(repeats, rng):
    tile = rng.integers(0, 256, (13, 19, 3), np.uint8)
    assert regular(np.tile(tile, (*repeats, 1))) == pytest.approx(1, abs=0.02)


def test_it_falls_as_noise_is_added(rng):
    tile = np.tile(rng.integers(60, 200, (16, 16)), (6, 6))
    found = [
        regular(np.clip(tile + amount * rng.standard_normal(tile.shape), 0, 255).astype(np.uint8))
        for amount in (0, 15, 40, 120)
    ]
    assert found[0] > found[1] > found[2] > found[3]
    assert found[0] >= 0.98 and found[3] < 0.3
    # Signal over signal and noise: the variance of the tile is that of evenly spread levels.
    assert found[2] == pytest.approx(140**2 / 12 / (140**2 / 12 + 40**2), abs=0.06)


@pytest.mark.parametrize("name", REAL)
def test_real_samples(name):
    exemplar = weftex.load_exemplar(f"sample:{name}")
    assert regularity(exemplar) == pytest.approx(REAL[name], abs=0.01)
    turned = Exemplar(np.ascontiguousarray(np.rot90(exemplar.pixels)))
    assert regularity(turned) == pytest.approx(REAL[name], abs=0.03)


def test_parts_of_a_wall_are_as_regular():
    pixels = weftex.load_exemplar("sample:tiles").pixels
    for part in (pixels[:128, :128], pixels[:, :150], pixels[60:]):
        assert regular(part) > 0.8


def test_lines_that_go_on_do_not_repeat():
    """Along them the correlation is 1 and never falls."""
    for seed in range(6):
        row = np.random.default_rng(seed).integers(0, 256, 160, np.uint8)
        assert regular(np.tile(row, (80, 1))) < 0.35
        assert regular(np.tile(row[:, None], (1, 80))) < 0.35


def test_one_large_thing_is_less_than_a_pattern():
    y, x = np.mgrid[:80, :80]
    bowl = 255 * np.exp(-((y - 30.0) ** 2 + (x - 50.0) ** 2) / 900)
    assert regular(bowl.astype(np.uint8)) < 0.5


def test_noise_does_not_repeat():
    for seed in range(10):
        noise = np.random.default_rng(seed).integers(0, 256, (64, 64), np.uint8)
        assert regular(noise) < 0.2


def test_lighting_does_not_hide_a_pattern(rng):
    tile = np.tile(rng.integers(0, 60, (16, 16)), (5, 5))
    lit = tile + np.add.outer(np.arange(80), np.arange(80))
    assert regular(lit.astype(np.uint8)) > 0.95


def test_what_the_mask_leaves_out_does_not_count(rng):
    tile = np.tile(rng.integers(0, 256, (12, 12)), (8, 8))
    mask = np.ones(tile.shape, bool)
    mask[30:60, 20:90] = False
    junk = np.where(mask, tile, rng.integers(0, 256, tile.shape)).astype(np.uint8)
    assert regular(junk) < 0.9 < regular(junk, mask=mask)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1), (30, 30), (5, 1, 3)])
def test_constant_and_tiny_samples(shape, rng):
    for value in (0, 77, 255):
        assert regular(np.full(shape, value, np.uint8)) == 0
    assert 0 <= regular(rng.integers(0, 256, shape, np.uint8)) <= 1


def test_one_usable_pixel():
    mask = np.zeros((20, 20), bool)
    mask[3, 4] = True
    assert regular(np.zeros((20, 20), np.uint8), mask=mask) == 0
