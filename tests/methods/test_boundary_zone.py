"""The squares of boundary zones, and long and wide ones; see `brute_force` for zones of patches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import distance_transform_cdt

from weftex.methods.patches import patch_kernels as _kernels
from weftex.methods.patches.boundary_zone import boundary_zone

masks = arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12)))
widths = st.integers(1, 6)


def zone_of(known, width):
    """The band of width w_E along the border: known, and that near something unknown."""
    return known & (distance_transform_cdt(known, "chessboard") <= width) & (not known.all())


@given(masks, widths, st.sampled_from([1, 2, 4, 8, 16]))
def test_squares_lie_in_the_zone(known, width, square_side):
    zone = boundary_zone(known, width, square_side=square_side)
    expected = zone_of(known, width)
    assert zone.side <= min(square_side, width)
    assert zone.side & (zone.side - 1) == 0
    for v, u in zone.squares.tolist():
        block = expected[v : v + zone.side, u : u + zone.side]
        assert block.shape == (zone.side, zone.side)
        assert block.all()
    assert (len(zone.squares) > 0) == bool(expected.any())


@given(masks, widths, st.sampled_from([1, 2, 4, 8]))
def test_squares_share_little(known, width, square_side):
    """Whole squares first, then those that are at least half new, until there are no more."""
    zone = boundary_zone(known, width, square_side=square_side, most_squares=10**6)
    side = zone.side
    seen, shares = np.zeros(known.shape, bool), []
    for v, u in zone.squares.tolist():
        own = seen[v : v + side, u : u + side]
        shares.append(np.count_nonzero(~own))
        own[:] = True
    whole = [share == side * side for share in shares]
    assert whole == sorted(whole, reverse=True)
    assert all(2 * share >= side * side for share in shares)
    expected = zone_of(known, width)
    for v, u in np.argwhere(expected).tolist():
        block = expected[v : v + side, u : u + side]
        if block.shape == (side, side) and block.all():
            left = np.count_nonzero(~seen[v : v + side, u : u + side])
            assert 2 * left < side * side or (side == 1 and left == 0)
    assert len(zone.squares) * side * side * 2 >= expected.sum()


@pytest.mark.parametrize("most", [1, 5, 16, 1000])
def test_squares_are_thinned_out_evenly(most):
    known = np.zeros((64, 64), bool)
    known[:, :4] = known[:4] = True
    every = boundary_zone(known, 4, most_squares=10**6).squares.tolist()
    some = boundary_zone(known, 4, most_squares=most).squares.tolist()
    assert len(some) == min(most, len(every))
    kept = [every.index(block) for block in some]
    assert kept == sorted(set(kept))
    if 1 < most < len(every):
        gaps = np.diff(kept)
        assert kept[0] == 0 and kept[-1] == len(every) - 1 and gaps.max() - gaps.min() <= 1


def test_squares_cover_most_of_the_zones_of_the_paper():
    for left, top in ((True, False), (False, True), (True, True)):
        known = np.zeros((64, 64), bool)
        known[:, :4] |= left
        known[:4] |= top
        zone = boundary_zone(known, 4)
        seen = np.zeros_like(known)
        for v, u in zone.squares.tolist():
            seen[v : v + zone.side, u : u + zone.side] = True
        assert zone.side == 4
        assert np.array_equal(seen, known)  # 16 + 15 squares for the L, as section 3.3 counts them
        if left and top:
            assert len(zone.squares) == 31


@pytest.mark.parametrize("width", [255, 256, 300, 700])
def test_a_very_wide_zone_is_blended_everywhere(width):
    known = np.zeros((1, 2 * width), bool)
    known[:, :width] = True
    zone = boundary_zone(known, width)
    assert zone.area == width
    assert (zone.weight[known] > 0).all(), "weight 0 means the canvas stays, also when it is cut"


def test_distances_of_long_zones_do_not_overflow():
    """All black against all white, past what 31 bits hold."""
    known = np.ones((200, 300), bool)
    known[100, 150] = False
    zone = boundary_zone(known, 200)
    black, white = np.zeros((200, 300, 3), np.uint8), np.full((200, 300, 3), 255, np.uint8)
    transposed = np.ascontiguousarray(white.transpose(1, 0, 2))
    query = np.empty(zone.area * 3, np.uint8)
    assert _kernels.copy_zone(black, 0, 0, zone.strips, query) == 0
    key = _kernels.zone_distance(white, transposed, 0, 0, zone.strips, query, -1)
    assert key == zone.area * 3 * 255**2 > 2**31
