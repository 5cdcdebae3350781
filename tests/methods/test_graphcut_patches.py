"""Patches of graph-cut textures: how large they are, and where in the sample they come from."""

import sys
from pathlib import Path

import numpy as np
import pytest

import weftex
from families import canvas_of, noise, refused
from weftex.methods.graphcut import GraphCut, subpatch
from weftex.methods.graphcut.cost_kernels import find_runs
from weftex.methods.graphcut.cutting import CutCanvas
from weftex.methods.graphcut.subpatch import SubPatchMatching

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks" / "quality"))
import repeats


def test_entire_patches_show_all_of_the_sample():
    """Its places are shown more evenly than in the paper's way, and less often in line."""
    exemplar = weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:128, :128])
    uneven, in_line = np.zeros(2), np.zeros(2)
    for seed in range(3):
        for i, variety in enumerate((0.0, 1.0)):
            model = GraphCut(placement="entire", variety=variety).fit(exemplar)
            source = model.sample(320, seed=seed).source
            uneven[i] += repeats.use(source, (128, 128))[0]
            in_line[i] += repeats.again(source, 128)[0]
    assert uneven[1] < 0.9 * uneven[0]
    assert in_line[1] < 0.7 * in_line[0]


def test_in_a_photo_only_what_is_around_a_hole_counts(monkeypatch):
    """Entire patches are cut where the hole is, and far pixels do not change what fills it."""
    pixels = np.tile(weftex.load_exemplar("sample:pebbles").pixels[40:100, 50:110], (3, 3, 1))
    hole = np.zeros((180, 180), bool)
    hole[80:100, 90:104] = True
    pasted, cost = [], CutCanvas.cost

    def counted(self, patch):
        pasted.append(patch)
        return cost(self, patch)

    monkeypatch.setattr(CutCanvas, "cost", counted)
    sample = weftex.Exemplar(pixels[:60, :60])
    method, filled = GraphCut(placement="entire"), []
    for shade in (0, 90):
        photo = pixels.copy()
        photo[:40, :] = shade
        canvas = weftex.Canvas(180, 180, hole=hole, known=photo)
        filled.append(method.fit(sample).sample(canvas, seed=2).image[hole])
    assert pasted and all(p.top >= 80 and p.top + p.height <= 100 for p in pasted)
    assert all(p.left >= 90 and p.left + p.width <= 104 for p in pasted)
    assert np.array_equal(*filled)


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"patch_size": 31}, "patch_size is 31; .* at most 30"),
        ({"patch_size": 10, "boundary_width": 5}, "boundary_width is 5; .* 4"),
        ({"halvings": 9}, "halvings is 9"),
    ],
)
def test_wrong_parameters_are_named(wrong, message):
    refused(message, lambda: GraphCut(**wrong).fit(weftex.Exemplar(noise((30, 31), values=4))))


@pytest.mark.parametrize("tileable", [False, True])
def test_of_large_samples_each_patch_is_looked_for_in_a_part(monkeypatch, tileable):
    """Time and memory do not grow with the sample; patches come from all over it, and match."""
    monkeypatch.setattr(subpatch, "_MOST_PIXELS", 5000)
    monkeypatch.setattr(subpatch, "_PART", 1600)
    y, x = np.indices((120, 160))
    levels = 90 * (x % 8 < 4) + 90 * (y % 8 < 4) + noise((120, 160)) % 16
    mask = np.ones((120, 160), bool)
    mask[:60, :50] = False
    exemplar = weftex.Exemplar(levels.astype(np.uint8), tileable=tileable, mask=mask)
    looked_at = []
    made = SubPatchMatching.part

    def part(self, number):
        looked_at.append(made(self, number))
        return looked_at[-1]

    monkeypatch.setattr(SubPatchMatching, "part", part)
    model = GraphCut(patch_size=24).fit(exemplar)
    results = [model.sample((100, 90), seed=3, threads=threads) for threads in (1, 2)]
    assert np.array_equal(results[0].image, results[1].image)
    assert not np.array_equal(results[0].image, model.sample((100, 90), seed=4).image)
    assert all(p.corners[0].shape == (40, 40) and p.corners[0].any() for p in looked_at)
    assert max(p.top for p in looked_at) > 60 and max(p.left for p in looked_at) > 100
    source = results[0].source
    assert mask[source[..., 0], source[..., 1]].all()
    # The chessboard goes on across seams: every pixel is as it is 8 pixels before.
    image = results[0].image.astype(int)
    assert (abs(image[8:] - image[:-8]) < 32).mean() > 0.9


def test_a_mask_without_room_is_an_error_for_a_given_patch_only():
    mask = np.zeros((30, 31), bool)
    mask[::2] = True
    exemplar = weftex.Exemplar(noise((30, 31), values=4), mask=mask)
    refused("patch_size is 2; no patch", GraphCut(patch_size=2).fit, exemplar)
    model = GraphCut().fit(exemplar)
    assert model.method.patch_size == 1
    assert mask[model.sample(20, seed=1).source[..., 0].ravel(), 0].all()


def test_defaults_follow_from_the_sample():
    method = GraphCut().fit(weftex.Exemplar(noise((100, 120), values=4))).method
    assert (method.patch_size, method.boundary_width) == (45, 15)


@pytest.mark.parametrize("placement", ["subpatch", "entire", "random"])
def test_provenance_has_the_shape_of_patches(placement):
    exemplar = weftex.Exemplar(noise((40, 50), values=4))
    model = GraphCut(placement=placement).fit(exemplar)
    assert model.method == GraphCut(placement=placement).resolved(exemplar)
    expected = [18, 18] if placement == "subpatch" else [40, 40]  # as far as the canvas goes
    about = model.sample((60, 40), seed=1).provenance
    assert about["patch_shape"] == expected
    if placement == "subpatch":
        assert (about["patch_size"], about["boundary_width"]) == (18, 6)


@pytest.mark.parametrize("seed", [1, 3])
@pytest.mark.parametrize("kind", ["plain", "x", "xy", "hole", "wrapped hole"])
def test_cuts_that_end_early_and_updated_runs_change_nothing(kind, seed, monkeypatch):
    compared = []

    def cheapest(self, patches, map_=map):
        costs = []
        for patch in patches:
            self._least = np.inf
            costs.append(self.cost(patch))
        filling, chosen = self.filling, whole(self, patches, map_)
        assert costs[patches.index(chosen)] <= max(min(costs), (1.4 if filling else 1) * min(costs))
        compared.append(max(costs) > min(costs))
        return chosen

    def pasted(self, patch):
        covered, kept = paste(self, patch), self.runs.copy()
        find_runs(self.labeling)
        assert np.array_equal(self.runs, kept)
        return covered

    whole, paste = CutCanvas.cheapest, CutCanvas.paste
    monkeypatch.setattr(CutCanvas, "cheapest", cheapest)
    monkeypatch.setattr(CutCanvas, "paste", pasted)
    pixels = np.ascontiguousarray(weftex.load_exemplar("sample:pebbles").pixels[40:90, 50:90])
    model = GraphCut(placement="entire", halvings=2, refinements=1.0).fit(weftex.Exemplar(pixels))
    made = model.sample(canvas_of(kind, pixels, (61, 70)), seed=seed)
    assert made.canvas.hole is not None or sum(compared) > 3
