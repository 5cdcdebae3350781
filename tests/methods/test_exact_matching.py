"""Exact neighborhood matching: the fast code is its slow twin, and keeps the paper's promises."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import weftex
from families import noise
from twins import exact_matching as reference
from weftex.errors import InvalidInputError

WRAPS = [(False, False), (False, True), (True, False), (True, True)]


def blobs(shape, step, seed=0):
    """Few colors in patches, so that lists are long and windows alike."""
    small = noise((shape[0] // 3 + 1, shape[1] // 3 + 1, *shape[2:]), seed=seed)
    return (small.repeat(3, 0).repeat(3, 1)[: shape[0], : shape[1]] // step * step).astype(np.uint8)


def same(exemplar, canvas, seed=1, **parameters):
    model = weftex.ExactMatching(**parameters).fit(exemplar)
    result = model.sample(canvas, seed=seed)
    wanted = reference.exact_matching(model.method, exemplar, canvas, seed)
    made = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    assert np.array_equal(result.source[made], wanted[made])
    return result


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("init", ["random", "structured"])
@pytest.mark.parametrize("tiles", [False, True])
def test_it_is_the_slow_twin(wrap, init, tiles):
    exemplar = weftex.Exemplar(blobs((13, 15, 2), 64), tileable=tiles)
    same(exemplar, weftex.Canvas(7, 8, wrap), window_width=5, init=init)
    same(exemplar, weftex.Canvas(4, 3, wrap), window_width=7, init=init, repeat_distance=2)


@pytest.mark.parametrize("wrap", WRAPS)
@pytest.mark.parametrize("from_sample", [False, True])
def test_holes_are_the_slow_twins(wrap, from_sample):
    pixels = blobs((14, 15, 3), 32)
    hole = np.zeros((9, 8), bool)
    hole[1:6, 2:7] = hole[7:, :2] = True
    known = pixels[3:12, 4:12] if from_sample else noise((9, 8, 3), seed=5)
    canvas = weftex.Canvas(
        9, 8, wrap, known=known, hole=hole, known_from=(3, 4) if from_sample else None
    )
    same(weftex.Exemplar(pixels), canvas, window_width=5)
    same(weftex.Exemplar(pixels), canvas, window_width=3, passes=0, repeat_distance=3)


@pytest.mark.parametrize(
    "parameters",
    [
        {"tolerance": 0.0},
        {"tolerance": 0.2},
        {"tolerance": 1.0},
        {"nearest_colors": 1},
        {"nearest_colors": 3},
        {"nearest_colors": 1000},
        {"grouping": 0.1},
        {"candidates": 0},
        {"candidates": 3},
        {"candidates": 30, "tolerance": 1.0},
        {"candidates": 20, "nearest_colors": 7},
        {"grouping": 1.0, "tolerance": 0.1},
        {"copying": "blocks"},
        {"repeat_distance": 0},
        {"repeat_distance": 50},
        {"levels": 2},
        {"levels": 2, "tolerance": 0.05, "copying": "blocks"},
    ],
    ids=str,
)
@pytest.mark.parametrize("name", ["few", "pebbles"])
def test_every_parameter_is_the_slow_twins(parameters, name):
    pixels = {
        "few": blobs((16, 17), 86),
        "pebbles": weftex.load_exemplar("sample:pebbles").pixels[:16, :20],
    }[name]
    exemplar = weftex.Exemplar(pixels)
    same(exemplar, weftex.Canvas(6, 7), window_width=5, init="random", **parameters)
    same(
        exemplar, weftex.Canvas(7, 6, (True, True)), window_width=5, init="structured", **parameters
    )


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("tiles", [False, True])
def test_masks_are_the_slow_twins(levels, tiles):
    mask = np.ones((18, 20), bool)
    mask[6:9, :5] = mask[0, 16:] = False
    exemplar = weftex.Exemplar(blobs((18, 20), 50), mask=mask, tileable=tiles)
    result = same(exemplar, weftex.Canvas(7, 6, (True, False)), window_width=3, levels=levels)
    assert mask[result.source[..., 0], result.source[..., 1]].all()


@settings(max_examples=40)
@given(data=st.data())
def test_anything_small_is_the_slow_twins(data):
    shape = data.draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    size = data.draw(st.tuples(st.integers(1, 7), st.integers(1, 7)))
    pixels = noise(
        shape, values=data.draw(st.sampled_from([1, 2, 5, 256])), seed=data.draw(st.integers(0, 99))
    )
    known = hole = None
    if data.draw(st.booleans()):
        known, hole = noise(size, seed=7), noise(size, values=2, seed=8).astype(bool)
    canvas = weftex.Canvas(*size, data.draw(st.sampled_from(WRAPS)), known=known, hole=hole)
    exemplar = weftex.Exemplar(pixels, tileable=data.draw(st.booleans()))
    parameters = {
        "init": data.draw(st.sampled_from(["random", "structured"])),
        "copying": data.draw(st.sampled_from(["pixels", "blocks"])),
        "grouping": data.draw(st.sampled_from([0.0, 0.3])),
        "repeat_distance": data.draw(st.sampled_from([None, 0, 2])),
    }
    if "known" in canvas.kinds:  # these have no effect there, and are refused
        del parameters["init" if parameters["repeat_distance"] is not None else "copying"]
        parameters.pop("copying", None)
    same(exemplar, canvas, seed=data.draw(st.integers(0, 2**64 - 1)), **parameters)


def test_a_larger_tolerance_tests_more():
    """Figure 9; everything is a candidate at 100 %."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:48, :48])
    tested = []
    for tolerance in (0.0, 0.01, 0.05, 1.0):
        model = weftex.ExactMatching(
            window_width=7, tolerance=tolerance, init="random", candidates=0
        ).fit(exemplar)
        facts = model.sample((16, 16), seed=1).provenance
        tested.append(facts["windows_compared"] / facts["pixels_chosen"])
    assert tested == sorted(tested)
    assert tested[0] < 20 < 1000 < tested[-1]
    with_room = (48 - 6) * (48 - 6)
    assert tested[-1] <= with_room + 5


