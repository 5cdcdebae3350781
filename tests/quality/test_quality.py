"""Measures rank known degradations below a real picture of the same surface, and are defined."""

import dataclasses
import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import weftex
from weftex.errors import InvalidInputError
from weftex.exemplar import Exemplar
from weftex.quality.assess import Assessment, assess, real_crops
from weftex.quality.figures import FIGURES
from weftex.quality.score import Scorer
from weftex.quality.seams import seams, wrap_seam

SAMPLES = Path(__file__).parents[2] / "examples" / "samples"
SURFACES = ["cobbles", "gingham", "shingles", "boards"]


@cache
def surface(name):
    """Two disjoint pictures of one surface, (128, 256, 3) each."""
    pixels = weftex.load_exemplar(SAMPLES / f"{name}.png").pixels
    return np.ascontiguousarray(pixels[:128]), np.ascontiguousarray(pixels[128:])


def blurred(pixels):
    levels = pixels.astype(float)
    for axis in (0, 1):
        levels = sum(np.roll(levels, k, axis) for k in range(-2, 3)) / 5
    return np.rint(levels).astype(np.uint8)


def hard_patches(pixels, rng, side=32):
    """Squares from anywhere, side by side."""
    result = np.empty((192, 256, *pixels.shape[2:]), pixels.dtype)
    for y in range(0, 192, side):
        for x in range(0, 256, side):
            top, left = (rng.integers(0, s - side + 1) for s in pixels.shape[:2])
            result[y : y + side, x : x + side] = pixels[top : top + side, left : left + side]
    return result


def shuffled(pixels, rng, side=32):
    rows, columns = pixels.shape[0] // side, pixels.shape[1] // side
    blocks = pixels[: rows * side, : columns * side].reshape(rows, side, columns, side, -1)
    blocks = blocks.swapaxes(1, 2).reshape(rows * columns, side, side, -1)
    blocks = blocks[rng.permutation(len(blocks))].reshape(rows, columns, side, side, -1)
    return blocks.swapaxes(1, 2).reshape(rows * side, columns * side, *pixels.shape[2:])


DEGRADED = {
    "plain repetition": lambda a, b, rng: np.tile(a[:, :128], (2, 2, 1)),
    "hard patches": lambda a, b, rng: hard_patches(a, rng),
    "blur": lambda a, b, rng: blurred(b),
    "noise": lambda a, b, rng: rng.permutation(b.reshape(-1, 3)).reshape(b.shape),
    "shuffled": lambda a, b, rng: shuffled(b, rng),
}


@cache
def measured(name, what):
    first, second = surface(name)
    rng = np.random.default_rng(7)
    picture = second if what == "real" else DEGRADED[what](first, second, rng)
    return assess(first, picture)


@pytest.mark.parametrize("name", SURFACES)
def test_a_real_picture_is_better_than_degraded_ones(name):
    real = measured(name, "real")
    assert [what for what in DEGRADED if measured(name, what).score <= real.score] == []


@pytest.mark.parametrize("name", SURFACES)
def test_each_figure_detects_its_fault(name):
    real = measured(name, "real")
    bad = {what: measured(name, what) for what in DEGRADED}
    assert bad["noise"].patches > 1.5 * real.patches
    assert bad["hard patches"].seams > 1.5 * real.seams
    assert bad["shuffled"].seams > 1.5 * real.seams
    assert bad["blur"].sharpness < 0.5 < real.sharpness < 1.5 < bad["noise"].sharpness


def test_hardly_any_degraded_picture_passes():
    faults = [what for what in DEGRADED if what != "plain repetition"]  # only the score detects it
    passed = [(n, what) for n in SURFACES for what in faults if not measured(n, what).flags]
    assert len(passed) <= 1, passed
    assert [n for n in SURFACES if measured(n, "real").flags] == []


def test_order_is_seen_where_there_is_some():
    real, bad = measured("gingham", "real"), measured("gingham", "shuffled")
    assert bad.lattice < 0.5 < 0.8 < real.lattice < 1.2
    assert measured("gingham", "hard patches").lattice < 0.5
    assert measured("gingham", "noise").autocorrelation > 2 * real.autocorrelation
    first, _ = surface("gingham")
    repeated = np.tile(first[:, :169], (2, 2, 1))  # twice its period of 84.5 pixels
    assert assess(first, repeated).lattice > 0.8
    assert measured("cobbles", "real").lattice is None


def test_colors(rng):
    first, second = surface("cobbles")
    real = measured("cobbles", "real")
    other = assess(first, np.minimum(second, 235) + np.uint8(20))
    assert other.color > 2 * real.color
    assert "color" in other.flags and "other colors" in other.verdict()
    gray = assess(first[..., 0], second[..., 0])
    noise = assess(first[..., 0], rng.permutation(second[..., 0].ravel()).reshape(128, 256))
    assert gray.color is not None and gray.score < noise.score


def test_made_by_weft_is_good_and_says_where_from(rng):
    sample = weftex.load_exemplar("sample:pebbles")
    made = weftex.synthesize(sample, 192, method="quilting", seed=1, tileable=True)
    found = assess(sample, made)
    assert found == assess(sample, made.image, tileable=True)
    assert found.flags == () and found.verdict().startswith("Good")
    assert found.score < assess(sample, hard_patches(sample.pixels, rng)).score
    assert found.wrap < 0.1
    assert assess(sample, sample.pixels).flags == ()
    json.dumps(found.as_dict(), allow_nan=False)


