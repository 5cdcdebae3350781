"""Pictures of how a result was put together."""

import numpy as np
import pytest

import weftex
from families import BLENDS, noise, refused
from laid import make
from weftex.canvas import Canvas
from weftex.results.pixels import PixelSynthesis


def result_of(sample, source, canvas=None):
    """A result with these sources."""
    canvas = canvas or Canvas(*source.shape)
    return PixelSynthesis(canvas, source, sample_shape=sample.shape, exemplar=sample)


def test_what_is_copied_as_a_whole_has_one_color():
    sample = weftex.Exemplar(noise((30, 31, 3)))
    y, x = np.indices((20, 20))
    around = (y + 14) % 30 * 31 + (x + 17) % 31  # of a sample that repeats
    copied = result_of(sample, around.astype(np.int32))
    assert len(np.unique(copied.draw("patches").reshape(-1, 3), axis=0)) == 1
    assert not (copied.draw("seams") == (255, 0, 0)).all(axis=2).any()
    source = np.where(x < 10, (y + 4) * 31 + x + 7, (y + 1) * 31 + x + 2).astype(np.int32)
    halves = result_of(sample, source)
    pieces = halves.draw("patches")
    assert (pieces[:, :10] == pieces[0, 0]).all() and (pieces[:, 10:] == pieces[0, 10]).all()
    assert (pieces[0, 0] != pieces[0, 10]).any()


def test_what_was_known_has_no_patches():
    photo = noise((40, 40, 3))
    hole = np.zeros((40, 40), bool)
    hole[10:20, 12:25] = True
    filled = weftex.fill(photo, hole, sample=noise((30, 30, 3), seed=4), seed=1)
    assert not filled.draw("patches")[~hole].any() and filled.draw("patches")[hole].all()


def test_it_needs_the_sample_and_a_known_name(tmp_path):
    made = weftex.synthesize(noise((30, 30)), 30, seed=1, method="quilting")
    made.save(tmp_path / "r.npz")
    refused("without its sample", weftex.Synthesis.load(tmp_path / "r.npz").draw, "seams")
    assert weftex.Synthesis.load(tmp_path / "r.npz").draw("patches").shape == (30, 30, 3)
    refused("known: sources, seams, patches", made.draw, "nothing")


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
