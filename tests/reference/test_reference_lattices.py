"""Lattices, and the methods that use them: equal bytes without options beyond the thesis."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import weftex
from families import noise, refused
from materials import wall
from twins.lattice import normalized_correlation
from weftex import reference
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.canvas import Canvas
from weftex.methods.best_tile import runs_of
from weftex.reference.best_tile import within
from weftex.reference.lattice import autocorrelation, goodness, identifiers, multiples

BOND = ((16, 0), (8, 12))


@pytest.mark.parametrize("border", [1, 2, 3, 4])
@pytest.mark.parametrize(
    "vectors", [((7, 0), (0, 6)), ((5.5, 2), (-3, 6.25)), ((-5, 3), (4, 5)), BOND]
)
def test_best_tile(vectors, border):
    sample = noise((37, 40, 3))
    expected = reference.best_tile(sample, (30, 33), vectors, border)
    method = weftex.BestTile(lattice=(*vectors[0], *vectors[1]), border_width=border)
    result = method.fit(weftex.Exemplar(sample)).sample(Canvas(30, 33), seed=0)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, expected.sources)


@given(st.lists(st.floats(-12, 12).map(lambda n: round(4 * n) / 4), min_size=4, max_size=4),
       st.integers(1, 4))  # fmt: skip
@example([-10.75, 10.75, -6.25, 0.75], 2)  # whose sides lead through corners of pixels
def test_pixels_near_a_tile(sides, reach):
    """By lines along its sides in the reference, and row by row in the method."""
    first, second = np.reshape(sides, (2, 2))
    rows = runs_of(first, second, reach).tolist()
    found = [[row, column] for row, left, right in rows for column in range(left, right)]
    assert sorted(found) == sorted(within(first, second, reach).tolist())


def test_a_tile_without_a_multiple_of_v1_has_no_goodness():
    """The text at Fig. 3.5: multiples of v2 alone do not count."""
    gamma = autocorrelation(wall(50, 55, spread=10))
    assert goodness(gamma, (48, 0), (8, 12)) == (0, 0)
    assert goodness(gamma, (8, 12), (48, 0))[0] > 1


@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("match", ["difference", "gncc"])
@pytest.mark.parametrize("blend", [0, 4, 6])
def test_near_regular(blend, match, seed):
    """With seeds by which no drawn block repeats what is beside it, which the method avoids."""
    sample = noise((110, 120, 3)) // 2 + wall(110, 120) // 2
    expected = reference.near_regular(sample, (17, 19), BOND, 8, 4, blend, 2, match, seed)
    joints = {"blend": "feather", "blend_width": blend} if blend else {"blend": "none"}
    method = weftex.NearRegular(
        defaults="paper", lattice=(*BOND[0], *BOND[1]), block_size=8, border_width=4, tolerance=2,
        match=match, **joints,
    )  # fmt: skip
    result = method.fit(weftex.Exemplar(sample)).sample(Canvas(17, 19), seed=seed)
    apart = abs(result.image.astype(int) - expected.image)
    assert apart.max() <= (1 if blend else 0)  # the method blends in steps of 1/256


def test_the_autocorrelation_is_that_of_each_overlap():
    """Eq. (3.10), shift by shift."""
    pixels = noise((9, 11, 2)).astype(int)
    np.testing.assert_allclose(
        autocorrelation(pixels), normalized_correlation(pixels.astype(float)), atol=1e-9
    )


@pytest.mark.parametrize(("v1", "v2"), [((5, 1), (-2, 4)), ((6, 0), (3, 5))])
def test_a_rectangle_contains_positions_within_the_tile(v1, v2):
    """Section 3.3.1: those that no multiple leads to another of."""
    shifts = multiples(v1, v2, 40, 40)
    for width, height in ((1, 1), (3, 8), (9, 2), (12, 12)):
        places = {(x, y) for x in range(width) for y in range(height)}
        again = {p for p in places if any((p[0] - x, p[1] - y) in places for x, y in shifts)}
        assert identifiers(v1, v2, width, height) == len(places - again)


@pytest.mark.parametrize("size", [(40, 44), (36, 50)])
def test_the_lattice_is_found(size):
    sample = wall(*size, spread=10)
    found = reference.lattice(sample)
    assert Lattice(found.vectors).same_as(Lattice(BOND), 0.05)
    assert find_lattice(weftex.Exemplar(sample), goodness="height").same_as(Lattice(BOND))


def test_sizes_that_do_not_fit_are_refused():
    sample = wall(30, 30)
    refused("block with its border is 31", reference.near_regular, sample, 20, BOND, 21, 10)
    refused("no such tile lies in the sample", reference.best_tile, sample, 20, ((29, 0), (0, 29)))
