"""Rows by their joints: edges along lines, of strips that share no pixel."""

import numpy as np
import pytest

from analysis.test_lattice import smooth
from weftex.analysis.autocorrelations import autocorrelations
from weftex.analysis.bonds import Bonds
from weftex.analysis.evidence import Evidence, bond_candidate, checked_by_rows, row_candidate
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.lines import Courses, checked, edges_of, find_courses
from weftex.analysis.relief import Relief, relief
from weftex.exemplar import Exemplar


def courses(rng, heights, side=192, turned=False):
    """Stones of any tone and width in courses of such heights, with joints of one tone."""
    pixels = np.full((side, side, 3), 90.0)
    top = 0
    for height in heights:
        left = -int(rng.integers(0, 30))
        while left < side:
            wide = int(rng.integers(24, 60))
            tone = rng.uniform(60, 200) + rng.normal(0, 12, 3)
            pixels[max(top, 0) + 2 : top + height, max(left + 2, 0) : max(left + wide, 0)] = tone
            left += wide
        top += height
    pixels += rng.normal(0, 12, pixels.shape)
    found = np.clip(np.rint(pixels), 0, 255).astype(np.uint8)
    return found.swapaxes(0, 1).copy() if turned else found


@pytest.mark.parametrize("turned", [False, True])
def test_courses_whose_heights_differ_by_a_tenth_are_rows(rng, turned):
    heights = [34, 39, 36, 41, 35, 38]
    found = find_lattice(Exemplar(courses(rng, heights, turned=turned)))
    assert found is not None and len(found.vectors) == 1 and found.confidence > 0.6
    assert found.vectors[0][0 if turned else 1] == pytest.approx(np.mean(heights), rel=0.05)
    assert found.vectors[0][1 if turned else 0] == pytest.approx(0, abs=1)


def test_courses_of_any_height_are_none(rng):
    assert find_lattice(Exemplar(courses(rng, [20, 62, 31, 50, 18, 40]))) is None


def test_a_strip_knows_nothing_of_the_others(rng):
    noise = edges_of(Relief(rng.normal(size=(1, 96, 96)), np.ones((96, 96)), 1))
    assert abs(noise.alike(0.3)[:48]).max() < 0.3
    lines = np.repeat(rng.normal(size=(1, 96, 1)), 96, axis=2)
    assert edges_of(Relief(lines, np.ones((96, 96)), 1)).alike(0.0)[0] == pytest.approx(1, abs=1e-6)


def test_what_a_mask_leaves_out_has_no_joints(rng):
    pixels = courses(rng, [36] * 6)
    mask = np.ones(pixels.shape[:2], bool)
    mask[60:110, 40:120] = False
    pixels[~mask] = rng.integers(0, 256, (int((~mask).sum()), 3))
    found = find_courses(relief(Exemplar(pixels, mask=mask)))
    assert found is not None and abs(found.vector[1]) == pytest.approx(36, abs=1)


def test_confidence_of_rows_grows_with_each_figure():
    def of(height, alike, contrast=0.0, clear=0.0):
        sure = Courses(np.eye(2)[0], height, alike).sure
        return Evidence(np.eye(2)[:1], "rows", contrast, clear, 3, sure).confidence

    assert of(-1, 0.5) == of(0, 0.5) == of(0.5, -1) < of(0.3, 0.5) < of(0.5, 0.5) < of(0.5, 0.8)
    assert of(0.3, 0.5) < of(0.3, 0.5, 0.1) < of(0.3, 0.5, 0.1, 1.0)
    assert of(2, 1) == pytest.approx(0.95, abs=1e-3)


def test_a_pair_by_chance_is_rows(rng):
    """Two vectors that each lead some rows on, and stones of any width: nothing else tells them."""
    rows = autocorrelations(Exemplar(courses(rng, [34, 39, 36, 41, 35, 38])))
    chance = Evidence(np.array([[92.0, -37.0], [76.0, 74.0]]), "pairs", 0.1, 5.0, 9)
    assert checked_by_rows(rows, chance).vectors.shape == (1, 2)


