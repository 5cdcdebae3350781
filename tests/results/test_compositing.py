"""Laying patches over each other, against pixel-by-pixel twins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from families import DTYPES, noise
from twins import compositing as reference
from weftex.raster.mixing import Kind
from weftex.results import paste_kernels
from weftex.results.paste_kernels import Layout


def layout(rng, canvas, sample, rows, columns, count, cut):
    """Random patches, some of which hang over the border, with random weights and cuts."""
    weights = rng.choice([0, 1, 100, 128, 255, 256], (3, rows, columns), p=[0.1, *[0.15] * 4, 0.3])
    placements = np.stack(
        [
            rng.integers(0, canvas[0], count),
            rng.integers(0, canvas[1], count),
            rng.integers(0, sample[0], count),
            rng.integers(0, sample[1], count),
            rng.integers(0, 3, count),
        ],
        axis=1,
    )
    cuts = np.zeros((0, 0), np.uint16)
    if cut:
        parts = [
            rng.integers(0, columns // 2 + 1, (count, rows)),
            rng.integers(columns // 2, columns + 1, (count, rows)),
            rng.integers(0, rows // 2 + 1, (count, columns)),
            rng.integers(rows // 2, rows + 1, (count, columns)),
        ]
        cuts = np.concatenate(parts, axis=1).astype(np.uint16)
    return placements.astype(np.int32), weights.astype(np.uint16), cuts


def check(out, source, top, left, canvas, layout, scale, alpha):
    expected = out.copy()
    reference.paste_all(expected, source, top, left, canvas, *layout, scale, alpha)
    paste_kernels.paste_all(out, source, Layout(*layout, *canvas, top, left, scale, alpha))
    if out.dtype == np.float32 and alpha:
        # The kernel sums in float32 what the twin sums in float64.
        assert np.allclose(out, expected, rtol=1e-5, atol=1e-6)
    else:
        assert np.array_equal(out, expected)


@given(
    st.sampled_from(DTYPES),
    st.integers(1, 5),
    st.booleans(),
    st.booleans(),
    st.integers(1, 3),
    st.integers(0, 2**30),
)
def test_pasting_is_the_slow_twin(dtype, channels, cut, alpha, scale, seed):
    rng = np.random.default_rng(seed)
    canvas, sample = (9, 11), (6, 7)
    alpha = alpha and channels > 1
    source = noise((sample[0] * scale, sample[1] * scale, channels), dtype, rng=rng)
    out = noise((canvas[0] * scale, canvas[1] * scale, channels), dtype, rng=rng)
    check(out, source, 0, 0, canvas, layout(rng, canvas, sample, 5, 4, 6, cut), scale, alpha)


@given(st.sampled_from(DTYPES), st.integers(3, 5), st.booleans(), st.integers(0, 2**30))
def test_vectors_and_labels_are_the_slow_twin(dtype, channels, signed, seed):
    rng = np.random.default_rng(seed)
    middle = 0.0 if signed else 0.5
    source = noise((6, 7, channels), dtype, rng=rng)
    if np.dtype(dtype).kind == "f":
        source -= 0.5 - middle
    plan = layout(rng, (9, 11), (6, 7), 5, 4, 6, False)
    for kind, blend in (
        (Kind.VECTORS, lambda *of: reference.blend_vectors(*of, middle)),
        (Kind.LABELS, reference.take_label),
    ):
        out = np.ascontiguousarray(np.resize(source[::-1], (9, 11, channels)))
        expected = out.copy()
        reference.paste_all(expected, source, 0, 0, (9, 11), *plan, blend=blend)
        paste_kernels.paste_all(out, source, Layout(*plan, 9, 11, 0, 0, 1, kind, middle))
        if np.dtype(dtype).kind == "f" or kind is Kind.VECTORS:
            # Sums in another order may round a half to the other side.
            step = 2 if np.dtype(dtype).kind == "u" else 1e-5
            assert np.allclose(out.astype(float), expected.astype(float), rtol=0, atol=step)
        else:
            assert np.array_equal(out, expected)


def test_opposite_vectors_are_not_mixed_to_nothing():
    up, down = np.array([0, 0, 1], np.float64), np.array([0, 0, -1], np.float64)
    one, none = np.array([[0, 0, 0, 0, 0]], np.int32), np.zeros((0, 0), np.uint16)
    for weight, expected in ((128, down), (127, up)):
        out = up.reshape(1, 1, 3).copy()
        layout = Layout(one, np.full((1, 1, 1), weight, np.uint16), none, 1, 1, mixing=Kind.VECTORS)
        paste_kernels.paste_all(out, down.reshape(1, 1, 3), layout)
        if weight == 128:
            assert np.array_equal(out[0, 0], expected)
        else:  # a shade nearer to the old one
            assert np.allclose(out[0, 0] / np.linalg.norm(out), expected)


@given(st.booleans(), st.integers(1, 14), st.integers(0, 2**30))
def test_layers_are_the_slow_twin(cut, count, seed):
    rng = np.random.default_rng(seed)
    canvas, window = (8, 9), (1, 2, 6, 5)
    plan = layout(rng, canvas, (6, 7), 5, 4, count, cut)
    patch = np.full((6, 5, 4), -1, np.int32)
    share = np.zeros((6, 5, 4), np.float32)
    paste_kernels.layer_all(patch, share, Layout(*plan, *canvas, 1, 2))
    for at, entries in reference.layers(window, canvas, *plan).items():
        got = [(int(p), float(s)) for p, s in zip(patch[at], share[at], strict=True) if s > 0]
        assert got == [(p, float(s)) for p, s in entries]


@pytest.mark.parametrize("dtype", DTYPES)
def test_clear_pixels_bleed_no_color(dtype):
    """Straight alpha: a clear pixel changes the alpha of what it is mixed with, not its color."""
    full = 1 if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    red = np.array([full, 0, 0, full], dtype)
    clear_green = np.array([0, full, 0, 0], dtype)
    one = np.array([[0, 0, 0, 0, 0]], np.int32)
    half = np.full((1, 1, 1), 128, np.uint16)
    for old, new in ((red, clear_green), (clear_green, red)):
        out = old.reshape(1, 1, 4).copy()
        layout = Layout(one, half, np.zeros((0, 0), np.uint16), 1, 1, mixing=Kind.ALPHA)
        paste_kernels.paste_all(out, new.reshape(1, 1, 4), layout)
        assert out[0, 0, :3].tolist() == red[:3].tolist()
        assert abs(float(out[0, 0, 3]) - full / 2) <= 0.5


@pytest.mark.parametrize("alpha", [False, True])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_numbers_that_floats_just_hold_stay_numbers(dtype, alpha):
    rng = np.random.default_rng(3)
    largest = np.finfo(dtype).max
    source, out = (rng.choice([-1, 0, 0.25, 1], (9, 9, 4)).astype(dtype) * largest for _ in "ab")
    plan = layout(rng, (9, 9), (9, 9), 5, 5, 20, cut=False)
    paste_kernels.paste_all(out, source, Layout(*plan, 9, 9, mixing=alpha))
    assert np.isfinite(out).all()
