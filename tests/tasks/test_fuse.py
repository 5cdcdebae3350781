"""Texture fusion: several materials in one picture."""

import functools

import numpy as np
import pytest
from PIL import Image

import weftex
from families import refused
from weftex.cli import main
from weftex.io.pictures import read_image
from weftex.prepare.combining import combined
from weftex.roles import ROLES

SIZE = (70, 80)


def sample(level, shape=(40, 44), seed=0, dtype=np.uint8):
    """Noise around a level, so that it is seen from which sample a pixel is."""
    noise = np.random.default_rng(seed).integers(0, 20, (*shape, 3))
    return (noise + level).astype(dtype)


A, B, C = sample(10), sample(100, (44, 40), 1), sample(200, (50, 50), 2)
HALVES = (np.arange(80) >= 40) * np.ones((70, 1), int)
THREE = np.where(np.arange(70)[:, None] >= 35, 2, HALVES)
FAST = {"iterations": 2, "window_width": 9}


@functools.cache
def halves(boundary="cut"):
    """What most tests compare with."""
    return weftex.fuse([A, B], HALVES, seed=1, boundary=boundary, **FAST)


def which(result, count):
    """The sample that each pixel is from, by its place in the stack."""
    tops = np.cumsum([e.shape[0] for e in (A, B, C)[:count]])
    return np.searchsorted(tops, result.source[..., 0], side="right")


@pytest.mark.parametrize("tileable", [False, True, "x", "y"])
def test_regions_are_of_their_samples(tileable):
    result = weftex.fuse([A, B, C], THREE, seed=1, tileable=tileable, **FAST)
    assert result.image.shape == (*SIZE, 3)
    stacked = result.exemplar.pixels
    assert np.array_equal(result.image, stacked[tuple(np.moveaxis(result.source, -1, 0))])
    assert result.exemplar.mask[tuple(np.moveaxis(result.source, -1, 0))].all()
    made = which(result, 3)
    # Beyond the belts nothing is from another sample.
    for k, part in enumerate((np.s_[8:27, 8:32], np.s_[8:27, 48:72], np.s_[43:62, 8:72])):
        assert (made[part] == k).all()
    assert len(np.unique(made)) == 3


@pytest.mark.parametrize("boundary", ["cut", "merged"])
def test_the_boundary_is_merged_and_not_straight(boundary):
    rough = [np.random.default_rng(s).integers(0, 256, A.shape, np.uint8) for s in (0, 1)]
    result = weftex.fuse(
        rough, HALVES, seed=1, boundary=boundary, iterations=4, window_width=21, belt_width=20
    )
    first = (which(result, 2) == 0).sum(axis=1)
    reach = 10 + 5 * (boundary == "merged")  # the paper's belt lies along the cut
    assert first.min() > 40 - reach and first.max() < 40 + reach
    assert len(np.unique(first)) > 4


def test_thin_regions_stay():
    labels = HALVES * 0
    labels[:, 40:43] = 1
    labels[30, :20] = 1
    made = which(weftex.fuse([A, B], labels, seed=1, window_width=21), 2)
    assert (made[:, 41] == 1).all() and (made[30, :20] == 1).all()
    assert 0.02 < made.mean() < 0.25


def test_gray_beside_color():
    result = weftex.fuse([A, B[..., 0]], HALVES, seed=1, **FAST)
    assert result.image.shape == (*SIZE, 3)
    made = which(result, 2)
    assert (np.ptp(result.image[made == 1], axis=1) == 0).all()
    swapped = weftex.fuse([B[..., 0], A], 1 - HALVES, seed=1, **FAST)
    assert swapped.image.shape == (*SIZE, 3)


def test_the_same_seed_the_same_bytes():
    again, other = (
        weftex.fuse([A, B], HALVES, seed=s, threads=t, **FAST).image for s, t in ((1, 2), (2, 1))
    )
    assert np.array_equal(halves().image, again) and not np.array_equal(again, other)


@pytest.mark.parametrize("method", ["ashikhmin", "exact-matching", "efros-leung"])
def test_with_other_pixel_methods(method):
    result = weftex.fuse([A, B], HALVES[:30, 20:60], method=method, seed=1, window_width=5)
    made = which(result, 2)
    assert (made[:, :16] == 0).all() and (made[:, -16:] == 1).all()


def test_mixed_regions_are_of_both():
    labels = HALVES.copy()
    labels[:, 30:50] = 7
    result = weftex.fuse([A, B], labels, mixed={7: (1, 0)}, seed=3, belt_width=4, **FAST)
    made = which(result, 2)
    assert (made[:, :28] == 0).all() and (made[:, 52:] == 1).all()
    assert 0.1 < made[:, 30:50].mean() < 0.9


def test_everything_may_be_mixed():
    labels = np.full((30, 30), 2)
    labels[0, 0], labels[-1, -1] = 0, 1
    result = weftex.fuse([A, B], labels, mixed={2: (0, 1)}, seed=1, window_width=3)
    assert len(np.unique(which(result, 2))) == 2


def test_the_gradient_goes_over():
    gradient = weftex.label_maps.Gradient(width=0.8)
    result = weftex.fuse([A, B], gradient, (260, 60), seed=1, **FAST)
    made = which(result, 2)
    assert made[:10].mean() < 0.35 and made[-40:].mean() > 0.9


def test_painted_maps_files_and_arrays_are_the_same(tmp_path):
    painted = np.array([(255, 0, 0), (0, 0, 255)], np.uint8)[HALVES]
    Image.fromarray(painted).save(tmp_path / "map.png")
    expected = halves().image
    for label_map in (painted, tmp_path / "map.png", Image.fromarray(painted)):
        assert np.array_equal(weftex.fuse([A, B], label_map, seed=1, **FAST).image, expected)
    swapped = weftex.fuse([B, A], painted, colors=[(0, 0, 255), (255, 0, 0)], seed=1, **FAST)
    assert (swapped.image[:, :30] < 60).all()


