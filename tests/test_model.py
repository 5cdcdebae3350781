"""What every model declares: outputs, and windows of an endless plane."""

import dataclasses

import numpy as np
import pytest

import weftex
from families import METHODS, method_of, noise


@pytest.mark.parametrize("slug", METHODS)
def test_a_model_makes_windows_or_refuses_in_one_line(slug):
    model = method_of(slug).fit(weftex.Exemplar(noise((30, 31, 3))))
    if "random_access" in weftex.METHODS[slug].supports:
        whole = model.sample((40, 45), seed=3).image
        part = model.window(7, 9, 20, 25, seed=3)
        assert np.array_equal(part.image, whole[7:27, 9:34])
        assert part.canvas.origin == (7, 9)
        return
    with pytest.raises(weftex.UnsupportedError) as refused:
        model.window(0, 0, 20, 25, seed=3)
    text = str(refused.value)
    assert text.startswith(f"{slug} does not do windows of an endless plane; these do: ")
    assert "near-regular" in text and "\n" not in text


#: Parameters that are None in a settled method, as they have no effect there: one of two that
#: exclude each other, or one that hangs on the canvas.
WITHOUT_EFFECT = {
    "ashikhmin": {"jumps"},
    "exact-matching": {"tolerance", "nearest_colors"},
    "patch-sampling": {"randomness"},  # patch_size says it
    "graphcut": {"halvings"},  # each patch has its own
    "quilting": {"randomness"},
    "refinement": {"joints", "seed_scale"},
    "near-regular": {"blend_width"},
}


@pytest.mark.parametrize("slug", METHODS)
def test_a_result_says_all_that_was_settled(slug):
    model = method_of(slug).fit(weftex.Exemplar(noise((30, 31, 3))))
    said = model.sample((24, 25), seed=3).provenance
    assert [name for name, value in said.items() if value is None] == []
    settled = dataclasses.asdict(model.method)
    open_still = {name for name, value in settled.items() if value is None}
    assert open_still <= WITHOUT_EFFECT.get(slug, set())
    assert {name: said[name] for name in settled if settled[name] is not None} == {
        name: value for name, value in settled.items() if value is not None
    }


def test_an_origin_is_saved_with_the_result(tmp_path):
    model = weftex.NearRegular(block_size=10).fit(weftex.Exemplar(noise((40, 40))))
    result = model.window(2**33, -5, 30, 31, seed=1)
    result.save(tmp_path / "window.npz")
    again = weftex.Synthesis.load(tmp_path / "window.npz", result.exemplar)
    assert again.canvas.origin == (2**33, -5)
    assert np.array_equal(again.image, result.image)


@pytest.mark.parametrize(
    "origin, match",
    [
        ((0.5, 0), "top is 0.5"),
        ((0, 2**40 + 1), "left is"),
        ((1,), r"must be \(top, left\)"),
        (7, r"must be \(top, left\)"),
    ],
)
def test_origins_are_checked(origin, match):
    with pytest.raises(weftex.InvalidInputError, match=match):
        weftex.Canvas(4, 4, origin=origin)


def test_a_window_of_a_plane_neither_wraps_nor_has_holes():
    with pytest.raises(weftex.InvalidInputError, match="neither wraps nor has known pixels"):
        weftex.Canvas(4, 4, (True, False), origin=(3, 3))
    hole = np.ones((4, 4), bool)
    with pytest.raises(weftex.InvalidInputError, match="neither wraps nor has known pixels"):
        weftex.Canvas(4, 4, known=noise((4, 4)), hole=hole, origin=(3, 3))
