"""What holds for every method on every kind of canvas it declares; see `families`."""

import pickle

import numpy as np
import pytest

import weftex
from families import FORMATS, SEARCHES, TRIALS, canvas_of, every, kinds_of, made, method_of, noise
from weftex.results import paste_kernels


def make(method, pixels, kind, way=None, *, seed=7, threads=None, size=(40, 37), **parameters):
    exemplar = pixels if isinstance(pixels, weftex.Exemplar) else weftex.Exemplar(pixels)
    model = method_of(method, way, **parameters).fit(exemplar)
    canvas = canvas_of(kind, exemplar.pixels, size)
    return model.sample(canvas, seed=seed, threads=threads)


def shape_of(channels):
    return (30, 31) if channels is None else (30, 31, channels)


def pebbles(side):
    return weftex.Exemplar(weftex.load_exemplar("sample:pebbles").pixels[:side, :side])


def same(one, other):
    return np.array_equal(one.image, other.image) and np.array_equal(one.source, other.source)


def test_every_method_has_a_trial():
    missing = sorted(set(weftex.METHODS) - set(TRIALS))
    assert not missing, f"say in TRIALS of tests/families.py how to try {', '.join(missing)}"


@every("method", "kind", "way", "dtype")
def test_constant_in_constant_out(method, kind, way, dtype):
    value = np.array([3, 200, 77, 255]).astype(dtype)
    if np.dtype(dtype).kind == "f":
        value = value / dtype(255)
    elif dtype == np.uint16:
        value = value * dtype(257)
    pixels = np.broadcast_to(value, (20, 22, 4)).copy()
    canvas = canvas_of(kind, pixels)
    if canvas.hole is not None:
        known = np.broadcast_to(value, (*canvas.shape, 4)).copy()
        canvas = weftex.Canvas(*canvas.shape, canvas.wrap, known=known, hole=canvas.hole)
    image = method_of(method, way).fit(weftex.Exemplar(pixels)).sample(canvas, seed=1).image
    assert np.array_equal(image, np.broadcast_to(value, image.shape))


@every("method", "kind", "way", "dtype")
def test_a_copying_methods_picture_is_the_sample_at_its_source(method, kind, way, dtype):
    if not TRIALS[method].copies(way):
        return
    pixels = noise((30, 31, 3), dtype)
    plain = {} if canvas_of(kind, pixels).hole is not None else TRIALS[method].plain
    result = make(method, pixels, kind, way, **plain)
    source, where = result.source, made(result)
    assert (source[~where] == -1).all()
    assert (source[where] >= 0).all() and (source[where] < (30, 31)).all()
    assert np.array_equal(result.image[where], pixels[source[where][:, 0], source[where][:, 1]])
    # Any aligned map follows the same coordinates.
    height = noise((30, 31), np.uint16, seed=3)
    background = None if where.all() else np.zeros(result.shape, np.uint16)
    rendered = result.render(height, background=background)
    assert np.array_equal(rendered[where], height[source[where][:, 0], source[where][:, 1]])


@every("method", "kind")
def test_maps_travel_with_the_picture(method, kind):
    """Maps that are the picture itself come out as the picture, whatever is blended."""
    pixels = noise((30, 31, 3))
    canvas = canvas_of(kind, pixels)
    if canvas.hole is not None or kind == "guide":
        return  # `weftex.fill` does holes; a canvas's known pixels and its guide have no maps
    result = method_of(method).fit(weftex.Exemplar(pixels, maps={"same": pixels})).sample(canvas)
    assert np.array_equal(result.maps["same"], result.image)


@every("method", "kind", "way", kinds=("hole", "wrapped hole"))
@pytest.mark.parametrize(("dtype", "channels"), FORMATS)
def test_known_pixels_are_untouched(method, kind, way, dtype, channels):
    result = make(method, noise(shape_of(channels), dtype), kind, way)
    hole = result.canvas.hole
    assert np.array_equal(result.image[~hole], result.canvas.known[~hole])
    assert np.array_equal(result.render()[~hole], result.canvas.known[~hole])
    assert (result.source[hole] >= 0).all()


