"""Random cases for the tests in `brute_force`; WEFTEX_RANDOM_SEED chooses which."""

import os

import numpy as np
import pytest

import weftex
from twins.windows import window_centers

SEED = int(os.environ.get("WEFTEX_RANDOM_SEED", "1"))


#: Earlier patches of a grid that a patch should not repeat, as rows and columns away.
AROUND = [(0, -2), (0, -1), *((-1, k) for k in range(-2, 2)), *((-2, k) for k in range(-2, 3))]


def random_cases(count):
    """Run a test with `count` generators `rng`; the name of a failed test has the seed."""
    return pytest.mark.parametrize(
        "rng",
        [np.random.default_rng([SEED, k]) for k in range(count)],
        ids=[f"WEFTEX_RANDOM_SEED={SEED} case {k}" for k in range(count)],
    )


def random_crop(rng, height, width):
    """Part of a sample that comes with weftex, in color; sometimes of four levels, for ties."""
    name = rng.choice(["bricks", "grass", "leaves", "pebbles", "weave", "wood"])
    pixels = np.atleast_3d(weftex.load_exemplar(f"sample:{name}").pixels)
    y, x = rng.integers(0, 192 - height + 1), rng.integers(0, 192 - width + 1)
    crop = pixels[y : y + height, x : x + width] * np.ones(3, np.uint8)
    return crop // 64 * 64 if rng.integers(3) == 0 else crop


def random_exemplar(rng, height, width):
    """A crop, which may tile and may have a few unusable pixels in its first rows."""
    mask = np.ones((height, width), bool)
    mask[: rng.integers(3), rng.integers(width) :] = False
    pixels = random_crop(rng, height, width)
    return weftex.Exemplar(pixels, tileable=bool(rng.integers(2)), mask=mask)


def random_canvas(rng, height, width):
    """A canvas that may wrap on each axis, and may have a hole in a crop of some sample."""
    wraps = tuple(bool(k) for k in rng.integers(0, 2, 2))
    if min(height, width) < 3 or rng.integers(2):
        return weftex.Canvas(height, width, wraps)
    y, x = np.indices((height, width))
    v, u = rng.integers(0, height), rng.integers(0, width)
    mask = (y - v) ** 2 + (x - u) ** 2 < rng.integers(1, min(height, width) // 2 + 2) ** 2
    mask |= rng.random(mask.shape) < 0.02
    mask[v, u], mask[v - height // 2, u] = True, False
    return weftex.Canvas(height, width, wraps, known=random_crop(rng, height, width), hole=mask)


def centers_of(exemplar, half):
    """Pixels of a sample whose whole window is usable, in scan order: (n, 2)."""
    return np.reshape(window_centers(exemplar.mask, half, exemplar.tileable), (-1, 2))


def distances(exemplar, places, picture, pixel, steps, weights=1):
    """Sums of squared differences of the windows of the sample and the one of the picture."""
    y, x = ((pixel + steps) % picture.shape[:2]).T
    v, u = np.moveaxis((np.asarray(places)[:, None] + steps) % exemplar.shape, 2, 0)
    apart = exemplar.pixels[v, u].astype(int) - picture[y, x]
    return ((apart**2).sum(axis=2) * weights).sum(axis=1)
