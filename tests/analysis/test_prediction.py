"""Lattices map edges onto edges, direction included: pieces that turn, and fixtures on rows."""

import numpy as np
import pytest

from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.prediction import predicting
from weftex.exemplar import Exemplar


def photo(levels, rng):
    """Levels with grain and uneven light, in color."""
    light = np.linspace(-12, 12, levels.shape[1]) + rng.normal(0, 8, levels.shape)
    pixels = (levels + light)[..., None] * [1, 0.9, 0.8]
    return Exemplar(np.clip(np.rint(pixels), 0, 255).astype(np.uint8))


def blocks(rng, wide, long, slanted, split=1, side=256):
    """Herringbone: blocks of any tone, each set against the side of another."""
    y, x = np.mgrid[:side, :side] + 3000.5
    if slanted:
        x, y = (x + y) / 2**0.5, (y - x) / 2**0.5
    i, j = np.floor(x / wide).astype(int), np.floor(y / wide).astype(int)
    part = (i - j) % (2 * long)
    lying = part < long
    first = np.where(lying, i - part, j + part - 2 * long + 1)
    along = np.where(lying, x, y) - first * wide
    piece, across = np.divmod(np.where(lying, y, x) % wide, wide / split)
    ends = np.minimum(along, long * wide - along)
    joint = np.minimum(ends, np.minimum(across, wide / split - across)) < 1.2
    number = first * 3 + piece.astype(int), np.where(lying, j, i + 256)
    tones = rng.normal(130, 18, (512, 512))[number[0] % 512, number[1] % 512]
    vectors = np.array([[wide, wide], [2 * long * wide, 0.0]])
    if slanted:
        vectors = vectors @ np.array([[1, 1], [-1, 1]]) / 2**0.5
    return np.where(joint, 60, tones), Lattice(tuple(map(tuple, vectors)))


@pytest.mark.parametrize("slanted", [False, True], ids=["90", "45"])
@pytest.mark.parametrize("wide, long, split", [(27, 2, 1), (29, 3, 1), (24, 2, 2)])
def test_lying_blocks_are_not_mapped_onto_standing_ones(wide, long, split, slanted):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        levels, truth = blocks(rng, wide, long, slanted, split)
        found = find_lattice(photo(levels, rng))
        assert found is not None and found.same_as(truth, 0.04), (seed, found)


@pytest.mark.parametrize("apart", [30, 44, 60])
def test_a_pair_of_bolts_on_each_board_is_no_lattice(apart):
    """The second bolt of a pair is where the first one was, and nothing is where it was."""
    rng = np.random.default_rng(apart)
    y, x = np.mgrid[:400, :400]
    levels = 110 + np.repeat(rng.normal(0, 8, 10), 40)[:, None] + rng.normal(0, 3, (400, 1))
    levels = np.where(y % 40 < 2, 50, levels)
    for place in (150, 150 + apart):
        levels[np.hypot(x - place, y % 40 - 20) < 4] = 220
    found = find_lattice(photo(levels, rng))
    assert found is None or found.same_as(Lattice(((0, 40),)), 0.06)


@pytest.mark.parametrize("half", [(1, 0), (0, 1), (1, 1)])
def test_a_vector_of_which_every_second_multiple_alone_meets_lines_is_doubled(half, rng):
    y, x = np.mgrid[:256, :256] + 37
    levels = np.where((y % 137 < 10) | (x % 137 < 10), 60, 130)
    found = predicting(autocorrelations(photo(levels, rng)), np.diag(np.where(half, 68.5, 137.0)))
    assert abs(np.abs(found) - np.diag([137, 137])).max() < 1
