"""Which sample goes where: painted maps, distances for belts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from families import refused
from weftex.label_maps import labels_of, map_picture
from weftex.raster.masks import squared_distance_to

RED, BLUE, GREEN = (255, 0, 0), (0, 0, 255), (0, 255, 0)


def painted(*rows):
    return np.array(rows, np.uint8)


def test_colors_are_numbered_as_they_appear():
    labels = labels_of(painted([GREEN, GREEN, RED], [BLUE, RED, GREEN]), 3)
    assert labels.tolist() == [[0, 0, 1], [2, 1, 0]]


def test_colors_that_are_given_keep_their_order_and_take_what_is_near():
    smooth = painted([RED, (200, 0, 50), (10, 0, 250), BLUE])
    labels = labels_of(smooth, 2, [BLUE, RED])
    assert labels.tolist() == [[1, 1, 0, 0]]


def test_a_map_from_a_canvas_has_an_alpha_that_says_nothing():
    plain = painted([RED, BLUE], [BLUE, BLUE])
    canvas = np.dstack([plain, np.full((2, 2), 255, np.uint8)])
    for colors in ([BLUE, RED], [(*BLUE, 255), (*RED, 255)]):
        assert labels_of(canvas, 2, colors).tolist() == [[1, 0], [0, 0]]
    canvas[0, 0, 3] = 9
    refused("each color must have 4 numbers", labels_of, canvas, 2, [BLUE, RED])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_gray_maps_of_any_depth(dtype):
    labels = labels_of(np.array([[0, 1], [1, 0]], dtype), 2)
    assert labels.tolist() == [[0, 1], [1, 0]]


def test_colors_and_samples_must_fit():
    picture = painted([RED, BLUE, GREEN])
    refused(r"3 colors \(\(255, 0, 0\), .* for 2 samples", labels_of, picture, 2)
    refused("3 colors .* for 4 samples", labels_of, picture, 4)
    refused(r"no pixel of the color \(9, 9, 9\)", labels_of, picture, 2, [RED, (9, 9, 9)])
    refused("1 colors for 2 samples", labels_of, picture, 2, [RED])
    for colors in ([1, 2], [RED, (1, 2)]):
        refused("3 numbers", labels_of, picture, 2, colors)
    refused(r"colors=\[\.\.\.\], or --colors", labels_of, picture, 2)
    noise = np.arange(100, dtype=np.uint8).reshape(10, 10)
    refused(r"100 colors \(0, 1, 2, 3, 4, 5, \.\.\.\)", labels_of, noise, 2)


def test_pictures_of_maps():
    assert map_picture(np.array([[True, False]])).tolist() == [[1, 0]]
    assert map_picture(np.array([[1, 70000]], np.int64)).tolist() == [[1, 70000]]
    for wrong in (
        np.array([[1, -5]]),
        np.array([[0.0, np.nan]]),
        np.array([["a"]]),
        np.zeros((0, 4)),
        None,
    ):
        refused("the (label )?map", map_picture, wrong)


@given(st.integers(1, 12), st.integers(1, 12), st.integers(0, 6), st.booleans(), st.booleans(),
       st.integers(0, 99))  # fmt: skip
def test_distances_are_those_to_the_nearest(height, width, most, wrap_y, wrap_x, seed):
    mask = np.random.default_rng(seed).random((height, width)) < 0.1
    got = squared_distance_to(mask, most, (wrap_y, wrap_x))
    for y, x in np.ndindex(height, width):
        best = (most + 1) ** 2
        for v, u in np.argwhere(mask).tolist():
            dy, dx = abs(y - v), abs(x - u)
            dy = min(dy, height - dy) if wrap_y else dy
            dx = min(dx, width - dx) if wrap_x else dx
            if max(dy, dx) <= most:
                best = min(best, dy**2 + dx**2)
        assert got[y, x] == best
