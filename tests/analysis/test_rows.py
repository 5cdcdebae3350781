"""Rows of a sample: colors of their own and joints, and how methods continue them."""

import numpy as np
import pytest

import weftex
from methods.test_near_regular import model_of
from weftex.analysis.rows import find_boards, find_colored_rows
from weftex.canvas import Canvas


def boards(side, high=16, tone=40):
    """Boards that lie, `high` pixels each, with grain and a color of their own."""
    rng, y = np.random.default_rng(4), np.arange(side)
    tones = rng.integers(90, 90 + tone, (side // high + 1, 3))[y // high]
    pixels = tones[:, None] + rng.integers(0, 9, (side, side, 1))
    pixels[y % high < 2] = 20
    return pixels.astype(np.uint8)


@pytest.mark.parametrize("stands", [False, True])
def test_boards_go_on(stands):
    """One vector is found, joints stay where they are and boards do not end."""
    pixels = boards(128)
    pixels = pixels.swapaxes(0, 1) if stands else pixels
    model = model_of(np.ascontiguousarray(pixels))
    assert model.blocks.colored_rows.axis == stands
    out = model.sample((300, 300), seed=1)
    image = out.image.swapaxes(0, 1) if stands else out.image
    dark = image.max(axis=2) < 60
    assert dark[np.arange(300) % 16 < 2].mean() > 0.98
    # Means over 20 pixels along each board.
    parts = image[:, :300].reshape(300, 15, 20, 3).mean(axis=2)[np.arange(300) % 16 > 4]
    assert np.ptp(parts, axis=1).max() < 9
    assert len(np.unique(parts[::11, 0].round(-1), axis=0)) > 2
    part = model.window(40, 90, 50, 60, seed=1).image
    assert np.array_equal(part, out.image[40:90, 90:150])
    far = model.window(2**40 - 20, -(2**40), 50, 60, seed=1).image
    assert np.array_equal(far[20:, 9:], model.window(2**40, 9 - 2**40, 30, 51, seed=1).image)


@pytest.mark.parametrize(("height", "size"), [(16, 112), (16, 80), (56, 168), (56, 224)])
def test_boards_go_on_around_a_tileable_picture(height, size):
    """An odd number of boards, or boards that are wider than a block, too."""
    model = model_of(boards(160, height), lattice=(1, 0, 0, height))
    assert (model.method.block_size < height) == (height == 56)
    image = model.sample((size, size), seed=1, tileable=True).image
    dark = np.flatnonzero((image.max(axis=2) < 60).mean(axis=1) > 0.98)
    assert len(dark) == 2 * size // height  # joints are whole, and lie in rows
    starts = dark[np.diff(dark, prepend=dark[-1] - size) > 1]
    for start in starts.tolist():
        board = image[(start + 4 + np.arange(height - 6)) % size]
        parts = board.reshape(height - 6, size // 8, 8, 3).mean(axis=2)
        assert np.ptp(parts, axis=1).max() < 9  # of one color around


def test_rows_that_are_given_are_rows_that_are_found():
    """By a vector along them and one across, in any order; and by the resolved parameters."""
    found = model_of(boards(128))
    for lattice in ((1, 0, 0, 16), (0, 16, 1, 0), found.method.lattice):
        model = model_of(boards(128), lattice=lattice)
        assert model.blocks.colored_rows.axis == 0
        assert model.method.block_size == found.method.block_size
    assert np.array_equal(model.sample((90, 90), seed=1).image, found.sample(90, seed=1).image)


def test_boards_wider_than_a_block_keep_their_color():
    """Blocks share a board; windows of the plane agree."""
    model = model_of(boards(240, 40), lattice=(1, 0, 0, 40), block_size=36)
    image = model.sample((300, 300), seed=2).image
    y = np.arange(300) % 40
    inner = image[(y > 4) & (y < 38)].reshape(-1, 15, 20, 3).mean(axis=2)
    assert np.ptp(inner, axis=1).max() < 9
    assert np.array_equal(model.window(70, 33, 90, 80, seed=2).image, image[70:160, 33:113])


def test_rows_of_mixed_colors_are_free():
    """What differs along a row may come from any row."""
    rng = np.random.default_rng(0)
    pixels = boards(128, tone=2).astype(int)
    pixels += rng.integers(-30, 30, (8, 8, 1)).repeat(16, 0).repeat(16, 1)
    pixels[np.arange(128) % 16 < 2] = 20
    level, slanted = (0, 16, 7, 0), (8, 14, -14, 8)
    assert find_colored_rows(boards(128), level).axis == 0
    assert find_colored_rows(boards(128), slanted) is None
    for other in (pixels.astype(np.uint8), np.full((128, 128, 3), 9, np.uint8)):
        assert find_colored_rows(other, level) is None


UNEVEN = np.array([0, 21, 55, 80, 126, 147, 180])  # where boards begin


def planks(side=180):
    """Boards that lie, of different heights, with a joint of three lines above each."""
    rng, y = np.random.default_rng(8), np.arange(side)
    row = np.searchsorted(UNEVEN, y, side="right") - 1
    pixels = rng.integers(0, 9, (side, side, 1)) + rng.integers(90, 160, (7, 3))[row][:, None]
    pixels[y - UNEVEN[row] < 3] = 20
    return pixels.astype(np.uint8)


@pytest.mark.parametrize(("stands", "tileable"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_joints_run_through_an_output(stands, tileable):
    """Each of its lines shows one line of the sample, or one beside it."""
    pixels = np.ascontiguousarray(planks().swapaxes(0, 1) if stands else planks())
    rows = find_boards(pixels)
    assert np.abs(rows.edges[2:] - UNEVEN[1:]).max() <= 3 and rows.axis == stands
    model = weftex.Auto().fit(weftex.Exemplar(pixels))
    assert model.choose(300).parameters == {"placement": "rows"}
    out = model.sample((300, 340), seed=1, tileable=tileable == 1)
    lines, image = (one.swapaxes(0, stands) for one in (out.source[..., stands], out.image))
    assert (abs(lines - np.median(lines, axis=1)[:, None]) <= 2).mean() > 0.9
    dark = (image.max(axis=2) < 60).mean(axis=1)
    assert ((dark < 0.05) | (dark > 0.95)).all() and 20 < (dark > 0.95).sum() < 60
    starts = np.flatnonzero((dark > 0.95) & (np.roll(dark, 1) < 0.05))
    heights = np.diff(starts, append=starts[:1] + len(dark)) if tileable else np.diff(starts)
    assert heights.min() > 15 and heights.max() < 60  # the last board is whole, too
    assert model.sample((60, 50), tileable=True).source.min() >= 0  # a board is most of it
    filled = weftex.fill(pixels, hole := np.pad(np.ones((60, 60), bool), 60), seed=1)
    assert abs(filled.source[..., stands] - np.indices(hole.shape)[stands])[hole].max() <= 1


def test_a_map_of_rows_fills_an_output():
    assert find_boards(np.random.default_rng(1).integers(0, 255, (96, 96, 3), np.uint8)) is None
    noisy = planks() + np.random.default_rng(1).integers(0, 60, (180, 180, 1), np.uint8)
    found, large = (find_boards(noisy.repeat(n, 0).repeat(n, 1)) for n in (1, 4))
    assert found and not find_boards(noisy, even=True)
    assert abs(large.edges - 4 * found.edges)[2:].max() <= 4  # of a photo of more pixels
    filled = weftex.fill(boards(128), np.pad(np.ones((40, 40), bool), 44), seed=1)
    assert "joints run" in filled.provenance["reason"]
    for size in (90, 700):
        one, other = (find_boards(planks()).row_map(Canvas(size, size), k).bands for k in (3, 4))
        start, end, source = np.array(one).T
        assert [*start, size] == [0, *end] and (end > start).all()
        assert source.min() >= 0 and (source + end - start).max() <= 180 and other[0][1] != end[0]
