"""The nearest of all windows: exactly, however much of one is known."""

import numpy as np
import pytest

import weftex
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
