"""Pixel methods without options beyond the paper make the bytes of the references."""

import numpy as np
import pytest

import weftex
from weftex import reference
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError

SEEDS = [0, 5]


def crop(name, height, width):
    return weftex.load_exemplar(f"sample:{name}").pixels[:height, :width]


def check(method, sample, size, expected, seed):
    result = method.fit(weftex.Exemplar(sample)).sample(Canvas(*size), seed=seed)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, expected.sources)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("name", "parameters"),
    [("pebbles", {}), ("grass", {"seed_size": 4}), ("pebbles", {"tolerance": 0.0, "seed_size": 1})],
)
def test_efros_leung(name, parameters, seed):
    sample, size = crop(name, 24, 26), (13, 15)
    expected = reference.efros_leung(sample, size, window=7, seed=seed, **parameters)
    check(weftex.EfrosLeung(window_width=7, **parameters), sample, size, expected, seed)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("levels", "tree_size"), [(1, 0), (3, 0), (1, 5), (2, 9)])
def test_wei_levoy(levels, tree_size, seed):
    sample, size = crop("pebbles", 36, 32), (15, 14)
    expected = reference.wei_levoy(sample, size, 5, levels, 3, tree_size, seed)
    several = {"start": "noise", "parent_width": 3} if levels > 1 else {}
    search = {"tree_size": tree_size, "leaves": 1} if tree_size else {"search": "full"}
    method = weftex.WeiLevoy(window_width=5, levels=levels, most_windows=0, **several, **search)
    check(method, sample, size, expected, seed)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("structured", [False, True])
@pytest.mark.parametrize("tolerance", [0.0, 0.05])
def test_exact_matching(tolerance, structured, seed):
    """Of a sample that tiles, which the reference is given with its continuation around it."""
    sample, size = crop("pebbles", 30, 26), (14, 16)
    around = np.pad(sample, ((3, 3), (3, 3), (0, 0)), "wrap")
    expected = reference.exact_matching(around, size, 7, tolerance, structured, seed)
    method = weftex.ExactMatching(
        window_width=7,
        tolerance=tolerance,
        init="structured" if structured else "random",
        candidates=0,
        repeat_distance=0,
        levels=1,
    )
    model = method.fit(weftex.Exemplar(sample, tileable=True))
    result = model.sample(Canvas(*size), seed=seed)
    assert np.array_equal(result.image, expected.image)
    assert np.array_equal(result.source, (expected.sources - 3) % sample.shape[:2])


def test_gray_pictures_stay_gray():
    made = reference.efros_leung(crop("pebbles", 12, 12)[:, :, 0], 6, 3)
    assert made.image.shape == (6, 6) and made.sources.shape == (6, 6, 2)


def test_errors_name_the_parameter():
    sample = crop("pebbles", 12, 12)
    with pytest.raises(InvalidInputError, match="window is 4; it must be odd and from 1 to 12"):
        reference.efros_leung(sample, 10, window=4)
    for method in (reference.wei_levoy, reference.exact_matching):
        with pytest.raises(InvalidInputError, match="window is 1; it must be odd and from 3 to 12"):
            method(sample, 10, window=1)
    with pytest.raises(InvalidInputError, match="size is 0; both sides must be 1 or more"):
        reference.ashikhmin(sample, 0)
    with pytest.raises(InvalidInputError, match="sample is float64"):
        reference.ashikhmin(sample / 255, 10)
