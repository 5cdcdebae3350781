"""Cells that differ in turn: as faintly as a fifth of the pattern, and not where they do not."""

import numpy as np
import pytest

from analysis.test_lattice import assert_found, smooth
from weftex.analysis.relief import relief
from weftex.analysis.tile_multiples import alternating, halves_agree
from weftex.exemplar import Exemplar

CELLS = {"square": ((16, 0), (0, 16)), "aslant": ((17.4, 0.5), (-1, 21.3))}
CELLS["bond"] = ((24, 0), (12, 15))


def turns(vectors, rng, index, amount, noise=0.0, size=192):
    """A pattern in every cell, and one of `index` others, so much of it, in cells in turn."""
    y, x = np.mgrid[: 2 * size, : 2 * size] / 2
    a, b = np.tensordot(np.linalg.inv(vectors).T, np.stack([x, y]), 1) + 0.3
    i, j = (np.floor(c * 16).astype(int) % 16 for c in (b, a))
    tiles = [smooth(rng.standard_normal((16, 16, 3)), 1.0) for _ in range(index + 1)]
    levels, *others = [(tile / tile.std())[i, j] for tile in tiles]
    kind = (np.floor(a) + np.floor(b)).astype(int) % index
    levels = levels + amount / 2 * np.choose(kind[..., None], others)
    levels = levels.reshape(size, 2, size, 2, 3).mean(axis=(1, 3))
    levels += noise * rng.standard_normal(levels.shape)
    return np.clip(128 + 32 * levels, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("amount, noise", [(0, 0), (0, 0.5), (0.2, 0), (0.4, 0.5)])
@pytest.mark.parametrize("index", [2, 3])
@pytest.mark.parametrize("cells", CELLS)
def test_cells_in_turn(cells, index, amount, noise):
    expected = np.array(CELLS[cells], np.float64)
    if amount:
        expected = np.array([[index, 0], [-1, 1]]) @ expected
    for seed in range(4 - index):
        rng = np.random.default_rng(seed)
        assert_found(Exemplar(turns(CELLS[cells], rng, index, amount, noise)), expected)


def test_what_halves_agree_on_is_the_mean_over_ways_to_halve():
    """By definition: differences of means in two random halves, correlated."""
    rng = np.random.default_rng(3)
    kinds = np.arange(80) % 2
    tiles = rng.standard_normal((80, 400)) + 0.4 * kinds[:, None] * rng.standard_normal(400)
    products, powers = [], []
    for _ in range(200):
        half = np.zeros(80, bool)
        for kind in (0, 1):
            half[rng.permutation(np.flatnonzero(kinds == kind))[:20]] = True
        one, other = (
            tiles[part & (kinds == 1)].mean(axis=0) - tiles[part & (kinds == 0)].mean(axis=0)
            for part in (half, ~half)
        )
        products.append((one * other).mean())
        powers.append(((one**2).mean() * (other**2).mean()) ** 0.5)
    expected = np.mean(products) / np.mean(powers)
    assert halves_agree(tiles, kinds, 2) == pytest.approx(expected, abs=0.02)
    assert halves_agree(tiles, kinds[rng.permutation(80)], 2) < 0.3


def test_masked_and_few_tiles_are_left_out(rng):
    pixels = turns(CELLS["square"], rng, 2, 0.4)
    vectors = np.array(CELLS["square"], np.float64)
    mask = np.ones(pixels.shape[:2], bool)
    mask[:80, :60] = False
    spoilt = np.where(mask[..., None], pixels, rng.integers(0, 256, pixels.shape, np.uint8))
    flat = relief(Exemplar(spoilt.astype(np.uint8), mask=mask))
    whole = alternating(flat, vectors)
    assert whole is not None and abs(np.linalg.det(whole)) == pytest.approx(2)
    assert alternating(relief(Exemplar(pixels[:40, :40])), vectors) is None
    assert alternating(relief(Exemplar(pixels[:9, :9])), vectors) is None


def test_rows_of_one_tone_do_not_alternate():
    """Each row of cells has a tone of its own: three rows are no period of three."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        pixels = turns(((16, 0), (0, 48)), rng, 2, 0, 0.2).astype(int)
        pixels += np.repeat(rng.integers(-20, 20, 4), 48)[:, None, None]
        vectors = np.array([[16.0, 0.0], [0.0, 48.0]])
        assert alternating(relief(Exemplar(pixels.clip(0, 255).astype(np.uint8))), vectors) is None
