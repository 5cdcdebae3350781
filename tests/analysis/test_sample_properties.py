"""Regularity and sidedness are high where a sample repeats, or has an orientation."""

import numpy as np
import pytest

import weftex
from weftex.analysis.properties import regularity, sidedness
from weftex.exemplar import Exemplar

#: The samples that ship with weftex.
REAL = {
    "tiles": 0.91, "weave": 0.77, "bricks": 0.61,
    "pebbles": 0.15, "grass": 0.10, "wood": 0.10, "leaves": 0.10,
}  # fmt: skip


def regular(pixels, **options):
    return regularity(Exemplar(np.ascontiguousarray(pixels), **options))


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


def test_lines_that_go_on_do_not_repeat():
    """Along them the correlation is 1 and never falls."""
    for seed in range(6):
        row = np.random.default_rng(seed).integers(0, 256, 160, np.uint8)
        assert regular(np.tile(row, (80, 1))) < 0.35
        assert regular(np.tile(row[:, None], (1, 80))) < 0.35


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


def discs(rng, lit):
    """Balls on a dark ground, lit from above or from in front."""
    y, x = np.mgrid[:160, :160]
    picture = np.full((160, 160), 40.0)
    for cy, cx in rng.uniform(0, 160, (90, 2)):
        v, u = (y - cy) / 9, (x - cx) / 9
        inside = v * v + u * u < 1
        bright = 120 + 110 * (-v if lit else np.sqrt(np.maximum(1 - v * v - u * u, 0)))
        picture = np.where(inside, bright, picture)
    return Exemplar(np.clip(picture, 0, 255).astype(np.uint8))


@pytest.mark.parametrize("seed", range(3))
def test_light_from_above_is_seen(seed):
    rng = np.random.default_rng(seed)
    assert max(sidedness(discs(rng, lit=False))) <= 0.06
    assert sidedness(discs(rng, lit=True))[0] > 0.15


@pytest.mark.parametrize("angle", [0, 45, 90, 135])
def test_grain_has_directions_and_looks_the_same_upside_down(angle, rng):
    """At a slant it is told from its mirror image, as light from a corner is."""
    noise = rng.normal(0, 1, (240, 240))
    v, u = np.mgrid[-8:9, -8:9]
    turn = np.radians(angle)
    along, across = u * np.cos(turn) - v * np.sin(turn), u * np.sin(turn) + v * np.cos(turn)
    brush = np.exp(-(along**2) / 32 - across**2 / 2)
    windows = np.lib.stride_tricks.sliding_window_view(noise, brush.shape)
    grain = np.einsum("yxvu,vu->yx", windows, brush)
    upside_down, turned = sidedness(Exemplar(np.clip(127 + 8 * grain, 0, 255).astype(np.uint8)))
    assert upside_down <= 0.06 and turned > 0.3


def test_sides_are_the_same_upside_down_and_in_a_mirror():
    pixels = weftex.read_image("sample:pebbles").pixels
    found = sidedness(Exemplar(pixels))
    for other in (pixels[::-1, ::-1], pixels[:, ::-1], pixels[::-1], pixels.swapaxes(0, 1)):
        assert sidedness(Exemplar(np.ascontiguousarray(other))) == pytest.approx(found, abs=0.03)


def test_sides_of_what_is_masked_do_not_count(rng):
    pixels = rng.integers(100, 140, (120, 120)).astype(np.uint8)
    pixels[:40] = (np.arange(40) % 12 * 20)[:, None]
    mask = np.ones((120, 120), bool)
    mask[:40] = False
    assert sidedness(Exemplar(pixels))[0] > 0.2
    assert max(sidedness(Exemplar(pixels, mask=mask))) <= 0.06
