"""Iterative refinement: byte by byte its slow twin, the start, the sweeps, and when they stop."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import weftex
from families import canvas_of, noise, refused
from twins import refinement as reference
from weftex.analysis.scale import structure_scale
from weftex.canvas import Canvas
from weftex.methods.refinement.start import hole_start, starts_for
from weftex.methods.refinement.sweeps import cyclic_lines, rows_of

WRAPS = [(False, False), (False, True), (True, False), (True, True)]


def check_twin(method, exemplar, canvas, seed):
    model = method.fit(exemplar)
    result = model.sample(canvas, seed=seed)
    start, prepared = None, model.prepared
    for name in starts_for(prepared, canvas)[:1]:
        hole = canvas.hole
        other = prepared.starts[name] if hole is None else hole_start(name, hole, exemplar)
        start = other.sample(canvas, seed=seed).source
    expected = reference.refinement(model.method, exemplar, canvas, seed, start)
    source = result.source
    if canvas.hole is not None:
        source[~canvas.hole] = -1
    assert np.array_equal(source, expected)
    return result


@settings(max_examples=40)
@given(st.data())
def test_it_is_the_slow_twin(data):
    """Small samples on every kind of canvas, one resolution; `brute_force` has the other search."""
    draw = data.draw
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    shape = draw(st.integers(5, 9)), draw(st.integers(5, 9))
    channels, colors = draw(st.integers(1, 3)), draw(st.sampled_from([1, 2, 5, 200]))
    mask = None
    if draw(st.booleans()):
        mask = np.ones(shape, bool)
        mask[0, rng.integers(shape[1])] = False
    pixels = rng.integers(0, colors, (*shape, channels)) * (255 // max(colors - 1, 1))
    pixels = pixels.astype(np.uint8)
    exemplar = weftex.Exemplar(pixels, mask=mask, tileable=draw(st.booleans()), alpha=False)
    size = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    more = {}
    if draw(st.booleans()):
        more = {"known": noise((*size, channels)), "hole": rng.random(size) < 0.6}
        if size <= shape and size[1] <= shape[1] and draw(st.booleans()):
            corner = shape[0] - size[0], shape[1] - size[1]
            more |= {"known": pixels[corner[0] :, corner[1] :].copy(), "known_from": corner}
    starts = ["seeds"] if exemplar.mask is not None else ["seeds", "ashikhmin"]
    parameters = {"init": draw(st.sampled_from(starts))}
    if parameters["init"] == "seeds":
        parameters |= {"matches": draw(st.integers(1, 5)), "seed_density": draw(st.just(0.5))}
    parameters |= {"similar": draw(st.integers(0, 2)), "evenness": draw(st.just(2.0))}
    if parameters["init"] != "seeds" and draw(st.booleans()):
        parameters["joints"] = draw(st.sampled_from([2, 4, 6]))
    method = weftex.Refinement(
        window_width=draw(st.sampled_from([1, 3, 5])) if mask is None else 3,
        iterations=draw(st.integers(1, 5)),
        **parameters,
    )
    canvas = Canvas(*size, draw(st.sampled_from(WRAPS)), **more)
    check_twin(method, exemplar, canvas, draw(st.integers(0, 2**64 - 1)))


@pytest.mark.parametrize("kind", ["plain", "xy", "hole"])
@pytest.mark.parametrize(("init", "tileable"), [("seeds", True), ("quilting", False)])
def test_levels_are_the_slow_twins(kind, tileable, init):
    """Two levels; the second sample has odd sides and a mask."""
    sample = weftex.load_exemplar("sample:pebbles").pixels
    pixels = np.ascontiguousarray(sample[20:68, 10:59, :1])
    mask = np.ones(pixels.shape[:2], bool)
    mask[:9, 30:] = False
    exemplar = weftex.Exemplar(pixels, mask=mask, tileable=tileable)
    method = weftex.Refinement(window_width=13, iterations=1, init=init, similar=1 + tileable)
    canvas = canvas_of(kind, pixels, (13, 15))
    model = method.fit(exemplar)
    assert len(model.prepared.levels) == 2
    check_twin(method, exemplar, canvas, 5)


def test_the_depth_follows_the_window_and_the_sample():
    pixels = noise((100, 120))
    for width, depth in ((3, 1), (7, 1), (9, 2), (15, 3), (29, 3), (99, 3)):
        levels = weftex.Refinement(window_width=width).fit(weftex.Exemplar(pixels)).prepared.levels
        assert len(levels) == depth
        assert [level.reach for level in levels] == [1 if depth > 1 else min(3, width // 2)] + [
            3
        ] * (depth - 1)
    model = weftex.Refinement(window_width=29, search="nearest").fit(weftex.Exemplar(pixels))
    (level,) = model.prepared.levels
    assert level.reach == 14


def test_the_window_is_twice_the_scale():
    y, x = np.indices((128, 128))
    waves = np.rint(127 + 60 * np.sin(x * np.pi / 10) + 60 * np.sin(y * np.pi / 10))
    exemplar = weftex.Exemplar(waves.astype(np.uint8))
    for search in ("coherent", "nearest"):
        width = weftex.Refinement(search=search).fit(exemplar).method.window_width
        assert width == structure_scale(exemplar).window_width and 39 <= width <= 43
    grain = weftex.Exemplar(noise((128, 128)))
    assert weftex.Refinement().fit(grain).method.window_width == 29
    assert weftex.Refinement(search="nearest").fit(grain).method.window_width < 29


@pytest.mark.parametrize("init", ["quilting", "graphcut"])
def test_only_joints_are_refined(init):
    """Patches stay, and pictures of a pattern are the pattern."""
    pixels = weftex.load_exemplar("sample:pebbles").pixels[:72, :72].copy()
    method = weftex.Refinement(window_width=15, init=init, joints=10)
    made = method.fit(weftex.Exemplar(pixels)).sample(80, seed=2)
    start = weftex.METHODS[init]().fit(weftex.Exemplar(pixels)).sample(80, seed=2)
    same = (made.source == start.source).all(axis=2)
    step = np.diff(start.source, axis=1) != (0, 1)
    seams = np.pad(step.any(axis=2), ((0, 0), (0, 1)))
    assert same[~reference.seam_belts(start.source, 5, (False, False), made.exemplar)].all()
    assert not same[seams].all() and same.mean() > 0.2
    refused("joints has no effect unless init is", weftex.Refinement, init="seeds", joints=10)


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_joints_of_levels_are_the_slow_twins(wrap):
    pixels = weftex.load_exemplar("sample:pebbles").pixels[20:68, 10:59, :1].copy()
    method = weftex.Refinement(window_width=13, iterations=1, similar=0, joints=6)
    check_twin(method, weftex.Exemplar(pixels, tileable=wrap[0]), Canvas(23, 25, wrap), 5)


def curve_of(**parameters):
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:64, :64])
    method = weftex.Refinement(**parameters)
    return method.fit(exemplar).sample(48, seed=3).provenance["convergence"]


def test_the_number_of_iterations_stops_it():
    curve = curve_of(window_width=13, iterations=4, threshold=0.0)
    found = [(p["level"], p["iteration"]) for p in curve]
    assert found == [*((1, n) for n in range(1, 9)), (0, 1), (0, 2)]


def test_a_small_difference_stops_it():
    curve = curve_of(window_width=13, iterations=50, threshold=0.05)
    last = {point["level"]: point for point in curve}
    assert all(point["difference"] < 0.05 for point in last.values())
    assert all(
        p["difference"] >= 0.05 for p in curve if p is not last[p["level"]] and p["iteration"] > 1
    )
    assert len(curve) < 40


def test_the_curve_says_what_changed():
    """Iterations of one level, from the pictures before and after each."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:40, :40])
    pictures = []
    for iterations in (1, 2, 3):
        method = weftex.Refinement(
            search="nearest", window_width=7, init="seeds", seed_scale=3.0, iterations=iterations
        )
        pictures.append(method.fit(exemplar).sample(24, seed=1))
    curve = pictures[-1].provenance["convergence"]
    assert curve[0]["changed"] > 0.98  # a seed may stay
    assert 0.8 < curve[0]["difference"] <= 1.0  # what was not there before counts as different
    for k in (1, 2):
        old, new = (pictures[n].image.astype(float) for n in (k - 1, k))
        moved = (pictures[k].source != pictures[k - 1].source).any(axis=2)
        assert curve[k]["changed"] == moved.mean()
        assert curve[k]["mse"] == pytest.approx(((new - old) ** 2).mean())
        away = np.sqrt(((new - old) ** 2).sum(axis=2) / np.maximum((old**2).sum(axis=2), 1))
        assert curve[k]["difference"] == pytest.approx(away.mean(), abs=1e-6)