def border_against_inside(picture, axis):
    """Mean difference across the border, in spreads of the mean differences inside.

    Two neighboring lines of a smooth material differ little; the last line and the first one
    differ like any two, unless the picture wraps.
    """
    picture = np.moveaxis(picture.astype(float), axis, 0)
    steps = np.abs(np.roll(picture, -1, axis=0) - picture).reshape(len(picture), -1).mean(axis=1)
    inside, border = steps[:-1], steps[-1]
    return (border - inside.mean()) / inside.std()


@pytest.mark.pictures
@every("method", "real")
@pytest.mark.parametrize("name", ["pebbles", "grass", "wood"])
def test_a_wrapped_canvas_has_no_seam_at_its_border(method, real, name):
    """No line pair stands out; without wrapping, the same measure shows that one does."""
    if "wrap" not in weftex.METHODS[method].supports:
        return
    exemplar = weftex.load_exemplar(f"sample:{name}")
    patches = TRIALS[method].family == "patch"
    model = weftex.METHODS[method](**real).fit(exemplar)
    size = (150, 140) if patches else (TRIALS[method].largest - 4, TRIALS[method].largest - 11)
    wrapped, plain = [], []
    for seed in range(6 if patches else 2):
        ways = (True, False, "x", "y")
        made = {way: model.sample(size, seed=seed, tileable=way).image for way in ways}
        for axis, only, other in ((0, "y", "x"), (1, "x", "y")):
            wrapped += [border_against_inside(made[way], axis) for way in (True, only)]
            plain += [border_against_inside(made[way], axis) for way in (False, other)]
    # Lines inside a picture lie within three spreads; a patch border may be anywhere among them.
    assert np.mean(wrapped) < 3
    if method == "wei-levoy":  # it makes every canvas on a torus, so its border shows little
        assert np.mean(wrapped) < np.mean(plain)
        return
    assert np.mean(plain) > 3, "the measure must see a seam where there is one"
    assert np.mean(plain) > 3 * max(np.mean(wrapped), 0)


@every("method", family="patch")
@pytest.mark.parametrize("size", [(21, 21), (31, 45), (17, 60), (25, 33), (20, 20), (24, 41)])
@pytest.mark.parametrize("boundary_width", [2, 5, 8])
def test_small_wrapped_canvases_have_no_seam_inside_either(method, size, boundary_width):
    """On a smooth periodic sample every neighbor pair is near, in the middle and at the border."""
    y, x = np.indices((64, 64)) * (2 * np.pi / 16)
    smooth = np.rint(127 + 60 * np.sin(x) + 60 * np.sin(y)).astype(np.uint8)
    steepest = np.abs(np.diff(smooth.astype(int), axis=1)).max()
    model = weftex.METHODS[method](
        patch_size=16, boundary_width=boundary_width, search="exhaustive", repeat_distance=0.0,
        **({"epsilon": 0.0} if method == "patch-sampling" else {"tolerance": 0.0}),
    ).fit(weftex.Exemplar(smooth))  # fmt: skip
    whole = model.sample((48, 48), seed=1, tileable=True).image.astype(int)  # three periods
    for axis in (0, 1):
        assert np.abs(np.roll(whole, 1, axis) - whole).max() <= 2 * steepest
    result = model.sample(size, seed=1, tileable=True)
    # Every patch but the first has something to match: none is laid beside what it did not see.
    assert _unseen_borders(result) == 0


