"""Heights and tones that join without steps."""

import numpy as np
import pytest

import weftex
from laid import SAMPLE, filled, make
from twins import heights as reference
from weftex.results import joining
from weftex.results.pixels import PixelSynthesis


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


@pytest.mark.parametrize("scale", [1, 3])
def test_lines_between_nodes_are_joined_first_and_then_the_cells(scale, monkeypatch):
    monkeypatch.setattr(joining, "_HEIGHTS", 4.0)  # few pixels, as cells are small here
    monkeypatch.setattr(reference, "REACH", 4.0)
    method = weftex.PatchSampling(patch_size=5, boundary_width=2, blend="cut")
    result = method.fit(weftex.Exemplar(SAMPLE)).sample(weftex.Canvas(18, 26, (True, True)), seed=3)
    heights = hills((30 * scale, 34 * scale))
    ends = (-1, 1, 8, 10, 17, 19), (-2, 2, 11, 15, 24, 28)
    around = [np.arange(some[0], some[-1]) for some in ends]
    y, x = np.moveaxis(result.source, 2, 0)
    index = (y * 34 + x).take(around[0], 0, mode="wrap").take(around[1], 1, mode="wrap")
    cells = np.array([(axis, end) for axis in (0, 1) for end in ends[axis]])
    plane = PixelSynthesis(result.canvas, index.astype(np.int32), cells, exemplar=result.sample)
    all_of_it = weftex.Canvas(*index.shape)
    whole = PixelSynthesis(all_of_it, plane.index, exemplar=result.sample)
    laid = whole.render(heights)
    at_line = [
        (np.searchsorted(some, np.repeat(side, scale), "right") % 2).astype(bool)
        for some, side in zip(ends, around, strict=True)
    ]
    lines, nodes = (f.outer(*at_line) for f in (np.logical_or, np.logical_and))
    told = laid, heights, *whole.layers(), (False, False), scale
    first = reference.joined(*told, np.where(nodes | ~lines, laid, np.nan), lines)
    expected = reference.joined(*told, np.where(lines, first, np.nan))
    expected = expected[scale * -ends[0][0] :, scale * -ends[1][0] :][: 18 * scale, : 26 * scale]
    joined = plane.render(heights, role="height")
    assert np.allclose(joined, expected, atol=1e-3 * np.ptp(heights))
    part = plane.render(heights, role="height", window=(3, 11, 8, 5))
    assert np.array_equal(part, joined[3 * scale : 11 * scale, 11 * scale : 16 * scale])
    moved = abs(joined - plane.render(heights)) > 0.02
    assert moved[:, :scale].any() and moved[4 * scale : 5 * scale].any()


def test_blocks_do_not_show(monkeypatch):
    result, values = make("cut", (True, True)), hills((30, 34))
    whole = result.render(values, role="height")
    monkeypatch.setattr(joining, "_BLOCK", 16)
    blocks = result.render(values, role="height")
    assert np.allclose(blocks, whole, atol=1e-3)
    result.threads = 3
    assert np.array_equal(result.render(values, role="height"), blocks)


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


@pytest.mark.parametrize("wrap", [(False, False), (True, False)])
@pytest.mark.parametrize("role", ["height", "color"])
def test_a_window_of_a_result_is_that_part_of_it(monkeypatch, wrap, role):
    monkeypatch.setattr(joining, "_BLOCK", 16)
    monkeypatch.setattr(joining, "_MARGIN", 1)
    result, values = make("cut", wrap), hills((60, 68))
    result.tone_reach = 4.0
    window = (5, 7, 20, 18)
    whole = result.render(values, role=role)
    assert np.array_equal(result.render(values, role=role, window=window), whole[10:50, 14:50])


def stepped(tone_reach, **more):
    """Bands of many tones, cut from light and dark halves of a sample."""
    light = np.random.default_rng(1).integers(90, 110, (48, 48, 3)).astype(np.uint8)
    light[:, 24:] += 60
    sample = weftex.Exemplar(light, **more)
    method = weftex.GraphCut(patch_size=20, tone_reach=tone_reach)
    return method.fit(sample).sample((48, 64), seed=2)


def test_tones_join_as_heights_do_and_stay_within_those_of_the_sample(tmp_path):
    laid, joined = stepped(0), stepped(8)
    assert np.array_equal(laid.source, joined.source)
    places = laid.source[..., 0], laid.source[..., 1]
    assert np.array_equal(laid.image, laid.sample.pixels[places])
    gray = laid.sample.pixels[..., 0].astype(np.float64)
    joined.tone_reach = 24.0  # that of heights
    values = joined.render(gray)
    expected = laid.render(gray, role="height")
    assert np.allclose(values, np.clip(expected, gray.min(), gray.max()))
    assert abs(values - laid.render(gray)).max() > 3
    joined.save(tmp_path / "joined.npz")
    again = weftex.Synthesis.load(tmp_path / "joined.npz")
    assert np.array_equal(again.render(gray), values)


def test_what_has_no_tones_between_is_not_joined():
    joined = stepped(8)
    labels = (joined.sample.pixels[..., 0] // 8).astype(np.uint8)
    places = joined.source[..., 0], joined.source[..., 1]
    for other, role in ((labels, None), (joined.sample.pixels, "id")):
        assert np.array_equal(joined.render(other, role=role), other[places])
    assert not np.array_equal(joined.image, joined.sample.pixels[places])


def test_windows_of_a_plane_agree_also_after_they_were_saved(tmp_path):
    heights = np.rint(255 * hills((48, 48))).astype(np.uint8)
    sample = weftex.Exemplar(heights, maps={"height": heights})
    model = weftex.NearRegular(lattice=(16, 0, 0, 16)).fit(sample)
    one, other = (model.window(0, left, 64, 64, seed=1) for left in (0, 30))
    assert np.array_equal(one.maps["height"][:, 30:], other.maps["height"][:, :34])
    one.save(tmp_path / "one.npz")
    again = weftex.Synthesis.load(tmp_path / "one.npz")
    assert np.array_equal(again.render(heights, role="height"), one.maps["height"])


def test_numbers_without_squares_are_laid_as_they_are():
    values = np.where(hills((30, 34)) > 0.5, 1e300, -1e300)
    result = make("cut")
    assert np.array_equal(result.render(values, role="height"), result.render(values))


@pytest.mark.parametrize("method", ["auto", "quilting"])
def test_values_that_must_not_be_copied_change_nothing(method):
    mask, made = np.indices((48, 64)).min(axis=0) > 9, []
    for value in (-9999.0, 0.0):
        pixels = np.where(mask, hills((48, 64)), value).astype(np.float32)
        sample = weftex.Exemplar(pixels, mask=mask, maps={"height": pixels})
        made.append(weftex.synthesize(sample, 80, seed=1, method=method))
    assert np.array_equal(made[0].image, made[1].image)
    assert np.array_equal(made[0].maps["height"], made[1].maps["height"])
