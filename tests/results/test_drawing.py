"""Pictures of how a result was put together."""

import numpy as np
import pytest

import weftex
from families import noise
from laid import BLENDS, make
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError
from weftex.results.pixels import PixelSynthesis


def result_of(sample, source, canvas=None):
    """A result with these sources."""
    canvas = canvas or Canvas(*source.shape)
    return PixelSynthesis(canvas, source, sample_shape=sample.shape, exemplar=sample)


def test_what_is_copied_as_a_whole_is_certain_and_has_one_color():
    sample = weftex.Exemplar(noise((30, 31, 3)))
    y, x = np.indices((20, 20))
    copied = result_of(sample, ((y + 4) * 31 + x + 7).astype(np.int32))
    assert (copied.uncertainty() == 0).all() and (copied.draw("uncertainty") == 0).all()
    assert len(np.unique(copied.draw("patches").reshape(-1, 3), axis=0)) == 1
    source = np.where(x < 10, (y + 4) * 31 + x + 7, (y + 1) * 31 + x + 2).astype(np.int32)
    halves = result_of(sample, source)
    pieces = halves.draw("patches")
    assert (pieces[:, :10] == pieces[0, 0]).all() and (pieces[:, 10:] == pieces[0, 10]).all()
    assert (pieces[0, 0] != pieces[0, 10]).any()


def test_uncertainty_is_its_definition():
    sample = weftex.Exemplar(noise((23, 25, 3)))
    rng = np.random.default_rng(1)
    result = result_of(sample, rng.integers(0, 23 * 25, (300, 9)).astype(np.int32))
    pixels, made, source = sample.pixels.astype(float), result.image.astype(float), result.source
    random = 2 * pixels.reshape(-1, 3).var(axis=0).mean()
    found = result.uncertainty()
    for y, x in ((0, 0), (150, 4), (255, 8), (256, 3), (299, 1)):
        apart = []
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                v, u = source[y, x] + (dy, dx)
                if 0 <= y + dy < 300 and 0 <= x + dx < 9 and 0 <= v < 23 and 0 <= u < 25:
                    apart.append(((made[y + dy, x + dx] - pixels[v, u]) ** 2).mean())
        assert found[y, x] == pytest.approx(np.mean(apart) / random)
    # Sources at random are as bad as at random, but for the pixel itself.
    assert 0.85 < found.mean() < 1.05


def test_what_wraps_and_what_is_known():
    tile = weftex.Exemplar(noise((12, 14)), tileable=True)
    around = np.arange(12 * 14, dtype=np.int32).reshape(12, 14)
    assert not result_of(tile, around, Canvas(12, 14, (True, True))).uncertainty().any()
    photo = noise((40, 40, 3))
    hole = np.zeros((40, 40), bool)
    hole[10:20, 12:25] = True
    filled = weftex.fill(photo, hole, sample=noise((30, 30, 3), seed=4), seed=1)
    assert not filled.uncertainty()[~hole].any() and filled.uncertainty()[hole].any()
    assert not filled.draw("patches")[~hole].any() and filled.draw("patches")[hole].all()


def test_maps_of_the_sample_do_not_matter_to_what_is_certain():
    pixels = noise((30, 30, 3), np.uint16)
    sample = weftex.Exemplar(pixels, maps={"height": noise((30, 30), np.float32)})
    copied = result_of(sample, np.arange(900, dtype=np.int32).reshape(30, 30))
    assert not copied.uncertainty().any()


def test_it_needs_the_sample_and_a_known_name(tmp_path):
    made = weftex.synthesize(noise((30, 30)), 30, seed=1, method="quilting")
    made.save(tmp_path / "r.npz")
    with pytest.raises(InvalidInputError, match="without its sample"):
        weftex.Synthesis.load(tmp_path / "r.npz").draw("uncertainty")
    assert weftex.Synthesis.load(tmp_path / "r.npz").draw("patches").shape == (30, 30, 3)
    with pytest.raises(InvalidInputError, match="known: sources, seams, patches"):
        made.draw("nothing")
    flat = weftex.synthesize(np.zeros((9, 9), np.uint8), 12, seed=1)
    assert not flat.draw("uncertainty").any()


@pytest.mark.parametrize("blend", BLENDS)
def test_drawings(blend):
    result = make(blend)
    for what in ("sources", "seams"):
        drawing = result.draw(what)
        assert drawing.shape == (40, 45, 3) and drawing.dtype == np.uint8
    sources = result.draw("sources")
    y, x = np.moveaxis(result.source, -1, 0)
    assert np.array_equal(sources[..., 0], np.rint(x * (255 / 33)))
    assert np.array_equal(sources[..., 1], np.rint(y * (255 / 29)))
    red = (result.draw("seams") == (255, 0, 0)).all(axis=2)
    assert 0 < red.sum() < red.size
    # No seam inside a patch: every second neighbor pair that goes on is not red.
    step = np.diff(result.source, axis=1)
    goes_on = (step == (0, 1)).all(axis=2)
    goes_down = (np.diff(result.source, axis=0) == (1, 0)).all(axis=2)
    assert not red[1:, 1:][goes_on[1:] & goes_down[:, 1:]].any()
    assert red[:, 1:][~goes_on].all()
