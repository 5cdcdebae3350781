"""The quadtree pyramid against the paper's recursive construction (section 3.2, figure 9)."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from twins import quadtree_pyramid as reference
from weftex.methods.patches.boundary_zone import boundary_zone
from weftex.search import approximate_nearest_kernels as _kernels
from weftex.search.approximate_nearest import QuadtreePyramid


@given(st.sampled_from([1, 2, 4]), st.sampled_from([1, 2, 4]), st.integers(1, 3), st.data())
def test_windows_gather_the_squares_of_each_window(side, stride, channels, data):
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    pixels = rng.integers(0, 256, (15, 13, channels), np.uint8)
    window = 7
    offsets = st.tuples(*[st.integers(0, window - side)] * 2)
    squares = np.array(data.draw(st.lists(offsets, min_size=1, max_size=5)), np.int32)
    rows, columns = (-(-(n - window + 1) // stride) for n in (15, 13))
    found = QuadtreePyramid(pixels).windows(squares, side, stride, rows, columns)
    for i, j in itertools.product(range(rows), range(columns)):
        expected = [
            reference.square_mean(pixels, i * stride + v, j * stride + u, side) for v, u in squares
        ]
        assert np.array_equal(found[:, i * columns + j], np.concatenate(expected))


@given(st.sampled_from([1, 2, 4]), st.integers(1, 3), st.integers(0, 20), st.integers(0, 20))
def test_square_means_of_a_canvas_wrap(side, channels, y, x):
    rng = np.random.default_rng(side * channels)
    canvas = rng.integers(0, 256, (21, 21, channels), np.uint8)
    squares = np.array([(0, 0), (3, 1), (1, 5)], np.int32)
    means = np.empty(3 * channels, np.int32)
    _kernels.square_means(canvas, y, x, squares, side, means)
    expected = [reference.square_mean(canvas, y + v, x + u, side) for v, u in squares]
    assert np.array_equal(means, np.concatenate(expected))


def shortlist(pixels, zone, means, usable, stride, wanted):
    nodes = QuadtreePyramid(pixels).nodes(zone.side, stride)
    keys, places = np.empty(wanted, np.int64), np.empty(wanted, np.int32)
    count = _kernels.nearest_by_squares(nodes, zone.squares, means, usable, wanted, keys, places)
    return keys[:count].tolist(), [divmod(p, usable.shape[1]) for p in places[:count].tolist()]


@given(
    st.sampled_from([1, 2, 4]),
    st.sampled_from([1, 2, 4]),
    st.sampled_from([1, 3]),
    st.integers(1, 60),
    st.integers(0, 2**30),
)
def test_square_shortlist_is_the_m_smallest(side, stride, channels, wanted, seed):
    rng = np.random.default_rng(seed)
    few = int(rng.choice([3, 256]))  # few values make many ties
    pixels = rng.integers(0, few, (22, 19, channels)).astype(np.uint8)
    known = np.zeros((9, 9), bool)
    known[:4] = known[:, :4] = True
    zone = boundary_zone(known, 4, square_side=side)
    usable = (rng.random((14, 11)) < 0.8).astype(np.uint8)
    usable[0, 0] = 1
    query = rng.integers(0, few, len(zone.squares) * channels).astype(np.int32)
    expected = reference.square_distances(pixels, zone.squares, zone.side, query, usable, stride)
    keys, places = shortlist(pixels, zone, query, usable, stride, wanted)
    assert sorted(keys) == sorted(expected.values())[:wanted]
    assert len(set(places)) == len(places)
    assert [expected[p] for p in places] == keys
