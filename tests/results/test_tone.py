"""Tones of fillings: shifted where they differ, left alone where they do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from materials import ellipse
from weftex.results.tone import match_tone

DTYPES = (np.uint8, np.uint16, np.float32, np.float64)


def texture(seed, shape=(120, 140), channels=3):
    rng = np.random.default_rng(seed)
    return rng.integers(100, 130, (*shape, channels)).astype(np.uint8)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_a_step_is_taken_off_and_the_rest_stays(dtype, wrap):
    photo = texture(1).astype(dtype)
    hole = ellipse((120, 140), (60, 70), (30, 40))
    if wrap[0]:
        hole = np.roll(hole, (60, 70), (0, 1))
    x = np.broadcast_to(np.arange(140), hole.shape)
    lit = photo.copy()
    lit[hole] += (20 + 10 * np.cos(2 * np.pi * x[hole] / 140)[:, None]).astype(dtype)
    found = match_tone(lit, hole, wrap)
    assert found.dtype == dtype and np.array_equal(found[~hole], lit[~hole])
    error = found[hole].astype(float) - photo[hole]
    assert abs(error).mean() < 5  # of 20


@pytest.mark.parametrize("seed", range(5))
def test_what_differs_by_chance_stays_nearly(seed):
    photo, other = texture(2 * seed), texture(2 * seed + 1)
    hole = ellipse((120, 140), (60, 70), (30, 40))
    photo[hole] = other[hole]
    assert abs(match_tone(photo, hole).astype(int) - photo)[hole].mean() < 0.5


def test_labels_and_clear_pixels_stay():
    labels = (texture(0) // 32).astype(np.uint8)[..., :1]
    hole = ellipse((120, 140), (60, 70), (30, 40))
    labels[hole] += 1
    assert match_tone(labels, hole) is labels
    photo = texture(1, channels=4)
    photo[..., 3] = np.where(hole, 7, 0)
    assert match_tone(photo, hole, alpha=True) is photo


@given(
    st.sampled_from(DTYPES),
    st.tuples(st.integers(1, 24), st.integers(1, 24)),
    st.tuples(st.booleans(), st.booleans()),
    st.integers(1, 2),
    st.integers(0, 2**16),
)
def test_anything_works(dtype, shape, wrap, scale, seed):
    rng = np.random.default_rng(seed)
    top = np.finfo(dtype).max if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    photo = (rng.random((*shape, 2)) * top).astype(dtype)
    hole = rng.random(shape) < rng.random()
    found = match_tone(photo, hole, wrap, scale=scale)
    assert np.array_equal(found[~hole], photo[~hole]) and np.isfinite(found).all()


def test_fill_matches_tones_unless_a_method_is_named(tmp_path):
    photo = weftex.read_image("sample:pebbles").pixels
    hole = ellipse(photo.shape[:2], (90, 100), (30, 30))
    photo = np.rint(photo * np.linspace(0.5, 1, photo.shape[1])[:, None]).astype(np.uint8)
    found = [weftex.fill(photo, hole, seed=3, **way) for way in ({}, {"match_tone": False})]
    own, plain = (one.image for one in found)
    assert not np.array_equal(own, plain)
    assert np.array_equal(own[~hole], photo[~hole])
    assert np.array_equal(found[0].source, found[1].source)
    ways = [{"match_tone": given} for given in (True, False)] + [{}]
    named = [weftex.fill(photo, hole, seed=3, method="patch-sampling", **way).image for way in ways]
    assert np.array_equal(named[1], named[2]) and not np.array_equal(named[0], named[1])
    # What is saved, or rendered in parts, or larger, is the same.
    found[0].save(tmp_path / "a.npz")
    again = weftex.Synthesis.load(tmp_path / "a.npz")
    assert np.array_equal(again.render(photo), own)
    assert np.array_equal(again.render(photo, window=(50, 60, 40, 50)), own[50:90, 60:110])
    large = again.render(photo.repeat(2, 0).repeat(2, 1))
    assert abs(large[::2, ::2].astype(int) - own).max() <= 1
    for value in ("yes", 1, 0.0):
        with pytest.raises(weftex.InvalidInputError, match="match_tone is"):
            weftex.fill(photo, hole, match_tone=value)
