"""Running bonds whose bricks are not laid to the pixel."""

from __future__ import annotations

import numpy as np
import pytest

from weftex.analysis.lattice import Lattice, find_lattice
from weftex.exemplar import Exemplar


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


@pytest.mark.parametrize("jitter", [0, 2, 4])
def test_uneven_bonds(jitter):
    for seed in range(5):
        found = find_lattice(Exemplar(bond(np.random.default_rng(seed), 54, 20, jitter)))
        assert found is not None and found.same_as(Lattice(((54, 0), (27, 20))), 0.04)
