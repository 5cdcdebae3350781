"""What holds for every method on every kind of canvas."""

import hashlib
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weft
from weft import _compositing

METHODS = list(weft.METHODS)
WRAPS = {"plain": (False, False), "x": (False, True), "y": (True, False), "xy": (True, True)}
KINDS = [*WRAPS, "hole", "wrapped hole"]
BLENDS = ("feather", "feather-at-end", "cut", "none")
DTYPES = (np.uint8, np.uint16, np.float32, np.float64)
every_method = pytest.mark.parametrize("method", METHODS)
every_kind = pytest.mark.parametrize("kind", KINDS)


def noise(shape, dtype=np.uint8, seed=2):
    rng = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "f":
        return rng.random(shape).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max + 1, shape).astype(dtype)


def canvas_of(kind, pixels, size=(40, 37)):
    """A canvas of this kind; a hole's surroundings are other pixels of the same sort."""
    if kind in WRAPS:
        return weft.Canvas(*size, WRAPS[kind])
    y, x = np.indices(size)
    hole = (y - 18) ** 2 + (x - 15) ** 2 < 90
    hole[-3:, 25:] = True  # touches the border
    hole[:2, 30:33] = True
    known = np.resize(pixels[::-1], (*size, *pixels.shape[2:])).astype(pixels.dtype)
    known[hole] = 0
    return weft.Canvas(*size, (kind == "wrapped hole",) * 2, known=known, hole=hole)


def make(method, pixels, kind, seed=7, threads=None, **parameters):
    parameters = {"patch_size": 9, "boundary_width": 3} | parameters
    exemplar = pixels if isinstance(pixels, weft.Exemplar) else weft.Exemplar(pixels)
    model = weft.METHODS[method](**parameters).fit(exemplar)
    return model.sample(canvas_of(kind, exemplar.pixels), seed=seed, threads=threads)


@every_method
@every_kind
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("patch_size", [1, 9])
def test_constant_in_constant_out(method, kind, dtype, patch_size):
    value = np.array([3, 200, 77, 255]).astype(dtype)
    if np.dtype(dtype).kind == "f":
        value = value / dtype(255)
    elif dtype == np.uint16:
        value = value * dtype(257)
    pixels = np.broadcast_to(value, (20, 22, 4)).copy()
    canvas = canvas_of(kind, pixels)
    if canvas.hole is not None:
        known = np.broadcast_to(value, (*canvas.shape, 4)).copy()
        canvas = weft.Canvas(*canvas.shape, canvas.wrap, known=known, hole=canvas.hole)
    model = weft.METHODS[method](patch_size=patch_size).fit(weft.Exemplar(pixels))
    image = model.sample(canvas, seed=1).image
    assert np.array_equal(image, np.broadcast_to(value, image.shape))


@every_method
@every_kind
@pytest.mark.parametrize("blend", ["cut", "none"])
@pytest.mark.parametrize("dtype", DTYPES)
def test_a_copying_methods_picture_is_the_sample_at_its_source(method, kind, blend, dtype):
    pixels = noise((30, 31, 3), dtype)
    result = make(method, pixels, kind, blend=blend)
    source, where = result.source, np.ones(result.shape, bool)
    if result.canvas.hole is not None:
        where = result.canvas.hole
        assert (source[~where] == -1).all()
    assert (source[where] >= 0).all() and (source[where] < (30, 31)).all()
    assert np.array_equal(result.image[where], pixels[source[where][:, 0], source[where][:, 1]])
    # Any aligned map follows the same coordinates.
    height = noise((30, 31), np.uint16, seed=3)
    background = np.zeros(result.shape, np.uint16)
    rendered = result.render(
        height, background=background if result.canvas.hole is not None else None
    )
    assert np.array_equal(rendered[where], height[source[where][:, 0], source[where][:, 1]])


@every_method
@every_kind
def test_pixels_are_copied_one_by_one_too(method, kind):
    pixels = noise((20, 21, 3))
    result = make(method, pixels, kind, patch_size=1, boundary_width=2)
    where = np.ones(result.shape, bool) if result.canvas.hole is None else result.canvas.hole
    at = result.source[where]
    assert np.array_equal(result.image[where], pixels[at[:, 0], at[:, 1]])


