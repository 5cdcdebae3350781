"""Components (section 3.3), exact in any order of summation, shortlists, and kd-trees (3.1)."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from processes import ENVIRONMENT, run
from weftex.errors import UnsupportedError
from weftex.search import approximate_nearest_kernels as _kernels
from weftex.search.approximate_nearest import fit_pca, kd_tree


def made_up(seed, size, count):
    """Columns that lie near a few directions, as real windows do."""
    rng = np.random.default_rng(seed)
    hidden = rng.normal(size=(max(1, min(size // 2, 6)), count))
    mixing = rng.normal(size=(size, len(hidden)))
    values = mixing @ hidden * 40 + 128 + rng.normal(size=(size, count)) * 4
    return np.clip(values, 0, 255).astype(np.uint8)


def check_exact(pca, windows):
    """Coordinates are what whole-number arithmetic gives, which has no order of summation."""
    raw = pca.basis.astype(np.int64) @ windows.astype(np.int64) - pca.offset[:, None]
    half = (1 << pca.shift) >> 1
    assert np.array_equal(pca.coordinates, (raw + half) >> pca.shift)


def test_coordinates_are_exact_where_everything_is_bright(rng):
    """The longest sums there are: every byte 0 or 255, all together."""
    windows = np.repeat(rng.choice([0, 255], (1, 400)).astype(np.uint8), 200, axis=0)
    windows[:, 0] = 255
    check_exact(fit_pca(windows, 1.0), windows)


@given(st.integers(0, 10**6), st.integers(2, 40), st.integers(2, 200))
def test_coordinates_are_exact_and_a_query_gets_those_of_its_window(seed, size, count):
    windows = made_up(seed, size, count)
    pca = fit_pca(windows, 0.97)
    check_exact(pca, windows)
    for n in {0, count // 2, count - 1}:
        features = np.empty(len(pca.basis), np.int16)
        means = windows[:, n].astype(np.int32)
        _kernels.project(pca.basis, pca.offset, pca.shift, means, features)
        assert np.array_equal(features, pca.coordinates[:, n])


@given(st.integers(0, 10**6), st.integers(1, 30))
def test_queries_far_outside_do_not_overflow(seed, size):
    windows = made_up(seed, size, 50)
    pca = fit_pca(windows, 0.97)
    for level in (0, 255):
        features = np.empty(len(pca.basis), np.int16)
        means = np.full(size, level, np.int32)
        _kernels.project(pca.basis, pca.offset, pca.shift, means, features)
        raw = pca.basis.astype(np.int64) @ means - pca.offset
        expected = (raw + ((1 << pca.shift) >> 1)) >> pca.shift
        assert np.array_equal(features, expected.clip(-4095, 4095))


@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(2, 120))
def test_enough_components_are_kept(seed, size, count):
    windows = made_up(seed, size, count)
    centered = windows.astype(float) - windows.mean(axis=1, keepdims=True)
    power = np.linalg.svd(centered, compute_uv=False) ** 2
    share = np.cumsum(power) / max(power.sum(), 1e-300)
    for variance in (0.5, 0.97):
        keep = len(fit_pca(windows, variance).basis)
        least = int(np.argmax(share >= variance - 1e-9)) + 1
        most = int(np.argmax(share >= min(variance + 1e-9, share[-1]))) + 1
        assert min(least, 48) <= keep <= max(most, 1)
    rank = np.linalg.matrix_rank(centered)
    assert len(fit_pca(windows, 1.0).basis) >= min(rank, 48)


def test_at_most_48_components_fit_the_kernels_sums(rng):
    windows = rng.integers(0, 256, (120, 2000)).astype(np.uint8)
    pca = fit_pca(windows, 1.0)
    assert len(pca.basis) <= 48
    # Two opposite points, as far as clamping allows, in all components.
    assert len(pca.basis) * (4095 + int(np.abs(pca.coordinates).max())) ** 2 < 2**31


def test_constant_windows_have_one_component():
    pca = fit_pca(np.full((9, 40), 77, np.uint8), 0.97)
    assert pca.coordinates.shape == (1, 40)
    assert len(np.unique(pca.coordinates)) == 1


@given(st.integers(0, 10**6), st.integers(1, 10), st.integers(1, 3000), st.integers(1, 60))
def test_feature_shortlist_is_the_m_smallest(seed, size, count, wanted):
    rng = np.random.default_rng(seed)
    spread = int(rng.choice([2, 2047]))
    features = rng.integers(-spread, spread + 1, (size, count)).astype(np.int16)
    query = rng.integers(-spread, spread + 1, size).astype(np.int16)
    at = rng.permutation(10 * count)[:count].astype(np.int32)
    keys, places = np.empty(wanted, np.int64), np.empty(wanted, np.int32)
    found = _kernels.nearest_by_coordinates(features, at, query, wanted, keys, places)
    expected = ((features.T.astype(int) - query) ** 2).sum(axis=1).tolist()
    assert found == min(wanted, count)
    assert sorted(keys[:found].tolist()) == sorted(expected)[:wanted]
    column = {int(p): n for n, p in enumerate(at)}
    assert [expected[column[p]] for p in places[:found].tolist()] == keys[:found].tolist()
    assert len(set(places[:found].tolist())) == found


SCRIPT = """
import hashlib, weftex
exemplar = weftex.load_exemplar("sample:pebbles")
picture = weftex.PatchSampling(patch_size=24).fit(exemplar).sample((150, 150), seed=3).image
print(hashlib.sha256(picture.tobytes()).hexdigest())
"""


def test_same_bytes_whatever_blas_does():
    """BLAS and LAPACK on one thread or two: another order of summation, the same picture."""
    found = set()
    for threads in "12":
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        done = run(SCRIPT, env=ENVIRONMENT | dict.fromkeys(names, threads))
        found.add(done.stdout)
    assert len(found) == 1


def test_equal_points_make_a_tree():
    """Sliding midpoint splits cannot part them; the tree must still end."""
    tree = kd_tree(np.zeros((500, 7), np.int16))
    assert len(set(tree.query(np.ones(7), 40)[1].tolist())) == 40


def test_without_scipy_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    with pytest.raises(UnsupportedError, match="pip install 'scipy>=1.13'"):
        kd_tree(np.zeros((1, 1), np.int16))