def test_a_mesh_is_no_rows(rng):
    """Joints along both families of its lines tell a lattice that joints within rows do not."""
    pixels = rng.normal(120, 30, (192, 192))
    pixels[::32], pixels[:, ::24] = 220, 220
    pixels[1::32], pixels[:, 1::24] = 220, 220
    mesh = Evidence(np.array([[24.0, 0.0], [0.0, 32.0]]), "pairs", 0.1, 5.0, 9)
    fields = autocorrelations(Exemplar(np.clip(np.rint(pixels), 0, 255).astype(np.uint8)))
    assert checked_by_rows(fields, mesh) is mesh


def test_rows_of_a_bond_are_told_by_the_joints_within_them(rng):
    fields = autocorrelations(Exemplar(courses(rng, [36] * 6)))
    y, x = np.mgrid[-143:144, -191:192]
    piece = np.cos(2 * np.pi * x / 48 + np.pi * y / 18)
    bonds = Bonds(piece * (np.cos(np.pi * y / 18) > 0.9), np.array([0.0, 18.0]))
    vectors, sure, _ = bonds.best()
    assert Lattice(tuple(map(tuple, vectors))).same_as(Lattice(((48, 0), (24, 18))), 0.03)
    assert sure > 3 > 1.5 > bonds.of(np.array([[30.0, 0.0], [8.0, 18.0]]))
    assert bonds.of(np.array([[48.0, 5.0], [3.0, 40.0]])) is None and bonds.best(half=True)[2] > 0.5
    assert bond_candidate(fields, row_candidate(fields)).bond < 3


def test_checks_of_which_two_are_seen_are_as_sure_as_others(rng):
    side = 208
    warp, weft = (np.tanh(4 * np.sin(2 * np.pi * np.arange(side) / n)) for n in (70, 100))
    dirt = smooth(rng.normal(size=(side, side, 1)), 10)[..., 0]
    levels = 128 + 16 * np.add.outer(weft, warp) + 14 * dirt / dirt.std()
    levels += rng.normal(0, 10, levels.shape)
    found = find_lattice(Exemplar(np.clip(np.rint(levels), 0, 255).astype(np.uint8)))
    assert found is not None and found.same_as(Lattice(((70, 0), (0, 100))), 0.08)
    assert found.confidence > 0.9


def test_stripes_of_any_width_are_no_checks(rng):
    ends = np.zeros(208)
    ends[np.cumsum(rng.integers(12, 60, 8))[:6] % 208] = 1
    tone = np.cumsum(ends) % 2 * 100 + 60
    plain = np.add.outer(tone, tone[::-1]) + rng.normal(0, 10, (208, 208))
    flat = relief(Exemplar(np.clip(np.rint(plain), 0, 255).astype(np.uint8)))
    for high in (40, 60, 80, 100):
        told = checked(flat, np.array([[70.0, 0.0], [0.0, high]]))
        assert told.contrast < 0.3 < told.alike
    assert checked(flat, np.array([[70.0, 0.0], [0.0, 8.0]])) is None


def bond(rng, length, high, jitter, size=256):
    """Courses of bricks of any tone; each joint is off by so many pixels."""
    levels = np.full((size, size, 3), 90.0)
    for row in range(-1, size // high + 2):
        top = row * high + rng.normal(0, jitter / 3)
        below, above = max(0, round(top + high - 2)), max(0, round(top + 2))
        for k in range(-2, size // length + 2):
            left, right = (k + np.array([0, 1]) + (row % 2) / 2) * length
            left, right = rng.normal((left, right), jitter)
            columns = slice(max(0, round(left + 2)), max(0, round(right - 2)))
            levels[above:below, columns] = 160 + rng.normal(0, 18, 3)
    return (levels + rng.normal(0, 10, levels.shape)).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("jitter, wide, high", [(0, 54, 20), (4, 54, 20), (2, 124, 46)])
def test_uneven_bonds(jitter, wide, high):
    for seed in range(5):
        found = find_lattice(Exemplar(bond(np.random.default_rng(seed), wide, high, jitter)))
        assert found is not None and found.same_as(Lattice(((wide, 0), (wide / 2, high))), 0.04)
