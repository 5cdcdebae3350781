"""Two samples merged: islands of one in the other."""

import numpy as np
import pytest
from scipy.ndimage import label

import weftex
from weftex.seams.merge import islands


def parts(mask):
    """Each connected part of a mask."""
    numbers, count = label(mask)
    return [numbers == k for k in range(1, count + 1)]


@pytest.fixture(scope="module")
def merged():
    sea, land = (weftex.load_exemplar(f"sample:{name}").pixels for name in ("leaves", "pebbles"))
    usable = np.ones(land.shape[:2], bool)
    return islands(sea, land, usable, 15, seed=3), land.shape


def test_islands_are_several_each_of_its_own_shape_and_place(merged):
    found, land = merged
    whole = [p for p in parts(found >= 0) if p.sum() > 40]
    assert len(whole) >= 4
    shapes, offsets = set(), set()
    for part in whole:
        y, x = np.nonzero(part)
        shapes.add(part[y.min() : y.max() + 1, x.min() : x.max() + 1].tobytes())
        v, u = np.divmod(found[part], land[1])
        # One piece of the other sample, laid as a whole.
        assert len(np.unique(v - y)) == 1 and len(np.unique(u - x)) == 1
        offsets.add((int(v[0] - y[0]), int(u[0] - x[0])))
    assert len(shapes) == len(whole) and len(offsets) == len(whole)
    assert (0, 0) not in offsets


def test_no_island_hugs_a_square(merged):
    """Neither do its sides follow the axes, nor does it fill the box around it."""
    for part in parts(merged[0] >= 0):
        if part.sum() < 200:
            continue
        y, x = np.nonzero(part)
        box = (y.max() - y.min() + 1) * (x.max() - x.min() + 1)
        assert part.sum() / box < 0.85
        firsts = [int(np.flatnonzero(line)[0]) for line in part[y.min() : y.max() + 1]]
        longest = max(np.diff(np.flatnonzero(np.diff(firsts, prepend=-1, append=-1))), default=0)
        assert longest <= 12


def test_only_usable_pixels_are_shown(rng):
    sea, land = rng.integers(0, 256, (2, 60, 64, 3)).astype(np.uint8)
    usable = np.zeros((60, 64), bool)
    usable[:, 20:] = True
    found = islands(sea, land, usable, 5, seed=1)
    assert (found >= 0).any()
    assert usable.ravel()[found[found >= 0]].all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (4, 3), (9, 9), (40, 7)])
@pytest.mark.parametrize("other", [(1, 1), (12, 12)])
def test_small_samples(shape, other):
    sea, land = np.zeros((*shape, 3), np.uint8), np.full((*other, 3), 9, np.uint8)
    found = islands(sea, land, np.ones(other, bool), 7, seed=2)
    assert found.shape == shape and found.max() < land[..., 0].size