def test_maps_and_saved_results(tmp_path):
    exemplars = [
        weftex.Exemplar(p, maps={"level": p[..., 0].astype(np.uint16), str(k): p[..., 1].copy()})
        for k, p in enumerate((A, B))
    ]
    result = weftex.fuse(exemplars, HALVES, seed=1, **FAST)
    assert list(result.maps) == ["level"]
    assert np.array_equal(result.maps["level"], result.image[..., 0])
    result.save(tmp_path / "f.npz")
    stacked = combined([weftex.Exemplar(A), weftex.Exemplar(B)])
    again = weftex.Synthesis.load(tmp_path / "f.npz", stacked)
    assert np.array_equal(again.image, result.image)


def test_what_does_not_fit_is_refused():
    refused("1 sample to fuse", weftex.fuse, [A], HALVES)
    other = r"sample 2 \(array 2\) is uint16 with 3 channels, sample 1 \(array 1\) is uint8 with 3"
    refused(other, weftex.fuse, [A, B.astype(np.uint16)], HALVES)
    two = weftex.Exemplar(B[..., :2], alpha=False)
    refused("is uint8 with 2 channels", weftex.fuse, [A, two], HALVES)
    refused("with 3 channels and alpha", weftex.fuse, [A, np.dstack([B, B[..., 0]])], HALVES)
    for single in (A, "sample:pebbles", None):
        refused("give a list of two or more samples", weftex.fuse, single, HALVES)
    refused("boundary is 'soft'.*merged", weftex.fuse, [A, B], HALVES, boundary="soft")
    for wide in (0, 1, -4, 3.5, True):
        refused(f"belt_width is {wide}", weftex.fuse, [A, B], HALVES, belt_width=wide)
    refused("belt_width is 81; it must be at most 80", weftex.fuse, [A, B], HALVES, belt_width=81)
    refused("the label map is 80x70, the size 50x60", weftex.fuse, [A, B], HALVES, (60, 50))
    refused("needs the size", weftex.fuse, [A, B], "gradient")
    refused("a gradient has no colors", weftex.fuse, [A, B], "gradient", 50, colors=[0, 1])
    refused("mixed is 3", weftex.fuse, [A, B], HALVES, mixed=3)
    refused("two numbers of samples", weftex.fuse, [A, B], HALVES, mixed={2: 1})
    refused("two numbers of samples", weftex.fuse, [A, B], HALVES, mixed={2: (0, 2)})
    refused("colors of the samples beside", weftex.fuse, [A, B], HALVES + 5, mixed={2: (0, 1)})
    for method in ("quilting", "patch-sampling", "near-regular"):
        how = {"method": method, "error": weftex.UnsupportedError}
        refused("several samples in one picture; .*refinement", weftex.fuse, [A, B], HALVES, **how)
    refused("nowhere.png", weftex.fuse, [A, B], "nowhere.png", error=weftex.FileError)


def test_progress_can_cancel():
    how = {"progress": lambda *_: False, "error": weftex.CancelledError, **FAST}
    refused("cancel", weftex.fuse, [A, B], HALVES, **how)


def test_the_command(tmp_path, capsys):
    for name, picture in (("a", A), ("b", B)):
        Image.fromarray(picture).save(tmp_path / f"{name}.png")
        for what in ("height", "red"):
            Image.fromarray(picture[..., 0].copy()).save(tmp_path / f"{name}_{what}.png")
    painted = np.array([(255, 0, 0), (0, 0, 255)], np.uint8)[HALVES]
    Image.fromarray(painted).save(tmp_path / "map.png")
    path = {p.name: str(p) for p in tmp_path.iterdir()}
    out, source = str(tmp_path / "out.png"), str(tmp_path / "out.npz")
    common = ["--iterations", "2", "--window-width", "9", "--seed", "1"]
    words = ["--map", path["map.png"], "--save-source", source]
    assert main(["fuse", path["a.png"], path["b.png"], "-o", out, *common, *words]) == 0
    expected = halves()
    assert np.array_equal(read_image(out).pixels, expected.image)
    assert "fused 2 samples in" in capsys.readouterr().err
    for what in ("red", "height"):
        maps = [path[f"a_{what}.png"], path[f"b_{what}.png"]]
        assert main(["replay", source, *maps, "-o", str(tmp_path / f"{what}.png")]) == 0
    assert np.array_equal(read_image(tmp_path / "red.png").pixels, expected.image[..., 0])
    stacked = combined([weftex.Exemplar(p[..., 0].copy(), role=ROLES["height"]) for p in (A, B)])
    joined = expected.render(stacked)  # heights join without cliffs
    assert np.array_equal(read_image(tmp_path / "height.png").pixels, joined)


def test_each_material_is_made_by_what_suits_it():
    """Bricks on their lattice, as by `synth`; tones are joined within a material alone."""
    bricks = weftex.read_image("sample:bricks").pixels
    flat = np.full((40, 40, 3), 128, np.uint8)
    result = weftex.fuse([bricks, flat], HALVES, seed=1, tileable=True)
    assert "lattice of 126.2 x 41.8 px" in result.provenance["reason"]
    (note,) = result.provenance["warnings"]
    assert "array 1: the lattice has to be stretched" in note and "--fit" not in note
    row, column = np.moveaxis(result.source, -1, 0)
    changed = (result.image != result.exemplar.pixels[row, column]).any(axis=2)
    assert changed[row < 256].any() and not changed[row >= 256].any()
