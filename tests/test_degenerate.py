"""Degenerate inputs are cases, not accidents: each works, or raises a WeftexError."""

import itertools

import numpy as np
import pytest

import weftex
from families import SEARCHES, TRIALS, every, kinds_of, method_of, noise, refused

WRAPS = list(itertools.product([False, True], repeat=2))


def wraps_of(method):
    """The ways around that a method supports."""
    return WRAPS if "xy" in kinds_of(method) else WRAPS[:1]


def check(result, exemplar, size):
    """A whole picture of the sample's kind, all of it from the sample."""
    assert result.image.shape == (*size, *exemplar.pixels.shape[2:])
    assert result.image.dtype == exemplar.pixels.dtype
    source = result.source
    assert (source >= 0).all() and (source < exemplar.shape).all()
    if exemplar.mask is not None:
        assert exemplar.mask[source[..., 0], source[..., 1]].all()


def attempt(method, exemplar, canvas, **parameters):
    """Run, or raise a WeftexError of one line; True if there is a picture."""
    try:
        result = weftex.METHODS[method](**parameters).fit(exemplar).sample(canvas, seed=3)
    except weftex.WeftexError as error:
        assert str(error) and "\n" not in str(error)
        return False
    check(result, exemplar, canvas.shape)
    return True


# Patches


@every("method", family="patch")
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("patch_size", [2, 3, 8, 16])
def test_a_sample_of_one_patch(method, search, patch_size):
    """One window: every patch is the same one, whatever the search."""
    exemplar = weftex.Exemplar(noise((patch_size, patch_size, 3)))
    model = weftex.METHODS[method](search=search, patch_size=patch_size).fit(exemplar)
    for wrap in WRAPS:
        result = model.sample(weftex.Canvas(20, 21, wrap), seed=1)
        check(result, exemplar, (20, 21))
        assert (result.placements[:, 2:4] == 0).all()


@every("method", family="patch")
@pytest.mark.parametrize("patch_size, width", [(2, 1), (12, 6), (13, 6), (24, 12), (1, 11)])
@pytest.mark.parametrize("search", SEARCHES)
def test_huge_boundaries(method, patch_size, width, search):
    exemplar = weftex.Exemplar(noise((24, 24)))
    sizes = ((25, 25), (13, 40), (30, 7)) if patch_size > 1 else ((9, 13),)
    for wrap in ((False, False), (True, True)):
        for size in sizes:
            assert attempt(
                method, exemplar, weftex.Canvas(*size, wrap),
                patch_size=patch_size, boundary_width=width, search=search,
            )  # fmt: skip


@pytest.mark.parametrize(
    "method, parameters",
    [
        ("refinement", {"init": "seeds", "seed_scale": 1e308, "seed_density": 0.5}),
        ("refinement", {"init": "seeds", "seed_scale": 9.3e18}),
        ("wei-levoy", {"leaves": 2**62}),
        ("graphcut", {"tolerance": 5e-324}),
    ],
)
def test_the_ends_of_ranges_work(method, parameters):
    sample = weftex.Exemplar(noise((24, 24)))
    assert attempt(method, sample, weftex.Canvas(30, 30), **parameters)
    hole = np.zeros((24, 24), bool)
    hole[9:12, 9:14] = True
    weftex.fill(sample, hole, method=method, seed=1, **parameters)


# Every method


@every("method")
@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 2), (2, 1), (1, 30), (30, 1), (2, 2), (3, 3), (4, 4), (7, 5)]
)
@pytest.mark.parametrize("tileable", [False, True])
def test_defaults_work_on_tiny_samples(method, shape, tileable):
    """Windows shrink to fit; patches need three pixels."""
    exemplar = weftex.Exemplar(noise(shape), tileable=tileable)
    works = [
        attempt(method, exemplar, weftex.Canvas(*size, wrap))
        for size in ((1, 1), (5, 7))
        for wrap in wraps_of(method)
    ]
    assert set(works) == {min(shape) >= TRIALS[method].least}


@every("method", "way")
def test_tiny_canvases_in_every_way(method, way):
    exemplar = weftex.Exemplar(noise((20, 22, 3)))
    model = method_of(method, way).fit(exemplar)
    sizes = ((1, 1), (1, 2), (2, 1), (2, 2), (1, 40), (40, 1), (3, 3), (6, 6), (7, 5))
    wraps = [] if method == "best-tile" else wraps_of(method)  # tiles stay whole
    for number, size in enumerate(sizes):
        for wrap in wraps[number % 2 :: 2] or [(False, False)]:
            check(model.sample(weftex.Canvas(*size, wrap), seed=1), exemplar, size)


@every("method", "way")
def test_holes_of_nothing_everything_one_pixel_and_all_but_one(method, way):
    if "hole" not in kinds_of(method):
        return
    exemplar, known = weftex.Exemplar(noise((20, 20, 3))), noise((9, 8, 3))
    model = method_of(method, way).fit(exemplar)
    for alone in (False, True):
        holes = [np.full((9, 8), not alone) for _ in range(4)]
        for hole, place in zip(holes, ((0, 0), (4, 4), (8, 7)), strict=False):
            hole[place] = alone
        for hole in holes:
            result = model.sample(weftex.Canvas(9, 8, known=known, hole=hole), seed=1)
            assert np.array_equal(result.image[~hole], known[~hole])
            at = result.source[hole]
            assert (at >= 0).all() and (at < 20).all()
            if hole.all():
                check(result, exemplar, (9, 8))


@every("method", "way")
@pytest.mark.parametrize("tileable", [False, True])
def test_masks_that_leave_few_windows(method, way, tileable):
    """What is not usable is never copied, and a mask without a whole window is refused."""
    mask = np.zeros((30, 30), bool)
    mask[11:22, 7:18] = True
    mask[15, 17] = False
    exemplar = weftex.Exemplar(noise((30, 30)), mask=mask, tileable=tileable)
    model = method_of(method, way).fit(exemplar)
    for wrap in wraps_of(method)[tileable::2] or [(False, False)]:
        check(model.sample(weftex.Canvas(20, 18, wrap), seed=1), exemplar, (20, 18))
    stripes = weftex.Exemplar(noise((30, 30)), mask=np.indices((30, 30))[1] % 4 == 0)
    trial = TRIALS[method]
    if "single" not in way and trial.window in trial.small | trial.ways[way]:
        refused("lies (in|on) .*usable", method_of(method, way).fit, stripes)


@every("method")
def test_arrays_of_any_layout(method):
    pixels = noise((20, 20, 3))
    frozen = pixels.copy()
    frozen.flags.writeable = False
    expected = None
    for view in (pixels, np.asfortranarray(pixels), frozen, pixels[::-1][::-1], [[1, 2], [3, 4]]):
        try:
            result = weftex.synthesize(view, 30, method=method_of(method), seed=1)
        except weftex.WeftexError:
            assert isinstance(view, list)
            continue
        expected = result.image if expected is None else expected
        assert np.array_equal(result.image, expected)
