"""What iterative refinement starts from where that is left open."""

import pickle

import numpy as np
import pytest

import weftex
from families import noise
from weftex.analysis.lattice import find_lattice
from weftex.canvas import Canvas


@pytest.fixture(scope="module")
def tiles():
    """Squares of 24 px with joints, each with grain of its own."""
    y, x = np.indices((128, 128))
    joints = (y % 24 < 3) | (x % 24 < 3)
    pixels = np.where(joints, 40, 180)[..., None] + noise((128, 128, 1)) // 6
    return weftex.Exemplar(pixels.astype(np.uint8))


@pytest.fixture(scope="module")
def model(tiles):
    return weftex.Refinement().fit(tiles)


def test_a_sure_lattice_lays_the_start(tiles, model):
    """Blocks keep the distances of what repeats; the text makes the same start again."""
    vectors = find_lattice(tiles).vectors
    assert sorted(round(max(map(abs, vector))) for vector in vectors) == [24, 24]
    start = "near-regular lattice=" + ",".join(str(part) for vector in vectors for part in vector)
    made = pickle.loads(pickle.dumps(model)).sample(96, seed=1)
    assert model.method.init == made.provenance["init"] == start
    again = weftex.Refinement(init=start).fit(tiles).sample(96, seed=1)
    assert np.array_equal(again.image, made.image)


def test_regular_things_keep_their_distances(model):
    image = model.sample(144, seed=3).image[..., 0].astype(int)
    assert np.abs(image[:, 24:] - image[:, :-24]).mean() < 25  # shifts of the grain are 14 apart
    assert np.abs(image[24:] - image[:-24]).mean() < 25


@pytest.mark.parametrize(
    ("shape", "wrap", "init"),
    [
        ((96, 96), (True, True), "near-regular"),
        ((96, 60), (True, True), "quilting"),  # two and a half tiles
        ((96, 60), (True, False), "near-regular"),
    ],
)
def test_a_canvas_that_would_strain_the_lattice_is_quilted(model, shape, wrap, init):
    made = model.sample(Canvas(*shape, wrap), seed=1)
    assert made.provenance["init"].split(" ")[0] == init


def test_a_start_that_was_asked_for_is_not_replaced(tiles):
    model = weftex.Refinement(init="near-regular").fit(tiles)
    with pytest.raises(weftex.InvalidInputError, match="init: the lattice would have to be strain"):
        model.sample(Canvas(96, 60, (True, True)), seed=1)


def test_guides_and_the_papers_search_take_seeds_all_the_same(tiles, model):
    made = model.sample(Canvas(40, 40, guide=noise((40, 40, 1))), seed=1)
    assert made.provenance["init"] == "seeds"
    assert weftex.Refinement(search="nearest").settle(tiles).init == "seeds"


def test_a_hole_that_the_first_start_refuses_is_filled_from_the_next(tiles, monkeypatch):
    model = weftex.Refinement(window_width=7, iterations=1).fit(tiles)
    first, second = model.prepared.starts.values()

    def refuse(*_, **__):
        raise weftex.InvalidInputError("no whole piece")

    monkeypatch.setattr(first, "sample", refuse)
    hole = np.zeros((60, 60), bool)
    hole[20:40, 20:40] = True
    canvas = Canvas(60, 60, known=tiles.pixels[:60, :60].copy(), hole=hole)
    assert model.sample(canvas, seed=1).provenance["init"] == "quilting"
    monkeypatch.setattr(second, "sample", refuse)
    assert model.sample(canvas, seed=1).provenance["init"] == "seeds"
    model = weftex.Refinement(init="quilting").fit(tiles)
    monkeypatch.setattr(model.prepared.starts["quilting"], "sample", refuse)
    with pytest.raises(weftex.InvalidInputError, match="init: no whole piece"):
        model.sample(canvas, seed=1)


@pytest.mark.parametrize("name", ["pebbles", "grass", "stone_wall", "wood"])
def test_what_has_no_sure_lattice_is_quilted(name):
    assert weftex.Refinement().settle(weftex.load_exemplar(f"sample:{name}")).init == "quilting"


@pytest.mark.parametrize("name", ["bricks", "tiles", "weave"])
def test_materials_with_a_lattice_start_from_it(name):
    settled = weftex.Refinement().settle(weftex.load_exemplar(f"sample:{name}"))
    assert settled.init.startswith("near-regular lattice=")


def test_joints_along_blocks_of_a_lattice_are_refined(tiles):
    made = weftex.Refinement(joints=8).fit(tiles).sample(96, seed=1)
    start = weftex.NearRegular(lattice=made.provenance["init"].split("=")[1]).fit(tiles)
    same = (made.source == start.sample(96, seed=1).source).all(axis=2)
    assert 0.2 < same.mean() < 1


@pytest.mark.parametrize("thick", [1, 2, 3, 5, 6])
@pytest.mark.parametrize("search", ["coherent", "nearest"])
def test_thin_frames_are_filled_from(thick, search):
    """Windows are narrowed until one lies on the frame; a width that was given is kept."""
    pixels, hole = noise((40, 40, 3)), np.zeros((40, 40), bool)
    hole[thick:-thick, thick:-thick] = True
    made = weftex.fill(pixels, hole, method="refinement", search=search, iterations=1, seed=1)
    assert made.provenance["window_width"] == 2 * ((thick - 1) // 2) + 1
    assert np.array_equal(made.image[~hole], pixels[~hole])
    with pytest.raises(weftex.InvalidInputError, match="no whole window of 7x7"):
        weftex.fill(pixels, hole, method="refinement", search=search, window_width=7)


def test_cells_of_a_grid_are_filled_from():
    y, x = np.indices((40, 40))
    for side in (1, 2, 5):
        hole = (y % (side + 1) == 0) | (x % (side + 1) == 0)
        made = weftex.fill(noise((40, 40)), hole, method="refinement", iterations=1, seed=1)
        assert made.provenance["window_width"] == 2 * ((side - 1) // 2) + 1


def test_belts_of_joints_are_as_wide_as_they_say():
    """A seam lies between two pixels, so a belt along it has an even width."""
    with pytest.raises(weftex.InvalidInputError, match="joints is 5; it must be even"):
        weftex.Refinement(joints=5)
