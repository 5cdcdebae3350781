"""Pixel methods without options beyond the paper make the bytes of the references."""

import numpy as np
import pytest

import weftex
from families import refused
from weftex import reference
from weftex.canvas import Canvas
from weftex.errors import InvalidInputError

SEEDS = [0, 5]


def crop(name, height, width):
    return weftex.load_exemplar(f"sample:{name}").pixels[:height, :width]


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


def test_errors_name_the_parameter():
    sample = crop("pebbles", 12, 12)
    with pytest.raises(InvalidInputError, match="window is 4; it must be odd and from 1 to 12"):
        reference.efros_leung(sample, 10, window=4)
    for method in (reference.wei_levoy, reference.exact_matching):
        refused("window is 1; it must be odd and from 3 to 12", method, sample, 10, window=1)
    refused("size is 0; both sides must be 1 or more", reference.ashikhmin, sample, 0)
    with pytest.raises(InvalidInputError, match="seed_size is 0; it must be from 1 to 12"):
        reference.efros_leung(sample, 10, 5, seed_size=0)
    refused("threshold 0; from 0 on and above 0", reference.efros_leung, sample, 10, 5, threshold=0)
    with pytest.raises(InvalidInputError, match=r"seed is -1; it must be from 0 to 2\*\*64 - 1"):
        reference.iterative_refinement(sample, 10, 2, seed=-1)
    refused("sample is float64", reference.ashikhmin, sample / 255, 10)
