"""The nearest of all windows: exactly, however much of one is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise
from weftex.exemplar import Exemplar
from weftex.methods.refinement import nearest_kernels as kernels
from weftex.methods.refinement.nearest import nearest_search
from weftex.search import picture_kernels
from weftex.search.picture_kernels import Query
from weftex.search.windows import windows_of


def all_windows(windows, reach):
    places = [divmod(int(c), windows.pixels.shape[1]) for c in windows.centers]
    around = np.arange(-reach, reach + 1)
    return np.stack([windows.pixels[np.ix_(y + around, x + around)] for y, x in places])


def found_and_expected(search, window, there, near=()):
    """The place that is found for a window of which some pixels are known, and the true one."""
    reach = search.reach
    there = there.copy()
    there[reach, reach] = False
    runs = np.zeros((there.size, 3), np.int32)
    count = picture_kernels.known_runs(
        np.pad(there, reach).astype(np.uint8), 2 * reach, 2 * reach, False, False, reach, runs
    )
    query = np.append(window[there].ravel(), np.zeros(1, np.uint8))
    near = np.array(near, np.int32)
    place = kernels.nearest_window(*search.bundles(), Query(runs, query, count), near, len(near))
    every = all_windows(search.windows, reach).astype(int)
    apart = ((every - window)[:, there] ** 2).reshape(len(every), -1).sum(axis=1)
    return place, int(search.windows.centers[apart.argmin()])


KNOWN = {
    "whole": lambda y, x: np.ones_like(y, bool),
    "above": lambda y, x: (y < 0) | ((y == 0) & (x < 0)),
    "above and seeds": lambda y, x: (y < 0) | ((y == 0) & (x < 0)) | ((y % 5 == 2) & (x % 5 == 1)),
    "seeds": lambda y, x: (y % 5 == 2) & (x % 5 == 1),
    "right": lambda y, x: x > 0,
}


@pytest.mark.parametrize("known", KNOWN)
@pytest.mark.parametrize("name", ["pebbles", "grass", "weave"])
def test_a_half_known_window_finds_its_true_nearest_as_a_whole_one_does(name, known):
    """Windows of another part of the material, so that none is in the sample."""
    pixels = np.atleast_3d(weftex.load_exemplar(f"sample:{name}").pixels)
    windows = windows_of(Exemplar(pixels[:70, :72].copy()), (8,) * 4)
    search = nearest_search(windows, 8)
    away = np.indices((17, 17)) - 8
    for seed in range(12):
        y, x = np.random.default_rng(seed).integers(80, 160, 2)
        place, expected = found_and_expected(
            search, pixels[y : y + 17, x : x + 17], KNOWN[known](*away), [-1]
        )
        assert place == expected


@given(st.integers(0, 10**6), st.booleans())
def test_it_is_exhaustive_search(seed, tileable):
    """Few colors, so that many windows are equally near; and windows unlike all of the sample."""
    rng = np.random.default_rng(seed)
    channels, reach = int(rng.integers(1, 4)), int(rng.integers(0, 3))
    pixels = noise((9, 11, channels), seed=seed) // int(rng.choice([1, 100]))
    exemplar = Exemplar(pixels, alpha=False, tileable=tileable)
    search = nearest_search(windows_of(exemplar, (reach,) * 4), reach)
    side = 2 * reach + 1
    window = (rng.integers(0, 256, (side, side, channels)) // rng.choice([1, 100])).astype(np.uint8)
    there = rng.random((side, side)) < rng.choice([0.0, 0.5, 1.1])
    near = rng.choice(search.windows.centers, 3)
    place, expected = found_and_expected(search, window, there, near)
    assert place == expected


@given(st.integers(0, 10**6))
def test_components_bound_the_distance(seed):
    """No window is farther in coordinates than its distance allows; so none is left out wrongly."""
    rng = np.random.default_rng(seed)
    pixels = noise((20, 21, 3), seed=seed)
    pixels[:, 8:] //= int(rng.choice([1, 8, 255]))
    windows = windows_of(Exemplar(pixels), (2,) * 4)
    search = nearest_search(windows, 2)
    every = all_windows(windows, 2).reshape(len(windows.centers), -1, 3).astype(int)
    one = seed % len(every)
    for bound, part in ((search.whole, np.arange(25) != 12), (search.above, np.arange(25) < 12)):
        away = ((every - every[one])[:, part] ** 2).sum(axis=(1, 2))
        features = bound.components.features.astype(int)
        apart = ((features - features[:, [one]]) ** 2).sum(axis=0)
        assert (np.sqrt(apart) <= bound.length * np.sqrt(away) + np.sqrt(len(features))).all()
        # The bound is worth something: most of the distance is along the components.
        assert apart.sum() > 0.5 * (bound.length**2 * away).sum()


def test_a_constant_sample_has_a_nearest_window_too():
    windows = windows_of(Exemplar(np.full((9, 9, 3), 200, np.uint8)), (2,) * 4)
    search = nearest_search(windows, 2)
    window = noise((5, 5, 3))
    place, expected = found_and_expected(search, window, np.ones((5, 5), bool))
    assert place == expected == windows.centers[0]
