"""Lattices in words: a running bond is as long as its bricks and not as its diagonals."""

import math

import pytest

from weftex.analysis.lattice import Lattice
from weftex.analysis.overlay import courses


@pytest.mark.parametrize(
    "vectors, words",
    [
        (((64, 64), (64, -64)), "128 x 64 px, every other row shifted by half"),
        (((62.73, 41.85), (63.42, -41.69)), "126.2 x 41.8 px, every other row shifted by half"),
        (((126, 0), (42, 41)), "126 x 41 px, each row shifted by a third"),
        (((126, 0), (84, 41)), "126 x 41 px, each row shifted by a third"),
        (((100, 0), (25, 30)), "100 x 30 px, each row shifted by a quarter"),
        (((100, 0), (41, 30)), "100 x 30 px, each row shifted by 0.41"),
        (((100, 1), (-1, 30)), "100 x 30 px"),
        (((20, 0), (0, 20)), "20 x 20 px"),
        (((41, 64), (-41, 64)), "41 x 128 px, every other column shifted by half"),
        (((31, 0), (0, 102)), "31 x 102 px"),
        (((85.34, -0.58), (43.08, 85.43)), "85.3 x 85.7 px, every other row shifted by half"),
        (((0, 18.75),), "18.8 px"),
    ],
)
def test_sides_and_shifts(vectors, words):
    assert courses(Lattice(vectors)) == words
    if len(vectors) == 2:  # by whatever vectors of the same lattice
        (a, b), (c, d) = vectors
        assert courses(Lattice(((a + 2 * c, b + 2 * d), (-c, -d)))) == words


def test_a_lattice_that_lies_aslant_has_lengths():
    for angle in (0.3, 0.6):
        c, s = math.cos(angle), math.sin(angle)
        found = courses(Lattice(((30 * c, 30 * s), (-70 * s, 70 * c))))
        assert found == "30 x 70 px"
