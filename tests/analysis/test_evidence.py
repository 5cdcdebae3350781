"""Which of several lattices is taken: what crosses rows, blocks that turn, lines that run on."""

import numpy as np
import pytest

from analysis.test_lattice import smooth
from weftex.analysis.autocorrelations import autocorrelations, fit_vectors
from weftex.analysis.evidence import Evidence, crossing_candidate
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.tile_multiples import halves_agree, made_of
from weftex.exemplar import Exemplar


def sample(pixels):
    return Exemplar(np.clip(np.rint(pixels), 0, 255).astype(np.uint8))


def stones(rng, side):
    """Soft spots of any tone, and grain."""
    spots = smooth(rng.normal(size=(side, side, 1)), 9)[..., 0]
    return 128 + 44 * spots / spots.std() + rng.normal(0, 12, (side, side))


def test_wires_before_stones_are_told_by_both_families_of_lines():
    pixels = stones(np.random.default_rng(9), 192)
    for k in (0, 1):
        pixels[k::48] += 40
        pixels[:, k::40] += 40
    found = find_lattice(sample(pixels))
    assert found.same_as(Lattice(((40, 0), (0, 48)))) and found.confidence > 0.6


@pytest.mark.parametrize("shift", [0, 1 / 2, 1 / 3])
def test_what_crosses_rows_says_how_they_are_shifted(rng, shift):
    """Bricks of any tone; their joints cross rows at every second or third of these lines."""
    pixels, (wide, high) = rng.normal(120, 8, (192, 192)), (48, 24)
    for row in range(8):
        for piece in range(-1, 4):
            left = round(piece * wide + row % round(1 / shift if shift else 1) * shift * wide)
            end = max(left + wide, 0)
            pixels[row * high : (row + 1) * high, max(left, 0) : end] += rng.normal(0, 15)
            pixels[row * high : (row + 1) * high, max(left, 0) : max(left + 2, 0)] = 200
        pixels[row * high : row * high + 2] = 200
    fields = autocorrelations(sample(pixels))
    rows = Evidence(np.array([[0.0, 24.0]]), "rows")
    vectors = crossing_candidate(fields, rows).vectors
    truth = Lattice(((wide, 0), (shift * wide, high)))
    assert Lattice(tuple(map(tuple, vectors))).same_as(truth, 0.03)


@pytest.mark.parametrize("brick, number, speckles", [(12, 6, 0), (30, 4, 0.12)])
def test_blocks_of_bricks_that_turn(brick, number, speckles):
    rng = np.random.default_rng(0)
    wide, pixels = 2 * brick, np.empty((2 * brick * number, 2 * brick * number))
    for top, left in np.ndindex(number, number):
        block = np.full((wide, wide), 60.0)
        for k in (0, 1):
            block[k * brick + 1 : (k + 1) * brick, 1:] = rng.uniform(110, 200)
        turned = block if (top + left) % 2 else block.T
        pixels[wide * top : wide * (top + 1), wide * left : wide * (left + 1)] = turned
    dark = smooth(rng.normal(size=(*pixels.shape, 1)), 1.5)[..., 0]
    pixels[dark > np.quantile(dark, 1 - speckles)] *= 0.4
    assert find_lattice(sample(pixels)).same_as(Lattice(((wide, wide), (wide, -wide))))
    assert made_of(np.array([[24, 24], [24, -24]]), np.array([[12, 0], [0, 12.5]])) is not None
    assert made_of(np.array([[24, 24], [24, -24]]), np.array([[16, 0], [0, 12]])) is None


def test_threads_of_any_tone_do_not_alternate(rng):
    lines = np.repeat(np.arange(12), 12)
    kinds = lines % 2
    tones = rng.normal(size=(12, 40))
    tiles = tones[lines] + 0.1 * rng.normal(size=(144, 40))
    assert halves_agree(tiles, kinds, 2) > 0.8 > 0.4 > halves_agree(tiles, kinds, 2, 0, lines)
    tiles += 3 * kinds[:, None]
    assert halves_agree(tiles, kinds, 2, 0, lines) > 0.9


def test_lines_that_come_at_any_distance_are_no_rows():
    rng = np.random.default_rng(3)
    pixels, top = np.empty((192, 192)), 0
    for high in np.rint(rng.uniform(14, 44, 12)).astype(int):
        pixels[top : top + high] = 120 + rng.normal(0, 12)
        pixels[top : top + 2], top = 80, top + high
    assert find_lattice(sample(pixels + rng.normal(0, 10, pixels.shape))) is None


def test_vectors_longer_than_what_is_compared_stay_as_they_are(rng):
    correlation = rng.normal(size=(59, 39))
    vectors = np.array([[15.0, 2.0], [1.0, 21.0]])
    fitted, agreed = fit_vectors(correlation, vectors, 24)
    assert np.array_equal(fitted, vectors) and agreed == 0
