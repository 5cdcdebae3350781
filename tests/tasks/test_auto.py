"""The method that is chosen for a sample, what is said of it, and where it may be asked for."""

import dataclasses
import pickle
import re

import numpy as np
import pytest

import weftex
from families import canvas_of, kinds_of, noise, refused
from weftex.analysis.canvas_lattice import Around
from weftex.analysis.lattice import Lattice, find_lattice
from weftex.analysis.properties import Evenness
from weftex.canvas import Canvas
from weftex.tasks.auto import Findings, choose, look
from weftex.tasks.auto.findings import count_colors, with_full

EVEN = Evenness(0.0, 0.0, 0.0)
GRASS = Findings((256, 256), None, True, 12.5, 5000, EVEN)
TILES = Lattice(((31.05, 0.0), (-0.25, 102.17)), 0.87)
ROWS = Lattice(((0.0, 46.0),), 0.95)
PLANE = Around(2**40, 2**40, (False, False))


def with_(**changes):
    return dataclasses.replace(GRASS, **changes)


RULE = [
    (GRASS, Canvas(1024, 1024), "graphcut", r"features are small \(12.5 px of 256\)"),
    (with_(scale=9.5), Canvas(512, 512), "graphcut", r"small \(9.5 px of 256\)$"),
    (with_(scale=9.5, sidedness=(0.0, 0.1)), Canvas(512, 512), "graphcut", r"px of 256\)$"),
    (with_(scale=9.5, sidedness=(0.0, 0.0)), Canvas(512, 512), "graphcut", "same from all sides$"),
    (with_(scale=20.0, sidedness=(0.0, 0.1)), Canvas(512, 512), "graphcut", "same upside down$"),
    (with_(scale=9.5), PLANE, "graphcut", r"small \(9.5 px of 256\)"),
    (with_(scale=9.5, colors=2), Canvas(512, 512), "quilting", r"few colors \(2\)"),
    (with_(scale=21.3), Canvas(4100, 4100), "graphcut", "small"),
    (with_(scale=21.4), Canvas(512, 512), "graphcut", "irregular .features of 21.4 px"),
    (with_(lattice=ROWS, rows=True), Canvas(512, 512), "graphcut", "rows of different kinds$"),
    (with_(lattice=ROWS, rows=True), PLANE, "graphcut", "has rows 46 px apart"),
    (with_(lattice=TILES), Around(2**20, 2**20), "near-regular", "lattice of 31.1 x 102.2"),
    (with_(lattice=ROWS), Canvas(4096, 4096), "graphcut", "has rows 46 px apart"),
    (with_(lattice=ROWS), Canvas(4096, 4097), "near-regular", "has rows 46 px apart"),
    (with_(lattice=ROWS, exact=False), Canvas(512, 512), "near-regular", "has rows 46 px apart"),
    (with_(lattice=Lattice(((0.0, 46.0),), 0.5)), Canvas(512, 512), "graphcut", "small"),
    (with_(lattice=TILES), Canvas(512, 512), "graphcut", "lattice of 31.1 x 102.2 px.* 0.87"),
    (with_(lattice=TILES), Canvas(9999, 9999), "near-regular", "lattice of 31.1 x 102.2 px.* 0.87"),
    (with_(lattice=TILES, shape=(100, 120)), Canvas(150, 150), "graphcut", "lattice of 31.1"),
    (with_(lattice=TILES, shape=(90, 105)), Canvas(150, 150), "graphcut", "irregular"),
    (with_(shape=(300, 31)), Canvas(512, 512), "graphcut", "too small to analyze .31x300"),
    (with_(shape=(7, 300)), Canvas(512, 512), "ashikhmin", "too small to analyze .300x7"),
]


@pytest.mark.parametrize(("findings", "canvas", "method", "reason"), RULE)
def test_the_rule(findings, canvas, method, reason):
    choice = choose(findings, canvas)
    assert choice.method == method
    assert choice.reason.startswith(f"{method}, because ") and "\n" not in str(choice)
    assert re.search(reason, choice.reason), choice.reason
    assert choice.warnings == ()


