"""Fillings joined to the photo: as a dense solver does it, and only inside the hole."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from materials import ellipse
from weftex.results.cloning import join_filling

DTYPES = (np.uint8, np.uint16, np.float32)


def joined(picture, sample, sources, hole, wrap=(False, False), reach=6.0):
    """Return a picture (H, W, C) with its filling, which comes from `sources`, joined to it."""
    found = picture.copy()
    layers = (sources[:, :, None].astype(np.int32), np.ones((*hole.shape, 1), np.float32))
    canvas = weftex.Canvas(*hole.shape, wrap, known=np.zeros(hole.shape, np.uint8), hole=hole)
    join_filling(found, weftex.Exemplar(sample), layers, canvas, None, 1, reach)
    return found


def by_dense_solve(picture, sample, sources, hole, wrap, reach):
    """The same for one channel: one equation for each pixel of the hole."""
    pixels = [tuple(at) for at in np.argwhere(hole)]
    number = {at: k for k, at in enumerate(pixels)}
    matrix, right = np.eye(len(pixels)) / reach**2, np.zeros(len(pixels))
    values = picture[..., 0].astype(float)
    right += values[hole] / reach**2
    for k, (y, x) in enumerate(pixels):
        for way in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            there = y + way[0], x + way[1]
            if not all(w or 0 <= t < n for t, n, w in zip(there, hole.shape, wrap, strict=True)):
                continue
            there = there[0] % hole.shape[0], there[1] % hole.shape[1]
            slopes = []
            for at, back in ((sources[y, x], 1), (sources[there], -1)):
                beyond = at + back * np.array(way)
                if (beyond >= 0).all() and (beyond < sample.shape[:2]).all():
                    here = sample[tuple(at)][0].astype(float)
                    slopes.append(back * (sample[tuple(beyond)][0] - here))
            slope = np.mean(slopes) if slopes else values[there] - values[y, x]
            matrix[k, k] += 1
            right[k] -= slope
            if there in number:
                matrix[k, number[there]] -= 1
            else:
                right[k] += values[there]
    return np.linalg.solve(matrix, right)


@pytest.mark.parametrize("wrap", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("seed", range(3))
def test_it_solves_the_equation(wrap, seed):
    rng = np.random.default_rng(seed)
    sample = rng.random((18, 20, 1)).astype(np.float32)
    hole = rng.random((14, 16)) < 0.5
    sources = np.stack([rng.integers(0, n, hole.shape) for n in sample.shape[:2]], axis=2)
    picture = sample[sources[..., 0], sources[..., 1]]
    picture[0, :2] = [[-9], [9]]  # values are not cut
    hole[0, :2] = False
    found = joined(picture, sample, sources, hole, wrap)
    expected = by_dense_solve(picture, sample, sources, hole, wrap, 6.0)
    np.testing.assert_allclose(found[hole][:, 0], expected, atol=0.02)


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_step_across_the_outline_is_taken_off(dtype):
    rng = np.random.default_rng(1)
    photo = rng.integers(100, 130, (60, 70, 3)).astype(dtype)
    hole = ellipse((60, 70), (30, 35), (8, 10))
    sources = np.stack(np.indices(hole.shape), axis=2)
    sources[hole] += (0, 70)  # another piece, of a sample that shows the photo twice
    lit = photo.copy()
    lit[hole] += dtype(20)
    found = joined(lit, np.hstack([photo, photo]), sources, hole, reach=24.0)
    assert found.dtype == dtype and np.array_equal(found[~hole], lit[~hole])
    assert abs(found[hole].astype(float) - photo[hole]).mean() < 5


@given(
    st.sampled_from(DTYPES),
    st.tuples(st.integers(1, 24), st.integers(1, 24)),
    st.tuples(st.booleans(), st.booleans()),
    st.integers(0, 2**16),
)
def test_any_picture_stays_outside_its_hole(dtype, shape, wrap, seed):
    rng = np.random.default_rng(seed)
    top = np.finfo(dtype).max if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    photo = (rng.random((*shape, 3)) * top).astype(dtype)
    hole = rng.random(shape) < rng.random()
    hole.flat[0] = False
    sources = np.stack([rng.integers(0, n, shape) for n in shape], axis=2)
    found = joined(photo, photo, sources, hole, wrap)
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
    assert abs(large[::2, ::2].astype(int) - own)[hole].mean() < 2  # steps are two pixels there
