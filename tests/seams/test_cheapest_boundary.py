"""The boundary between two pictures that shows least."""

import numpy as np
import pytest

from twins.maxflow import least_labelling
from weftex.seams.boundary import HELD, UNIT, _costs, cheapest_boundary


def costs_by_definition(first, second):
    """What each pair of neighbors costs, by what `cheapest_boundary` says."""
    height, width = first.shape[:2]
    seen, edges = {}, {}
    for y, x in np.ndindex(height, width):
        for v, u in ((y, x + 1), (y + 1, x), (y, x - 1), (y - 1, x)):
            if 0 <= v < height and 0 <= u < width:
                p, q = (y, x), (v, u)
                seen[p, q] = int(np.abs(second[p].astype(int) - first[q]).sum())
                edges[p, q] = sum(
                    int(np.abs(of[p].astype(int) - of[q]).sum()) for of in (first, second)
                )
    strong = 2 * (sum(edges.values()) // max(1, len(edges))) + 1
    squares = {
        k: (s * (2 * strong - min(edges[k], strong)) * 128 // strong // 16) ** 2
        for k, s in seen.items()
    }
    mean = sum(squares.values()) // max(1, len(squares)) + 1
    small = sorted(squares.values())[len(squares) // 4] if squares else 0
    unit = max(1, small, mean // 16)
    return {k: min(s * UNIT // unit, 256 * UNIT) + 1 for k, s in squares.items()}


@pytest.mark.parametrize("shape", [(9, 12), (20, 15), (1, 9), (2, 2)])
@pytest.mark.parametrize("seed", range(3))
def test_it_is_a_minimum_cut(shape, seed):
    rng = np.random.default_rng(seed)
    first, second = rng.integers(0, 256, (2, *shape, 3)).astype(np.uint8)
    leaning = rng.integers(-300, 300, shape).astype(np.int32)
    leaning[:, 0], leaning[:, -1] = -HELD, HELD
    side = cheapest_boundary(first, second, leaning)
    assert not side[:, 0].any() and side[:, -1].all()
    costs = costs_by_definition(first, second)
    value = sum(c for (p, q), c in costs.items() if side[p] and not side[q])
    value += int(np.abs(leaning)[(leaning > 0) != side][leaning[(leaning > 0) != side] != 0].sum())
    number = np.arange(side.size).reshape(shape)
    arcs = {(number[p], number[q]): c for (p, q), c in costs.items()}
    least = least_labelling((-leaning.ravel()).tolist(), arcs)[1]
    assert value == least + int(leaning[leaning > 0].sum())


def test_what_takes_no_part_costs_nothing(rng):
    first, second = rng.integers(0, 256, (2, 6, 8, 3)).astype(np.uint8)
    free = np.ones((6, 8), bool)
    free[:, 4] = False
    costs = _costs(first.astype(np.int32), second.astype(np.int32), free)
    assert not costs[:, 4].any() and not costs[:, 3, 0].any() and not costs[:, 5, 2].any()
    assert (costs[:, :3, 0] > 0).all()


@pytest.mark.parametrize("wrap", [(True, False), (False, True), (True, True)])
def test_around_a_border_it_goes_on(wrap, rng):
    """A picture moved around has its boundary in the same places, where that has no choice."""
    first = rng.integers(0, 40, (24, 30, 3)).astype(np.uint8)
    second = (first + 200).astype(np.uint8)
    y, x = np.indices((24, 30))
    # A path of no steps for the boundary, across the border.
    inside = ((y - 12) ** 2 + (x - 15) ** 2) < 49
    leaning = np.where(inside, HELD, -HELD).astype(np.int32)
    moved = [n // 2 * wraps for n, wraps in zip((24, 30), wrap, strict=True)]
    side = cheapest_boundary(
        *(np.roll(each, moved, (0, 1)) for each in (first, second, leaning)), wrap=wrap
    )
    assert np.array_equal(side, np.roll(inside, moved, (0, 1)))


def test_it_closes_around_a_border(rng):
    """Where it leaves at the right it comes in at the left."""
    first, second = rng.integers(0, 256, (2, 30, 40, 3)).astype(np.uint8)
    leaning = np.zeros((30, 40), np.int32)
    leaning[:4], leaning[-4:] = -HELD, HELD
    side = cheapest_boundary(first, second, leaning, wrap=(False, True))
    around = np.concatenate([side[:, -1:], side[:, :1]], axis=1)
    # A cut that is not closed differs at the border by half of the free rows.
    assert (around[:, 0] != around[:, 1]).sum() <= 6
