"""Graph-cut textures against their slow twin, and what seams and placement are to do."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import weftex
from families import canvas_of, noise
from twins import graphcut as reference
from weftex.methods.graphcut import GraphCut
from weftex.methods.graphcut.placement import chances_of, drawn_places
from weftex.methods.graphcut.seams import CanvasSeams
from weftex.search.translation import Spectra, fast_size, overlap_mismatch, window_mismatch

KINDS = ("plain", "x", "y", "xy", "hole", "wrapped hole")
WAYS = {
    "subpatch": {"patch_size": 7, "refinements": 1.0},
    "halved": {"patch_size": 9, "halvings": 1, "refinements": 0.5},
    "quartered": {"patch_size": 8, "halvings": 2, "refinements": 0.5},
    "entire halved": {"placement": "entire", "halvings": 2},
    "difference": {"patch_size": 7, "seam_cost": "difference"},
    "papers": {"patch_size": 9, "boundary_width": 2, "variety": 0.0, "candidates": 1},
    "best": {"patch_size": 6, "tolerance": 0.0},
    "entire": {"placement": "entire", "tolerance": 0.03},
    "lattice": {"placement": "entire", "lattice": (3.2, 0.0, 0.0, 3.4)},
    "rows": {"placement": "entire", "lattice": (0.0, 3.4, 1.0, 0.0), "halvings": 1},
    "random": {"placement": "random", "refinements": 0.5},
}


def material(name, height, width, channels=3):
    pixels = weftex.load_exemplar(f"sample:{name}").pixels
    return np.ascontiguousarray(pixels[40 : 40 + height, 50 : 50 + width, :channels])


def few_levels(shape, seed=0, levels=4):
    return np.random.default_rng(seed).integers(0, levels, shape).astype(np.uint8) * 60


def check(exemplar, method, canvas, seed=5):
    """The method and its twin give the same sources."""
    model = method.fit(exemplar)
    result = model.sample(canvas, seed=seed)
    twin = reference.GraphCutTwin(exemplar, model.method, canvas, seed)
    assert np.array_equal(result.index >= 0, np.ones(canvas.shape, bool) if canvas.hole is None
                          else canvas.hole)  # fmt: skip
    expected = twin.source()
    made = expected[..., 0] >= 0
    assert np.array_equal(result.source[made], expected[made])
    return twin


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", WAYS)
def test_it_is_the_slow_twin(kind, way):
    pixels = few_levels((13, 14, 2)) if kind in ("x", "hole") else material("pebbles", 13, 14)
    canvas = canvas_of(kind, pixels, (16, 15)) if "hole" not in kind else small_hole(kind, pixels)
    check(weftex.Exemplar(pixels), GraphCut(**WAYS[way]), canvas)


def small_hole(kind, pixels):
    size = (20, 19)
    hole = np.zeros(size, bool)
    hole[5:14, 4:13] = hole[-2:, 15:] = hole[:2, 9] = True
    known = np.resize(pixels[::-1], (*size, *pixels.shape[2:]))
    return weftex.Canvas(*size, (kind != "hole",) * 2, known=known, hole=hole)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("wrap", [False, True])
def test_samples_that_tile_and_samples_with_masks(way, wrap):
    pixels = few_levels((11, 12, 3), seed=3)
    canvas = weftex.Canvas(10, 13, (wrap, wrap))
    check(weftex.Exemplar(pixels, tileable=True), GraphCut(**WAYS[way]), canvas)
    mask = np.ones((11, 12), bool)
    mask[2:4, 9:] = mask[10, :2] = False
    for tileable in (False, True):
        exemplar = weftex.Exemplar(pixels, mask=mask, tileable=tileable)
        check(exemplar, GraphCut(**WAYS[way]), canvas)
        result = GraphCut(**WAYS[way]).fit(exemplar).sample(canvas, seed=2)
        assert mask[tuple(result.source.transpose(2, 0, 1))].all()


@pytest.mark.parametrize("way", ["subpatch", "entire"])
def test_holes_whose_surroundings_are_the_sample(way):
    pixels = material("bricks", 18, 20)
    hole = np.zeros((18, 20), bool)
    hole[6:11, 7:12] = True
    canvas = weftex.Canvas(18, 20, known=pixels, hole=hole, known_from=(0, 0))
    check(weftex.Exemplar(pixels, mask=~hole), GraphCut(**WAYS[way] | {"variety": 1.0}), canvas)


@st.composite
def jobs(draw):
    sides = st.integers(1, 9)
    pixels = few_levels(
        (draw(sides), draw(sides), draw(st.integers(1, 2))), draw(st.integers(0, 99))
    )
    canvas = weftex.Canvas(
        draw(st.integers(1, 14)), draw(st.integers(1, 14)),
        (draw(st.booleans()), draw(st.booleans())),
    )  # fmt: skip
    parameters = {
        "placement": draw(st.sampled_from(["subpatch", "entire", "random"])),
        "seam_cost": draw(st.sampled_from(["difference", "gradient"])),
        "candidates": draw(st.integers(1, 3)),
        "refinements": draw(st.sampled_from([0.0, 1.0])),
        "halvings": draw(st.sampled_from([None, 1, 2, 3])),
    }
    return weftex.Exemplar(pixels, tileable=draw(st.booleans())), canvas, parameters


@given(jobs(), st.integers(0, 2**64 - 1))
@settings(max_examples=60, deadline=None)
def test_anything_small_is_the_slow_twin(job, seed):
    exemplar, canvas, parameters = job
    check(exemplar, GraphCut(**parameters), canvas, seed)


# Seams


@pytest.mark.parametrize("seam_cost", ["difference", "gradient"])
@pytest.mark.parametrize("kind", KINDS)
def test_refinement_never_makes_seams_worse(seam_cost, kind, monkeypatch):
    totals = []

    def update(self, *box):
        change = whole(self, *box)
        kept = [a.copy() for a in (self.cost, self.cells, self.squares, self.most)]
        for a in (self.cost, self.cells, self.squares, self.most):
            a[...] = 0
        whole(self, 0, 0, *self.canvas.shape)
        afresh = self.cost, self.cells, self.squares, self.most
        assert all(np.array_equal(a, b) for a, b in zip(kept, afresh, strict=True))
        totals.append(int(self.cost.sum()))
        return change

    whole = CanvasSeams.update
    pixels = material("pebbles", 40, 40)
    canvas = canvas_of(kind, pixels, (61, 50))
    method = GraphCut(patch_size=14, seam_cost=seam_cost, refinements=3.0)
    monkeypatch.setattr(CanvasSeams, "update", update)
    method.fit(weftex.Exemplar(pixels)).sample(canvas, seed=1)
    assert len(totals) > 5
    assert all(later <= before for before, later in itertools.pairwise(totals))
    assert totals[-1] < totals[0]


# Placement


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 3), st.integers(0, 99))
def test_mismatch_is_the_sum_of_squared_differences(height, width, channels, seed):
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 256, (12, 13, channels)).astype(np.uint8)
    window = rng.integers(0, 256, (height, width, channels)).astype(np.uint8)
    here = rng.random((12, 13)) < 0.8
    there = rng.random((height, width)) < 0.6
    size = fast_size(12), fast_size(13)
    whole, part = Spectra(picture, np.ones((12, 13)), size), Spectra(window, there, size)
    holed = Spectra(picture, here, size)
    total = window_mismatch(whole, part)
    common, area = overlap_mismatch(holed, part)
    for y in range(12 - height + 1):
        for x in range(13 - width + 1):
            like = picture[y : y + height, x : x + width].astype(int)
            squares = ((like - window.astype(int)) ** 2).sum(axis=2)
            assert total[y, x] == squares[there].sum()
            both = there & here[y : y + height, x : x + width]
            assert common[y, x] == squares[both].sum()
            assert area[y, x] == both.sum()


def test_mismatch_is_exact_where_it_is_largest():
    """Black against white over the largest patch: still the exact whole number."""
    black, white = np.zeros((600, 640, 4), np.uint8), np.full((300, 310, 4), 255, np.uint8)
    size = (600, 640)
    total = window_mismatch(
        Spectra(black, np.ones((600, 640)), size), Spectra(white, np.ones((300, 310)), size)
    )
    assert (total[:301, :331] == 300 * 310 * 4 * 255**2).all()


def test_chances_follow_the_exponential():
    costs = np.linspace(0, 300, 50).reshape(5, 10)
    chances = chances_of(costs, np.ones((5, 10), bool), 40.0)
    assert np.allclose(chances / chances[0, 0], np.exp(-costs / 40), rtol=0.03)
    drawn = drawn_places(costs[::-1], np.ones((5, 10), bool), 0.0, (7, 0, 3), [0, 0])
    assert drawn == [(4, 0), (4, 1), (4, 2)]  # without a spread the best ones, in turn


def test_variety_keeps_repeats_apart():
    """Fewer pixels near each other come from the same place than in the paper's way."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:leaves").pixels[:128, :128])

    def distinct(variety):
        source = GraphCut(variety=variety).fit(exemplar).sample(256, seed=4).source
        flat = source[..., 0] * 128 + source[..., 1]
        boxes = [flat[y : y + 64, x : x + 64] for y in range(0, 256, 64) for x in range(0, 256, 64)]
        return np.mean([len(np.unique(box)) / box.size for box in boxes])

    def largest(variety):
        """The share of the sample that is copied in one piece, at most."""
        result = GraphCut(variety=variety, refinements=0.0).fit(exemplar).sample(256, seed=4)
        shift = result.source - np.indices((256, 256)).transpose(1, 2, 0)
        _, counts = np.unique(shift.reshape(-1, 2), axis=0, return_counts=True)
        return counts.max() / 128**2

    assert distinct(1.0) > 0.9
    assert largest(1.0) < 0.5 * largest(0.0)


