"""Graph-cut textures: what seams, placement, sizes and lattices of patches are to do."""

import itertools
import types

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import canvas_of, noise, refused
from weftex.analysis.canvas_lattice import first_place
from weftex.guides import Guiding
from weftex.methods.graphcut import GraphCut
from weftex.methods.graphcut.cutting import WorstSeams
from weftex.methods.graphcut.placement import chances_of, drawn_places
from weftex.search.fft_mismatch import Spectra, overlap_mismatch, window_mismatch

KINDS = ("plain", "x", "y", "xy", "hole", "wrapped hole")


# Seams


@pytest.mark.parametrize("seam_cost", ["difference", "gradient"])
@pytest.mark.parametrize("kind", KINDS)
def test_refinement_never_makes_seams_worse(seam_cost, kind, monkeypatch):
    totals = []

    def update(self, *box):
        whole(self, *box)
        kept = self.cost.copy(), self.cells.copy()
        self.cost[...] = self.cells[...] = 0
        whole(self, 0, 0, *self.canvas.shape)
        assert all(map(np.array_equal, kept, (self.cost, self.cells)))
        totals.append(int(self.cost.sum()))

    whole = WorstSeams.update
    pixels = weftex.load_exemplar("sample:pebbles").pixels[40:80, 50:90].copy()
    canvas = canvas_of(kind, pixels, (61, 50))
    method = GraphCut(patch_size=14, seam_cost=seam_cost, refinements=3.0)
    monkeypatch.setattr(WorstSeams, "update", update)
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
    size = 12, 15
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


@pytest.mark.parametrize("side", [9, 32])
def test_refinements_end_when_nothing_is_mended(side):
    exemplar = weftex.Exemplar(noise((34, 34)))
    both = (weftex.GraphCut(patch_size=side, refinements=many) for many in (500.0, 1000.0))
    assert np.array_equal(*(m.fit(exemplar).sample((30, 40), seed=1).image for m in both))


def test_labels_are_followed():
    """A sample of two materials, and a map that asks for much of one and a piece of the other."""
    y, x = np.indices((60, 90))
    own = x > 60 + 4 * np.sin(y / 5)
    pixels = np.where(own, 200, 60) + noise((60, 90)) // 8
    exemplar = weftex.Exemplar(pixels.astype(np.uint8), guide=own)
    y, x = np.indices((48, 64))
    wanted = (y - 24) ** 2 + (x - 24) ** 2 > 200
    canvas = weftex.Canvas(48, 64, guide=wanted)
    image = GraphCut(tone_reach=0.0).fit(exemplar).sample(canvas, seed=1).image
    assert ((image > 150) == wanted).mean() > 0.97


@pytest.mark.parametrize("level", [0, 1])
def test_the_mismatch_of_guides_is_the_mean_difference_of_a_box(level, rng):
    """Of labels; the sample begins again beyond its border, and a level has means of squares."""
    own, wanted = rng.integers(0, 3, (12, 14)), rng.integers(0, 3, (20, 22))
    exemplar = weftex.Exemplar(noise((12, 14)), guide=own)
    canvas = weftex.Canvas(20, 22, guide=wanted)
    output = types.SimpleNamespace(canvas=canvas, source=np.full((20, 22), -1, np.int32))
    rows, columns = np.arange(3, 9, dtype=np.int32), np.arange(18, 26, dtype=np.int32) % 22
    found = Guiding(exemplar, output, 2.0, 1.0).mismatch(rows, columns, level)
    whole, box = np.tile(own, (2, 2)), wanted[np.ix_(rows, columns)]
    whole, box = (np.rint(255.0 * (p[..., None] == [0, 1, 2])) for p in (whole, box))
    if level:
        whole, box = (
            np.rint((p[::2, ::2] + p[1::2, ::2] + p[::2, 1::2] + p[1::2, 1::2]) / 4)
            for p in (whole, box)
        )
    high, wide = box.shape[:2]
    for y, x in np.ndindex(12 >> level, 14 >> level):
        apart = np.square(whole[y : y + high, x : x + wide] - box).sum() / (high * wide)
        assert found[y, x] == pytest.approx(2 * apart / (2 * 255**2))


def test_tones_are_not_spread_between_labels():
    """A sample of two tones, each of which is its label: no pixel gets one between them."""
    own = np.indices((60, 80))[1] > 40
    pixels = np.where(own, 200, 60).astype(np.uint8) + noise((60, 80)) // 8
    wanted = np.indices((64, 64))[0] % 40 > 20
    made = GraphCut().fit(weftex.Exemplar(pixels, guide=own))
    image = made.sample(weftex.Canvas(64, 64, guide=wanted), seed=1).image
    assert ((image > 185) | (image < 105)).all()
    method, message = GraphCut(placement="entire"), "a guide needs placement 'subpatch'"
    refused(message, weftex.synthesize, pixels, (60, 80), method=method, guide=pixels)


# Lattices


def test_pieces_keep_to_a_lattice():
    """Tiles keep their size, which the best matches of a sample with uneven joints do not."""
    exemplar = weftex.load_exemplar("sample:tiles")
    method = GraphCut(placement="entire", lattice=(31.05, 0, -0.25, 102.17))
    result = method.fit(exemplar).sample(200, seed=2)
    y, x = np.indices((200, 200))
    off = np.stack([y, x], axis=2) + first_place(result.canvas, 2) - result.source
    times = off @ np.linalg.inv(np.array([[0, 31.05], [102.17, -0.25]]))
    strayed = abs((times - np.rint(times)) @ np.array([[0, 31.05], [102.17, -0.25]]))
    assert strayed.max() <= 31.05 / 16
    with pytest.raises(weftex.WeftexError, match="less than two cells"):
        GraphCut(placement="entire", lattice=(200, 0, 0, 200)).fit(exemplar)
    refused("lattice", GraphCut, lattice=(20, 0, 0, 20), error=weftex.WeftexError)


def test_small_outputs_on_a_lattice_differ():
    model = GraphCut(placement="entire", lattice=(63, 41.8, 63, -41.8)).fit("sample:bricks")
    assert len({one.tobytes() for one in model.samples(30, (40, 50), seed=1)}) == 30


def test_the_least_reach_of_tones_there_is(rng):
    sample = rng.integers(0, 256, (23, 30)).astype(np.uint8)
    made, plain = (
        weftex.synthesize(sample, 40, method="graphcut", seed=1, tone_reach=reach).image
        for reach in (np.finfo(float).smallest_subnormal, 0.0)
    )
    assert np.array_equal(made, plain)