def test_holes_are_swept_from_four_sides():
    hole = np.zeros((3, 4), bool)
    hole[0, 1:], hole[2, 2] = True, True
    lines = rows_of(hole)
    expected = [[[1, 2, 3], [10]], [[1], [2, 10], [3]], [[10], [3, 2, 1]], [[3], [10, 2], [1]]]
    for turn in range(8):
        assert [k.tolist() for k in cyclic_lines(lines, turn, hole.shape)] == expected[turn % 4]


def test_it_starts_from_a_method_with_parameters(tmp_path):
    """As an object, as a text, and as what is saved; and it is that method's result."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:64, :64].copy())
    start = weftex.GraphCut(placement="entire", tolerance=0.5)
    method = weftex.Refinement(init=start, joints=4)
    assert method == weftex.Refinement(init="graphcut tolerance=0.5 placement=entire", joints=4)
    assert method.init == "graphcut placement=entire tolerance=0.5"
    model = pickle.loads(pickle.dumps(method.fit(exemplar)))
    made = model.sample(80, seed=1)
    made.save(tmp_path / "made.npz")
    saved = weftex.Synthesis.load(tmp_path / "made.npz").provenance
    assert saved["init"] == made.provenance["init"] == method.init
    again = weftex.Refinement(init=saved["init"], joints=4).fit(exemplar).sample(80, seed=1)
    assert np.array_equal(made.source, again.source)
    same = (made.source == start.fit(exemplar).sample(80, seed=1).source).all(axis=2)
    plain = (made.source == weftex.GraphCut().fit(exemplar).sample(80, seed=1).source).all(axis=2)
    assert same.mean() > 0.5 > plain.mean()


def test_joints_are_refined_where_materials_are_joined():
    """A belt between two materials is a joint all of it: refined from seeds, without an error."""
    for init in ("auto", "quilting"):
        method = weftex.Refinement(window_width=9, joints=6, init=init)
        assert method.for_belt(9).joints is None
    samples = [noise((40, 40), seed=k) for k in (1, 2)]
    labels = np.where(np.indices((40, 48))[1] > 24, 255, 0).astype(np.uint8)
    method = weftex.Refinement(window_width=9, joints=6, iterations=1)
    assert weftex.fuse(samples, labels, method=method, seed=1).image.shape[:2] == (40, 48)


def test_seed_points_lie_a_scale_apart():
    """Of the sample, whatever the window is wide; and as often as the density says."""
    x = np.indices((96, 96))[1]
    waves = np.rint(127 + 60 * np.sin(x * np.pi / 3)) + noise((96, 96)) // 16
    exemplar = weftex.Exemplar(waves.astype(np.uint8))
    scale = structure_scale(exemplar).scale
    assert 5 < scale < 7
    for width, density in ((None, 1.0), (41, 1.0), (None, 0.5)):
        for search in ("coherent", "nearest"):
            method = weftex.Refinement(
                window_width=width, init="seeds", seed_density=density, search=search
            )
            model = method.fit(exemplar)
            assert model.prepared.seed_spacing == scale / density
            assert model.method.seed_scale == scale
    assert weftex.Refinement().fit(exemplar).method.seed_scale is None
    given = weftex.Refinement(init="seeds", seed_scale=20.0).fit(exemplar)
    assert given.prepared.seed_spacing == 20
