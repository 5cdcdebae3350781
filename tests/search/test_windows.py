"""Windows around pixels: which there are in a sample, which part is known, how far two differ."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from twins import windows as reference
from weftex.search import picture_kernels
from weftex.search import window_kernels as kernels
from weftex.search.windows import windows_of


@given(
    st.integers(1, 9), st.integers(1, 9), st.tuples(*[st.integers(0, 3)] * 4), st.booleans(),
    st.integers(0, 99),
)  # fmt: skip
def test_usable_is_where_the_whole_window_is(height, width, reach, tileable, seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((height, width)) < 0.9
    mask[0, 0] = True
    pixels = rng.integers(0, 256, (height, width, 2)).astype(np.uint8)
    exemplar = weftex.Exemplar(pixels, mask=mask, tileable=tileable, alpha=False)
    expected = reference.window_centers(mask, reach, tileable)
    if not expected:
        with pytest.raises(weftex.InvalidInputError, match="window_width"):
            windows_of(exemplar, reach)
        return
    windows = windows_of(exemplar, reach)
    own = windows.to_sample(windows.centers)
    assert [divmod(int(k), width) for k in own] == expected
    assert np.array_equal(windows.from_sample(own), windows.centers)
    flat = windows.pixels.reshape(-1, 2)
    assert np.array_equal(flat[windows.centers], pixels.reshape(-1, 2)[own])
    assert windows.to_sample(np.array([-1], np.int32)) == [-1]
    assert windows.from_sample(np.array([-1], np.int32)) == [-1]
    # Every window can be read without leaving the array.
    y, x = np.divmod(windows.centers, windows.pixels.shape[1])
    up, down, left, right = reach
    assert (y >= up).all() and (x >= left).all()
    assert (y + down < windows.pixels.shape[0]).all()
    assert (x + right < windows.pixels.shape[1]).all()


@given(
    st.integers(1, 8), st.integers(1, 8), st.tuples(*[st.integers(0, 4)] * 4),
    st.tuples(st.booleans(), st.booleans()), st.booleans(), st.integers(0, 99),
)  # fmt: skip
def test_runs_are_what_is_known_of_the_window(height, width, reach, wrap, causal, seed):
    done = (np.random.default_rng(seed).random((height, width)) < 0.6).astype(np.uint8)
    runs = np.zeros(((sum(reach[:2]) + 1) * (sum(reach[2:]) + 2), 3), np.int32)
    for y, x in np.ndindex(height, width):
        if not causal:
            reach = reach[:1] * 4
        else:  # everything above and to the left is made
            done[:] = np.arange(height * width).reshape(height, width) < y * width + x
        count = (
            kernels.causal_runs(y, x, height, width, wrap[1], reach[0], *reach[2:], runs)
            if causal
            else picture_kernels.known_runs(done, y, x, *wrap, reach[0], runs)
        )
        got = [(dy, dx + k) for dy, dx, length in runs[:count].tolist() for k in range(length)]
        inside = (False, wrap[1]) if causal else wrap
        limits = (reach[0], 0, *reach[2:]) if causal else reach
        expected = reference.known_window(done, y, x, inside, limits)
        places = [((y + dy) % height, (x + dx) % width) for dy, dx in got]
        assert len(set(places)) == len(places)
        around = causal and wrap[1] and (reach[2] > (width - 1) // 2 or reach[3] > width // 2)
        if around:  # a row shorter than the window: which way around does not matter
            rows = [sum(v == dy for v, _ in got) for dy in range(-min(reach[0], y), 0)]
            assert rows == [min(reach[2] + reach[3] + 1, width)] * len(rows)
        else:
            assert sorted(got) == expected
        assert all(done[place] for place in places)
        # They can be gathered: no run is longer than the canvas, none starts more than one off it.
        for dy, dx, length in runs[:count].tolist():
            assert 1 <= length <= width and -height <= y + dy < 2 * height
            assert -width <= x + dx < 2 * width


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_distances_are_sums_over_the_runs(rng, channels):
    levels = rng.integers(0, 256, (11, 13, channels)).astype(np.uint8)
    pixels = rng.integers(0, 256, (20, 21, channels)).astype(np.uint8)
    done = np.ones((11, 13), np.uint8)
    runs, query = np.zeros((99, 3), np.int32), np.zeros(999, np.uint8)
    places = [(3, 3), (10, 9), (16, 17)]
    for y, x in np.ndindex(11, 13):
        count = picture_kernels.known_runs(done, y, x, True, True, 3, runs)
        kernels.gather_runs(levels, y, x, runs, count, query)
        got = [kernels.run_distance(pixels, v, u, runs, count, query, -1) for v, u in places]
        window = [(dy, dx) for dy, dx in itertools.product(range(-3, 4), repeat=2) if dy or dx]
        for (v, u), distance in zip(places, got, strict=True):
            assert distance == sum(
                int(((levels[(y + dy) % 11, (x + dx) % 13].astype(int)
                - pixels[v + dy, u + dx]) ** 2).sum())
                for dy, dx in window
            )  # fmt: skip
        bound = min(got)
        centers = np.array([v * 21 + u for v, u in places], np.int32)
        out = np.zeros(3, np.int64)
        kernels.distances(pixels, centers, runs, count, query, out)
        assert out.tolist() == got
        early = [kernels.run_distance(pixels, v, u, runs, count, query, bound) for v, u in places]
        assert [d for d in early if d <= bound] == [d for d in got if d <= bound]


@given(st.integers(-9, 20), st.integers(-9, 20), st.booleans(), st.integers(0, 99))
def test_a_place_is_usable_where_a_window_may_be_centered(y, x, tileable, seed):
    mask = np.random.default_rng(seed).random((6, 7)) < 0.97
    exemplar = weftex.Exemplar(np.zeros((6, 7), np.uint8), mask=mask, tileable=tileable)
    try:
        windows = windows_of(exemplar, (1, 1, 1, 1))
    except weftex.InvalidInputError:
        return
    got = picture_kernels.usable_place(windows.usable, windows.period, y, x)
    top, left = windows.period[:2].tolist()
    own = (y - top, x - left)
    if tileable:
        own = (own[0] % 6, own[1] % 7)
    expected = -1
    if own in reference.window_centers(mask, (1, 1, 1, 1), tileable):
        expected = (own[0] + top) * windows.pixels.shape[1] + own[1] + left
    assert got == expected
