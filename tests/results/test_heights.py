"""Heights that join without cliffs."""

import numpy as np
import pytest

import weftex
from laid import SAMPLE, filled, make
from twins import heights as reference


def hills(shape, seed=3):
    """Rounded heights on a slope, in 0 to 1."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: shape[0], : shape[1]]
    waves = [np.sin((a * y + b * x) / 9 + c) for a, b, c in rng.normal(0, 1, (6, 3))]
    return (sum(waves) / 12 + 0.5) * 0.5 + 0.4 * x / shape[1]


@pytest.mark.parametrize("wrap", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("blend", ["feather", "cut"])
@pytest.mark.parametrize("scale", [1, 2])
def test_joined_heights_are_the_slow_twin(wrap, blend, scale):
    method = weftex.PatchSampling(patch_size=9, boundary_width=3, blend=blend)
    result = method.fit(weftex.Exemplar(SAMPLE)).sample(weftex.Canvas(18, 16, wrap), seed=3)
    heights = hills((30 * scale, 34 * scale))
    laid, joined = result.render(heights), result.render(heights, role="height")
    expected = reference.joined(laid, heights, *result.layers(), wrap, scale)
    assert np.allclose(joined, expected, atol=1e-3 * np.ptp(heights))
    assert abs(joined - laid).max() > 0.02


def test_bands_and_blocks_do_not_show(monkeypatch):
    from weftex.results import heights as module

    result, values = make("cut", (True, True)), hills((30, 34))
    whole = result.render(values, role="height")
    monkeypatch.setattr(module, "_BAND", 200)
    monkeypatch.setattr(module, "_BLOCK", 16)
    assert np.allclose(result.render(values, role="height"), whole, atol=1e-3)


@pytest.mark.parametrize("method", ["quilting", "graphcut", "wei-levoy"])
def test_steps_across_seams_are_like_those_of_the_sample(method):
    heights = hills((64, 64))
    color = np.rint(255 * hills((64, 64), 9)[..., None] ** [1, 1.2, 1.5]).astype(np.uint8)
    result = weftex.synthesize(color, (96, 96), method=method, seed=1)
    source = result.source.astype(int)
    seam = (np.diff(source, axis=1) != (0, 1)).any(axis=2)
    own = abs(np.diff(heights, axis=1)).mean()
    laid, joined = (
        abs(np.diff(result.render(heights, role=role), axis=1)) for role in (None, "height")
    )
    assert laid[seam].mean() > 2 * own
    assert joined[seam].mean() < 1.2 * own
    assert joined[~seam].mean() < 1.2 * own


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_whole_numbers_are_cut_to_their_type(dtype):
    top = np.iinfo(dtype).max
    values = np.where(hills((30, 34)) > 0.5, top, 0).astype(dtype)
    joined = make("cut").render(values, role="height")
    assert joined.dtype == dtype
    near = make("cut").render(values.astype(np.float64), role="height")
    assert np.allclose(joined, np.clip(near, 0, top), atol=1)


def test_known_pixels_stay():
    result = filled()
    values = np.rint(hills((30, 34)) * 255).astype(np.uint8)
    joined, laid = result.render(values, role="bump"), result.render(values)
    known = ~result.canvas.hole
    assert np.array_equal(joined[known], laid[known]) and not np.array_equal(joined, laid)


def test_a_window_of_a_result_is_that_part_of_it():
    result, values = make("cut"), hills((30, 34))
    window = (5, 7, 20, 18)
    whole = result.render(values, role="height")
    assert np.array_equal(result.render(values, role="height", window=window), whole[5:25, 7:25])


def test_windows_of_a_plane_agree_also_after_they_were_saved(tmp_path):
    heights = np.rint(255 * hills((48, 48))).astype(np.uint8)
    model = weftex.NearRegular(lattice=(16, 0, 0, 16)).fit(
        weftex.Exemplar(heights, maps={"height": heights})
    )
    one, other = (model.window(0, left, 64, 64, seed=1) for left in (0, 30))
    assert np.array_equal(one.maps["height"][:, 30:], other.maps["height"][:, :34])
    one.save(tmp_path / "one.npz")
    again = weftex.Synthesis.load(tmp_path / "one.npz")
    assert np.array_equal(again.render(heights, role="height"), one.maps["height"])


def test_numbers_without_squares_are_laid_as_they_are():
    values = np.where(hills((30, 34)) > 0.5, 1e300, -1e300)
    result = make("cut")
    assert np.array_equal(result.render(values, role="height"), result.render(values))
