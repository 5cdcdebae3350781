"""Narrow peaks before broad ones: meshes before stones, and what chance makes of noise."""

import sys
from pathlib import Path

import numpy as np
import pytest

from analysis.test_lattice import assert_found, smooth
from weftex.analysis.correlation import correlate, whitened
from weftex.analysis.evidence import SUREST, Evidence, better_pair
from weftex.analysis.lattice import find_lattice
from weftex.analysis.lines import find_rows
from weftex.analysis.relief import Relief, relief
from weftex.exemplar import Exemplar

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks" / "quality"))
from drawn import draw


def flat_of(levels):
    return Relief(levels[None], np.ones(levels.shape), 1)


def test_of_noise_nothing_but_chance_is_left(rng):
    """Whatever its color: as much as white noise has, one over the root of what overlaps."""
    shares = np.outer(1 - abs(np.arange(-95, 96)) / 96, 1 - abs(np.arange(-127, 128)) / 128)
    far = shares >= 0.05
    far[95 - 30 : 95 + 31, 127 - 30 : 127 + 31] = False  # near shifts are not white
    for radius in (0.0, 2.0, 8.0):
        noise = smooth(rng.standard_normal((192, 256, 1)), radius)[:96, :128, 0]
        found, chance = whitened(flat_of(noise / noise.std()))
        assert found[95, 127] == 1 and 0.01 < chance < 0.1
        assert abs(found * shares**0.5)[far].max() < 8 * chance
        assert np.allclose(found, found[::-1, ::-1], atol=1e-9)


def test_a_mesh_is_narrow_before_stones(rng):
    """Stones correlate over more than the mesh's distance, which has a peak in one view only."""
    stones = smooth(rng.standard_normal((160, 160, 1)), 9.0)[..., 0]
    y, x = np.mgrid[:160, :160]
    levels = 40 * stones / stones.std()
    levels[(y % 32 < 2) | (x % 27 < 2)] = 25
    sample = Exemplar(np.clip(128 + levels + rng.normal(0, 4, levels.shape), 0, 255))
    assert_found(sample, ((27, 0), (0, 32)), 0.03)
    fields = relief(sample)
    white, chance = whitened(fields)
    own = correlate(fields.levels)

    def stands_out(correlation):
        around = correlation[159 + 32 - 6 : 159 + 32 + 7, 159 + 27 - 6 : 159 + 27 + 7]
        return around[5:8, 5:8].max() - np.median(around)

    assert stands_out(white) > 5 * chance and stands_out(own) < 0.5


@pytest.mark.parametrize("name", ["mesh 0", "hexagons 0", "bricks 3", "flemish 0", "flemish 2"])
def test_chance_makes_no_tile_better(name):
    """Of the plain correlation a tile of four to seven, or a part of a period, was the best."""
    pixels, truth = draw(name[:-2], int(name[-1]))
    assert_found(Exemplar(np.ascontiguousarray(pixels[:256, 256:])), truth, 0.04)


@pytest.mark.parametrize("seed", [0, 1, 2, 4, 5])
def test_courses_of_any_height_are_no_rows(seed):
    """Some of their ridges are high by chance, and others are not."""
    pixels, truth = draw("any courses", seed)
    assert truth == ()
    assert find_lattice(Exemplar(np.ascontiguousarray(pixels[:256, 256:]))) is None


def test_rows_are_the_closest_that_stand_out_as_much():
    pixels, truth = draw("ribs", 0)
    found = find_rows(relief(Exemplar(np.ascontiguousarray(pixels[:256, 256:]))))
    assert found is not None and abs(abs(found[0]) - np.abs(truth[0])).max() < 0.2


def test_a_copy_is_no_lattice(rng):
    """A part of a picture that is pasted once gives one high multiple."""
    pixels = rng.integers(0, 256, (160, 160), np.uint8)
    pixels[90:150, 80:150] = pixels[10:70, 5:75]
    assert find_lattice(Exemplar(pixels)) is None


def test_confidence_grows_with_either_figure():
    def of(contrast, clear, number=30):
        return Evidence(np.eye(2), "pairs", contrast, clear, number).confidence

    assert of(-0.1, -2) == of(0, 0) < 0.1
    for low, high in ((of(0, 1), of(0, 3)), (of(0.02, 1), of(0.1, 1)), (of(0, 2, 4), of(0, 2, 40))):
        assert low < high
    assert of(1, 1e9) == pytest.approx(SUREST) and of(0, -1e300) > 0


def test_the_clearer_pair_is_taken_if_it_has_half_of_the_contrast():
    strong = Evidence(np.array([[20.0, 0.0], [0.0, 17.0]]), "pairs", 0.3, 1.0, 9)
    clear = Evidence(np.array([[7.0, 1.0], [0.0, 9.0]]), "pairs", 0.1, 5.0, 9)
    half, same = clear._replace(contrast=0.15), strong._replace(vectors=strong.vectors + 0.01)
    assert better_pair([]) is None and better_pair([clear]) is clear
    for other, better in ((clear, strong), (half, half), (same, strong)):
        assert better_pair([strong, other]) is better
