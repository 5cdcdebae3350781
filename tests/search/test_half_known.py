"""Half-known windows by principal components: the twin's windows, and most of the best ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import families
import weftex
from materials import made_up, states
from twins import components as reference
from twins.exhaustive import choice_of_all as slow
from twins.windows import known_window
from weftex.search import exhaustive_kernels, half_known
from weftex.search import half_known_kernels as _half_known_kernels
from weftex.search import weighted_kernels as _weighted_kernels
from weftex.search.exhaustive import ExhaustiveSearch
from weftex.search.half_known import HalfKnownSearch
from weftex.search.weighted_windows import gaussian_weights
from weftex.search.windows import windows_of

WRAPS = list(families.WRAPS.values())


def search_of(exemplar, reach, candidates=8, variance=0.9):
    windows = windows_of(exemplar, (reach,) * 4)
    weights = gaussian_weights(2 * reach + 1, (2 * reach + 1) / 6.4)
    return HalfKnownSearch(windows, weights, candidates, variance)


def rows_of(search, values, fill=0):
    """Numbers of a window's bytes (width**2 * K) in the rows that kernels want."""
    width = search.sample.width
    rows = np.full((width, search.sample.stride), fill, values.dtype)
    rows[:, : width * search.sample.channels] = values.reshape(width, -1)
    return rows.ravel()


def leaves_of(search):
    """Places and coordinates of each leaf."""
    leaves = []
    for n, size in enumerate(search.leaves.sizes):
        at = slice(64 * n, 64 * n + size)
        leaves.append((search.leaves.places[at].tolist(), search.leaves.planes[:, at].T))
    return leaves


