"""A sample beside its mirror image and its quarter turns."""

import numpy as np
import pytest

import weftex
from families import TRIALS
from materials import normal_map
from weftex.turns import TURNS


def copies(shape, turn):
    """For each pixel of the picture of copies the flat index of the sample's; -1 between them."""
    index = np.arange(shape[0] * shape[1], dtype=np.float64).reshape(shape)
    found = weftex.turned(weftex.Exemplar(index), turn)
    return np.where(found.mask, found.pixels, -1).astype(int)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("shape", [(9, 9), (7, 12), (12, 5)])
def test_every_copy_is_there_once(turn, shape):
    found = copies(shape, turn)
    count = sum(len(row) for row in TURNS[turn])
    assert (np.bincount(found[found >= 0]) == count).all()
    # Neighbors in the picture of copies are neighbors in the sample: none lies across two copies.
    for axis in (0, 1):
        ends = [np.delete(found, at, axis) for at in (-1, 0)]
        both = (ends[0] >= 0) & (ends[1] >= 0)
        (y, x), (v, u) = (np.divmod(end[both], shape[1]) for end in ends)
        assert (abs(y - v) + abs(x - u) == 1).all()


def test_the_first_copy_is_the_sample(rng):
    pixels = rng.integers(0, 256, (9, 14, 3)).astype(np.uint8)
    for turn in TURNS:
        assert np.array_equal(weftex.turned(pixels, turn).pixels[:9, :14], pixels)


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
        store, read = (
            lambda v: np.rint((v + 1) * top / 2).astype(dtype),
            lambda s: s / (top / 2) - 1,
        )
    else:
        store, read = lambda v: ((v + 1) / 2).astype(dtype), lambda s: 2 * s - 1
    exemplar = weftex.Exemplar(heights, maps={name: store(normals(heights))})
    found = weftex.turned(exemplar, "8")
    expected = normals(np.where(found.mask, found.pixels, np.nan))
    inside = np.isfinite(expected).all(axis=2)
    inside[1:-1, 1:-1] &= found.mask[2:, 1:-1] & found.mask[:-2, 1:-1]
    inside[1:-1, 1:-1] &= found.mask[1:-1, 2:] & found.mask[1:-1, :-2]
    assert inside.mean() > 0.6
    assert np.allclose(read(found.maps[name])[inside], expected[inside], atol=0.02)


@pytest.mark.parametrize("slug", [slug for slug in TRIALS if slug != "best-tile"])
def test_every_method_takes_from_copies_and_replays_maps_of_the_sample(slug, rng, tmp_path):
    pixels = rng.integers(0, 256, (24, 30, 3)).astype(np.uint8)
    maps = {"height": rng.random((24, 30)), "normal": normal_map(rng, (48, 60))}
    exemplar = weftex.Exemplar(pixels, maps=maps)
    small = {} if slug == "near-regular" else TRIALS[slug].small  # which has a lattice
    method = weftex.METHODS[slug](**small)
    result = method.fit(weftex.turned(exemplar, "4")).sample(weftex.Canvas(40, 44), seed=1)
    y, x = result.source[..., 0], result.source[..., 1]
    index = copies((24, 30), "4")
    assert (index[y, x] >= 0).all()
    for name, map_ in maps.items():
        assert np.array_equal(result.render(map_, role=name), result.maps[name])
    assert result.maps["normal"].shape == (80, 88, 3)
    result.save(tmp_path / "r.npz")
    again = weftex.Synthesis.load(tmp_path / "r.npz", exemplar)
    assert np.array_equal(again.image, result.image)
    assert np.array_equal(again.render(pixels), result.image)


def test_maps_of_fewer_pixels_come_at_the_sample_s_own(rng):
    maps = {"ao": rng.random((10, 12))}
    found = weftex.turned(weftex.Exemplar(rng.random((20, 24)), maps=maps), "flip")
    assert found.maps["ao"].shape == found.shape == (20, 49)


def test_mask_guide_and_labels_come_along(rng):
    mask = np.ones((8, 8), bool)
    mask[0, 0] = False
    exemplar = weftex.Exemplar(rng.random((8, 8)), mask=mask, guide=mask.astype(np.uint8))
    found = weftex.turned(exemplar, "flip")
    assert found.mask[0].tolist() == [False, *[True] * 7, False, *[True] * 7, False]
    assert np.array_equal(found.guide[:, 9:], exemplar.guide[:, ::-1])


@pytest.mark.parametrize("turn", ["2", None, 4, ["flip"]])
def test_there_is_no_such_turn(turn):
    with pytest.raises(weftex.InvalidInputError, match="turn is .* must be one of flip, half"):
        weftex.turned(np.zeros((8, 8), np.uint8), turn)


def test_copies_of_copies_and_lattices_are_refused(rng):
    found = weftex.turned(rng.integers(0, 256, (32, 32)).astype(np.uint8), "flip")
    with pytest.raises(weftex.InvalidInputError, match="is of turned copies already"):
        weftex.turned(found, "4")
    for method in (weftex.NearRegular(lattice=(8, 0, 0, 8)), weftex.BestTile(lattice=(8, 0, 0, 8))):
        with pytest.raises(weftex.UnsupportedError, match="goes by one lattice"):
            method.fit(found)


def test_auto_finds_no_lattice_across_copies():
    tiles = np.kron(np.random.default_rng(1).integers(0, 256, (3, 3)), np.ones((8, 8)))
    sample = weftex.turned(np.tile(tiles, (4, 4)).astype(np.uint8), "4")
    assert weftex.synthesize(sample, (64, 64), seed=1).provenance["method"] != "near-regular"
