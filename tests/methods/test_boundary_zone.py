"""Boundary zones against their definition: known, and within w_E of something unknown."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from twins import boundary_zone as reference
from twins import seams
from weftex.methods.patches import zone_kernels as _kernels
from weftex.methods.patches.boundary_zone import boundary_zone

masks = arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12)))
widths = st.integers(1, 6)


def covered(zone, shape):
    """How often each pixel is in a run."""
    count = np.zeros(shape, int)
    for upright, v, u, length in zone.runs.tolist():
        if upright:
            count[v : v + length, u] += 1
        else:
            count[v, u : u + length] += 1
        assert v + length * upright <= shape[0] and u + length * (not upright) <= shape[1]
    return count


@given(masks, widths)
def test_zone_and_weights_follow_the_definition(known, width):
    zone = boundary_zone(known, width)
    expected = reference.zone_of(known, width)
    assert np.array_equal(covered(zone, known.shape), expected.astype(int))
    assert zone.area == expected.sum()
    assert np.array_equal(zone.weight, reference.zone_weights(known, width))


@given(masks, widths, st.data())
def test_frozen_pixels_weigh_nothing(known, width, data):
    frozen = data.draw(arrays(bool, known.shape)) & known
    zone = boundary_zone(known, width, frozen=frozen)
    assert np.array_equal(zone.weight, reference.zone_weights(known, width, frozen))
    assert np.array_equal(covered(zone, known.shape), reference.zone_of(known, width))


@given(masks, widths)
def test_pasting_replaces_the_zone_and_nothing_else_that_is_known(known, width):
    zone = boundary_zone(known, width, paste=True)
    assert np.array_equal(zone.weight, reference.zone_weights(known, width, paste=True))
    assert set(np.unique(zone.weight)) <= {0, 256}


@given(masks, widths, st.sampled_from([1, 2, 4, 8, 16]))
def test_blocks_lie_in_the_zone(known, width, block_side):
    zone = boundary_zone(known, width, block_side=block_side)
    expected = reference.zone_of(known, width)
    assert zone.side <= min(block_side, width)
    assert zone.side & (zone.side - 1) == 0
    for v, u in zone.blocks.tolist():
        block = expected[v : v + zone.side, u : u + zone.side]
        assert block.shape == (zone.side, zone.side)
        assert block.all()
    assert (len(zone.blocks) > 0) == bool(expected.any())


@given(masks, widths, st.sampled_from([1, 2, 4, 8]))
def test_blocks_share_little(known, width, block_side):
    """Whole blocks first, then those that are at least half new, until there are no more."""
    zone = boundary_zone(known, width, block_side=block_side, most_blocks=10**6)
    side = zone.side
    seen, shares = np.zeros(known.shape, bool), []
    for v, u in zone.blocks.tolist():
        own = seen[v : v + side, u : u + side]
        shares.append(np.count_nonzero(~own))
        own[:] = True
    whole = [share == side * side for share in shares]
    assert whole == sorted(whole, reverse=True)
    assert all(2 * share >= side * side for share in shares)
    expected = reference.zone_of(known, width)
    for v, u in np.argwhere(expected).tolist():
        block = expected[v : v + side, u : u + side]
        if block.shape == (side, side) and block.all():
            left = np.count_nonzero(~seen[v : v + side, u : u + side])
            assert 2 * left < side * side or (side == 1 and left == 0)
    assert len(zone.blocks) * side * side * 2 >= expected.sum()


@pytest.mark.parametrize("most", [1, 5, 16, 1000])
def test_blocks_are_thinned_out_evenly(most):
    known = np.zeros((64, 64), bool)
    known[:, :4] = known[:4] = True
    every = boundary_zone(known, 4, most_blocks=10**6).blocks.tolist()
    some = boundary_zone(known, 4, most_blocks=most).blocks.tolist()
    assert len(some) == min(most, len(every))
    kept = [every.index(block) for block in some]
    assert kept == sorted(set(kept))
    if 1 < most < len(every):
        gaps = np.diff(kept)
        assert kept[0] == 0 and kept[-1] == len(every) - 1 and gaps.max() - gaps.min() <= 1


@given(masks, widths, st.booleans(), st.booleans(), st.data())
def test_bands_lie_along_the_box_that_the_patch_shows_in(known, width, hole, paste, data):
    frozen = data.draw(arrays(bool, known.shape)) & known if hole else None
    zone = boundary_zone(known, width, frozen=frozen, outlines=hole, paste=paste)
    weights = reference.zone_weights(known, width, frozen, paste)
    top, left, bottom, right = seams.box_of(weights)
    depth = seams.band_depth(weights, width, hole)
    assert zone.bands[:5].tolist() == [depth, left, top, right, bottom]
    if hole:
        assert depth >= min(bottom - top, right - left) // 2
    there = reference.zone_of(known, width)[top:bottom, left:right]
    sides = there[:, :depth], there[:depth].T, there[:, -depth:], there[-depth:].T
    lines = [s.any(axis=1) for s in sides]
    assert zone.bands[5:].tolist() == [int(s.any() if hole else s.all()) for s in lines]


@pytest.mark.parametrize("top", [False, True])
@pytest.mark.parametrize("left", [False, True])
def test_a_plain_canvas_is_cut_at_the_left_and_the_top_alone(left, top):
    known = np.zeros((9, 12), bool)
    known[:, :3] |= left
    known[:3] |= top
    assert boundary_zone(known, 3).bands[5:].tolist() == [left, top, False, False]


def test_blocks_cover_most_of_the_zones_of_the_paper():
    for left, top in ((True, False), (False, True), (True, True)):
        known = np.zeros((64, 64), bool)
        known[:, :4] |= left
        known[:4] |= top
        zone = boundary_zone(known, 4)
        seen = np.zeros_like(known)
        for v, u in zone.blocks.tolist():
            seen[v : v + zone.side, u : u + zone.side] = True
        assert zone.side == 4
        assert np.array_equal(seen, known)  # 16 + 15 blocks for the L, as section 3.3 counts them
        if left and top:
            assert len(zone.blocks) == 31


@pytest.mark.parametrize("width", [255, 256, 300, 700])
def test_a_very_wide_zone_is_blended_everywhere(width):
    known = np.zeros((1, 2 * width), bool)
    known[:, :width] = True
    zone = boundary_zone(known, width)
    assert zone.area == width
    assert (zone.weight[known] > 0).all(), "weight 0 means the canvas stays, also when it is cut"


def test_the_core_is_all_that_is_laid():
    known = np.zeros((5, 5), bool)
    known[:2] = True
    zone = boundary_zone(known, 2, core=(2, 2))
    assert zone.area == 10
    assert zone.weight.sum() == zone.weight[2, 2] == 256


@given(masks, widths, st.integers(1, 4), st.data())
def test_distances_are_equation_2(known, width, channels, data):
    """The kernel's sums are A d**2 and A d_max**2 / epsilon**2, at corners that wrap too."""
    zone = boundary_zone(known, width)
    rows, columns = known.shape
    bytes_ = np.random.default_rng(data.draw(st.integers(0, 999)))
    canvas = bytes_.integers(0, 256, (rows + 3, columns + 2, channels), np.uint8)
    pixels = bytes_.integers(0, 256, (rows + 2, columns + 4, channels), np.uint8)
    y, x = data.draw(st.integers(0, rows + 2)), data.draw(st.integers(0, columns + 1))
    corners = [(0, 0), (2, 4), (1, 2)]
    query = np.empty(zone.area * channels, np.uint8)
    transposed = np.ascontiguousarray(pixels.transpose(1, 0, 2))
    energy = _kernels.copy_zone(canvas, y, x, zone.runs, query)
    mask = reference.zone_of(known, width)
    at = np.ix_((y + np.arange(rows)) % (rows + 3), (x + np.arange(columns)) % (columns + 2))
    there = canvas[at][mask].astype(int)
    assert energy == (there**2).sum()
    for v, u in corners:
        key = _kernels.zone_distance(pixels, transposed, v, u, zone.runs, query, -1)
        here = pixels[v : v + rows, u : u + columns][mask].astype(int)
        assert key == ((here - there) ** 2).sum()


def test_distances_of_long_zones_do_not_overflow():
    """All black against all white, past what 31 bits hold."""
    known = np.ones((200, 300), bool)
    known[100, 150] = False
    zone = boundary_zone(known, 200)
    black, white = np.zeros((200, 300, 3), np.uint8), np.full((200, 300, 3), 255, np.uint8)
    transposed = np.ascontiguousarray(white.transpose(1, 0, 2))
    query = np.empty(zone.area * 3, np.uint8)
    assert _kernels.copy_zone(black, 0, 0, zone.runs, query) == 0
    key = _kernels.zone_distance(white, transposed, 0, 0, zone.runs, query, -1)
    assert key == zone.area * 3 * 255**2 > 2**31
