"""What iterative refinement starts from where that is left open."""

import pickle
import re

import numpy as np
import pytest

import weftex
from families import noise, refused
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
    with pytest.raises(weftex.InvalidInputError, match="init: the lattice would have to be"):
        model.sample(Canvas(96, 60, (True, True)), seed=1)


def test_the_papers_search_takes_seeds(tiles):
    assert weftex.Refinement(search="nearest").resolved(tiles).init == "seeds"


def test_a_hole_that_the_first_start_refuses_is_filled_from_the_next(tiles, monkeypatch):
    model = weftex.Refinement(window_width=7, iterations=1).fit(tiles)
    first, second = (type(start) for start in model.prepared.starts.values())

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
    refused("init: no whole piece", model.sample, canvas, seed=1)


START = dict.fromkeys(("bricks", "tiles", "weave"), "near-regular lattice=")
START |= dict.fromkeys(("pebbles", "grass", "stone_wall", "wood"), "quilting")


@pytest.mark.parametrize("name", START)
def test_what_has_no_sure_lattice_is_quilted(name):
    settled = weftex.Refinement().resolved(weftex.load_exemplar(f"sample:{name}"))
    assert settled.init.startswith(START[name])


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


def test_it_starts_from_methods_that_are_added_later(monkeypatch):
    refused("init is 'mine'; known: ashik.*wei-levoy", weftex.Refinement, init="mine")
    monkeypatch.setitem(weftex.registry._HOMES, "mine", "weftex.methods.quilting:Quilting")
    weftex.Refinement(init="mine", joints=6)
    refused("init is 'mina'; did you mean 'mine'", weftex.Refinement, init="mina")
    refused("init is 'refinement'", weftex.Refinement, init="refinement")


@pytest.mark.parametrize(
    ("init", "message"),
    [
        ("graphcut placment=entire", "init: graphcut has no parameter 'placment'; did you mean"),
        ("graphcut placement=all", "init: placement is 'all'"),
        ("quilting patch_size=big", "init: patch_size is 'big'; it must be an integer"),
        ("quilting 16", "init: quilting has '16'; it must be name=value"),
        ("quilting patch_size=16 patch_size=8", "once for each name"),
        ("quiltin patch_size=16", "init: unknown method 'quiltin'; did you mean 'quilting'"),
        ("quilting 'x", 'init: "quilting \'x" is not a method'),
        ("seeds matches=3", "init: unknown method 'seeds'"),
        ("refinement iterations=2", "init is 'refinement iterations=2'"),
        (weftex.Refinement(init="quilting"), "init is 'refinement init=quilting'"),
        (" ", "init: ' ' is not a method"),
        ("", "init is ''"),
        (5, "init is 5"),
    ],
)
def test_a_start_that_cannot_be_is_refused_in_one_line(init, message):
    refused(re.escape(message), weftex.Refinement, init=init)


def test_a_start_that_does_not_fit_is_refused_before_work():
    exemplar = weftex.Exemplar(noise((40, 40)))
    refused("init: .*patch of 99", weftex.Refinement(init="quilting patch_size=99").fit, exemplar)


def test_more_matches_than_there_are_tiles_are_all():
    exemplar = weftex.Exemplar(noise((40, 40)))
    sources = [
        weftex.Refinement(init="seeds", seed_scale=8.0, matches=matches, window_width=7)
        .fit(exemplar)
        .sample(24, seed=1)
        .source.tolist()
        for matches in (25, 10**9, 5)
    ]
    assert sources[0] == sources[1] != sources[2]


@pytest.mark.parametrize("init", ["auto", "quilting"])
def test_a_checkerboard_continues_in_a_hole(init):
    """Though coarse windows near the hole are not whole, nothing of its start is moved."""
    y, x = np.indices((192, 192))
    board = np.where((y // 32 + x // 32) % 2, 220, 40).astype(np.uint8)
    hole = (abs(y - 99) < 24) & (abs(x - 99) < 24)
    filled = weftex.fill(board * ~hole, hole, method="refinement", init=init, seed=1)
    assert (filled.image == board).mean() > 0.999
