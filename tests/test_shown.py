"""What notebooks, prompts and NumPy see of samples and results."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

import weftex

SAMPLE = np.random.default_rng(0).integers(0, 256, (40, 48, 3), np.uint8)


@pytest.fixture(scope="module")
def result():
    return weftex.synthesize(SAMPLE, (40, 50), method="quilting", seed=7)


def test_arrays(result):
    assert np.array_equal(np.asarray(result), result.image)
    assert np.array(weftex.Exemplar(SAMPLE), np.float32).dtype == np.float32


def test_pictures(result):
    shown = Image.open(io.BytesIO(result._repr_png_()))
    assert np.array_equal(np.asarray(shown), result.image)
    html = result._repr_html_()
    data = re.search('base64,([^"]*)', html)[1]
    assert base64.b64decode(data) == result._repr_png_() and "&lt;PatchSynthesis 50x40" in html


@pytest.mark.parametrize(
    ("pixels", "mode", "size"),
    [
        (SAMPLE[..., 0], "L", (48, 40)),
        (SAMPLE[..., :2], "LA", (48, 40)),
        (np.dstack([SAMPLE, SAMPLE[..., :1]]), "RGBA", (48, 40)),
        (SAMPLE.astype(np.uint16) * 257, "RGB", (48, 40)),
        (SAMPLE / 255.0, "RGB", (48, 40)),
        (np.zeros((1, 5000, 5), np.float32), "RGB", (1000, 1)),
    ],
)
def test_every_kind_of_picture(pixels, mode, size):
    exemplar = weftex.Exemplar(pixels)
    shown = Image.open(io.BytesIO(exemplar._repr_png_()))
    assert (shown.mode, shown.size) == (mode, size)
    if size == (48, 40):
        same = np.array_equal(np.asarray(shown)[..., 0].ravel(), SAMPLE[..., 0].ravel())
        assert same or mode == "L"


def test_without_a_sample_there_is_no_picture(result, tmp_path):
    result.save(tmp_path / "r.npz")
    loaded = weftex.Synthesis.load(tmp_path / "r.npz")
    assert loaded._repr_png_() is loaded._repr_html_() is None
    with pytest.raises(ValueError, match="loaded without its sample"):
        np.asarray(loaded)
    assert repr(loaded) == "<PatchSynthesis 50x40: by quilting, seed 7>"


def test_what_is_printed_is_short(result):
    sample = weftex.Exemplar(SAMPLE, maps={"height": SAMPLE[..., 0]}, name="wall")
    assert repr(sample) == "<Exemplar 'wall': 48x40, 3 x uint8, maps: height>"
    model = weftex.Quilting().fit(sample)
    report = weftex.pages.report(weftex.Exemplar(SAMPLE), result)
    hole = np.eye(40, dtype=bool)
    things = (result, model, weftex.METHODS, weftex.analyze(sample), report)
    things += (weftex.Canvas(40, 40, known=SAMPLE[:, :40], hole=hole),)
    for thing in things:
        assert len(repr(thing)) < 400 and "\n" not in repr(thing), thing
    assert 'srcdoc="&lt;!DOCTYPE' in report._repr_html_()
