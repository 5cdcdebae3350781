"""Whether a sample has a way up."""

import numpy as np
import pytest

import weftex
from weftex.analysis.properties import sidedness


def discs(rng, lit):
    """Balls on a dark ground, lit from above or from in front."""
    y, x = np.mgrid[:160, :160]
    picture = np.full((160, 160), 40.0)
    for cy, cx in rng.uniform(0, 160, (90, 2)):
        v, u = (y - cy) / 9, (x - cx) / 9
        inside = v * v + u * u < 1
        bright = 120 + 110 * (-v if lit else np.sqrt(np.maximum(1 - v * v - u * u, 0)))
        picture = np.where(inside, bright, picture)
    return weftex.Exemplar(np.clip(picture, 0, 255).astype(np.uint8))


@pytest.mark.parametrize("seed", range(3))
def test_light_from_above_is_seen(seed):
    rng = np.random.default_rng(seed)
    assert sidedness(discs(rng, lit=False)) <= 0.06
    assert sidedness(discs(rng, lit=True)) > 0.15


def test_it_is_the_same_upside_down_and_in_a_mirror():
    pixels = weftex.read_image("sample:pebbles").pixels
    found = sidedness(weftex.Exemplar(pixels))
    for other in (pixels[::-1, ::-1], pixels[:, ::-1], pixels[::-1]):
        assert sidedness(weftex.Exemplar(np.ascontiguousarray(other))) == pytest.approx(
            found, abs=0.03
        )


def test_nothing_is_said_of_a_constant_or_a_thin_sample():
    assert sidedness(weftex.Exemplar(np.full((40, 40), 7, np.uint8))) == 0
    assert sidedness(weftex.Exemplar(np.arange(40, dtype=np.uint8)[None])) >= 0


def test_what_is_masked_does_not_count(rng):
    pixels = rng.integers(100, 140, (120, 120)).astype(np.uint8)
    pixels[:40] = (np.arange(40) % 12 * 20)[:, None]
    mask = np.ones((120, 120), bool)
    mask[:40] = False
    assert sidedness(weftex.Exemplar(pixels)) > 0.2
    assert sidedness(weftex.Exemplar(pixels, mask=mask)) <= 0.06