@every_method
@every_kind
def test_maps_travel_with_the_picture(method, kind):
    """Maps that are the picture itself come out as the picture, whatever is blended."""
    pixels = noise((30, 31, 3))
    exemplar = weft.Exemplar(pixels, maps={"same": pixels})
    canvas = canvas_of(kind, pixels)
    if canvas.hole is not None:
        return  # `weft.fill` does these; a canvas's known pixels have no maps
    model = weft.METHODS[method](patch_size=9, boundary_width=3).fit(exemplar)
    result = model.sample(canvas, seed=1)
    assert np.array_equal(result.maps["same"], result.image)


@every_method
@pytest.mark.parametrize("kind", ["hole", "wrapped hole"])
@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_known_pixels_are_untouched(method, kind, blend, dtype, channels):
    result = make(method, noise((30, 31, channels), dtype), kind, blend=blend)
    hole = result.canvas.hole
    assert np.array_equal(result.image[~hole], result.canvas.known[~hole])
    assert np.array_equal(result.render()[~hole], result.canvas.known[~hole])
    assert (result.source[hole] >= 0).all()


def border_against_inside(picture, axis):
    """Mean difference across the border, in spreads of the mean differences inside.

    Two neighbouring lines of a smooth material differ little; the last line and the first one
    differ like any two, unless the picture wraps.
    """
    picture = np.moveaxis(picture.astype(float), axis, 0)
    steps = np.abs(np.roll(picture, -1, axis=0) - picture).reshape(len(picture), -1).mean(axis=1)
    inside, border = steps[:-1], steps[-1]
    return (border - inside.mean()) / inside.std()


@every_method
@pytest.mark.parametrize("name", ["pebbles", "grass", "wood"])
@pytest.mark.parametrize("patch_size, boundary_width", [(32, 5), (24, 12)])
def test_a_wrapped_canvas_has_no_seam_at_its_border(method, name, patch_size, boundary_width):
    """No line pair stands out; without wrapping, the same measure shows that one does."""
    exemplar = weft.load_exemplar(f"sample:{name}")
    model = weft.METHODS[method](patch_size=patch_size, boundary_width=boundary_width).fit(exemplar)
    wrapped, plain = [], []
    for seed in range(6):
        for axis, only in ((0, "y"), (1, "x")):
            for tileable in (True, only):
                image = model.sample((150, 140), seed=seed, tileable=tileable).image
                wrapped.append(border_against_inside(image, axis))
            for tileable in (False, {"x": "y", "y": "x"}[only]):
                image = model.sample((150, 140), seed=seed, tileable=tileable).image
                plain.append(border_against_inside(image, axis))
    # Lines inside a picture lie within three spreads; a patch border may be anywhere among them.
    assert np.mean(wrapped) < 3
    assert np.mean(plain) > 3, "the measure must see a seam where there is one"
    assert np.mean(plain) > 3 * max(np.mean(wrapped), 0)


@every_method
@pytest.mark.parametrize("size", [(21, 21), (31, 45), (17, 60), (25, 33), (20, 20), (24, 41)])
@pytest.mark.parametrize("boundary_width", [2, 5, 8])
def test_small_wrapped_canvases_have_no_seam_inside_either(method, size, boundary_width):
    """On a smooth periodic sample every neighbour pair is near, in the middle and at the border."""
    y, x = np.indices((64, 64)) * (2 * np.pi / 16)
    smooth = np.rint(127 + 60 * np.sin(x) + 60 * np.sin(y)).astype(np.uint8)
    steepest = np.abs(np.diff(smooth.astype(int), axis=1)).max()
    model = weft.METHODS[method](
        patch_size=16, boundary_width=boundary_width, search="exhaustive", repeat_distance=0.0,
        **({"epsilon": 0.0} if method == "patch-sampling" else {"tolerance": 0.0}),
    ).fit(weft.Exemplar(smooth))  # fmt: skip
    whole = model.sample((48, 48), seed=1, tileable=True).image.astype(int)  # three periods
    for axis in (0, 1):
        assert np.abs(np.roll(whole, 1, axis) - whole).max() <= 2 * steepest
    result = model.sample(size, seed=1, tileable=True)
    # Every patch but the first has something to match: none is laid beside what it did not see.
    assert _unseen_borders(result) == 0


