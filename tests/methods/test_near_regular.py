"""Near-regular synthesis: the same at any place, going on with the lattice."""

import pickle

import numpy as np
import pytest

import weftex
from families import noise, refused
from materials import wall

LATTICE = (16, 0, 8, 12)


def model_of(pixels, **parameters):
    return weftex.NearRegular(**parameters).fit(weftex.Exemplar(pixels))


@pytest.mark.parametrize("corner", [(2**40, -(2**40)), (-(2**40), 2**40), (12345678901, 3)])
def test_far_windows_agree_and_stay_on_the_lattice(corner):
    model = model_of(wall(60, 64, spread=1), lattice=LATTICE, block_size=14, border_width=8)
    y, x = (c - 80 if c > 0 else c for c in corner)
    b = model.window(y, x, 70, 80, seed=3).image
    a = model.window(y + 20, x + 20, 50, 60, seed=3).image
    assert np.array_equal(a, b[20:, 20:])
    v, u = np.indices(b.shape[:2])
    row = (v + y) // 12
    mortar = ((v + y) % 12 < 2) | ((u + x + 8 * (row % 2)) % 16 < 2)
    assert (b[mortar] > 200).all() and (b[~mortar] < 150).all()


def test_a_regular_sample_goes_on_for_ever():
    """Also where the vectors are fractions: places are rounded block by block."""
    tile = noise((7, 11, 3))
    exact = np.tile(tile, (6, 4, 1))
    out = model_of(exact, lattice=(11, 0, 0, 7)).sample((300, 200), seed=1).image
    assert np.array_equal(out, np.tile(tile, (43, 19, 1))[:300, :200])
    y, x = np.indices((90, 100))
    slanted = np.rint(127 + 60 * np.sin(x * 2 * np.pi / 12.3) + 60 * np.sin(y * 2 * np.pi / 9.7))
    model = model_of(slanted.astype(np.uint8), lattice=(12.3, 0, 0, 9.7), tolerance=0)
    far = model.window(10**6, 10**6, 150, 150, seed=1).image.astype(int)
    y, x = np.indices(far.shape) + 10**6
    ideal = 127 + 60 * np.sin(x * 2 * np.pi / 12.3) + 60 * np.sin(y * 2 * np.pi / 9.7)
    steepest = 60 * 2 * np.pi / 9.7 + 60 * 2 * np.pi / 12.3
    assert np.abs(far - ideal).max() < steepest  # within a pixel, a million pixels away


@pytest.mark.parametrize("tileable", [True, "x", "y"])
def test_what_goes_around_keeps_whole_tiles(tileable):
    model = model_of(wall(96, 96, spread=1), lattice=LATTICE, block_size=20)
    result = model.sample((97, 110), seed=1, tileable=tileable)
    assert 0 < result.provenance["strain"] < 0.1
    if tileable != "x":  # beds all the way down, none thicker across the border
        mortar = np.tile(result.image, (2, 1, 1))[..., 0] > 160
        beds = np.diff(np.r_[0, (mortar.mean(axis=1) > 0.6).astype(int), 0])
        runs = np.diff(np.flatnonzero(beds))[::2]
        assert runs.max() <= 4 and len(runs) == 16


def test_strain_is_refused_and_a_good_size_named():
    model = model_of(wall(96, 96), lattice=(16, 0, 0, 24), block_size=40)
    refused(r"stretched by .*96x\d+ fits", model.sample, (36, 96), tileable=True)
    model.sample((36, 96))
    model.sample((36, 96), tileable="x")


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"lattice": (8, 0, 16, 0)}, "line"),
        ({"lattice": (0, 0, 8, 8)}, "1 pixel"),
        ({"lattice": (90, 0, 0, 8)}, "smaller"),
        ({"lattice": (50, 0, 0, 40)}, "two cells"),
        ({"block_size": 20, "border_width": 20}, "less than the block"),
        ({"block_size": 40, "border_width": 22}, "together they must be at most 60"),
        ({"blend": "none", "blend_width": 4}, "no effect unless blend is 'feather'"),
        ({"border_width": 0, "match": "gncc"}, "match has no effect without borders"),
        ({"defaults": "paper", "blend_width": 20}, "blend_width is 20; it must be less than"),
        (
            {"defaults": "paper", "block_size": 40, "blend_width": 21},
            "block_size is 40 and blend_width 22; .* together they must be at most 60",
        ),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    refused(message, model_of, wall(60, 60), **{"lattice": LATTICE, "block_size": 20} | parameters)
    if list(parameters) == ["lattice"]:
        refused(message, weftex.BestTile(**parameters).fit, weftex.Exemplar(wall(60, 60)))


