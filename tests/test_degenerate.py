"""Degenerate inputs are cases, not accidents: each works, or raises a WeftError."""

import itertools

import numpy as np
import pytest

import weft

METHODS = list(weft.METHODS)
SEARCHES = ("exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca")
WRAPS = list(itertools.product([False, True], repeat=2))


def check(result, exemplar, size):
    """A whole picture of the sample's kind, all of it from the sample."""
    assert result.image.shape == (*size, *exemplar.pixels.shape[2:])
    assert result.image.dtype == exemplar.pixels.dtype
    source = result.source
    assert (source >= 0).all() and (source < exemplar.shape).all()
    if exemplar.mask is not None:
        assert exemplar.mask[source[..., 0], source[..., 1]].all()


def attempt(method, exemplar, canvas, **parameters):
    """Run, or raise a WeftError of one line; True if there is a picture."""
    try:
        result = weft.METHODS[method](**parameters).fit(exemplar).sample(canvas, seed=3)
    except weft.WeftError as error:
        assert str(error) and "\n" not in str(error)
        return False
    check(result, exemplar, canvas.shape)
    return True


def noise(*shape):
    return np.random.default_rng(8).integers(0, 256, shape).astype(np.uint8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("value", [0, 1, 128, 255])
@pytest.mark.parametrize("patch_size", [1, 2, 7, 8])
def test_constant_samples(method, search, value, patch_size):
    exemplar = weft.Exemplar(np.full((20, 22, 3), value, np.uint8))
    for wrap in ((False, False), (True, True)):
        canvas = weft.Canvas(24, 21, wrap)
        model = weft.METHODS[method](search=search, patch_size=patch_size).fit(exemplar)
        result = model.sample(canvas, seed=1)
        check(result, exemplar, canvas.shape)
        assert (result.image == value).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 2), (2, 1), (1, 30), (30, 1), (2, 2), (3, 3), (4, 4)]
)
@pytest.mark.parametrize("tileable", [False, True])
def test_tiny_samples(method, shape, tileable):
    exemplar = weft.Exemplar(noise(*shape), tileable=tileable)
    works = [
        attempt(method, exemplar, weft.Canvas(*size, wrap), **parameters)
        for size in ((1, 1), (5, 7))
        for wrap in ((False, False), (True, True))
        for parameters in ({}, {"patch_size": 1}, {"patch_size": 2}, {"patch_size": 3})
    ]
    # A window must fit the sample, whether it tiles or not; one of 3 single pixels need too.
    parameters = itertools.cycle([3, 3, 2, 3])
    assert works == [min(shape) >= next(parameters) for _ in works]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("patch_size", [2, 3, 8, 16])
def test_a_sample_of_one_patch(method, search, patch_size):
    """One window: every patch is the same one, whatever the search."""
    exemplar = weft.Exemplar(noise(patch_size, patch_size, 3))
    model = weft.METHODS[method](search=search, patch_size=patch_size).fit(exemplar)
    for wrap in WRAPS:
        result = model.sample(weft.Canvas(20, 21, wrap), seed=1)
        check(result, exemplar, (20, 21))
        assert (result.placements[:, 2:4] == 0).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("patch_size", [1, 6])
def test_tiny_canvases(method, search, patch_size):
    exemplar = weft.Exemplar(noise(20, 22, 3))
    model = weft.METHODS[method](search=search, patch_size=patch_size).fit(exemplar)
    for size in ((1, 1), (1, 2), (2, 1), (2, 2), (1, 40), (40, 1), (3, 3), (6, 6), (7, 5)):
        for wrap in WRAPS:
            check(model.sample(weft.Canvas(*size, wrap), seed=1), exemplar, size)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("channels", [1, 2, 7, 16, 40])
