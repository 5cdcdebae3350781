"""Windows around pixels: which there are in a sample, which part is known, how far two differ."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import weftex
from twins import windows as reference
from weftex.search import picture_kernels
from weftex.search import window_kernels as kernels
from weftex.search.windows import windows_of


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
            kernels.causal_runs(y, x, width, wrap[1], reach[0], *reach[2:], runs)
            if causal
            else picture_kernels.known_runs(done, y, x, *wrap, reach[0], runs)
        )
        got = [(dy, dx + k) for dy, dx, length in runs[:count].tolist() for k in range(length)]
        inside = (False, wrap[1]) if causal else wrap
        limits = (reach[0], 0, *reach[2:]) if causal else reach
        expected = reference.known_steps(done, (y, x), limits, inside)
        places = [((y + dy) % height, (x + dx) % width) for dy, dx in got]
        assert len(set(places)) == len(places)
        around = causal and wrap[1] and (reach[2] > (width - 1) // 2 or reach[3] > width // 2)
        if around:  # a row shorter than the window: which way around does not matter
            rows = [sum(v == dy for v, _ in got) for dy in range(-min(reach[0], y), 0)]
            assert rows == [min(reach[2] + reach[3] + 1, width)] * len(rows)
        else:
            assert sorted(got) == [*map(tuple, expected.tolist())]
        assert all(done[place] for place in places)
        # They can be gathered: no run is longer than the canvas, none starts more than one off it.
        for dy, dx, length in runs[:count].tolist():
            assert 1 <= length <= width and -height <= y + dy < 2 * height
            assert -width <= x + dx < 2 * width


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
    if own in reference.window_centers(mask, 1, tileable):
        expected = (own[0] + top) * windows.pixels.shape[1] + own[1] + left
    assert got == expected
