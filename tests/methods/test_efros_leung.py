"""Non-parametric sampling: byte by byte what growing one pixel after the other gives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise
from twins import efros_leung as reference
from weftex.canvas import Canvas
from weftex.methods import efros_leung

WRAPS = [(False, False), (False, True), (True, False), (True, True)]


def check_twin(method, exemplar, canvas, seed, threads=1):
    model = method.fit(exemplar)
    result = model.sample(canvas, seed=seed, threads=threads)
    expected = reference.efros_leung(model.method, exemplar, canvas, seed)
    if canvas.hole is not None:
        expected[~canvas.hole] = -1
        result.known_from = None
    assert np.array_equal(result.source, expected)
    return result


@given(st.data())
def test_it_is_the_slow_twin(data):
    """Small samples of few colors, which match in many places, on every kind of canvas."""
    draw = data.draw
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    height, width = draw(st.integers(5, 9)), draw(st.integers(5, 9))
    pixels = noise(
        (height, width, draw(st.integers(1, 3))),
        values=draw(st.sampled_from([1, 2, 5, 200])),
        rng=rng,
    )
    mask = None
    if draw(st.booleans()):
        mask = np.ones((height, width), bool)
        mask[0, rng.integers(width)] = False
    exemplar = weftex.Exemplar(pixels, mask=mask, tileable=draw(st.booleans()), alpha=False)
    size = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    wrap = draw(st.sampled_from(WRAPS))
    canvas = Canvas(*size, wrap)
    if draw(st.booleans()):
        known = noise((*size, pixels.shape[2]), values=5, rng=rng)
        canvas = Canvas(*size, wrap, known=known, hole=rng.random(size) < 0.6)
    method = weftex.EfrosLeung(
        window_width=draw(st.sampled_from([None, 1, 3])),
        tolerance=draw(st.sampled_from([0.0, 0.1, 1.0])),
        threshold=draw(st.sampled_from([0.3, 0.02, 1e-6])),
    )
    check_twin(method, exemplar, canvas, draw(st.integers(0, 2**64 - 1)), draw(st.integers(1, 3)))


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("name", ["pebbles", "grass"])
def test_real_samples_are_the_slow_twin(name, wrap):
    exemplar = weftex.Exemplar(weftex.load_exemplar(f"sample:{name}").pixels[:29, :32])
    check_twin(weftex.EfrosLeung(window_width=9), exemplar, Canvas(16, 19, wrap), 7, threads=2)


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_holes_are_the_slow_twin(wrap, rng):
    """Two holes of a photo, learnt from the rest of it, one of them over its border."""
    photo = weftex.load_exemplar("sample:pebbles").pixels[:44, :40]
    hole = np.zeros(photo.shape[:2], bool)
    hole[15:22, 10:19] = hole[30:36, 34:] = True
    exemplar = weftex.Exemplar(photo, mask=~hole)
    canvas = Canvas(44, 40, wrap, known=photo, hole=hole, known_from=(0, 0))
    result = check_twin(weftex.EfrosLeung(window_width=7), exemplar, canvas, 5, threads=2)
    assert np.array_equal(result.image[~hole], photo[~hole])


def test_a_window_wider_than_the_canvas_sees_every_pixel_once(rng):
    exemplar = weftex.Exemplar(noise((20, 20, 1), values=7, rng=rng))
    for shape in ((1, 1), (1, 8), (6, 1), (4, 5)):
        for wrap in WRAPS:
            check_twin(weftex.EfrosLeung(window_width=11), exemplar, Canvas(*shape, wrap), 3)


@pytest.mark.parametrize("threshold", [1e-6, 0.01, 0.3])
def test_pixels_wait_until_the_threshold_has_risen(threshold, rng):
    exemplar = weftex.Exemplar(noise((9, 9, 2), values=256, rng=rng), alpha=False)
    check_twin(weftex.EfrosLeung(window_width=5, threshold=threshold), exemplar, Canvas(8, 8), 1)


def test_waiting_ends_after_some_tries(monkeypatch):
    """Of a wide tolerance few draws are below a low threshold: it rises with every layer then."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:14, :14])
    method = weftex.EfrosLeung(window_width=5, threshold=0.005, tolerance=1000.0)
    tries = []
    layers = efros_leung.unfilled_with_filled_neighbors

    def counted(*args):
        tries.append(len(layer := layers(*args)))
        return layer

    monkeypatch.setattr(efros_leung, "unfilled_with_filled_neighbors", counted)
    check_twin(method, exemplar, Canvas(10, 30), 1)
    bounded = sum(tries)
    tries.clear()
    monkeypatch.setattr(efros_leung, "_TRIES", 10**6)
    method.fit(exemplar).sample((10, 30), seed=1)
    assert 8 * 300 < bounded < 13 * 300 < sum(tries)


def test_the_window_shrinks_to_what_is_there(rng):
    for shape, width in (((1, 1), 1), ((2, 9), 1), ((8, 30), 7), ((40, 40), 15)):
        model = weftex.EfrosLeung().fit(weftex.Exemplar(noise((*shape, 1), values=9, rng=rng)))
        assert (model.method.window_width, model.method.seed_size) == (width, min(width, 3))
        assert model.sample(6, seed=1).shape == (6, 6)
    mask = np.zeros((30, 30), bool)
    mask[3:8, 4:9] = True
    model = weftex.EfrosLeung().fit(
        weftex.Exemplar(noise((30, 30, 1), values=9, rng=rng), mask=mask)
    )
    assert model.method.window_width == 5


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"window_width": 4}, "window_width is 4; it must be odd"),
        ({"window_width": 21}, "window_width is 21.* room for 19"),
        ({"window_width": 3, "seed_size": 5}, "seed_size is 5; .* window_width of 3"),
        ({"tolerance": -0.1}, "tolerance is -0.1; it must be from 0 to 1000"),
        ({"tolerance": float("inf")}, "tolerance is inf"),
        ({"threshold": 0.0}, "threshold is 0.0; it must be from 1e-06 to 1"),
        ({"seed_size": 0}, "seed_size is 0; it must be 1 or more"),
    ],
)
def test_what_cannot_be_is_refused(parameters, message, rng):
    with pytest.raises(weftex.InvalidInputError, match=message):
        weftex.EfrosLeung(**parameters).fit(weftex.Exemplar(noise((20, 20, 1), values=9, rng=rng)))


def test_a_mask_without_room_for_the_window_is_refused(rng):
    mask = np.indices((20, 20)).sum(axis=0) % 2 == 0
    exemplar = weftex.Exemplar(noise((20, 20, 1), values=9, rng=rng), mask=mask)
    with pytest.raises(weftex.InvalidInputError, match="no whole window"):
        weftex.EfrosLeung(window_width=3).fit(exemplar)
    result = weftex.EfrosLeung().fit(exemplar).sample(9, seed=1)
    assert mask[tuple(result.source.reshape(-1, 2).T)].all()


def test_a_photo_is_filled():
    photo = weftex.load_exemplar("sample:grass").pixels[:90, :80]
    hole = np.zeros(photo.shape, bool)
    hole[30:50, 30:44] = hole[60:66, 50:70] = True
    result = weftex.fill(photo, hole, method="efros-leung", window_width=9, seed=3)
    assert np.array_equal(result.image[~hole], photo[~hole])
    assert not hole[tuple(result.source[hole].T)].any()