@pytest.mark.parametrize(
    ("lattice", "side", "method", "reason"),
    [
        (TILES, 60, "graphcut", "does not fit a tileable 60x60"),
        (ROWS, 60, "graphcut", "does not fit a tileable 60x60"),
        (ROWS, 160, "graphcut", "rows 46 px apart"),
        (ROWS, 492, "graphcut", "rows 46 px apart"),
        (TILES, 512, "graphcut", "confidence 0.87"),
    ],
)
def test_a_lattice_that_does_not_go_around_names_the_sizes_that_do(lattice, side, method, reason):
    choice = choose(with_(lattice=lattice), Canvas(side, side, (True, True)))
    assert choice.method == method and reason in choice.reason
    (warning,) = choice.warnings
    sizes = re.findall(r"(\d+)x(\d+)", warning.split(";")[1])
    assert len(sizes) in (1, 2)
    for width, height in sizes:
        again = choose(with_(lattice=lattice), Canvas(int(height), int(width), (True, True)))
        assert again.method == "graphcut" and again.warnings == ()


def test_rows_of_the_sample_itself_place_entire_samples():
    """The rows of a smaller copy are not exact enough."""
    rows = {"placement": "entire", "lattice": (70.5, 0.0, 0.0, -1.0)}
    found = with_(lattice=Lattice(((70.0, 0.0),), 0.94), exact=False, shape=(490, 490))
    found = dataclasses.replace(found, full=Lattice(((70.5, 0.0),), 0.94))
    for width in (490, 507, 530):
        choice = choose(found, Canvas(512, width, (True, True)))
        assert choice.parameters == rows, choice.reason
        assert bool(choice.warnings) == (width != 490)
    assert choose(found, Canvas(512, 512)).parameters == rows


ENTIRE, ROW = {"placement": "entire"}, {"lattice": (0, 46, 1, 0)}
PARAMETERS = [
    (with_(scale=60.0, shape=(512, 513)), (4096, 4097), ENTIRE),
    # Fine grain is made of patches, as no thing is there to be kept whole.
    (with_(scale=12.8), (512, 512), {}),
    (with_(scale=12.9), (512, 512), ENTIRE),
    # near-regular finds the vector of the rows itself.
    (with_(lattice=ROWS), (99, 99), ENTIRE | ROW),
    (with_(lattice=ROWS), (9999, 9999), ROW),
]


@pytest.mark.parametrize(("findings", "size", "parameters"), PARAMETERS)
def test_parameters_of_the_rule(findings, size, parameters):
    assert choose(findings, Canvas(*size)).parameters == parameters


def test_checks_that_do_not_fit_keep_straight_sides():
    """Checks of 30 px, of which 18 fill the canvas after they are stretched."""
    y, x = np.mgrid[:240, :240] // 30
    noisy = 60 + 120 * ((y + x) % 2)[..., None] + noise((240, 240, 3)).astype(int) // 16
    made = weftex.synthesize(noisy.astype(np.uint8), 512, tileable=True, seed=1)
    assert made.provenance["method"] == "graphcut"
    bright = made.image[..., 0] > 128
    assert len({line.tobytes() for line in bright}) == 2


def test_effort_is_a_parameter_of_auto():
    models = [weftex.Auto(effort=e).fit("sample:tiles") for e in ("normal", "best")]
    made, same = (model.sample(90, seed=1) for model in models)
    assert made.provenance["method"] == "graphcut" and np.array_equal(made.image, same.image)
    assert [m.choose(4097).method for m in models] == ["near-regular", "graphcut"]
    refused("effort is 'fast'", weftex.Auto, effort="fast")
    refused("effort has no effect on tile", weftex.tile, "sample:tiles", method=models[1].method)


def test_patience_places_entire_samples_in_outputs_of_any_size():
    for one, found in (ROWS, ROW), (TILES, {"lattice": tuple(TILES)}):
        choice = choose(with_(lattice=one), Canvas(8192, 8192), patient=True)
        assert choice.parameters == ENTIRE | found


