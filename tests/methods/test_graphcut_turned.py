"""Entire patches of a sample and of copies that are turned."""

from types import SimpleNamespace

import numpy as np
import pytest

import weftex
from twins.salience import copy_sums, price_sums
from weftex.exemplar.turns import copies_in
from weftex.raster.turning import TURNS, turned_pixels
from weftex.repeats import Repetition
from weftex.repeats.salience import SaliencePenalty, cell_side


def laid(sample, size=(330, 300), **given):
    given = {"method": "graphcut", "placement": "entire", "seed": 3} | given
    return weftex.synthesize(sample, size, **given)


@pytest.mark.parametrize("turn", list(TURNS))
@pytest.mark.parametrize("shape", [(192, 192), (192, 140), (40, 190)])
def test_every_patch_is_of_one_copy(turn, shape):
    """The joint line between two copies, which are beside each other, is never shown."""
    pebbles = weftex.read_image("sample:pebbles").pixels
    sample = weftex.prepare.turned(pebbles[: shape[0], : shape[1]], turn)
    result = laid(sample)
    y, x = np.moveaxis(result.pictured_source(), -1, 0)
    assert sample.mask[y, x].all()
    copy_of = np.full(sample.shape, -1)
    for number, (top, left, height, width) in enumerate(copies_in(sample)):
        copy_of[top : top + height, left : left + width] = number
    shown, counts = np.unique(copy_of[y, x], return_counts=True)
    assert len(shown) > 1 and counts.max() < 0.98 * y.size


@pytest.mark.parametrize("turn", [None, "half", "8"])
def test_what_copies_would_repeat_is_summed_as_defined(turn, rng):
    sample = weftex.Exemplar(rng.integers(0, 255, (24, 22, 3), np.uint8))
    sample = sample if turn is None else weftex.prepare.turned(sample, turn)
    boxes = copies_in(sample) if turn else [(0, 0, *sample.shape)]
    usable = np.flatnonzero(sample.mask if turn else np.ones(528)).astype(np.int32)
    source = np.where(rng.random((33, 40)) < 0.6, np.int32(-1), rng.choice(usable, (33, 40)))
    canvas, side = weftex.Canvas(33, 40, wrap=(True, False)), cell_side(boxes)
    output = SimpleNamespace(canvas=canvas, source=source, done=(source >= 0).astype(np.uint8))
    small, policy = sample.pixels[:24:side, :22:side], Repetition(1.0, nearby=0.4, use=0.05)
    penalty = SaliencePenalty(policy, sample, output, boxes, (small, np.ones(small.shape[:2])), 22)
    for pixel in ((0, 3), (32, 25)):
        first, size = np.array([1, 0]), np.array([2, 3])
        found = penalty.sums(pixel, len(boxes), first, size)
        assert found[:, [0, 3, 4]].any()
        np.testing.assert_array_equal(found, copy_sums(penalty, boxes, pixel, first, size))
        penalty.look(pixel)
        patch = [(pixel[0] + np.arange(19, dtype=np.int32)) % 33, np.arange(9, 28, dtype=np.int32)]
        patch += [np.arange(1, 20, dtype=np.int32), np.arange(2, 21, dtype=np.int32)]
        repeats, places = price_sums(penalty, *patch)
        assert repeats.any() and places.any()
        mean = max((source[::side, ::side] >= 0).sum() / (penalty.cells.shape[1] - 1), 1)
        prices = np.rint(3.3 / (2 * 64 * 16) * repeats + 1.1 / mean * places)
        np.testing.assert_array_equal(penalty.prices(patch), prices)


