"""A sample beside its mirror image and its quarter turns."""

import json

import numpy as np
import pytest

import weftex
from families import TRIALS, refused
from materials import normal_map
from weftex.exemplar.turns import copies_in
from weftex.raster.turning import TURNS


def copies(shape, turn):
    """For each pixel of the picture of copies the flat index of the sample's; -1 between them."""
    index = np.arange(shape[0] * shape[1], dtype=np.float64).reshape(shape)
    found = weftex.prepare.turned(weftex.Exemplar(index), turn)
    return np.where(found.mask, found.pixels, -1).astype(int)


@pytest.mark.parametrize("name", ["normal", "normal_dx"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_vectors_are_turned_with_their_pixels(name, dtype):
    """The normals of a turned height map are the turned normals of the height map."""
    heights = np.random.default_rng(2).random((16, 16))

    def normals(heights):
        down, right = np.gradient(heights)
        vectors = np.dstack([-right, -down if name == "normal_dx" else down, np.ones(right.shape)])
        return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)

    if np.dtype(dtype).kind == "u":
        top = np.iinfo(dtype).max
        store = lambda v: np.rint((v + 1) * top / 2).astype(dtype)  # noqa: E731
        read = lambda s: s / (top / 2) - 1  # noqa: E731
    else:
        store, read = lambda v: ((v + 1) / 2).astype(dtype), lambda s: 2 * s - 1
    exemplar = weftex.Exemplar(heights, maps={name: store(normals(heights))})
    found = weftex.prepare.turned(exemplar, "8")
    expected = normals(np.where(found.mask, found.pixels, np.nan))
    inside = np.isfinite(expected).all(axis=2)
    inside[1:-1, 1:-1] &= found.mask[2:, 1:-1] & found.mask[:-2, 1:-1]
    inside[1:-1, 1:-1] &= found.mask[1:-1, 2:] & found.mask[1:-1, :-2]
    assert inside.mean() > 0.6
    assert np.allclose(read(found.maps[name])[inside], expected[inside], atol=0.02)


@pytest.mark.parametrize("slug", [s for s in TRIALS if s not in ("best-tile", "near-regular")])
def test_every_method_takes_from_copies_and_replays_maps_of_the_sample(slug, rng, tmp_path):
    pixels = rng.integers(0, 256, (24, 30, 3)).astype(np.uint8)
    maps = {"height": rng.random((24, 30)), "normal": normal_map(rng, (48, 60))}
    exemplar = weftex.Exemplar(pixels, maps=maps)
    method = weftex.METHODS[slug](**TRIALS[slug].small)
    result = method.fit(weftex.prepare.turned(exemplar, "4")).sample(weftex.Canvas(40, 44), seed=1)
    y, x = np.moveaxis(result.pictured_source(), -1, 0)
    own = copies((24, 30), "4")[y, x]  # of the sample, whichever copy is shown
    assert (own >= 0).all()
    assert np.array_equal(result.source, np.stack(np.divmod(own, 30), axis=-1))
    for name, map_ in maps.items():
        assert np.array_equal(result.render(map_, role=name), result.maps[name])
    assert result.maps["normal"].shape == (80, 88, 3)
    result.save(tmp_path / "r.npz")
    again = weftex.Synthesis.load(tmp_path / "r.npz", exemplar)
    assert np.array_equal(again.image, result.image)
    assert np.array_equal(again.render(pixels), result.image)
    without = weftex.Synthesis.load(tmp_path / "r.npz")
    assert np.array_equal(without.source, result.source)
    assert np.array_equal(without.layers((3, 4, 20, 30))[0], result.layers((3, 4, 20, 30))[0])


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (4, 1), (6, 9), (9, 6)])
def test_sources_are_of_the_sample_itself(turn, shape, rng):
    """Which is the first copy, so a picture of copies has the same pixels there."""
    sample = rng.integers(0, 256, shape).astype(np.uint8)
    way = {"orientations": "half-turns"} if turn == "half" else {}
    method = weftex.GraphCut(placement="entire", tone_reach=0.0, **way)
    given = sample if way else weftex.prepare.turned(sample, turn)
    result = weftex.synthesize(given, (20, 23), method=method, seed=1)
    assert result.turn == turn
    assert (result.source < shape).all()
    for pixels in (sample, result.sample.pixels):
        assert np.array_equal(result.image, pixels[result.source[..., 0], result.source[..., 1]])


def test_a_map_of_fewer_pixels_is_rendered_in_fewer(rng):
    sample, small = rng.random((20, 24)), rng.random((10, 12))
    result = weftex.synthesize(weftex.prepare.turned(sample, "flip"), 40, method="quilting", seed=1)
    large = result.render(small.repeat(2, axis=0).repeat(2, axis=1))
    means = large.reshape(20, 2, 20, 2).mean(axis=(1, 3))
    assert np.allclose(result.render(small), means)
    refused("map is 13x10; it must be the sample's", result.render, rng.random((10, 13)))


