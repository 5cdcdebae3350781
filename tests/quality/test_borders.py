"""Borders of pictures where they wrap around."""

import numpy as np
import pytest

import weftex
from weftex.quality import borders_of, draw_borders


def tile():
    return weftex.synthesize("sample:pebbles", 200, method="quilting", seed=3, tileable=True).image


def is_bad(pixels):
    return [border.badness > 1 for border in borders_of(weftex.Exemplar(pixels))]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_tiles_crops_and_tiles_with_one_broken_axis(dtype):
    made = tile().astype(np.float64) / 255
    made = (made * (np.iinfo(dtype).max if np.dtype(dtype).kind == "u" else 1)).astype(dtype)
    assert is_bad(made) == is_bad(np.roll(made, (50, 70), (0, 1))) == [False, False]
    assert is_bad(made.repeat(2, 0).repeat(2, 1)) == [False, False]
    assert is_bad(made[:170, :160]) == [True, True]
    assert is_bad(made[:170]) == [True, False]
    assert is_bad(made[:, :160]) == [False, True]


def test_a_broken_line_shows_where_it_is_broken():
    made = tile()
    rng = np.random.default_rng(0)
    made[0, 60:120] = rng.integers(0, 256, (60, 3))
    down, right = borders_of(weftex.Exemplar(made))
    assert down.badness > 1 >= right.badness
    drawn = draw_borders(weftex.Exemplar(made), (down, right))
    plain = np.roll(made, (100, 100), (0, 1))
    y, x = np.nonzero((drawn != plain).any(axis=2))
    assert set(y) == {96, 103} and len(set(x)) > 40
    if down.steps > 2:
        assert len(set(x)) == 200
    assert np.array_equal(drawn[98:102], plain[98:102])  # the border itself stays visible


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (22, 40), (23, 23), (40, 60, 4)])
def test_small_and_constant_pictures(shape):
    assert is_bad(np.full(shape, 9, np.uint8)) == [False, False]
    found = borders_of(weftex.Exemplar(np.full(shape, 9, np.uint8)))
    assert (found[0].seam is None) == (min(shape[:2]) < 23)


def test_a_border_on_one_joint_of_many_is_no_seam():
    rng = np.random.default_rng(2)
    boards = 120 + rng.normal(0, 8, (240, 1, 3)) + rng.normal(0, 2, (240, 240, 3))
    for joint in range(0, 240, 40):  # short dark gaps, at other places along each joint
        for at in rng.integers(0, 240, 2):
            boards[np.arange(at, at + 24) % 240, joint] -= 70
    boards = boards.clip(0, 255).astype(np.uint8)
    shares = [borders_of(weftex.Exemplar(np.roll(boards, by, 1)))[1].badness for by in (0, 20)]
    assert max(shares) <= 1