@pytest.mark.parametrize(
    ("even", "words"),
    [
        (Evenness(0.4, 80.0, 0.1), "light changes by 80 of 255 levels.* --even-light"),
        (Evenness(0.4, 80.0, 0.6), "one object, or too few features .*60 %"),
        (Evenness(0.4, 20.0, 0.3), None),
        (Evenness(0.2, 90.0, 0.3), None),
    ],
)
def test_what_no_method_can_do_is_said_and_made_all_the_same(even, words):
    choice = choose(with_(evenness=even), Canvas(512, 512))
    assert choice.method == "graphcut"
    assert len(choice.warnings) == (words is not None)
    if words:
        assert re.search(words, str(choice))


@pytest.mark.parametrize("name", ["bricks", "tiles", "weave", "grass", "wood", "leaves"])
def test_samples_get_the_method_for_them(name):
    regular = name in ("bricks", "tiles", "weave")
    findings = look(weftex.load_exemplar(f"sample:{name}"))
    small, large = (choose(findings, Canvas(n, n)) for n in (512, 4100))
    assert small.method == "graphcut" and not (small.warnings or large.warnings)
    assert ("lattice" in small.parameters) == regular
    assert large.method == ("near-regular" if regular else "graphcut")


def test_a_lattice_is_found_in_a_larger_sample_too():
    tiles = weftex.load_exemplar("sample:tiles").pixels
    sample = weftex.Exemplar(tiles.repeat(4, 0).repeat(4, 1))
    large = look(sample)
    assert not large.exact and large.lattice.same_as(Lattice(((124.2, 0.0), (-1, 408.7)), 1.0))
    own = tuple(find_lattice(sample).reduced())
    assert weftex.Auto().fit(sample).choose(600).parameters == ENTIRE | {"lattice": own}
    # One that only the smaller copy shows is none.
    assert with_full(large, weftex.Exemplar(noise((500, 500)))).lattice is None
    # A fine one is lost where pixels are averaged, and found in a part.
    y, x = np.indices((1100, 1000))
    fine = (127 + 90 * ((x // 2 + y // 3) % 2)).astype(np.uint8)
    found = look(weftex.Exemplar(fine))
    assert found.lattice is not None and found.lattice.area < 40
    assert choose(found, Canvas(500, 500)).parameters == {}  # it is found again, exactly


def test_light_and_one_object_are_noticed():
    leaves = weftex.load_exemplar("sample:leaves").pixels
    falling = leaves * np.linspace(1, 0.3, 256)[:, None, None]
    (warning,) = choose(look(weftex.Exemplar(falling.astype(np.uint8))), Canvas(99, 99)).warnings
    assert "light" in warning
    y, x = np.indices(leaves.shape[:2])
    object_ = np.where((np.hypot(y - 120, x - 130) < 70)[..., None], leaves, 240).astype(np.uint8)
    (warning,) = choose(look(weftex.Exemplar(object_)), Canvas(99, 99)).warnings
    assert "one object" in warning


def test_the_result_is_that_of_the_method_by_name():
    for name, size in (("grass", 120), ("tiles", 90), ("leaves", 60)):
        exemplar = weftex.load_exemplar(f"sample:{name}")
        made = weftex.synthesize(exemplar, size, seed=3, tileable="x")
        about = dict(made.provenance)
        assert about.pop("reason").startswith(f"{about['method']}, because ")
        seed = about.pop("seed")
        known = {f.name for f in dataclasses.fields(weftex.METHODS[about["method"]])}
        parameters = {k: v for k, v in about.items() if k in known}
        again = weftex.synthesize(
            exemplar, size, method=about["method"], seed=seed, tileable="x", **parameters
        )
        assert np.array_equal(made.image, again.image)
        assert np.array_equal(made.source, again.source)
    options = {"method": "auto", "tileable": "x", "threads": 1}
    same = weftex.synthesize(exemplar, size, seed=3, **options)
    assert np.array_equal(made.image, same.image)


def test_a_set_is_analyzed_by_its_color_and_its_lattice_by_all_maps():
    pebbles, weave = (weftex.load_exemplar(f"sample:{n}").pixels for n in ("pebbles", "weave"))
    plain, found = (
        weftex.Auto().fit(weftex.Exemplar(pebbles, maps=maps)).findings
        for maps in ({}, {"height": weave[..., 0]})
    )
    assert (found.sidedness, found.colors) == (plain.sidedness, plain.colors)
    assert found.lattice is not None and plain.lattice is None


@pytest.mark.parametrize("sample", ["tiles", "pebbles"])  # landmarks are kept, or thinned
def test_a_sample_is_analyzed_once(sample, monkeypatch):
    looks = []
    monkeypatch.setattr(weftex.tasks.auto, "look", lambda given: looks.append(0) or look(given))
    made = weftex.synthesize(f"sample:{sample}", 400, seed=1)
    assert ("landmarks" in made.provenance) == (sample == "pebbles")
    assert len(looks) == 1


@pytest.mark.parametrize("kind", ["plain", "xy", "hole", "wrapped hole", "guide"])
def test_any_canvas_that_a_method_does(kind):
    assert kind in kinds_of("graphcut")
    pixels = noise((30, 31, 3))
    model = weftex.Auto().fit(weftex.Exemplar(pixels))
    made = model.sample(canvas_of(kind, pixels), seed=1)
    assert made.provenance["method"] == "graphcut"
    same = pickle.loads(pickle.dumps(model)).sample(canvas_of(kind, pixels), seed=1)
    assert np.array_equal(made.image, same.image)


def test_hardly_anything_known_is_copied_by_pixels():
    photo = weftex.load_exemplar("sample:grass").pixels[:64, :64]
    mask = np.ones((64, 64), bool)
    mask[30:33, 30:33] = False
    made = weftex.fill(photo, mask, seed=1)
    assert made.provenance["reason"] == "ashikhmin, because only 9 pixels are known around the hole"


def test_a_mask_that_leaves_little_gets_a_method_that_takes_it():
    grass = weftex.load_exemplar("sample:grass").pixels
    mask = np.random.default_rng(0).random(grass.shape[:2]) < 0.7  # no patch is whole
    made = weftex.synthesize(weftex.Exemplar(grass, mask=mask), 40, seed=1)
    assert made.provenance["method"] in ("graphcut", "ashikhmin")
    grains = noise((122, 122, 3)).astype(float)
    grains = sum(grains[k : k + 120, j : j + 120] for k in range(3) for j in range(3)) > 9 * 128
    fine = weftex.Exemplar(grains[..., 0].astype(np.uint8), mask=mask[:120, :120])  # for quilting
    choice, _ = weftex.Auto().fit(fine).chosen((90, 90))
    assert choice.method in ("graphcut", "ashikhmin")
    assert " cannot use it (" in choice.reason
    wide = np.zeros((700, 900), bool)
    wide[640:, 850:] = True
    assert look(weftex.Exemplar(np.zeros((700, 900), np.uint8), mask=wide)).colors == 1


def test_holes_and_fusion_keep_their_own():
    photo = weftex.load_exemplar("sample:pebbles").pixels[:80, :80]
    hole = np.zeros((80, 80), bool)
    hole[30:50, 30:45] = True
    plain = weftex.fill(photo, hole, seed=1)
    for method in ("auto", weftex.Auto()):
        assert np.array_equal(weftex.fill(photo, hole, seed=1, method=method).image, plain.image)
    other = weftex.fill(photo, hole, method="auto", seed=1, patch_size=12)
    assert other.provenance["method"] == "patch-sampling"
    materials = [photo[:40, :40], 255 - photo[:40, :40]]
    made = weftex.fuse(materials, "gradient", 24, seed=1)
    same = weftex.fuse(materials, "gradient", 24, seed=1, method="auto")
    assert np.array_equal(made.image, same.image)


def test_parameters_belong_to_a_method():
    how = weftex.synthesize, noise((40, 40)), 40
    refused("these methods do: patch-sampling, quilting", *how, patch_size=9)
    refused("auto has no parameter 'nothing'", *how, nothing=9)
    assert "auto" not in weftex.METHODS
    assert weftex.Auto().resolved(weftex.Exemplar(noise((9, 9)))) == weftex.Auto()


def test_few_colors_are_counted():
    drawing = (np.indices((200, 200)).sum(0) // 3 % 2 * 255).astype(np.uint8)
    assert count_colors(weftex.Exemplar(drawing)) == 2
    assert count_colors(weftex.Exemplar(noise((60, 60, 3)))) == 1200
