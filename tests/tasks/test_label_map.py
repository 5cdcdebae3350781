"""Which sample goes where: painted maps, circle maps, distances for belts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from weftex.errors import InvalidInputError
from weftex.raster.masks import squared_distance_to
from weftex.tasks.label_map import circle_map, labels_of

RED, BLUE, GREEN = (255, 0, 0), (0, 0, 255), (0, 255, 0)


def painted(*rows):
    return np.array(rows, np.uint8)


def test_colors_are_numbered_as_they_appear():
    labels, colors = labels_of(painted([BLUE, BLUE, RED], [GREEN, RED, BLUE]), 3)
    assert labels.tolist() == [[0, 0, 1], [2, 1, 0]]
    assert colors == [BLUE, RED, GREEN]


def test_colors_that_are_given_keep_their_order_and_take_what_is_near():
    smooth = painted([RED, (200, 0, 50), (10, 0, 250), BLUE])
    labels, _ = labels_of(smooth, 2, [BLUE, RED])
    assert labels.tolist() == [[1, 1, 0, 0]]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_gray_maps_of_any_depth(dtype):
    labels, _ = labels_of(np.array([[0, 1], [1, 0]], dtype), 2)
    assert labels.tolist() == [[0, 1], [1, 0]]


def test_colors_and_samples_must_fit():
    picture = painted([RED, BLUE, GREEN])
    with pytest.raises(InvalidInputError, match=r"3 colors \(\(255, 0, 0\), .* for 2 samples"):
        labels_of(picture, 2)
    with pytest.raises(InvalidInputError, match="3 colors .* for 4 samples"):
        labels_of(picture, 4)
    with pytest.raises(InvalidInputError, match=r"no pixel of the color \(9, 9, 9\)"):
        labels_of(picture, 2, [RED, (9, 9, 9)])
    with pytest.raises(InvalidInputError, match="1 colors for 2 samples"):
        labels_of(picture, 2, [RED])
    for colors in ([1, 2], [RED, (1, 2)]):
        with pytest.raises(InvalidInputError, match="3 numbers"):
            labels_of(picture, 2, colors)
    noise = np.arange(100, dtype=np.uint8).reshape(10, 10)
    with pytest.raises(InvalidInputError, match=r"100 colors \(0, 1, 2, 3, 4, 5, \.\.\.\)"):
        labels_of(noise, 2)


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 6), st.booleans(), st.booleans(),
       st.integers(0, 99))  # fmt: skip
def test_distances_are_those_to_the_nearest(height, width, most, wrap_y, wrap_x, seed):
    mask = np.random.default_rng(seed).random((height, width)) < 0.1
    got = squared_distance_to(mask, most, (wrap_y, wrap_x))
    for y, x in np.ndindex(height, width):
        best = (most + 1) ** 2
        for v, u in np.argwhere(mask).tolist():
            dy, dx = abs(y - v), abs(x - u)
            dy, dx = (
                (min(dy, height - dy) if wrap_y else dy),
                (min(dx, width - dx) if wrap_x else dx),
            )
            if max(dy, dx) <= most:
                best = min(best, dy**2 + dx**2)
        assert got[y, x] == best


def test_a_circle_map_goes_over_from_top_to_bottom():
    labels = circle_map((400, 300), (15, 11), seed=3)
    assert set(np.unique(labels)) == {0, 1, 2}
    first = (labels == 0).mean(axis=1)
    assert first[:20].mean() > 0.8 and first[-100:].mean() < 0.02
    assert np.array_equal(labels, circle_map((400, 300), (15, 11), seed=3))
    assert not np.array_equal(labels, circle_map((400, 300), (15, 11), seed=4))
    # Mixed regions lie between the two, not at the ends.
    mixed = (labels == 2).mean(axis=1)
    assert mixed[40:160].mean() > 2 * mixed[-60:].mean()


@pytest.mark.parametrize("size", [(1, 1), (1, 50), (50, 1), (3, 4)])
@pytest.mark.parametrize("radii", [(1, 1), (40, 2)])
def test_small_circle_maps_are_covered(size, radii):
    labels = circle_map(size, radii, seed=1)
    assert labels.shape == size and (labels >= 0).all()