def test_nothing_meets_its_mirror_image():
    """What lies across a seam from a thing is not that thing in a mirror."""
    sample = weftex.prepare.turned("sample:pebbles", "flip")
    height, width = weftex.read_image("sample:pebbles").pixels.shape[:2]
    own = np.arange(height * width).reshape(height, width)
    result = laid(sample, size=(400, 400))
    y, x = np.moveaxis(result.pictured_source(), -1, 0)
    place = turned_pixels(own, "flip")[y, x]
    column, row = place % width, place // width
    mirrored = x > width
    beside = mirrored[:, 1:] != mirrored[:, :-1]
    apart = np.abs(np.diff(column, axis=1)) + np.abs(np.diff(row, axis=1))
    assert beside.sum() > 100
    assert (apart[beside] < 8).mean() < 0.1


@pytest.mark.parametrize(("orientations", "turn"), [("half-turns", "half"), ("all", "8")])
def test_copies_are_laid_by_name_and_replayed(orientations, turn, tmp_path):
    result = laid("sample:leaves", orientations=orientations, seed=4)
    assert result.provenance["orientations"] == orientations
    assert result.turn == turn
    leaves = weftex.prepare.turned("sample:leaves", turn)
    np.testing.assert_array_equal(result.image, laid(leaves, seed=4).image)
    half = leaves.copy_shape[1]
    share = (result.pictured_source()[..., 1] > half).mean()
    assert 0.02 < share < 0.98
    result.save(tmp_path / "r.npz")
    again = weftex.Synthesis.load(tmp_path / "r.npz", weftex.load_exemplar("sample:leaves"))
    np.testing.assert_array_equal(again.image, result.image)


def test_wrapped_and_larger_and_smaller_canvases():
    """With any number of threads, and without a cost of repeats."""
    for size, tileable, variety in (
        ((90, 400), True, 1),
        ((40, 40), False, 0),
        ((300, 99), "x", 1),
    ):
        way = {"size": size, "tileable": tileable, "variety": variety}
        one, other = (
            laid("sample:leaves", orientations="half-turns", threads=threads, **way)
            for threads in (1, 3)
        )
        assert one.image.shape[:2] == size and (one.source >= 0).all()
        np.testing.assert_array_equal(one.image, other.image)


def test_what_cannot_be_turned_is_refused():
    with pytest.raises(weftex.InvalidInputError, match="orientations .*placement"):
        weftex.GraphCut(orientations="half-turns")
    with pytest.raises(weftex.InvalidInputError, match="give lattice or orientations, not both"):
        laid("sample:tiles", orientations="half-turns", lattice=(31, 0, 0, 102))
    with pytest.raises(weftex.InvalidInputError, match="half-turns'; holes are filled with"):
        pebbles = weftex.read_image("sample:pebbles").pixels
        hole = np.zeros(pebbles.shape[:2], bool)
        hole[50:90, 60:90] = True
        turned = {"placement": "entire", "orientations": "half-turns"}
        weftex.fill(pebbles, hole, method="graphcut", seed=1, **turned)
    with pytest.raises(weftex.InvalidInputError, match="already consists of rotated copies"):
        laid(weftex.prepare.turned("sample:pebbles", "4"), orientations="half-turns")


def test_auto_turns_what_has_no_way_up_and_all_else_goes_on(tmp_path):
    """Reports, figures and replay take the sample as it was."""
    made = weftex.synthesize("sample:leaves", 300, seed=3, landmarks="keep")
    assert made.provenance["orientations"] == "all"
    assert "the same from all sides" in made.provenance["reason"]
    names = ("method", "placement", "orientations", "seed")
    again = weftex.synthesize("sample:leaves", 300, **{k: made.provenance[k] for k in names})
    np.testing.assert_array_equal(again.image, made.image)
    leaves = weftex.load_exemplar("sample:leaves")
    assert weftex.assess(leaves, made).score == weftex.pages.report(leaves, made).assessment.score
    for name, way in (("pebbles", "upright"), ("wood", "half-turns")):
        choice = weftex.Auto().fit(weftex.load_exemplar(f"sample:{name}")).choose(300)
        assert choice.parameters.get("orientations", "upright") == way
