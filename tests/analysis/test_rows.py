"""Rows and bonds, told by sums of edges: of faint joints, at any slant, and not of stones."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from analysis.test_lattice import smooth
from weftex.analysis.bonds import find_bond, rated_bond
from weftex.analysis.joints import Joints, alike
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.relief import Relief, relief
from weftex.analysis.rows import find_rows, rated_rows
from weftex.exemplar import Exemplar

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from drawn import draw


def joints_of(levels):
    return Joints(Relief(np.atleast_3d(levels).transpose(2, 0, 1), np.ones(levels.shape[:2]), 1))


def courses(rng, angle=0.0, period=24.0, joint=0.4, size=200):
    """Stones of any tone and length, with joints of less contrast than the stones have."""
    y, x = np.mgrid[:size, :size] - size / 2
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    down, along = c * y - s * x + 1000, c * x + s * y + 1000
    row = np.floor(down / period).astype(int)
    start, long = 37 * rng.random(999)[row % 999], 21 + 30 * rng.random(999)[row % 999]
    piece = np.floor((along + start) / long)
    levels = rng.standard_normal((99, 999))[row % 99, piece.astype(int) % 999]
    levels[down % period < 1.5] -= joint
    return levels + 0.1 * smooth(rng.standard_normal((size, size, 1)), 1.0)[..., 0]


@pytest.mark.parametrize("angle", [0, 1.3, -20, 90, 131])
def test_faint_courses_are_found_at_any_slant(angle, rng):
    rows = find_rows(joints_of(courses(rng, angle)))
    turn = np.deg2rad(angle)
    expected = 24 * np.array([-np.sin(turn), np.cos(turn)])
    assert min(abs(rows.vector - expected).max(), abs(rows.vector + expected).max()) < 0.8
    assert rows.sure > 5 and rows.apart > 5


@pytest.mark.parametrize("kind", ["stones", "clouds", "leaves", "disks", "blobs"])
def test_what_has_no_rows_looks_alike_along_all_lines(kind):
    rows = find_rows(Joints(relief(Exemplar(draw(kind, 3, 192)[0]))))
    assert rows is None or rows.apart < 4 or rows.sure < 3


def test_ribs_are_told_by_tones():
    """Both sides of a rib have edges, half of its period apart."""
    y = np.arange(160)[:, None] + np.zeros(160)
    rows = find_rows(joints_of(np.tanh(3 * np.sin(2 * np.pi * y / 20))))
    assert abs(rows.vector - [0, 20]).max() < 0.3 and rows.sure > 5
    assert rated_rows(joints_of(np.cos(2 * np.pi * y / 20)), np.array([0.0, 30.0])).contrast < 0.2


def test_constant_and_tiny_samples_have_no_rows():
    for shape in ((1, 1), (3, 40), (12, 12), (64, 64)):
        assert find_rows(joints_of(np.zeros(shape))) is None


def test_a_mask_has_no_edge(rng):
    """What may not be used, and its border, is left out of every sum."""
    levels, usable = courses(rng, 0), np.ones((200, 200))
    usable[60:150, 40:180] = 0
    rows = find_rows(Joints(Relief((levels * usable)[None], usable, 1)))
    assert abs(abs(rows.vector) - [0, 24]).max() < 0.8


def test_correlations_of_sums(rng):
    """Beside the definition, of what overlaps."""
    values = rng.standard_normal(40)
    found = alike(values, 20)
    for k in range(20):
        assert found[k] == pytest.approx(np.corrcoef(values[: 40 - k], values[k:])[0, 1])
    assert not alike(np.ones(30), 9).any()


@pytest.mark.parametrize("shift", [0, 0.5, 1 / 3])
def test_the_bond_under_courses(shift, rng):
    """Bricks of any tone; joints between them that are off by a pixel."""
    y, x = np.mgrid[:220, :220]
    row = y // 20
    k = np.floor((x + rng.normal(0, 1, 99)[row] + shift * 50 * row) / 50).astype(int)
    aside = (x + shift * 50 * row) % 50
    levels = rng.standard_normal((99, 99))[row, k]
    levels[(y % 20 < 2) | (aside < 2)] = 0.5
    joints = joints_of(levels + 0.2 * rng.standard_normal(levels.shape))
    rows = rated_rows(joints, np.array([0.0, 20.0]))
    bond = find_bond(joints, rows)
    truth = Lattice(((50, 0), (-shift * 50, 20)))
    assert Lattice(tuple(map(tuple, bond.vectors.tolist()))).same_as(truth, 0.04)
    assert bond.contrast > 0.25 and bond.sure > 6
    again = rated_bond(joints, rows, np.array(truth.vectors))
    assert again.contrast > 0.25
    assert rated_bond(joints, rows, np.array([[50.0, 5.0], [0.0, 31.0]])) is None


def test_courses_of_any_length_have_no_bond(rng):
    joints = joints_of(courses(rng))
    bond = find_bond(joints, rated_rows(joints, np.array([0.0, 24.0])))
    assert bond is None or bond.contrast < 0.2


@pytest.mark.parametrize(("kind", "seed"), [("basket", 21), ("basket", 22), ("herringbone", 23)])
def test_pieces_that_lie_and_stand_in_turn(kind, seed):
    """Their tones are any, so kinds of cell differ by their edges; and some by six or eight."""
    pixels, truth = draw(kind, seed)
    found = find_lattice(Exemplar(np.ascontiguousarray(pixels[128:384, 128:384])))
    assert found is not None and found.same_as(Lattice(truth), 0.04)
