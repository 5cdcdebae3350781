"""Near-regular synthesis whose gaps are warped."""

import numpy as np
import pytest

import weftex
from materials import ellipse, wall
from twins.near_regular import usable_of
from twins.near_regular_warps import WarpedTwin
from weftex.results.warped import WarpedSynthesis


def model_of(pixels, **parameters):
    return weftex.NearRegular(**parameters).fit(weftex.Exemplar(pixels))


WARPED = {"lattice": (16, 0, 8, 12), "block_size": 21, "border_width": 8, "warp": 1}


def bent(height, width):
    """Bricks whose rows rise and fall by a pixel, so that shifts do not make them meet."""
    pixels = wall(height + 4, width, spread=30)
    y, x = np.indices((height, width))
    rise = np.rint(1.5 * np.sin(x * 2 * np.pi / 37) + 1.5).astype(int)
    return pixels[y + rise, x]


def test_warped_gaps_are_like_the_twin():
    corner = -35, 1000
    pixels = bent(44, 48)
    model = model_of(pixels, **WARPED | {"candidates": 1, "tolerance": 0, "rectify": 0})
    twin = WarpedTwin(pixels, usable_of(model), model.method, 7)
    result = model.window(*corner, 12, 22, seed=7)
    assert isinstance(result, WarpedSynthesis) and np.ptp(result.warps) > 16
    assert np.array_equal(result.image, twin.image(*corner, 12, 22))


def test_warps_bring_joints_together():
    """What differs where a gap meets its neighbors gets less."""
    pixels = bent(96, 96)

    def error(warp):
        model = model_of(pixels, **WARPED | {"warp": warp, "rectify": 0, "blend": "none"})
        whole = model.sample(210, seed=1).image.astype(int)
        edges = np.arange(21, 210, 21)
        return np.abs(whole[:, edges] - whole[:, edges - 1]).sum()  # across rows of joints

    assert error(2) < 0.95 * error(0)


@pytest.mark.parametrize("blend", ["cut", "feather"])
def test_warped_results_are_the_same_in_parts_and_on_maps(blend, tmp_path):
    pixels = bent(90, 96)
    exemplar = weftex.Exemplar(pixels)
    model = weftex.NearRegular(**WARPED, blend=blend).fit(exemplar)
    for wrap in ((False, False), (True, False), (True, True)):
        canvas = weftex.Canvas(96, 112, wrap)
        whole = model.sample(canvas, seed=3, threads=1)
        assert np.array_equal(whole.image, model.sample(canvas, seed=3, threads=3).image)
        for top, left, height, width in ((0, 0, 1, 1), (13, 27, 40, 50), (60, 5, 36, 107)):
            part = whole.render(window=(top, left, height, width))
            assert np.array_equal(part, whole.image[top : top + height, left : left + width])
    whole = model.sample(120, seed=3)
    far = model.window(20, 31, 9, 50, seed=3)
    assert np.array_equal(far.image, whole.image[20:29, 31:81])
    # The picture is about its nearest pixels, and maps are warped as it is.
    source = whole.source
    near = pixels[source[..., 0], source[..., 1]]
    assert (near != whole.image).any()
    assert np.abs(near.astype(int) - whole.image).mean() < 8
    y, x = np.indices((180, 192)) / 2
    place = whole.render(np.stack([y, x, 0 * x], axis=2).astype(np.float32))[::2, ::2, :2]
    if blend == "cut":
        inside = np.abs(place - source).max(axis=2)
        assert np.median(inside) <= 0.5 and (inside < 4).all()
    flat = whole.render(np.full((90, 96), 7, np.uint16))
    assert (flat == 7).all()
    whole.save(tmp_path / "w.npz")
    again = weftex.Synthesis.load(tmp_path / "w.npz", exemplar)
    assert isinstance(again, WarpedSynthesis)
    assert np.array_equal(again.image, whole.image) and np.array_equal(again.source, source)
    for what in ("sources", "seams", "error"):
        assert np.array_equal(again.draw(what), whole.draw(what))


def test_warped_pixels_are_never_past_the_sample():
    """Nor is what is transparent ever seen."""
    pixels = np.dstack([bent(90, 96), np.full((90, 96), 255, np.uint8)])
    clear = (np.indices((90, 96))[0] % 12) < 2
    pixels[clear] = (0, 255, 0, 0)
    result = (
        weftex.NearRegular(**WARPED | {"warp": 2}).fit(weftex.Exemplar(pixels)).sample(150, seed=1)
    )
    assert isinstance(result, WarpedSynthesis) and result.warps.any()
    seen = result.image[result.image[..., 3] > 0]
    solid = pixels[~clear]
    assert (seen[:, :3] >= solid[:, :3].min(axis=0)).all()
    assert (seen[:, :3] <= solid[:, :3].max(axis=0)).all()
    assert np.ptp(result.image[..., 3]) == 255


def test_holes_are_filled_with_warps():
    pixels = bent(120, 128)
    hole = ellipse((120, 128), (50, 60), (30, 26))
    blank = np.where(hole[..., None], 255, pixels).astype(np.uint8)
    settings = {"method": "near-regular", "lattice": (16, 0, 8, 12), "seed": 3, "block_size": 20}
    result = weftex.fill(blank, hole, warp=2, **settings)
    assert np.array_equal(result.image[~hole], pixels[~hole])
    assert isinstance(result, WarpedSynthesis) and result.warps.any()
    assert not hole[result.source[..., 0], result.source[..., 1]][hole].any()


def test_warps_need_a_border():
    with pytest.raises(weftex.InvalidInputError, match="border_width"):
        model_of(wall(60, 60), lattice=(16, 0, 8, 12), block_size=20, border_width=0, warp=1)


def test_damaged_warps_are_refused(tmp_path):
    result = model_of(bent(60, 64), **WARPED).sample(60, seed=1)
    for key, value in (
        ("warps", np.zeros((len(result.warps), 3, 2, 2), np.int16)),
        ("warps", result.warps[:-1]),
        ("within", np.zeros_like(result.within)),
    ):
        name = tmp_path / "w.npz"
        result.save(name)
        with np.load(name) as file:
            arrays = dict(file) | {key: value}
        np.savez(name, **arrays)
        with pytest.raises(weftex.FileError, match="warps"):
            weftex.Synthesis.load(name)