def coordinates(search, query, known):
    """What the kernel estimates from the known bytes of a window."""
    width, fitted = search.sample.width, search.components
    keep = len(fitted.ridge)
    z, gram = np.empty(keep), np.empty(keep * (keep + 1) // 2)
    rows = np.arange(-1, width, dtype=np.int32)
    rows[0] = width
    runs = np.empty((1, 3), np.int32)
    _half_known_kernels.coordinates(
        search.sample.bundle(), _weighted_kernels.Query(runs, query, known, rows),
        _half_known_kernels.Components(
            fitted.mean, fitted.basis, fitted.products, fitted.ridge, fitted.factor, fitted.origin,
            gram, z,
        ),
    )  # fmt: skip
    return z


def as_bytes(search, z):
    values = np.zeros(len(search.leaves.planes), int)
    fitted = search.components.factor * z + search.components.origin
    values[: len(z)] = np.clip(fitted, 0, 255).astype(int)
    return values


@given(st.integers(0, 10**6), st.integers(1, 3), st.sampled_from(["noise", "few", "smooth"]))
def test_coordinates_are_weighted_least_squares(seed, reach, kind):
    rng = np.random.default_rng(seed)
    exemplar = weftex.Exemplar(made_up(rng, (20, 24), kind, rng.integers(1, 4)), alpha=False)
    search = search_of(exemplar, reach)
    width = 2 * reach + 1
    heavy = search.sample.weights * (rng.random((width, width)) < 0.5)
    heavy[reach, reach] = 0
    known = rows_of(search, np.repeat(heavy.ravel(), search.sample.channels).astype(np.int16))
    query = rng.integers(0, 256, len(known)).astype(np.uint8)
    expected = reference.ridge_coordinates(
        known, search.components.basis, query, search.components.mean, search.components.ridge
    )
    assert np.allclose(coordinates(search, query, known), expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["pebbles", "grass"])
def test_a_whole_window_gets_its_own_coordinates(name):
    """All of the window is known, so only the ridge and rounding move it."""
    exemplar = weftex.Exemplar(weftex.load_exemplar(f"sample:{name}").pixels[:48, :48])
    search = search_of(exemplar, 4)
    search.components.ridge[:] = 0
    heavy = search.sample.weights.copy()
    heavy[4, 4] = 0
    known = rows_of(search, np.repeat(heavy.ravel(), search.sample.channels).astype(np.int16))
    for places, features in leaves_of(search)[::5]:
        for place, feature in list(zip(places, features, strict=True))[::16]:
            y, x = divmod(place, 48)
            window = exemplar.matching()[y - 4 : y + 5, x - 4 : x + 5]
            query = rows_of(search, window.astype(np.uint8).ravel())
            found = as_bytes(search, coordinates(search, query, known))
            assert np.abs(found - feature.astype(int)).max() <= 3


@given(st.integers(1, 400), st.integers(0, 3))
def test_every_window_is_in_one_leaf(width, reach):
    pixels = made_up(np.random.default_rng(width), (9, width + 7), "few", 2)
    search = search_of(weftex.Exemplar(pixels), reach)
    found = sorted(place for places, _ in leaves_of(search) for place in places)
    assert found == search.sample.windows.centers.tolist()
    assert (search.leaves.sizes == 64).sum() >= len(search.leaves.sizes) - 1


@given(st.data())
def test_it_is_the_slow_twin(data):
    draw = data.draw
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    kind = draw(st.sampled_from(["noise", "few", "extreme", "smooth"]))
    pixels = made_up(rng, (rng.integers(12, 30), rng.integers(12, 90)), kind, rng.integers(1, 4))
    exemplar = weftex.Exemplar(pixels, tileable=draw(st.booleans()), alpha=False)
    search = search_of(exemplar, draw(st.integers(0, 3)), draw(st.sampled_from([1, 7, 40])))
    width, leaves = search.sample.width, leaves_of(search)
    wrap = draw(st.sampled_from(WRAPS))
    levels, done, source = states(rng, exemplar, search.sample.windows, (12, 14), wrap)
    places = np.flatnonzero(done == 0)[:15].astype(np.int32)
    bits = rng.integers(0, 2**64, len(places), dtype=np.uint64)
    found = search.on(levels, done, source, wrap, 0.1)(places, bits)
    for n, place in enumerate(places):
        y, x = divmod(int(place), 14)
        query = np.zeros((width, width, search.sample.channels), np.uint8)
        known = np.zeros((width, width, search.sample.channels), np.int16)
        for dy, dx in known_window(done, y, x, wrap, [width // 2] * 4):
            at = dy + width // 2, dx + width // 2
            query[at], known[at] = levels[(y + dy) % 12, (x + dx) % 14], search.sample.weights[at]
        z = coordinates(search, rows_of(search, query), rows_of(search, known))
        candidates = set(
            reference.near_leaves(
                as_bytes(search, z), leaves, exhaustive_kernels.largest_term, 16, search.candidates
            )
        )
        for dy, dx in known_window(done, y, x, wrap, [min(1, width // 2)] * 4):
            own = source[(y + dy) % 12, (x + dx) % 14]
            if own >= 0:
                candidates |= shifted(search.sample.windows, exemplar, int(own), -dy, -dx)
        expected = slow(search, exemplar, levels, done, wrap, place, bits[n], 0.1, candidates)
        assert tuple(int(part[n]) for part in found) == expected


def shifted(windows, exemplar, own, dy, dx):
    """Where the window beside a place of the sample is, if it is one."""
    y, x = divmod(int(windows.to_sample(np.array([own], np.int32))[0]), exemplar.shape[1])
    y, x = y + dy, x + dx
    if exemplar.tileable:
        y, x = y % exemplar.shape[0], x % exemplar.shape[1]
    elif not (0 <= y < exemplar.shape[0] and 0 <= x < exemplar.shape[1]):
        return set()
    place = int(windows.from_sample(np.array([y * exemplar.shape[1] + x], np.int32))[0])
    return {place} if windows.usable.flat[place] else set()


@pytest.mark.parametrize("name", ["pebbles", "bricks", "grass"])
def test_most_of_the_best_windows_are_found(name):
    """Along a front through what an exact search made."""
    exemplar = weftex.Exemplar(weftex.load_exemplar(f"sample:{name}").pixels[:96, :96])
    model = weftex.EfrosLeung(window_width=11).fit(exemplar)
    search = search_of(exemplar, 5, 32)
    result = model.sample(48, seed=1)
    source = model.prepared.windows.from_sample(result.index)
    levels = model.prepared.windows.pixels.reshape(-1, exemplar.channels)[source]
    done = np.ones((48, 48), np.uint8)
    done[:, 24:] = 0
    places = (np.arange(4, 44) * 48 + 24).astype(np.int32)
    bits = np.zeros(len(places), np.uint64)
    exact = ExhaustiveSearch(model.prepared.windows, model.prepared.search.sample.weights)
    near, best = (
        s.on(levels, done, source, (False, False), 0.0)(places, bits)[1] for s in (search, exact)
    )
    assert (near >= best).all()
    assert np.mean(near <= 1.21 * best) > 0.8


def test_with_room_for_all_windows_it_is_exact(monkeypatch):
    monkeypatch.setattr(half_known, "_MOST_LEAVES", 1000)
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:40, :40])
    near = weftex.EfrosLeung(window_width=7, search="pca", candidates=10**6).fit(exemplar)
    exact = weftex.EfrosLeung(window_width=7).fit(exemplar)
    assert np.array_equal(near.sample(24, seed=1).source, exact.sample(24, seed=1).source)


@pytest.mark.parametrize("value", [0, 255])
def test_a_constant_sample_has_no_components(value):
    exemplar = weftex.Exemplar(np.full((20, 20, 3), value, np.uint8))
    result = weftex.EfrosLeung(window_width=5, search="pca").fit(exemplar).sample(12, seed=1)
    assert (result.image == value).all()


def test_parameters_of_pca_need_it():
    for name in ("candidates", "variance"):
        with pytest.raises(weftex.InvalidInputError, match=f"{name} has no effect unless search"):
            weftex.EfrosLeung(**{name: 0.5 if name == "variance" else 8})