def _unseen_borders(result):
    """Neighbouring pixels whose patches meet outside the zone that the later one was matched in."""
    height, length = result.shape
    owner = np.full((height, length, 4), -1, np.int32)
    share = np.zeros((height, length, 4), np.float32)
    plan = result.placements, result.weights, result.cuts
    _compositing.layer_all(owner, share, 0, 0, height, length, *plan)
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


def digest(result):
    return hashlib.sha256(result.image.tobytes() + result.source.tobytes()).hexdigest()


@every_method
@every_kind
@pytest.mark.parametrize("blend", BLENDS)
def test_the_same_seed_the_same_bytes(method, kind, blend):
    pixels = noise((30, 31, 3))
    first = make(method, pixels, kind, blend=blend)
    again = make(method, pixels.copy(), kind, blend=blend)
    assert np.array_equal(first.placements, again.placements)
    assert np.array_equal(first.image, again.image)
    # A tolerance that lets several patches in, or the nearest is the only one to draw.
    wide = {"epsilon": 2.0} if method == "patch-sampling" else {"tolerance": 1.0}
    one = make(method, pixels, kind, blend=blend, **wide)
    other = make(method, pixels, kind, blend=blend, seed=8, **wide)
    assert not np.array_equal(one.image, other.image)


@every_method
@every_kind
@pytest.mark.parametrize("search", ["exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca"])
def test_a_pickled_model_makes_the_same_bytes(method, kind, search):
    exemplar = weft.Exemplar(weft.load_exemplar("sample:pebbles").pixels[:80, :80])
    model = weft.METHODS[method](
        patch_size=16, search=search, candidates=5 if search != "exhaustive" else 40
    ).fit(exemplar)
    canvas = canvas_of(kind, exemplar.pixels, (90, 95))
    fresh = pickle.loads(pickle.dumps(model)).sample(canvas, seed=1)
    result = model.sample(canvas, seed=1)
    used = pickle.loads(pickle.dumps(model)).sample(canvas, seed=1)
    assert np.array_equal(fresh.placements, result.placements)
    assert np.array_equal(used.placements, result.placements)
    assert np.array_equal(fresh.image, result.image)


@every_method
def test_a_model_does_not_remember(method):
    """What was made before, of whatever kind, changes nothing."""
    exemplar = weft.Exemplar(weft.load_exemplar("sample:pebbles").pixels[:80, :80])
    model = weft.METHODS[method](patch_size=16, boundary_width=4, candidates=5).fit(exemplar)
    first = [model.sample(canvas_of(k, exemplar.pixels, (60, 65)), seed=1).image for k in KINDS]
    for kind, image in list(zip(KINDS, first, strict=True))[::-1]:
        again = model.sample(canvas_of(kind, exemplar.pixels, (60, 65)), seed=1).image
        assert np.array_equal(again, image)


@every_method
@every_kind
@pytest.mark.parametrize("blend", BLENDS)
def test_threads_change_nothing(method, kind, blend):
    from weft.methods.patch_pasting import _THREADS_FROM

    exemplar = weft.Exemplar(noise((40, 41, 3)))
    model = weft.METHODS[method](patch_size=8, boundary_width=2, blend=blend).fit(exemplar)
    canvas = canvas_of(kind, exemplar.pixels, (200, 190))
    one = model.sample(canvas, seed=1, threads=1)
    assert canvas.hole is not None or len(one.placements) > _THREADS_FROM
    for threads in (2, 4):
        other = model.sample(canvas, seed=1, threads=threads)
        assert np.array_equal(other.placements, one.placements)
        assert np.array_equal(other.image, one.image)


SCRIPT = """
import hashlib, weft
for method in weft.METHODS:
    for tileable in (False, True):
        result = weft.synthesize(
            "sample:pebbles", (120, 130), method=method, seed=11, tileable=tileable
        )
        print(hashlib.sha256(result.image.tobytes() + result.source.tobytes()).hexdigest())
"""


