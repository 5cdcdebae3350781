"""Parts of the measures beside slow twins of them."""

import numpy as np
import pytest

from twins.measures import prediction_error
from weftex.quality import seams
from weftex.quality.score import Windows, nearest


def test_windows_are_compared_by_definition(rng):
    values, places = rng.integers(0, 256, (40, 75)), rng.integers(0, 20, (40, 2)).astype(np.int32)
    values[7] = values[9] = values[30]
    windows = Windows(values.astype(np.float32), places)
    apart = ((values[:, None] - values) ** 2).mean(axis=2)
    found, which = nearest(windows.of(places[:, 0] > 8), windows)
    np.testing.assert_array_equal(which, apart[places[:, 0] > 8].argmin(axis=1))
    assert not found.any()
    apart[abs(places[:, None] - places).max(axis=2) < 5] = np.inf
    found, which = nearest(windows, windows, 5)
    np.testing.assert_array_equal(which, apart.argmin(axis=1))
    np.testing.assert_allclose(found, apart.min(axis=1), rtol=1e-6)


@pytest.mark.parametrize("shape", [(21, 32), (30, 23), (40, 41)])
def test_the_surprise_by_definition(shape, rng):
    gray = rng.integers(0, 256, shape).astype(np.float32) / np.float32(np.sqrt(3))
    weights = rng.normal(size=30)
    knots = np.sort(rng.random(7)) * 2000 + 4000
    usual = np.sort(rng.random(7)) * 9000 + 100
    steps = gray[:, 1:] - gray[:, :-1]
    found = seams._surprise(steps, (weights, knots, usual))
    error = prediction_error(steps, weights, knots, usual)
    means = [error[y : y + 17].mean(axis=0) for y in range(len(error) - 16)]
    assert found.shape == (shape[0] - 20, shape[1] - 7)
    np.testing.assert_allclose(found, means, rtol=1e-5)


def test_steps_are_fitted_by_definition(rng):
    gray = np.cumsum(rng.normal(size=(40, 44)), axis=1).astype(np.float32)
    usable = np.ones(gray.shape, bool)
    usable[10:13, 9:14] = False
    weights, knots, usual = seams._fit(gray, usable)
    steps = (gray[:, 1:] - gray[:, :-1]).astype(float)
    beside, own = [], []
    for y in range(2, 38):
        for x in range(3, 40):
            if usable[y - 2 : y + 3, x - 3 : x + 5].all():
                around = np.delete(steps[y - 2 : y + 3, x - 3 : x + 4], 3, axis=1)
                beside.append(around.ravel())
                own.append(steps[y, x])
    beside, own = np.array(beside), np.array(own)
    gram = beside.T @ beside
    ridge = 1e-4 * np.trace(gram) / 30 + len(own) / 12
    expected = np.linalg.solve(gram + ridge * np.eye(30), beside.T @ own)
    np.testing.assert_allclose(weights, expected, rtol=1e-9)
    activity, left = (beside**2).mean(axis=1), (own - beside @ weights) ** 2
    parts = np.array_split(np.argsort(activity, kind="stable"), 24)
    np.testing.assert_allclose(knots, [activity[part].mean() for part in parts])
    assert (np.diff(usual) >= 0).all()
    np.testing.assert_allclose(usual[0], left[parts[0]].mean() + 1 / 6)