def test_the_wrap_is_judged_axis_by_axis():
    sample = weftex.load_exemplar("sample:pebbles")
    made = weftex.synthesize(sample, 160, method="quilting", seed=1, tileable="x").image
    scorer = Scorer(sample)
    model, result = scorer.steps, scorer.view(made)
    assert wrap_seam(model, result, (False, True)) < 0.1
    assert wrap_seam(model, result, (True, False)) > 0.3
    assert wrap_seam(model, result, (True, True)) == wrap_seam(model, result, (True, False))
    assert wrap_seam(model, result, (False, False)) is None


@pytest.mark.parametrize("axis", [0, 1])
def test_a_seam_is_found(axis):
    pixels = weftex.load_exemplar("sample:grass").pixels[:128, :128]
    pieces = np.split(pixels, [50], axis)
    cut = np.concatenate([pieces[1], pieces[0]], axis)  # the seam lies after 78 lines
    scorer = Scorer(Exemplar(pixels))
    made = scorer.view(np.ascontiguousarray(cut))
    assert seams(scorer.steps, made) > 1.5 * seams(scorer.steps, scorer.own)


def test_a_thing_that_the_sample_lacks_is_marked_where_it_is():
    sample = weftex.load_exemplar("sample:tiles")
    picture = sample.pixels.copy()
    picture[100:140, 60:120] = picture[100:140, 60:120].mean(axis=(0, 1))
    scorer = Scorer(sample)
    found, whole = (scorer.broken_map(scorer.view(one)) for one in (picture, sample.pixels))
    assert found.shape == sample.shape and whole.max() == 0
    inside = found[100:140, 60:120].mean()
    assert inside > 4 * found[:, 200:].mean() and assess(sample, picture).broken > 0


def test_depths_are_alike():
    first, second = surface("cobbles")
    wide = assess(first.astype(np.uint16) * 257, second.astype(np.uint16) * 257)
    assert wide.as_dict() == measured("cobbles", "real").as_dict()


@pytest.mark.parametrize(
    "own, made",
    [
        ((1, 1), (1, 1)),
        ((1, 1), (40, 33)),
        ((1, 40), (50, 1)),
        ((3, 3), (5, 6)),
        ((7, 9), (31, 31)),
        ((20, 20), (20, 20)),
        ((33, 36), (1, 1)),
        ((33, 36), (5, 40)),
        ((33, 36), (31, 40)),
    ],
)
@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.filterwarnings("error")
def test_small_and_flat_pictures_give_none_and_no_warning(own, made, plain, rng):
    colors = 1 if plain else 256
    sample = rng.integers(0, colors, (*own, 3), np.uint8)
    result = rng.integers(0, colors, (*made, 3), np.uint8)
    found = assess(sample, result, tileable=True)
    real_crops(Exemplar(sample))
    values = [v for v in dataclasses.asdict(found).values() if isinstance(v, float)]
    assert np.isfinite(values).all()
    assert found.verdict()
    if plain:
        assert found.color in (0, None) and found.sharpness in (1, None)


@pytest.mark.filterwarnings("error")
def test_masks_hide_what_is_under_them(rng):
    pixels = surface("cobbles")[0].copy()
    mask = np.ones(pixels.shape[:2], bool)
    mask[40:60, 100:130] = False
    other = pixels.copy()
    other[~mask] = rng.integers(0, 256, (int((~mask).sum()), 3))
    result = surface("cobbles")[1]
    found = assess(Exemplar(pixels, mask=mask), result)
    assert found == assess(Exemplar(other, mask=mask), result)
    assert found.score < measured("cobbles", "noise").score
    few = np.zeros_like(mask)
    few[3, 4] = True
    assert assess(Exemplar(pixels, mask=few), result).patches is None


def test_of_a_large_result_the_middle_is_looked_at(rng):
    sample = rng.integers(0, 256, (16, 16, 3), np.uint8)
    result = rng.integers(0, 256, (20, 2100, 3), np.uint8)
    assert assess(sample, result) == assess(sample, result[:, 26 : 26 + 2048])


def test_what_does_not_go_together_is_refused():
    sample = np.zeros((20, 20, 3), np.uint8)
    with pytest.raises(InvalidInputError, match="uint8 with 1 channels, the sample uint8 with 3"):
        assess(sample, np.zeros((9, 9), np.uint8))
    with pytest.raises(InvalidInputError, match="float32 with 3 channels"):
        assess(sample, np.zeros((9, 9, 3), np.float32))


def test_every_figure_is_described():
    fields = {field.name for field in dataclasses.fields(Assessment)}
    assert set(FIGURES) == fields - {"flags", "score"}
    for name, figure in FIGURES.items():
        assert (figure.limit is None) == (figure.good == "") == (figure.within() == "")
        if figure.limit is not None:
            assert figure.badness(figure.limit) == pytest.approx(1)
            text = Assessment(**{name: figure.limit}, flags=(name,), score=2.0).verdict()
            assert figure.fault(figure.limit) in text
    assert Assessment().verdict() == "Too small to be judged."
    assert FIGURES["sharpness"].fault(0.5) == "is blurred"
    assert FIGURES["sharpness"].fault(1.5).startswith("is noisier")