# Parameters


@pytest.mark.parametrize("shape", [(1, 40), (2, 40), (40, 3)])
def test_thin_samples_take_thin_patches(shape):
    """Squares of one pixel took a cut for every pixel of the canvas."""
    exemplar = weftex.Exemplar(noise((*shape, 3)))
    made = weftex.GraphCut().fit(exemplar).sample((30, 40), seed=1).provenance
    assert max(made["patch_shape"]) == 18 and "patch_size" not in made
    again = weftex.GraphCut(boundary_width=made["boundary_width"]).fit(exemplar)
    assert again.sample((30, 40), seed=1).provenance["patch_shape"] == made["patch_shape"]


def test_refinements_end_when_nothing_is_mended():
    exemplar = weftex.Exemplar(noise((24, 24)))
    pictures = [
        weftex.GraphCut(patch_size=9, refinements=many).fit(exemplar).sample((30, 40), seed=1).image
        for many in (500.0, 1000.0)
    ]
    assert np.array_equal(*pictures)


# Lattices


def test_pieces_keep_to_a_lattice():
    """Tiles keep their size, which the best matches of a sample with uneven joints do not."""
    exemplar = weftex.load_exemplar("sample:tiles")
    method = GraphCut(placement="entire", lattice=(31.05, 0, -0.25, 102.17))
    result = method.fit(exemplar).sample(200, seed=2)
    y, x = np.indices((200, 200))
    off = np.stack([y, x], axis=2) - result.source
    times = off @ np.linalg.inv(np.array([[0, 31.05], [102.17, -0.25]]))
    strayed = abs((times - np.rint(times)) @ np.array([[0, 31.05], [102.17, -0.25]]))
    assert strayed.max() <= 31.05 / 16
    with pytest.raises(weftex.WeftexError, match="less than two tiles"):
        GraphCut(placement="entire", lattice=(200, 0, 0, 200)).fit(exemplar)
    with pytest.raises(weftex.WeftexError, match="lattice"):
        GraphCut(lattice=(20, 0, 0, 20))


def test_the_least_reach_of_tones_there_is(rng):
    sample = rng.integers(0, 256, (23, 30)).astype(np.uint8)
    made, plain = (
        weftex.synthesize(sample, 40, method="graphcut", seed=1, tone_reach=reach).image
        for reach in (np.finfo(float).smallest_subnormal, 0.0)
    )
    assert np.array_equal(made, plain)
