"""How near-regular synthesis prepares a sample: rectified, and looked at for rows."""

import numpy as np
import pytest

import weftex
from families import noise
from materials import wall
from weftex.methods.near_regular.rectification import rectified
from weftex.methods.near_regular.rows import axis_of_rows
from weftex.results.patches import RectifiedSynthesis


def model_of(pixels, **parameters):
    return weftex.NearRegular(**parameters).fit(weftex.Exemplar(pixels))


def test_a_bent_sample_is_rectified():
    """Columns that wander come out straight, every pixel still one of the sample's."""
    straight = wall(120, 128, spread=1)
    y = np.arange(120)
    bend = np.rint(2 * np.sin(y * 2 * np.pi / 120)).astype(int)
    bent = np.stack([np.roll(line, b, axis=0) for line, b in zip(straight, bend, strict=True)])
    found = rectified(bent, (16, 0, 8, 12), 3)
    mended = bent.reshape(-1, 3)[found]
    inside = (slice(6, -6), slice(6, -6))

    def off(pixels):
        return np.abs(pixels.astype(int) - straight)[inside].mean()

    assert off(mended) < off(bent) / 2


def test_rectified_results_are_saved_and_replayed(tmp_path):
    pixels = wall(90, 96)
    height = noise((180, 192))
    exemplar = weftex.Exemplar(pixels)
    result = weftex.NearRegular(lattice=(16, 0, 8, 12)).fit(exemplar).sample((70, 80), seed=1)
    assert isinstance(result, RectifiedSynthesis)
    source = result.source
    assert np.array_equal(result.image, pixels[source[..., 0], source[..., 1]])
    double = height.reshape(90, 2, 96, 2)[source[..., 0], :, source[..., 1]]
    expected = double.transpose(0, 2, 1, 3).reshape(140, 160)
    assert np.array_equal(result.render(height), expected)
    result.save(tmp_path / "r.npz")
    again = weftex.Synthesis.load(tmp_path / "r.npz", exemplar)
    assert isinstance(again, RectifiedSynthesis)
    assert np.array_equal(again.image, result.image) and np.array_equal(again.source, source)
    for what in ("sources", "seams", "error"):
        assert np.array_equal(again.draw(what), result.draw(what))


def boards(height, width, tone=40):
    """Boards that lie, each with grain and a color of its own."""
    rng = np.random.default_rng(4)
    tones = rng.integers(90, 90 + tone, (height // 16 + 1, 3))[np.arange(height) // 16]
    pixels = tones[:, None] + rng.integers(0, 9, (height, width, 1))
    pixels[np.arange(height) % 16 < 2] = 20
    return pixels.astype(np.uint8)


@pytest.mark.parametrize("stands", [False, True])
def test_boards_go_on(stands):
    """One vector is found, joints stay where they are and boards do not end."""
    pixels = boards(128, 128)
    pixels = pixels.swapaxes(0, 1) if stands else pixels
    model = model_of(np.ascontiguousarray(pixels))
    assert model.blocks.row_axis == int(stands)
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


def test_rows_of_mixed_colors_are_free():
    """What differs along a row may come from any row."""
    rng = np.random.default_rng(0)
    pixels = boards(128, 128, tone=2).astype(int)
    pixels += rng.integers(-30, 30, (8, 8, 1)).repeat(16, 0).repeat(16, 1)
    pixels[np.arange(128) % 16 < 2] = 20
    mixed = axis_of_rows(pixels.astype(np.uint8), (0, 16, 7, 0))
    assert mixed is None and axis_of_rows(boards(128, 128), (0, 16, 7, 0)) == 0
    assert axis_of_rows(boards(128, 128), (8, 14, -14, 8)) is None
    flat = np.full((128, 128, 3), 9, np.uint8)
    assert axis_of_rows(flat, (0, 16, 7, 0)) is None
