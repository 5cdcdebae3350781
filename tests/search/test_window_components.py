"""Components of square windows: integers from transforms, and coordinates of a part."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise
from twins import components as reference
from weftex.exemplar import Exemplar
from weftex.search import projection_kernels as kernels
from weftex.search.window_components import window_components
from weftex.search.windows import windows_of


def all_windows(windows, reach):
    places = [divmod(int(c), windows.pixels.shape[1]) for c in windows.centers]
    around = np.arange(-reach, reach + 1)
    return np.stack([windows.pixels[np.ix_(y + around, x + around)] for y, x in places])


@pytest.mark.parametrize("tileable", [False, True])
@pytest.mark.parametrize("channels", [1, 3])
def test_coordinates_are_products_with_the_components(tileable, channels):
    pixels = weftex.load_exemplar("sample:pebbles").pixels[:40, :44, :channels]
    windows = windows_of(Exemplar(pixels, tileable=tileable), (4,) * 4)
    found = window_components(windows, 4, 0.9)
    basis = found.basis.reshape(9, -1, 9, channels).astype(np.int64)
    assert not basis[4, :, 4].any()  # a pixel is not part of its own neighborhood
    raw = np.einsum("nyxk,ydxk->dn", all_windows(windows, 4).astype(np.int64), basis)
    expected = (raw - found.offset[:, None] + (2**found.shift >> 1)) >> found.shift
    assert np.array_equal(found.features, expected)
    assert np.abs(found.features).max() <= 2047


def test_components_are_the_principal_ones():
    pixels = weftex.load_exemplar("sample:weave").pixels[:28, :28]
    windows = windows_of(Exemplar(pixels), (3,) * 4)  # fewer than are learnt from
    found = window_components(windows, 3, 0.8)
    rows = all_windows(windows, 3).astype(float)
    rows[:, 3, 3] = 0
    rows = rows.reshape(len(rows), -1)
    values, vectors = np.linalg.eigh(np.cov(rows.T))
    basis = found.basis.transpose(1, 0, 2).reshape(len(found.features), -1) / 2000
    count = len(basis)
    assert np.allclose(np.abs((basis * vectors.T[::-1][:count]).sum(axis=1)), 1, atol=1e-2)
    share = values[::-1].cumsum() / values.sum()
    assert count == np.argmax(share >= 0.8) + 1 or count == 48
    assert found.variance == pytest.approx(share[count - 1], abs=0.011)


@given(st.integers(0, 99), st.integers(0, 49))
def test_a_known_part_gives_the_slow_twins_coordinates(seed, share):
    rng = np.random.default_rng(seed)
    channels = int(rng.integers(1, 4))
    windows = windows_of(Exemplar(noise((14, 15, channels), seed=seed), alpha=False), (2,) * 4)
    found = window_components(windows, 2, 0.9)
    window = noise((5, 5, channels), seed=seed + 1)
    there = rng.random((5, 5)) < share / 48
    there[2, 2] = False
    known = [(int(y) - 2, int(x) - 2) for y, x in np.argwhere(there)]
    runs = np.array([(*at, 1) for at in known] or [(0, 0, 0)], np.int32)
    query = np.concatenate([window[y + 2, x + 2] for y, x in known] or [np.zeros(1, np.uint8)])
    result = kernels.coordinates_of_runs(found.for_kernels(), runs[: len(known)], query)
    assert list(result) == reference.component_coordinates(window, known, found, 2)


def test_whole_windows_have_their_own_coordinates():
    windows = windows_of(Exemplar(noise((20, 21, 3))), (2,) * 4)
    found = window_components(windows, 2, 0.97)
    every = [(y, x) for y in range(-2, 3) for x in range(-2, 3) if y or x]
    for k, window in list(enumerate(all_windows(windows, 2)))[::37]:
        expected = reference.component_coordinates(window, every, found, 2)
        assert found.features[:, k].tolist() == expected


def test_a_constant_sample_has_coordinates_too():
    windows = windows_of(Exemplar(np.full((9, 9, 3), 200, np.uint8)), (2,) * 4)
    assert not window_components(windows, 2, 0.97).features.any()