def test_processes_change_nothing():
    expected = [
        digest(weft.synthesize("sample:pebbles", (120, 130), method=m, seed=11, tileable=t))
        for m in METHODS
        for t in (False, True)
    ]
    for number in ("0", "1"):  # hashing of texts differs from process to process
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env=os.environ | {"PYTHONHASHSEED": number},
            capture_output=True,
            check=False,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout.split() == expected


@every_method
@every_kind
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [None, 1, 2, 3, 4, 5])
def test_dtype_and_channels_are_kept(method, kind, dtype, channels):
    shape = (30, 31) if channels is None else (30, 31, channels)
    result = make(method, noise(shape, dtype), kind)
    assert result.image.dtype == dtype
    assert result.image.shape == (*result.shape, *shape[2:])
    assert result.image.flags.c_contiguous


@every_method
@every_kind
@pytest.mark.parametrize("name", ["pebbles", "wood"])
def test_depth_does_not_change_what_goes_where(method, kind, name):
    """The 16-bit and the floating version of an 8-bit picture have its source map.

    For samples whose values span an eighth of the range or more; see test_exemplar.py.
    """
    pixels = weft.load_exemplar(f"sample:{name}").pixels[:60, :60]
    eight = make(method, pixels, kind, patch_size=16)
    deep = make(method, pixels.astype(np.uint16) * 257, kind, patch_size=16)
    assert np.array_equal(deep.placements, eight.placements)
    assert np.array_equal(deep.source, eight.source)
    for dtype in (np.float32, np.float64):
        real = make(method, (pixels / 255).astype(dtype), kind, patch_size=16)
        assert np.array_equal(real.placements, eight.placements)


@st.composite
def jobs(draw):
    """Any sample, any canvas, any of the parameters that change the way."""
    rng = np.random.default_rng(draw(st.integers(0, 2**30)))
    dtype = draw(st.sampled_from(DTYPES))
    channels = draw(st.sampled_from([None, 1, 2, 3, 4, 5]))
    sample_shape = draw(st.tuples(st.integers(8, 30), st.integers(8, 30)))
    size = draw(st.tuples(st.integers(1, 50), st.integers(1, 50)))
    rest = () if channels is None else (channels,)
    pixels = noise((*sample_shape, *rest), dtype, seed=int(rng.integers(2**30)))
    known = hole = None
    if draw(st.booleans()):
        known = noise((*size, *rest), dtype, seed=1)
        hole = rng.random(size) < draw(st.sampled_from([0.02, 0.3, 0.95, 1.0]))
    wrap = draw(st.tuples(st.booleans(), st.booleans()))
    parameters = {
        "patch_size": draw(st.sampled_from([1, 2, 5, 8])),
        "blend": draw(st.sampled_from(BLENDS)),
        "search": draw(st.sampled_from(["exhaustive", "quadtree", "pca", "kdtree", "kdtree-pca"])),
        "repeat_distance": draw(st.sampled_from([0.0, 0.5, 2.0])),
        "edge_weight": draw(st.sampled_from([0.0, 1.0])),
    }
    exemplar = weft.Exemplar(pixels, tileable=draw(st.booleans()))
    return exemplar, weft.Canvas(*size, wrap, known=known, hole=hole), parameters


@every_method
@given(job=jobs(), seed=st.integers(0, 2**64 - 1))
def test_anything_reasonable_works(method, job, seed):
    exemplar, canvas, parameters = job
    model = weft.METHODS[method](**parameters).fit(exemplar)
    result = model.sample(canvas, seed=seed)
    assert result.image.shape == (*canvas.shape, *exemplar.pixels.shape[2:])
    assert result.image.dtype == exemplar.pixels.dtype
    where = np.ones(canvas.shape, bool) if canvas.hole is None else canvas.hole
    source = result.source
    assert (source[where] >= 0).all() and (source[where] < exemplar.shape).all()
    assert np.array_equal(result.render(), result.image)
    if parameters["blend"] in ("cut", "none") or parameters["patch_size"] == 1:
        expected = exemplar.pixels[source[where][:, 0], source[where][:, 1]]
        assert np.array_equal(result.image[where], expected)
    if canvas.hole is not None:
        assert np.array_equal(result.image[~where], canvas.known[~where])