def test_auto_turns_nothing_whose_maps_would_change_their_size(rng):
    leaves = weftex.read_image("sample:leaves").pixels
    half = rng.random((leaves.shape[0] // 2, leaves.shape[1] // 2))
    assert weftex.synthesize(leaves, 300, seed=3).turn == "8"
    upright = weftex.synthesize(weftex.Exemplar(leaves, maps={"ao": half}), 300, seed=3)
    assert upright.turn is None and upright.maps["ao"].shape == (150, 150)


@pytest.mark.parametrize("name, turn", [("normal", "half"), ("normal_gl", "8"), ("normal_dx", "8")])
def test_auto_turns_normals_by_90_degrees_if_their_name_says_which_way_y_is(name, turn):
    """Turned by the other rule they would point the wrong way; upside down both are the same."""
    leaves = weftex.read_image("sample:leaves").pixels
    flat = np.broadcast_to(np.uint8([128, 128, 255]), leaves.shape)
    sample = weftex.Exemplar(leaves, maps={name: flat.copy()}, weights={name: 0})
    assert weftex.synthesize(sample, 300, seed=3).turn == turn


@pytest.mark.parametrize("shape", [(6, 5), (5, 6)])
def test_a_mask_of_few_pixels_does_not_hide_which_side_is_which(shape, rng):
    mask = np.zeros(shape, bool)
    mask[2, 0] = True
    sample = weftex.Exemplar(rng.integers(1, 256, shape).astype(np.uint8), mask=mask)
    for turn in TURNS:
        found = weftex.prepare.turned(sample, turn)
        assert found.copy_shape == shape
        for top, left, height, width in copies_in(found):
            assert found.mask[top : top + height, left : left + width].sum() == 1
        result = weftex.synthesize(found, 12, method="graphcut", placement="entire", seed=1)
        assert (result.source == (2, 0)).all()


def test_the_size_of_copies_goes_with_their_picture():
    fits = weftex.prepare.turned(np.zeros((8, 8), np.uint8), "flip")
    assert fits.changed(pixels=np.zeros((4, 4), np.uint8), mask=None).turn is None


def test_damaged_copies(rng, tmp_path):
    sample = weftex.prepare.turned(rng.random((8, 9)), "half")
    result = weftex.synthesize(sample, 12, method="quilting", seed=1)
    result.save(tmp_path / "whole.npz")
    with np.load(tmp_path / "whole.npz") as file:
        arrays = dict(file)
    facts = json.loads(str(arrays["about"]))
    assert facts["turn"] == "half" and facts["copy_shape"] == [8, 9]
    for damage in ({"copy_shape": [9, 8]}, {"copy_shape": None}, {"turn": "4"}, {"turn": "2"}):
        np.savez(tmp_path / "r.npz", **arrays | {"about": np.array(json.dumps(facts | damage))})
        with pytest.raises(weftex.FileError, match="is damaged: its copies do not fit its sample"):
            weftex.Synthesis.load(tmp_path / "r.npz")


def test_mask_guide_and_labels_come_along(rng):
    mask = np.ones((8, 8), bool)
    mask[0, 0] = False
    exemplar = weftex.Exemplar(rng.random((8, 8)), mask=mask, guide=mask.astype(np.uint8))
    found = weftex.prepare.turned(exemplar, "flip")
    assert found.mask[0].tolist() == [False, *[True] * 7, False, *[True] * 7, False]
    assert np.array_equal(found.guide[:, 9:], exemplar.guide[:, ::-1])


def test_copies_of_copies_and_lattices_are_refused(rng):
    found = weftex.prepare.turned(rng.integers(0, 256, (32, 32)).astype(np.uint8), "flip")
    refused("already consists of rotated copies", weftex.prepare.turned, found, "4")
    for turn in ("2", None, 4, ["flip"]):
        with pytest.raises(weftex.InvalidInputError, match="turn is .* must be one of flip, half"):
            weftex.prepare.turned(np.zeros((8, 8), np.uint8), turn)
    for method in (weftex.NearRegular(lattice=(8, 0, 0, 8)), weftex.BestTile(lattice=(8, 0, 0, 8))):
        refused("needs one lattice", method.fit, found, error=weftex.UnsupportedError)


def test_auto_finds_no_lattice_across_copies():
    tiles = np.kron(np.random.default_rng(1).integers(0, 256, (3, 3)), np.ones((8, 8)))
    sample = weftex.prepare.turned(np.tile(tiles, (4, 4)).astype(np.uint8), "4")
    assert weftex.synthesize(sample, (64, 64), seed=1).provenance["method"] != "near-regular"