def test_grouping_shortens_lists():
    exemplar = weftex.load_exemplar("sample:weave")
    cost = []
    for grouping in (0.0, 0.03):
        model = weftex.ExactMatching(
            window_width=11, grouping=grouping, init="random", candidates=0
        ).fit(exemplar)
        cost.append(model.sample((20, 40), seed=1).provenance["windows_compared"])
    assert cost[1] < cost[0] / 2


@pytest.mark.parametrize("tolerance", [0.0, 0.1, 1.0])
def test_the_cap_counts_each_window_once(tolerance):
    """Where a tolerance takes everything, each window is in all four lists."""
    pixels = noise((40, 40), values=3)
    compared = []
    for candidates in (0, 100):
        model = weftex.ExactMatching(
            window_width=5, tolerance=tolerance, init="random", candidates=candidates
        ).fit(weftex.Exemplar(pixels))
        facts = model.sample((24, 24), seed=2).provenance
        compared.append(facts["windows_compared"] / facts["pixels_chosen"])
    assert compared[0] > 150
    assert 80 < compared[1] < 110


def test_the_beginning_follows_the_sample():
    """Section 4.3: structured for near-regular samples, random for stochastic ones."""
    for name, init in (("bricks", "structured"), ("weave", "structured"), ("pebbles", "random")):
        method = weftex.ExactMatching().resolved(weftex.load_exemplar(f"sample:{name}"))
        assert (name, method.init) == (name, init)
        assert method.repeat_distance == (0 if init == "structured" else method.window_width // 2)


def test_a_tolerance_is_proposed_where_colors_hardly_occur_twice():
    assert weftex.ExactMatching().resolved(weftex.load_exemplar("sample:weave")).tolerance == 0
    assert weftex.ExactMatching().resolved(weftex.load_exemplar("sample:grass")).tolerance == 0
    many = weftex.Exemplar(noise((40, 40, 3)))
    assert 0 < weftex.ExactMatching().resolved(many).tolerance < 0.1
    assert weftex.ExactMatching(nearest_colors=4).resolved(many).tolerance is None


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"tolerance": 0.1, "nearest_colors": 2}, "give one of them"),
        ({"tolerance": 1.5}, "tolerance is 1.5; it must be from 0 to 1"),
        ({"window_width": 8}, "window_width is 8; it must be odd"),
        ({"window_width": 41}, "window_width is 41; sample is 40x30, which has room for 29"),
        ({"levels": 9}, "levels is 9; sample is 40x30, which is enough for 3"),
    ],
)
def test_errors_name_what_is_wrong(parameters, message):
    with pytest.raises(InvalidInputError, match=message):
        weftex.ExactMatching(**parameters).fit(weftex.Exemplar(noise((30, 40))))


def test_holes_are_filled_at_one_level():
    pixels = noise((30, 40))
    canvas = weftex.Canvas(30, 40, known=pixels, hole=pixels > 250)
    model = weftex.ExactMatching(levels=2).fit(weftex.Exemplar(pixels))
    with pytest.raises(InvalidInputError, match="levels is 2; holes are filled with 1"):
        model.sample(canvas, seed=1)


def test_passes_over_nothing_are_refused():
    """They go over pixels between known ones: holes, and last rows before the first."""
    pixels = np.random.default_rng(0).integers(0, 255, (20, 20), np.uint8)
    given = {"method": "exact-matching", "window_width": 3, "passes": 4}
    for tileable in (False, "x"):
        with pytest.raises(weftex.InvalidInputError, match="passes has no effect without a hole"):
            weftex.synthesize(pixels, 12, tileable=tileable, **given)
    assert weftex.synthesize(pixels, 12, tileable="y", **given).image.shape == (12, 12)
    hole = np.zeros((20, 20), bool)
    hole[8:12, 8:12] = True
    assert weftex.fill(pixels, hole, **given).image.shape == (20, 20)
