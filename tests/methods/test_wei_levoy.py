"""Wei and Levoy's method; what holds for every method is in test_invariants.py."""

import itertools

import numpy as np
import pytest

import weftex
from families import canvas_of, made, noise, refused
from weftex.methods.wei_levoy import inwards
from weftex.search import pyramid_windows


@pytest.mark.parametrize("kind", ["plain", "xy", "hole"])
def test_samples_that_tile_and_masks(kind):
    """Of a sample only places of whole windows are taken; where it tiles, each has one."""
    pixels = noise((14, 15, 2))
    mask = np.ones((14, 15), bool)
    mask[6:8, 7:9] = False
    sources = []
    for about in ({"mask": mask}, {"tileable": True}):
        model = weftex.WeiLevoy(levels=1, window_width=5).fit(weftex.Exemplar(pixels, **about))
        result = model.sample(canvas_of(kind, pixels), seed=2)
        sources.append(result.source[made(result)])
    y, x = sources[0].T
    assert y.min() >= 2 and x.min() >= 2 and x.max() < 13
    for dy, dx in itertools.product((-2, -1, 0), (-2, -1, 0, 1, 2)):
        assert dy == 0 < dx or mask[y + dy, x + dx].all()
    assert set(sources[1][:, 0]) == set(range(14)) and set(sources[1][:, 1]) == set(range(15))


def test_large_samples_are_thinned_out():
    exemplar = weftex.Exemplar(noise((40, 40)))
    every = pyramid_windows.window_vectors(exemplar, None, 3, 0, causal=False)[1]
    vectors, places = pyramid_windows.window_vectors(exemplar, None, 3, 0, causal=False, most=200)
    assert vectors.shape == (200, 8) and len(set(places.tolist())) == 200
    assert set(places.tolist()) < set(every.tolist()) and (np.diff(places) > 0).all()


def test_the_full_search_looks_at_all_windows_of_large_samples():
    """A tree is built over a part of them."""
    large = weftex.Exemplar(noise((370, 370)))
    tree = weftex.WeiLevoy(levels=1, window_width=3)
    full = weftex.WeiLevoy(levels=1, window_width=3, search="full")
    assert len(full.fit(large).prepared.trees.of(0, causal=True).rows) == 369 * 368
    assert len(tree.fit(large).prepared.trees.of(0, causal=True).rows) == 131072


def border_difference(image, axis):
    """Mean difference across the border over that between neighboring lines inside."""
    lines = np.moveaxis(image.astype(float), axis, 0)
    steps = np.abs(np.roll(lines, -1, axis=0) - lines).reshape(len(lines), -1).mean(axis=1)
    return steps[-1] / steps[:-1].mean()


@pytest.mark.pictures
@pytest.mark.parametrize("levels", [1, 3])
@pytest.mark.parametrize("name", ["pebbles", "wood"])
def test_a_further_pass_closes_the_seam(levels, name):
    """The causal pass alone shows where the last row meets the first; the paper has no more."""
    exemplar = weftex.Exemplar(weftex.load_exemplar(f"sample:{name}").pixels[:128, :128])
    model = weftex.WeiLevoy(levels=levels).fit(exemplar)
    closed, plain = [], []
    for seed in range(4):
        closed.append(border_difference(model.sample((70, 61), seed=seed, tileable="y").image, 0))
        plain.append(border_difference(model.sample((70, 61), seed=seed).image, 0))
    assert np.mean(closed) < 1.3
    assert np.mean(closed) - 1 < 0.6 * (np.mean(plain) - 1)


def test_settled_parameters():
    def settled(shape, tileable=False, **parameters):
        exemplar = weftex.Exemplar(noise(shape), tileable=tileable)
        method = weftex.WeiLevoy(**parameters).resolved(exemplar)
        return method.levels, method.window_width, method.parent_width

    assert settled((256, 256)) == (4, 9, 7)
    assert settled((152, 300)) == (4, 9, 7)  # 19 rows at the coarsest level
    assert settled((128, 128)) == (3, 9, 7)
    assert settled((24, 24)) == (1, 9, 0)
    assert settled((7, 40)) == (1, 7, 0)
    assert settled((1, 1)) == settled((1, 50)) == (1, 1, 0)
    assert settled((24, 24), levels=2) == (2, 9, 7)
    assert settled((40, 40), levels=3, window_width=5) == (3, 5, 3)
    assert settled((40, 40), window_width=3) == (3, 3, 1)
    assert settled((12, 12), tileable=True, levels=4, window_width=5, parent_width=1) == (4, 5, 1)


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"levels": 4}, "levels is 4; sample is 40x30, so it must be at most 2 with windows of 9"),
        ({"window_width": 31}, "window_width is 31; sample is 40x30, so it must be at most 29"),
        ({"parent_width": 5, "window_width": 5}, "must be below window_width, which is 5"),
        ({"parent_width": 9, "levels": 2}, "must be below window_width, which is 9"),
        ({"parent_width": 3, "levels": 1}, "parent_width has no effect"),
        ({"parent_width": 3, "window_width": 29}, "too small for two levels"),
        ({"levels": 2, "window_width": 1}, "at most 1 with windows of 1"),
    ],
)
def test_parameters_that_do_not_fit(parameters, message):
    refused(message, lambda: weftex.WeiLevoy(**parameters).fit(weftex.Exemplar(noise((30, 40)))))


def test_layers_go_inwards():
    unknown = np.zeros((9, 9), bool)
    unknown[2:7, 2:7] = True
    order = inwards(unknown, (False, False), 1)
    ring = np.abs(np.stack(np.divmod(order, 9)) - 4).max(axis=0)
    assert ring.tolist() == [2] * 16 + [1] * 8 + [0]
    assert order.tolist() != inwards(unknown, (False, False), 2).tolist()
    everything = inwards(np.ones((3, 3), bool), (True, True), 1)
    assert sorted(everything.tolist()) == list(range(9))
