"""Non-parametric sampling: windows, thresholds and photos; see `brute_force` for each pixel."""

import numpy as np

import weftex
from families import noise
from weftex.methods import efros_leung


def test_waiting_ends_after_some_tries(monkeypatch):
    """Of a wide tolerance few draws are below a low threshold: it rises with every layer then."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:14, :14])
    method = weftex.EfrosLeung(window_width=5, tolerance=1000.0)
    monkeypatch.setattr(efros_leung, "_THRESHOLD", 0.005)
    tries = []
    layers = efros_leung.unfilled_neighbors

    def counted(*args):
        tries.append(len(layer := layers(*args)))
        return layer

    monkeypatch.setattr(efros_leung, "unfilled_neighbors", counted)
    method.fit(exemplar).sample((10, 30), seed=1)
    bounded = sum(tries)
    tries.clear()
    monkeypatch.setattr(efros_leung, "_TRIES", 10**6)
    method.fit(exemplar).sample((10, 30), seed=1)
    assert 8 * 300 < bounded < 13 * 300 < sum(tries)


def test_the_window_shrinks_to_what_is_there(rng):
    for shape, width in (((1, 1), 1), ((2, 9), 1), ((8, 30), 7), ((40, 40), 15)):
        model = weftex.EfrosLeung().fit(weftex.Exemplar(noise((*shape, 1), values=9, rng=rng)))
        assert model.method.window_width == width
        assert model.sample(6, seed=1).shape == (6, 6)
    mask = np.zeros((30, 30), bool)
    mask[3:8, 4:9] = True
    exemplar = weftex.Exemplar(noise((30, 30, 1), values=9, rng=rng), mask=mask)
    model = weftex.EfrosLeung().fit(exemplar)
    assert model.method.window_width == 5
