"""Minimum-error paths against trying every path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from weft.seams import _kernels
from weft.search.boundary_zone import boundary_zone

import reference

SIDES = ("left", "top", "right", "bottom")


@given(
    arrays(np.int64, st.tuples(st.integers(1, 6), st.integers(1, 4)), elements=st.integers(0, 5))
)
def test_the_twins_agree(cost):
    assert reference.path_by_programming(cost) == reference.path_by_exhaustion(cost)


def kernel_cuts(canvas, pixels, corner, source, zone):
    rows, columns = zone.weight.shape
    cuts = np.full((2, 2 * (rows + columns)), 9999, np.uint16)
    cost = np.empty((max(rows, columns), int(zone.bands[0])), np.int64)
    _kernels.find_cuts(
        canvas, pixels, *corner, *source, zone.weight[None], zone.bands, cost, cuts, 1
    )
    assert (cuts[0] == 9999).all()  # only its own row
    return cuts[1]


@given(
    st.integers(1, 12),
    st.integers(1, 12),
    st.integers(1, 5),
    st.sets(st.sampled_from(SIDES), min_size=1),
    st.sampled_from([2, 4, 256]),
    st.integers(0, 2**30),
)
def test_cuts_follow_the_cheapest_paths(rows, columns, width, sides, levels, seed):
    rng = np.random.default_rng(seed)
    known = np.zeros((rows, columns), bool)
    known[:, :width] |= "left" in sides
    known[:width] |= "top" in sides
    known[:, -width:] |= "right" in sides
    known[-width:] |= "bottom" in sides
    canvas = rng.integers(0, levels, (15, 14, 2)).astype(np.uint8)
    pixels = rng.integers(0, levels, (16, 17, 2)).astype(np.uint8)
    corner = int(rng.integers(0, 15)), int(rng.integers(0, 14))
    source = int(rng.integers(0, 17 - rows)), int(rng.integers(0, 18 - columns))
    zone = boundary_zone(known, width)
    at = np.ix_((corner[0] + np.arange(rows)) % 15, (corner[1] + np.arange(columns)) % 14)
    new = pixels[source[0] : source[0] + rows, source[1] : source[1] + columns]
    weights, mask = reference.zone_weights(known, width), reference.zone_of(known, width)
    paths = reference.cut_sides(canvas[at], new, weights, mask, width)
    expected = reference.cut_row(paths, rows, columns)
    assert np.array_equal(kernel_cuts(canvas, pixels, corner, source, zone), expected)


def test_the_path_finds_the_place_where_patches_agree():
    """A zigzag of equal pixels in otherwise different ones is followed exactly."""
    known = np.zeros((6, 8), bool)
    known[:, :4] = True
    zone = boundary_zone(known, 4)
    canvas = np.full((6, 8, 1), 200, np.uint8)
    pixels = np.zeros((6, 8, 1), np.uint8)
    path = [1, 2, 3, 2, 1, 0]
    for v, u in enumerate(path):
        pixels[v, u] = 200
    # Only the left side has a band that is longer than it is deep.
    bands = zone.bands.copy()
    bands[3:] = 1, 0, 0, 0
    cuts = np.zeros((1, 2 * (6 + 8)), np.uint16)
    cost = np.empty((8, 4), np.int64)
    _kernels.find_cuts(canvas, pixels, 0, 0, 0, 0, zone.weight[None], bands, cost, cuts, 0)
    assert cuts[0, :6].tolist() == path


@pytest.mark.parametrize("level", [0, 7])
def test_equal_patches_are_cut_at_the_border(level):
    """Every path costs nothing: ties go to the pixel nearest to the window's border."""
    known = np.zeros((9, 9), bool)
    known[:3] = known[:, :3] = True
    zone = boundary_zone(known, 3)
    flat = np.full((9, 9, 1), level, np.uint8)
    cut = kernel_cuts(flat, flat, (0, 0), (0, 0), zone)
    assert cut[:9].tolist() == [0] * 9 and cut[18:27].tolist() == [0] * 9


def test_costs_of_long_bands_do_not_overflow():
    length = 40000
    known = np.zeros((length, 2), bool)
    known[:, :1] = True
    zone = boundary_zone(known, 1)
    canvas, pixels = np.zeros((length, 2, 1), np.uint8), np.full((length, 2, 1), 255, np.uint8)
    bands = zone.bands.copy()
    bands[3:] = 1, 0, 0, 0
    cost = np.empty((length, 1), np.int64)
    cuts = np.zeros((1, 2 * (length + 2)), np.uint16)
    _kernels.find_cuts(canvas, pixels, 0, 0, 0, 0, zone.weight[None], bands, cost, cuts, 0)
    assert cost[-1, 0] == length * 255**2 > 2**31
