"""Whatever is allowed works, or is refused in one line: every task with every method.

2,000 cases, the same in every run but for constants that hypothesis takes from the modules that are
loaded. `WEFTEX_CASES=50 pytest tests/test_properties.py
--hypothesis-seed=20261122` tries fifty times as many, others for every seed.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from html_page import Page
from strategies import canvases, cases, exemplars, finite, is_one_line, masks, methods, patience
from strategies import pictures as drawn_pictures

METHODS = list(weftex.METHODS)
SEEDS = st.sampled_from([0, 1, 2**64 - 1])


def allowed(work, *values, **named):
    """What `work` returns on one thread, or None where weftex refused or was stopped."""
    try:
        return work(*values, threads=1, progress=patience(), **named)
    except weftex.WeftexError as error:
        assert is_one_line(error)
        return None


def check(result, exemplar):
    """A whole picture, of pixels that may be used."""
    picture, source = result.image, result.source
    assert picture.shape == (*result.shape, *exemplar.pixels.shape[2:])
    assert picture.dtype == exemplar.pixels.dtype and finite(picture)
    made = np.ones(result.shape, bool) if result.canvas.hole is None else result.canvas.hole
    assert (source[made] >= 0).all() and (source < exemplar.shape).all()
    if exemplar.mask is not None:
        assert exemplar.mask[source[made][:, 0], source[made][:, 1]].all()


def check_replay(result, data):
    """A saved result, loaded, gives the same, and lays any other map."""
    exemplar, canvas = result.sample, result.canvas
    result.draw(data.draw(st.sampled_from(["sources", "seams", "patches"])))
    height, width = result.shape
    top, left = data.draw(st.integers(0, height - 1)), data.draw(st.integers(0, width - 1))
    window = (top, left, data.draw(st.integers(1, height - top)), width - left)
    part = result.render(window=window)
    assert np.array_equal(part, result.image[top : top + window[2], left:])
    if canvas.hole is None:
        times = data.draw(st.integers(1, 2))
        other = data.draw(drawn_pictures((times * exemplar.shape[0], times * exemplar.shape[1])))
        assert result.render(other).shape[:2] == (times * height, times * width)
    assert all(finite(value) for value in result.maps.values()) if canvas.hole is None else True


@pytest.mark.parametrize("slug", METHODS)
@cases(75)
@given(data=st.data())
def test_synthesize(slug, data):
    method, exemplar = data.draw(methods(slug)), data.draw(exemplars())
    canvas = data.draw(canvases(method, exemplar))
    result = allowed(weftex.synthesize, exemplar, canvas, method=method, seed=data.draw(SEEDS))
    if result is not None:
        check(result, exemplar)


@pytest.mark.parametrize("slug", [s for s in METHODS if "known" in weftex.METHODS[s].supports])
@cases(50)
@given(data=st.data())
def test_fill(slug, data):
    method, photo = data.draw(methods(slug)), data.draw(exemplars())
    hole = data.draw(masks(photo.shape))
    sample = None
    if not photo.maps and data.draw(st.integers(0, 3)) == 0:
        sample = data.draw(exemplars(like=photo.pixels))
    tileable = data.draw(st.sampled_from([False, True, "x", "y"]))
    given_to = {"seed": data.draw(SEEDS), "sample": sample, "method": method}
    given_to["tileable"] = tileable if "wrap" in method.supports else False
    result = allowed(weftex.fill, photo, hole, **given_to)
    if result is not None:
        check(result, photo if sample is None else sample)
        assert np.array_equal(result.image[~hole], photo.pixels[~hole], equal_nan=True)


@pytest.mark.parametrize("slug", [s for s in METHODS if "many" in weftex.METHODS[s].supports])
@cases(40)
@given(data=st.data())
def test_fuse(slug, data):
    method, first = data.draw(methods(slug)), data.draw(exemplars())
    others = data.draw(st.lists(exemplars(like=first.pixels), min_size=1, max_size=2))
    size = data.draw(st.tuples(st.integers(1, 30), st.integers(1, 30)))
    labels = "gradient"
    if data.draw(st.integers(0, 2)):
        labels = np.zeros(size, int)
        labels[size[0] // 2 :] = 1
        labels[:, size[1] // 2 :] += data.draw(st.integers(0, 1))
    tileable = data.draw(st.sampled_from([False, False, True, "x"]))
    given_to = {"seed": data.draw(SEEDS), "method": method}
    given_to["tileable"] = tileable if "wrap" in method.supports else False
    result = allowed(weftex.fuse, [first, *others], labels, size, **given_to)
    if result is not None:
        check(result, result.sample)


@pytest.mark.parametrize("slug", METHODS)
@cases(30)
@given(data=st.data())
def test_a_result_is_laid_again(slug, data, tmp_path_factory):
    method, exemplar = data.draw(methods(slug)), data.draw(exemplars())
    canvas = data.draw(canvases(method, exemplar))
    result = allowed(lambda **how: method.fit(exemplar).sample(canvas, seed=1, **how))
    if result is None:
        return
    check_replay(result, data)
    path = tmp_path_factory.getbasetemp() / "result.npz"
    result.save(path)
    again = weftex.Synthesis.load(path, exemplar, known=canvas.known)
    assert np.array_equal(again.source, result.source)
    assert np.array_equal(again.image, result.image)


@cases(100)
@given(data=st.data())
def test_auto(data):
    exemplar = data.draw(exemplars())
    canvas = data.draw(canvases(weftex.Auto(), exemplar))
    result = allowed(weftex.synthesize, exemplar, canvas, seed=1)
    if result is not None:
        check(result, exemplar)


@cases(100)
@given(exemplar=exemplars())
def test_analyze(exemplar):
    found = weftex.analyze(exemplar)
    assert str(found) and found.as_dict()["height"] == exemplar.shape[0]


@cases(100)
@given(data=st.data())
def test_assess_and_report(data):
    exemplar = data.draw(exemplars())
    size = data.draw(st.tuples(*[st.integers(1, 40)] * 2))
    made = data.draw(drawn_pictures(size, exemplar.pixels))
    if (found := allowed(lambda **_: weftex.pages.report(exemplar, made))) is not None:
        Page(html := found.html())  # its tags close
        assert html.count('<td class="over">over') == len(found.assessment.flags)
        assert "nan" not in html.partition("Measures")[2].lower()