@pytest.mark.parametrize("search", SEARCHES)
def test_many_channels(method, channels, search):
    exemplar = weft.Exemplar(noise(24, 24, channels))
    assert attempt(method, exemplar, weft.Canvas(30, 30), search=search, patch_size=8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("patch_size, width", [(2, 1), (12, 6), (13, 6), (24, 12), (1, 11)])
@pytest.mark.parametrize("search", SEARCHES)
def test_huge_boundaries(method, patch_size, width, search):
    exemplar = weft.Exemplar(noise(24, 24))
    for wrap in ((False, False), (True, True)):
        for size in ((25, 25), (13, 40), (30, 7)):
            assert attempt(
                method, exemplar, weft.Canvas(*size, wrap),
                patch_size=patch_size, boundary_width=width, search=search,
            )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tileable", [False, True])
@pytest.mark.parametrize(
    "parameters",
    [{"patch_size": 10**6}, {"patch_size": 10**9}, {"patch_size": 10**30},
     {"boundary_width": 10**9}, {"patch_size": 1, "boundary_width": 10**9}],
    ids=str,
)  # fmt: skip
def test_absurd_parameters_are_refused_before_work_starts(method, tileable, parameters):
    exemplar = weft.Exemplar(noise(24, 24), tileable=tileable)
    with pytest.raises(weft.InvalidInputError):
        weft.METHODS[method](**parameters).fit(exemplar)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("colours", [1, 2])
def test_two_colours(method, colours):
    exemplar = weft.Exemplar(((noise(30, 30) % colours) * 255).astype(np.uint8))
    for search in SEARCHES:
        assert attempt(method, exemplar, weft.Canvas(40, 40), patch_size=8, search=search)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("patch_size", [1, 6])
def test_holes_of_nothing_and_of_everything(method, patch_size):
    exemplar = weft.Exemplar(noise(20, 20, 3))
    model = weft.METHODS[method](patch_size=patch_size).fit(exemplar)
    known = noise(15, 16, 3)
    nothing = model.sample(weft.Canvas(15, 16, known=known, hole=np.zeros((15, 16), bool)), seed=1)
    assert np.array_equal(nothing.image, known)
    everything = model.sample(
        weft.Canvas(15, 16, known=known, hole=np.ones((15, 16), bool)), seed=1
    )
    check(everything, exemplar, (15, 16))


@pytest.mark.parametrize("method", METHODS)
def test_masks_with_one_window(method):
    mask = np.zeros((30, 30), bool)
    mask[11:17, 7:13] = True
    exemplar = weft.Exemplar(noise(30, 30), mask=mask)
    for search in SEARCHES:
        assert attempt(method, exemplar, weft.Canvas(20, 20), patch_size=6, search=search)
    assert not attempt(method, exemplar, weft.Canvas(20, 20), patch_size=7)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("value", [0.0, -1.0, 1e-30, 1e30, 1e300, -1e300])
def test_constant_floats(method, value):
    exemplar = weft.Exemplar(np.full((20, 20), value))
    result = weft.METHODS[method](patch_size=6).fit(exemplar).sample(30, seed=1)
    assert (result.image == value).all()


@pytest.mark.parametrize("method", METHODS)
def test_wild_floats(method):
    pixels = noise(20, 20).astype(float)
    pixels[3, 4], pixels[7, 7] = 1e308, -1e308
    with np.errstate(over="ignore"):
        assert attempt(method, weft.Exemplar(pixels), weft.Canvas(30, 30), patch_size=6)


@pytest.mark.parametrize("method", METHODS)
def test_arrays_of_any_layout(method):
    pixels = noise(20, 20, 3)
    frozen = pixels.copy()
    frozen.flags.writeable = False
    expected = None
    for view in (pixels, np.asfortranarray(pixels), frozen, pixels[::-1][::-1], [[1, 2], [3, 4]]):
        try:
            result = weft.synthesize(view, 30, method=method, seed=1, patch_size=6)
        except weft.WeftError:
            assert isinstance(view, list)
            continue
        expected = result.image if expected is None else expected
        assert np.array_equal(result.image, expected)


@pytest.mark.parametrize(
    "sample", [None, 5, "", "no/such/file.png", "sample:no-such", [[1, 2], [3]], {}, b"x", object()]
)
def test_samples_that_are_none(sample):
    with pytest.raises(weft.WeftError):
        weft.synthesize(sample, 30, seed=1)


def test_the_sample_is_not_changed():
    pixels = noise(30, 30, 3)
    before = pixels.copy()
    for blend in ("feather", "cut"):
        weft.synthesize(pixels, 40, seed=1, patch_size=8, blend=blend)
    assert np.array_equal(pixels, before)
    hole = np.zeros((30, 30), bool)
    hole[5:9, 5:9] = True
    canvas = weft.Canvas(30, 30, known=pixels, hole=hole)
    result = weft.synthesize(noise(20, 20, 3), canvas, seed=1, patch_size=8)
    result.image[:] = 0
    assert np.array_equal(pixels, before)