@pytest.mark.parametrize("case", ["plain", "mask", "tileable"])
def test_the_resolved_method_says_what_is_done(case):
    mask = np.ones((96, 96), bool)
    mask[40:44, 40:44] = False
    more = {"plain": {}, "mask": {"mask": mask}, "tileable": {"tileable": True}}[case]
    exemplar = weftex.Exemplar(wall(96, 96), **more)
    method = weftex.NearRegular(lattice=LATTICE, block_size=17)
    model = method.fit(exemplar)
    told = model.sample(20, seed=1).provenance
    assert told["blend"] == "feather" and told["blend_width"] > 0
    assert None not in told.values()
    assert method.resolved(exemplar) == model.method == model.method.resolved(exemplar)


def test_blends_are_as_wide_as_asked():
    """With the paper's defaults, which feathers, too."""
    pixels = wall(128, 128)
    images = []
    for width in (None, 0, 4, 10):
        model = model_of(pixels, lattice=LATTICE, defaults="paper", blend_width=width)
        method = model.method
        assert method.blend_width == (4 if width is None else width) and method.blend == "feather"
        assert (method.block_size, method.border_width, method.tolerance) == (40, 10, 3)
        images.append(model.sample(150, seed=1).image)
    assert np.array_equal(images[0], images[2])
    assert all((images[1] != other).any() for other in images[2:])
    assert (images[2] != images[3]).any()


def test_provenance_has_the_narrow_borders_of_small_canvases():
    model = model_of(wall(96, 96), lattice=(16, 0, 0, 12), block_size=30, border_width=20)
    assert model.sample((48, 48), seed=1).provenance.get("border_narrowed_to") is None
    told = model.sample((24, 32), seed=1, tileable=True).provenance
    assert told["border_narrowed_to"] == 10  # blocks of 12 wrap


def test_a_blend_wider_than_the_border():
    """Fig. 5.12: with borders of 10 and blends of 28 pixels, steps of light are spread."""
    light = wall(128, 128).astype(int) + np.linspace(-60, 60, 128).astype(int)[:, None]
    light = np.clip(light, 0, 255).astype(np.uint8)
    steps = {}
    for width in (4, 28):
        model = model_of(light, lattice=LATTICE, defaults="paper", blend_width=width)
        assert (model.method.block_size, model.method.border_width) == (40, 10)
        whole = model.sample((240, 240), seed=1)
        part = model.window(31, 52, 90, 80, seed=1).image
        assert np.array_equal(part, whole.image[31:121, 52:132])
        # Means over the beds, whose period of 12 rows is taken out.
        beds = whole.image[..., 0].astype(int).reshape(20, 12, 10, 24).mean(axis=(1, 3))
        steps[width] = abs(np.diff(beds, axis=0)).max()
    assert steps[28] < 0.9 * steps[4]


def test_a_sample_without_a_lattice_is_refused():
    sample = weftex.Exemplar(noise((64, 64, 3)), name="gravel")
    refused("gravel has neither .* graphcut", weftex.NearRegular().fit, sample)
    assert weftex.NearRegular(lattice=(1, 0, 0, 1)).fit(sample).sample(50, seed=1).image.any()


def test_lattice_mode_keeps_the_rules():
    """What test_invariants holds without a lattice: threads, pickles, masks, samples that tile."""
    pixels = wall(96, 96)
    settings = {"lattice": LATTICE, "block_size": 17}
    model = model_of(pixels, **settings)
    same = pickle.loads(pickle.dumps(model))
    for wrap in ((False, False), (True, False), (True, True)):
        canvas = weftex.Canvas(120, 128, wrap)
        one = model.sample(canvas, seed=5, threads=1)
        for other in (model.sample(canvas, seed=5, threads=4), same.sample(canvas, seed=5)):
            assert np.array_equal(one.image, other.image)
            assert np.array_equal(one.source, other.source)
    mask = np.ones((96, 96), bool)
    mask[40:50, 40:60] = False
    masked = weftex.NearRegular(**settings).fit(weftex.Exemplar(pixels, mask=mask))
    source = masked.sample(150, seed=1).source
    assert mask[source[..., 0], source[..., 1]].all()
    model = weftex.NearRegular(blend="none", **settings).fit(weftex.Exemplar(pixels, tileable=True))
    result = model.sample(150, seed=1)
    assert np.array_equal(result.image, pixels[result.source[..., 0], result.source[..., 1]])
    assert result.placements[:, 2].max() > 96 - 17  # windows go over the border
