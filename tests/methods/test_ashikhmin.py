"""Coherent candidates: layers of holes, and guides; see `brute_force` for each pixel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from twins.seams import path_around
from weftex.canvas import Canvas
from weftex.methods.ashikhmin import least_path
from weftex.raster.masks import peeled

WRAPS = [(False, False), (False, True), (True, False), (True, True)]


# Holes in layers


@given(st.data())
def test_layers_go_inwards(data):
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    shape = data.draw(st.integers(1, 9)), data.draw(st.integers(1, 9))
    wrap = data.draw(st.sampled_from(WRAPS))
    unknown = rng.random(shape) < data.draw(st.sampled_from([0.0, 0.5, 0.9, 1.0]))
    found = peeled(unknown, wrap)
    order = np.concatenate([*found, np.empty(0, int)])
    assert sorted(order) == np.flatnonzero(unknown).tolist()
    if unknown.all():
        assert len(found) == 1
        return
    known = ~unknown
    for layer in found:
        assert layer.dtype == np.int32 and (np.diff(layer) > 0).all()
        padded = np.pad(known, 1)
        for axis in (0, 1):
            if wrap[axis]:
                around = padded.swapaxes(0, axis)
                around[0], around[-1] = around[-2].copy(), around[1].copy()
        beside = padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]
        assert np.array_equal(layer, np.flatnonzero(beside & ~known))
        known.reshape(-1)[layer] = True


# The guide


def two_halves(height=60, width=64):
    """A sample with a dark and a bright half, and a guide with a bright disc on dark ground."""
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 60, (40, 48, 3), np.uint8)
    pixels[:, 24:] += 180
    y, x = np.indices((height, width))
    guide = np.full((height, width, 3), 30, np.uint8)
    guide[(y - 30) ** 2 + (x - 30) ** 2 < 300] = 210
    return weftex.Exemplar(pixels), guide


@pytest.mark.parametrize("passes", [1, 2])
@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_the_output_follows_the_guide(passes, wrap):
    exemplar, guide = two_halves()
    canvas = Canvas(*guide.shape[:2], wrap, guide=guide)
    bright = guide[..., 0] > 100
    guided = weftex.Ashikhmin(passes=passes, guide_weight=1.0)
    image = guided.fit(exemplar).sample(canvas, seed=1).image
    follows = (image.mean(axis=2) > 120) == bright
    assert follows.mean() > 0.95
    alone = weftex.Ashikhmin(passes=passes).fit(exemplar).sample(Canvas(60, 64, wrap), seed=1).image
    assert ((alone.mean(axis=2) > 120) == bright).mean() < 0.8


def test_a_heavier_guide_is_followed_more():
    exemplar = weftex.load_exemplar("sample:pebbles")
    guide = np.repeat(np.linspace(20, 200, 90).astype(np.uint8)[:, None], 90, 1)
    guide = np.repeat(guide[..., None], 3, 2)
    away = []
    for weight in (0.01, 0.1, 1.0, 10.0):
        model = weftex.Ashikhmin(guide_weight=weight).fit(exemplar)
        image = model.sample(Canvas(90, 90, guide=guide), seed=1).image
        away.append(np.abs(image.astype(int) - guide).mean())
    assert away == sorted(away, reverse=True)
    assert away[-1] < away[0] / 2


def test_a_guided_hole():
    exemplar, guide = two_halves()
    hole = np.zeros(guide.shape[:2], bool)
    hole[10:50, 10:50] = True
    known = np.where(hole[..., None], 0, guide).astype(np.uint8)
    canvas = Canvas(60, 64, known=known, hole=hole, guide=guide)
    image = weftex.Ashikhmin(guide_weight=1.0).fit(exemplar).sample(canvas, seed=1).image
    assert np.array_equal(image[~hole], known[~hole])
    assert ((image.mean(axis=2) > 120) == (guide[..., 0] > 100))[hole].mean() > 0.9


def test_guides_for_synthesize():
    """A path, an array or a picture; one place only."""
    from PIL import Image

    exemplar, guide = two_halves()
    canvas = Canvas(60, 64, guide=guide)
    expected = weftex.Ashikhmin().fit(exemplar).sample(canvas, seed=2).image
    for own_guide in (guide, Image.fromarray(guide), weftex.Exemplar(guide)):
        result = weftex.synthesize(exemplar, (60, 64), method="ashikhmin", guide=own_guide, seed=2)
        assert np.array_equal(result.image, expected)
    with pytest.raises(weftex.InvalidInputError, match="the canvas has a guide"):
        weftex.synthesize(exemplar, canvas, method="ashikhmin", guide=guide)


@given(st.integers(0, 10**6), st.integers(1, 30), st.integers(1, 12), st.booleans())
def test_paths_are_the_slow_twin(seed, rows, columns, closed):
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, rng.choice([1, 3, 2**40]), (rows, columns))
    assert least_path(cost, closed=closed).tolist() == list(path_around(cost, closed))
