"""From a color to the places that have it: the tree against looking at every color."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from weftex.exemplar import Exemplar
from weftex.methods.exact_matching.color_index import ColorIndex
from weftex.search.windows import windows_of


def index_of(pixels, reach=1, **about):
    windows = windows_of(Exemplar(pixels, **about), (reach,) * 4)
    return windows, ColorIndex(windows.pixels, windows.usable)


@st.composite
def samples(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**30)))
    shape = draw(st.tuples(st.integers(3, 20), st.integers(3, 20)))
    channels = draw(st.sampled_from([1, 2, 3, 4, 7]))
    top = draw(st.sampled_from([1, 2, 6, 256]))
    return rng.integers(0, top, (*shape, channels)).astype(np.uint8)


def distances(index, color):
    return ((index.colors.astype(int) - np.asarray(color, int)) ** 2).sum(axis=1)


@given(pixels=samples())
def test_each_color_is_there_once(pixels):
    windows, index = index_of(pixels)
    wanted = {tuple(c) for c in windows.pixels.reshape(-1, windows.pixels.shape[2]).tolist()}
    found = [tuple(c) for c in index.colors.tolist()]
    assert len(found) == len(set(found))
    assert set(found) == wanted  # every pixel touches a center, as windows have 3x3 pixels
    assert np.array_equal(index.colors[index.number], windows.pixels)
    assert sorted(found) == [c for _, c in sorted(zip(index.rank.tolist(), found, strict=True))]


@given(pixels=samples(), count=st.sampled_from([1, 2, 5, 1000]))
def test_reach_is_the_distance_of_the_nth(pixels, count):
    _, index = index_of(pixels)
    for number, reach in enumerate(index.reach(count).tolist()):
        wanted = np.sort(distances(index, index.colors[number]))
        if count <= len(wanted):
            assert reach == wanted[count - 1]
        else:
            assert reach >= wanted[-1]


@given(pixels=samples(), seed=st.integers(0, 99))
def test_the_nearest_color_is_the_first_of_equally_near_ones(pixels, seed):
    _, index = index_of(pixels)
    queries = np.random.default_rng(seed).integers(0, 256, (20, pixels.shape[2])).astype(np.uint8)
    for query, found in zip(queries, index.nearest(queries).tolist(), strict=True):
        wanted = min(
            (d, tuple(c))
            for d, c in zip(distances(index, query), index.colors.tolist(), strict=True)
        )
        assert wanted == (distances(index, query)[found], tuple(index.colors[found].tolist()))


def test_colors_that_no_window_touches_do_not_count():
    pixels = np.zeros((9, 9), np.uint8)
    pixels[0, 0] = 200
    _, index = index_of(pixels, reach=3)
    assert index.colors.ravel().tolist() == [0]
    assert index.number[0, 0] == 0  # the nearest that counts
    _, tiling = index_of(pixels, reach=3, tileable=True)
    assert sorted(tiling.colors.ravel().tolist()) == [0, 200]


def test_the_span_is_never_exceeded():
    pixels = np.random.default_rng(5).integers(20, 90, (12, 12, 3)).astype(np.uint8)
    _, index = index_of(pixels)
    largest = max(distances(index, color).max() for color in index.colors)
    assert largest <= index.span <= 3 * 70**2