def _unseen_borders(result):
    """Neighboring pixels whose patches meet outside the zone that the later one was matched in."""
    height, length = result.shape
    owner = np.full((height, length, 4), -1, np.int32)
    share = np.zeros((height, length, 4), np.float32)
    layout = paste_kernels.Layout(result.placements, result.weights, result.cuts, *result.shape)
    paste_kernels.layer_all(owner, share, layout)
    owner = owner[..., 0]

    def looked(patch, y, x):
        top, left, _, _, zone = result.placements[patch].tolist()
        v, u = (y - top) % height, (x - left) % length
        weight = result.weights[zone]
        return v < weight.shape[0] and u < weight.shape[1] and 0 < weight[v, u] < 256

    count = 0
    for y, x in np.ndindex(height, length):
        for other in (((y + 1) % height, x), (y, (x + 1) % length)):
            later = max(owner[y, x], owner[other])
            if owner[y, x] != owner[other]:
                count += not (looked(later, y, x) or looked(later, *other))
    return count


@every("method", "kind", "way")
def test_another_seed_makes_other_bytes(method, kind, way):
    """With something wide, or the nearest is the only one to draw."""
    pixels, wide = noise((30, 31, 3)), TRIALS[method].wide
    one, other = (make(method, pixels, kind, way, seed=seed, **wide) for seed in (7, 8))
    assert method == "best-tile" or not np.array_equal(one.image, other.image)


def check_memory(model, canvases):
    """A model makes the same whatever it made before, and so do copies of it, new and used."""
    new = pickle.loads(pickle.dumps(model))
    first = {kind: model.sample(canvas, seed=1) for kind, canvas in canvases.items()}
    used = pickle.loads(pickle.dumps(model))
    for kind in reversed(canvases):
        assert same(new.sample(canvases[kind], seed=1), first[kind]), kind
    for kind in canvases:
        assert same(used.sample(canvases[kind], seed=1), first[kind]), kind


@every("method", "way")
def test_a_model_and_its_copies_do_not_remember(method, way):
    exemplar = pebbles(40)
    model = method_of(method, way).fit(exemplar)
    kinds = kinds_of(method, way)
    check_memory(model, {kind: canvas_of(kind, exemplar.pixels) for kind in kinds})


@every("method", family="patch")
@pytest.mark.parametrize("search", SEARCHES)
def test_pickled_search_structures_find_the_same(method, search):
    exemplar = pebbles(64)
    few = {} if search == "exhaustive" else {"candidates": 5}
    model = weftex.METHODS[method](patch_size=16, search=search, **few).fit(exemplar)
    kinds = kinds_of(method)
    check_memory(model, {kind: canvas_of(kind, exemplar.pixels, (70, 75)) for kind in kinds})


@pytest.mark.pictures
@every("method", "kind", "way", kinds=("plain", "xy", "wrapped hole"))
def test_threads_change_nothing(method, kind, way):
    exemplar = weftex.Exemplar(noise((40, 41, 3)))
    largest = 60 if way == "single pixels" else TRIALS[method].largest
    canvas = canvas_of(kind, exemplar.pixels, (largest, largest - 10))
    model = method_of(method, way).fit(exemplar)
    one = model.sample(canvas, seed=1, threads=1)
    assert same(model.sample(canvas, seed=1, threads=3), one)


@every("method", family="patch")
def test_there_are_enough_patches_for_threads(method):
    from weftex.methods.patches.orders import THREADS_FROM

    side = TRIALS[method].largest
    result = make(method, noise((40, 41, 3)), "plain", size=(side, side - 10))
    assert len(result.placements) > THREADS_FROM


@pytest.mark.pictures
@every("method", "kind", "way", kinds=("plain", "wrapped hole", "guide"))
def test_depth_does_not_change_what_goes_where(method, kind, way):
    """The 16-bit and the floating version of an 8-bit picture have its source map.

    For samples whose values span an eighth of the range or more; see test_exemplar.py.
    """
    pixels = weftex.load_exemplar("sample:pebbles").pixels[:40, :40]
    eight = make(method, pixels, kind, way)
    deep = make(method, pixels.astype(np.uint16) * 257, kind, way)
    assert np.array_equal(deep.source, eight.source)
    for dtype in (np.float32, np.float64):
        real = make(method, (pixels / 255).astype(dtype), kind, way)
        assert np.array_equal(real.source, eight.source)
