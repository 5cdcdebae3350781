"""Near-regular synthesis: like its twin, the same at any place, going on with the lattice."""

import pickle

import numpy as np
import pytest

import weftex
from families import noise
from materials import wall
from twins import near_regular as reference
from twins.near_regular_holes import NearRegularHoleTwin
from twins.near_regular_warps import WarpedTwin
from weftex.methods.lattices.model import origin_of
from weftex.methods.near_regular import seam_kernels as kernels
from weftex.methods.near_regular.rectification import rectified
from weftex.methods.near_regular.rows import axis_of_rows
from weftex.methods.near_regular.sample import wedges_of
from weftex.results.patches import RectifiedSynthesis
from weftex.results.warped import WarpedSynthesis


def model_of(pixels, **parameters):
    return weftex.NearRegular(**parameters).fit(weftex.Exemplar(pixels))


def usable_of(model):
    y, x = np.nonzero(model.blocks.windows.usable)
    return list(zip(y.tolist(), x.tolist(), strict=True))


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"match": "gncc", "variety": 0.0},
        {"candidates": 1, "tolerance": 0, "variety": 5.0},
        {"border_width": 2, "lattice": (8.0, 12.25, -16.5, 0.3)},
    ],
    ids=str,
)
@pytest.mark.parametrize("corner", [(0, 0), (-35, 1000)])
def test_like_its_twin(parameters, corner):
    pixels = noise((44, 48, 3)) // 2 + wall(44, 48) // 2
    settings = {
        "lattice": (16.0, 0.0, 8.0, 12.0),
        "block_size": 9,
        "border_width": 6,
        "tolerance": 1,
        "candidates": 3,
        "rectify": 0,
    } | parameters
    model = model_of(pixels, **settings)
    twin = reference.NearRegularTwin(pixels, usable_of(model), model.method, 7)
    result = model.window(*corner, 25, 30, seed=7)
    assert np.array_equal(result.source, twin.source(*corner, 25, 30))


def ellipse(shape, place, radius):
    y, x = np.indices(shape)
    return ((y - place[0]) / radius[0]) ** 2 + ((x - place[1]) / radius[1]) ** 2 < 1


@pytest.mark.parametrize(
    "inside, radius, parameters",
    [
        (True, (17, 15), {}),
        (True, (19, 16), {"match": "gncc", "variety": 0.0}),
        (False, (26, 30), {"variety": 3.0}),
        (False, (9, 6), {"lattice": (8.0, 12.25, -16.5, 0.3), "tolerance": 0}),
        (True, (3, 11), {"lattice": (1.0, 0.0, 0.0, 1.0)}),
    ],
)
def test_holes_are_filled_like_the_twin_does(inside, radius, parameters):
    pixels = noise((80, 84, 3)) // 2 + wall(80, 84) // 2
    settings = {
        "lattice": (16.0, 0.0, 8.0, 12.0),
        "block_size": 9,
        "border_width": 6,
        "tolerance": 1,
        "candidates": 3,
        "rectify": 0,
    } | parameters
    if inside:
        hole = ellipse((80, 84), (41, 44), radius)
        mask = ~hole
        mask[28 if "lattice" in parameters else 80 :] = False
        exemplar = weftex.Exemplar(pixels, mask=mask)
        canvas = weftex.Canvas(80, 84, known=pixels, hole=hole, known_from=(0, 0))
    else:
        other = noise((60, 64, 3), seed=5) // 2 + wall(67, 69, seed=2)[7:, 5:] // 2
        hole = ellipse((60, 64), (33, 34), radius)
        exemplar = weftex.Exemplar(pixels)
        canvas = weftex.Canvas(60, 64, known=other, hole=hole)
    model = weftex.NearRegular(**settings).fit(exemplar)
    origin = origin_of(canvas, exemplar, model.vectors) if model.vectors else (0, 0)
    twin = NearRegularHoleTwin(pixels, usable_of(model), model.method, 7, canvas, origin)
    result = model.sample(canvas, seed=7)
    assert np.array_equal(result.source[hole], twin.source(canvas, origin)[hole])


@pytest.mark.parametrize("tileable", [False, True, "x"])
def test_holes_go_on_with_the_surroundings(tileable):
    """Mortar where it was, whether the pixels are part of the sample or of another wall."""
    pixels = wall(120, 128, spread=1)
    hole = ellipse((120, 128), (50, 60), (25, 20)) | ellipse((120, 128), (120, 20), (12, 9))
    hole |= np.roll(hole, 8, axis=0) & (np.indices(hole.shape)[0] < 12)
    blank = np.where(hole[..., None], 255, pixels).astype(np.uint8)
    settings = {"method": "near-regular", "lattice": (16, 0, 8, 12), "seed": 3}
    for sample in (None, wall(90, 100, spread=1)[5:, 3:]):
        result = weftex.fill(blank, hole, sample=sample, tileable=tileable, **settings)
        assert np.array_equal(result.image[~hole], pixels[~hole])
        assert ((result.image[..., 0] > 180) == (pixels[..., 0] > 180)).all()
        if sample is None:
            assert not hole[result.source[..., 0], result.source[..., 1]][hole].any()


def test_holes_that_leave_no_whole_piece():
    pixels = wall(96, 96)
    small = np.zeros((96, 96), bool)
    small[40:50, 40:50] = True
    with pytest.raises(weftex.InvalidInputError, match="make them smaller"):
        weftex.fill(pixels, small, method="near-regular", lattice=(16, 0, 8, 12), block_size=45)
    # Whole windows in one corner alone, and not at all places of the large tile.
    large = np.ones((96, 96), bool)
    large[:40, :40] = False
    with pytest.raises(weftex.InvalidInputError, match="no whole piece of .*give a sample"):
        weftex.fill(pixels, large, method="near-regular", lattice=(32, 0, 0, 48), block_size=24)


@pytest.mark.parametrize("unconstrained", [False, True])
def test_windows_of_the_plane_agree(unconstrained):
    pixels = wall(60, 64)
    lattice = (1, 0, 0, 1) if unconstrained else (16, 0, 8, 12)
    for blend in ("cut", "feather"):
        model = model_of(pixels, lattice=lattice, block_size=14, border_width=8, blend=blend)
        whole = model.sample((150, 140), seed=3)
        for window in ((0, 0, 1, 1), (13, 27, 40, 50), (149, 139, 1, 1), (60, 0, 90, 140)):
            part = model.window(*window, seed=3)
            y, x, height, width = window
            assert np.array_equal(part.image, whole.image[y : y + height, x : x + width])
            if blend == "cut":
                assert np.array_equal(part.source, whole.source[y : y + height, x : x + width])


@pytest.mark.parametrize("corner", [(2**40, -(2**40)), (-(2**40), 2**40), (12345678901, 3)])
def test_far_windows_agree_and_stay_on_the_lattice(corner):
    model = model_of(wall(60, 64, spread=1), lattice=(16, 0, 8, 12), block_size=14, border_width=8)
    a = model.window(*corner, 50, 60, seed=3).image if max(corner) < 2**40 else None
    y, x = (c - 20 if c > 0 else c for c in corner)
    b = model.window(y, x, 70, 80, seed=3).image
    if a is not None:
        oy, ox = corner[0] - y, corner[1] - x
        assert np.array_equal(a, b[oy : oy + 50, ox : ox + 60])
    v, u = np.indices(b.shape[:2])
    row = (v + y) // 12
    mortar = ((v + y) % 12 < 2) | ((u + x + 8 * (row % 2)) % 16 < 2)
    assert (b[mortar] > 200).all() and (b[~mortar] < 150).all()


def test_places_are_refused_past_the_plane():
    model = model_of(wall(60, 64), lattice=(16, 0, 8, 12))
    for at in (2**40 + 1, 0.5, None, True):
        with pytest.raises(weftex.InvalidInputError, match="2\\*\\*40"):
            model.window(0, at, 9, 9)


def test_a_regular_sample_goes_on_for_ever():
    """Also where the vectors are fractions: places are rounded block by block."""
    tile = noise((7, 11, 3))
    exact = np.tile(tile, (6, 4, 1))
    out = model_of(exact, lattice=(11, 0, 0, 7)).sample((300, 200), seed=1).image
    assert np.array_equal(out, np.tile(tile, (43, 19, 1))[:300, :200])
    y, x = np.indices((90, 100))
    slanted = np.rint(127 + 60 * np.sin(x * 2 * np.pi / 12.3) + 60 * np.sin(y * 2 * np.pi / 9.7))
    model = model_of(slanted.astype(np.uint8), lattice=(12.3, 0, 0, 9.7), rectify=0, tolerance=0)
    far = model.window(10**6, 10**6, 150, 150, seed=1).image.astype(int)
    y, x = np.indices(far.shape) + 10**6
    ideal = 127 + 60 * np.sin(x * 2 * np.pi / 12.3) + 60 * np.sin(y * 2 * np.pi / 9.7)
    steepest = 60 * 2 * np.pi / 9.7 + 60 * 2 * np.pi / 12.3
    assert np.abs(far - ideal).max() < steepest  # within a pixel, a million pixels away


def test_blocks_do_not_repeat_what_those_drawn_beside_show():
    pixels = wall(200, 200)
    model = model_of(pixels, lattice=(16, 0, 8, 12), block_size=30, border_width=10, rectify=0)
    result = model.sample(600, seed=2)
    y, x, sy, sx, _ = result.placements.T
    drawn = (y + 5) // 30 % 2 == (x + 5) // 30 % 2
    near = again = chance = 0
    other = np.random.default_rng(0).permutation(len(y))
    for i in np.flatnonzero(drawn):
        away = np.stack([y - y[i], x - x[i]])
        others = drawn & (np.abs(away).max(axis=0) <= 60) & (np.abs(away).sum(axis=0) <= 60)
        others[i] = False
        shift = np.stack([sy - sy[i], sx - sx[i]])
        overlap = np.prod(np.clip(30 - np.abs(shift), 0, None), axis=0)
        overlap[(shift == away).all(axis=0)] = 0
        near += others.sum()
        again += (overlap[others] > 30 * 30 / 8).sum()
        shift = np.stack([sy[other] - sy[i], sx[other] - sx[i]])
        overlap = np.prod(np.clip(30 - np.abs(shift), 0, None), axis=0)
        chance += (overlap[others] > 30 * 30 / 8).sum()
    # Where all places show something again, the one that shows least is taken.
    assert near > 1000 and again < near * 0.02 < chance / 2


@pytest.mark.parametrize("tileable", [True, "x", "y"])
def test_what_goes_around_keeps_whole_tiles(tileable):
    model = model_of(wall(96, 96, spread=1), lattice=(16, 0, 8, 12), block_size=20)
    result = model.sample((97, 110), seed=1, tileable=tileable)
    assert 0 < result.provenance["strain"] < 0.1
    twice = np.tile(result.image, (2, 2, 1))[..., 0] > 160
    rows, columns = twice.mean(axis=1) > 0.6, twice[:, :110].mean(axis=1)
    if tileable in (True, "y"):  # beds all the way down, none thicker across the border
        runs = np.diff(np.flatnonzero(np.diff(np.r_[0, rows.astype(int), 0])))[::2]
        assert runs.max() <= 4 and len(runs) == 16
    assert columns.size


def test_strain_is_refused_and_a_good_size_named():
    model = model_of(wall(96, 96), lattice=(16, 0, 0, 24), block_size=40)
    with pytest.raises(weftex.InvalidInputError, match=r"strained by .*96x\d+ would do"):
        model.sample((36, 96), tileable=True)
    model.sample((36, 96))
    model.sample((36, 96), tileable="x")


@pytest.mark.parametrize(
    "lattice, message",
    [
        ((8, 0, 16, 0), "line"),
        ((0, 0, 8, 8), "1 pixel"),
        ((90, 0, 0, 8), "smaller"),
        ((40, 0, 0, 40), "two tiles"),
    ],
)
def test_bad_lattices(lattice, message):
    for method in (weftex.NearRegular, weftex.BestTile):
        with pytest.raises(weftex.InvalidInputError, match=message):
            method(lattice=lattice).fit(weftex.Exemplar(noise((50, 60))))


def test_bad_sizes():
    exemplar = weftex.Exemplar(noise((50, 60)))
    for parameters, message in (
        ({"border_width": 5}, "even"),
        ({"block_size": 20, "border_width": 20}, "less than the block"),
        ({"block_size": 40, "border_width": 12}, "room for 50 together"),
    ):
        with pytest.raises(weftex.InvalidInputError, match=message):
            weftex.NearRegular(lattice=(8, 0, 0, 8), **parameters).fit(exemplar)


def test_the_papers_preset():
    model = model_of(wall(128, 128), lattice=(16, 0, 8, 12), preset="paper")
    m = model.method
    assert (m.block_size, m.border_width, m.blend, m.blend_width) == (40, 10, "feather", 4)
    assert (m.tolerance, m.rectify, m.variety, m.candidates) == (3, 0, 0.0, 512)


def test_the_settled_method_says_what_is_done():
    """Also where a parameter has no effect; nothing but the blending of cut blocks is left open."""
    pixels, lattice = wall(96, 96), (16, 0, 8, 12)
    mask = np.ones((96, 96), bool)
    mask[40:44, 40:44] = False
    for exemplar, parameters, rectify in (
        (weftex.Exemplar(pixels), {"lattice": lattice}, 1),
        (weftex.Exemplar(pixels, mask=mask), {"lattice": lattice, "rectify": 2}, 0),
        (weftex.Exemplar(pixels, tileable=True), {"lattice": lattice, "rectify": 2}, 0),
        (weftex.Exemplar(pixels), {"lattice": (1, 0, 0, 1), "rectify": 2}, 0),
    ):
        model = weftex.NearRegular(**parameters, block_size=17).fit(exemplar)
        told = model.sample(20, seed=1).provenance
        assert told["rectify"] == model.method.rectify == rectify
        assert told["blend"] == "cut" and "blend_width" not in told
        assert None not in told.values()
        assert weftex.NearRegular(**parameters, block_size=17).settle(exemplar) == model.method
    model = model_of(pixels, lattice=lattice, blend="feather", border_width=6, blend_width=20)
    assert model.method.blend_width == 6  # it cannot be wider than what blocks share


def test_blending_is_linear():
    """Equations 4.6 to 4.10: over a corner the shares are products, over an edge they fall."""
    model = model_of(noise((60, 60)), lattice=(1, 0, 0, 1), block_size=12, border_width=6,
                     blend="feather", blend_width=4)  # fmt: skip
    result = model.sample(48, seed=1)
    coordinates, share = result.layers((8, 8, 8, 8))
    alpha = np.array([1, 1, 0.8, 0.6, 0.4, 0.2, 0, 0])  # the corner is at (12, 12)
    parts = [np.outer(a, b) for a in (alpha, 1 - alpha) for b in (alpha, 1 - alpha)]
    expected = np.sort(np.stack(parts), axis=0)[::-1].transpose(1, 2, 0)
    assert np.abs(np.sort(share, axis=2)[..., ::-1] - expected).max() < 0.02
    assert (coordinates[..., 0, 0] >= 0).all()


def test_blocks_that_would_show_are_blended_widely():
    light = wall(128, 128).astype(int) + np.linspace(-60, 60, 128).astype(int)[:, None]
    light = np.clip(light, 0, 255).astype(np.uint8)
    wide = model_of(light, lattice=(16, 0, 8, 12), blend="feather").method
    narrow = model_of(wall(128, 128, spread=1), lattice=(16, 0, 8, 12), blend="feather").method
    assert narrow.blend_width == 4 and wide.blend_width > wide.block_size // 2


@pytest.mark.parametrize("seed", range(20))
def test_least_paths(seed):
    """Against every path, by the cost of the pixels beside it and beyond."""
    rng = np.random.default_rng(seed)
    length, depth = 4, 4
    error = rng.integers(0, 1000, (length, depth)).astype(np.int64)
    beyond = rng.integers(-1000, 1000, (length, depth + 1)).astype(np.int64) * (seed % 2)
    begin, end = (int(k) for k in rng.integers(1, depth, 2))
    if abs(begin - end) > length - 1:
        return

    def cost(path):
        total = sum(
            int(error[i, k - 1] + error[i, k] + beyond[i, k]) for i, k in enumerate(path) if i
        )
        for i in range(1, length):
            a, b = sorted(path[i - 1 : i + 1])
            total += int(error[i - 1, a:b].sum() + error[i, a:b].sum())
        return total

    paths = [
        (begin, a, b, end)
        for a in range(1, depth)
        for b in range(1, depth)
        if abs(a - begin) <= 1 and abs(b - begin) <= 2 and abs(b - end) <= 1 and abs(a - end) <= 2
    ]
    found = np.zeros(length, np.int32)
    scratch = kernels.Scratch(
        error=error,
        beyond=beyond[: length * (seed % 2)],
        total=np.zeros((length, depth + 1), np.int64),
        came=np.zeros((length, depth + 1), np.int32),
        path=found,
    )
    kernels.path_through(scratch, begin, end)
    assert tuple(found) in paths and cost(tuple(found)) == min(map(cost, paths))


def test_wedges_do_not_overlap_and_are_even():
    wedges = wedges_of(10, 12, 4, 3)
    counts = np.bincount(wedges.ravel())
    assert counts[0] == 18 * 20 - 16 * 18 + 4 * 6
    # Trapezia, and the diagonals between them on one side or the other.
    assert abs(counts[1] - counts[3]) <= 6 and abs(counts[2] - counts[4]) <= 6
    assert (wedges[1, 1:-1] == 1).all() and (wedges[0] == 0).all()


def test_a_bent_sample_is_rectified():
    """Columns that wander come out straight, every pixel still one of the sample's."""
    straight = wall(120, 128, spread=1)
    y = np.arange(120)
    bend = np.rint(2 * np.sin(y * 2 * np.pi / 120)).astype(int)
    bent = np.stack([np.roll(line, b, axis=0) for line, b in zip(straight, bend, strict=True)])
    found = rectified(bent, (16, 0, 8, 12), 3)
    mended = bent.reshape(-1, 3)[found]
    inside = (slice(6, -6), slice(6, -6))

    def off(pixels):
        return np.abs(pixels.astype(int) - straight)[inside].mean()

    assert off(mended) < off(bent) / 2


def test_rectified_results_are_saved_and_replayed(tmp_path):
    pixels = wall(90, 96)
    height = noise((180, 192))
    exemplar = weftex.Exemplar(pixels)
    result = weftex.NearRegular(lattice=(16, 0, 8, 12)).fit(exemplar).sample((70, 80), seed=1)
    assert isinstance(result, RectifiedSynthesis)
    source = result.source
    assert np.array_equal(result.image, pixels[source[..., 0], source[..., 1]])
    double = height.reshape(90, 2, 96, 2)[source[..., 0], :, source[..., 1]]
    expected = double.transpose(0, 2, 1, 3).reshape(140, 160)
    assert np.array_equal(result.render(height), expected)
    result.save(tmp_path / "r.npz")
    again = weftex.Synthesis.load(tmp_path / "r.npz", exemplar)
    assert isinstance(again, RectifiedSynthesis)
    assert np.array_equal(again.image, result.image) and np.array_equal(again.source, source)
    for what in ("sources", "seams", "error"):
        assert np.array_equal(again.draw(what), result.draw(what))


WARPED = {"lattice": (16, 0, 8, 12), "block_size": 21, "border_width": 8, "warp": 1}


def bent(height, width):
    """Bricks whose rows rise and fall by a pixel, so that shifts do not make them meet."""
    pixels = wall(height + 4, width, spread=30)
    y, x = np.indices((height, width))
    rise = np.rint(1.5 * np.sin(x * 2 * np.pi / 37) + 1.5).astype(int)
    return pixels[y + rise, x]


def test_warped_gaps_are_like_the_twin():
    corner = -35, 1000
    pixels = bent(44, 48)
    model = model_of(pixels, **WARPED | {"candidates": 1, "tolerance": 0, "rectify": 0})
    twin = WarpedTwin(pixels, usable_of(model), model.method, 7)
    result = model.window(*corner, 12, 22, seed=7)
    assert isinstance(result, WarpedSynthesis) and np.ptp(result.warps) > 16
    assert np.array_equal(result.image, twin.image(*corner, 12, 22))


def test_warps_bring_joints_together():
    """What differs where a gap meets its neighbors gets less."""
    pixels = bent(96, 96)

    def error(warp):
        model = model_of(pixels, **WARPED | {"warp": warp, "rectify": 0, "blend": "none"})
        whole = model.sample(210, seed=1).image.astype(int)
        edges = np.arange(21, 210, 21)
        return np.abs(whole[:, edges] - whole[:, edges - 1]).sum()  # across rows of joints

    assert error(2) < 0.95 * error(0)


@pytest.mark.parametrize("blend", ["cut", "feather"])
def test_warped_results_are_the_same_in_parts_and_on_maps(blend, tmp_path):
    pixels = bent(90, 96)
    exemplar = weftex.Exemplar(pixels)
    model = weftex.NearRegular(**WARPED, blend=blend).fit(exemplar)
    for wrap in ((False, False), (True, False), (True, True)):
        canvas = weftex.Canvas(96, 112, wrap)
        whole = model.sample(canvas, seed=3, threads=1)
        assert np.array_equal(whole.image, model.sample(canvas, seed=3, threads=3).image)
        for top, left, height, width in ((0, 0, 1, 1), (13, 27, 40, 50), (60, 5, 36, 107)):
            part = whole.render(window=(top, left, height, width))
            assert np.array_equal(part, whole.image[top : top + height, left : left + width])
    whole = model.sample(120, seed=3)
    far = model.window(20, 31, 9, 50, seed=3)
    assert np.array_equal(far.image, whole.image[20:29, 31:81])
    # The picture is about its nearest pixels, and maps are warped as it is.
    source = whole.source
    near = pixels[source[..., 0], source[..., 1]]
    assert (near != whole.image).any()
    assert np.abs(near.astype(int) - whole.image).mean() < 8
    y, x = np.indices((180, 192)) / 2
    place = whole.render(np.stack([y, x, 0 * x], axis=2).astype(np.float32))[::2, ::2, :2]
    if blend == "cut":
        inside = np.abs(place - source).max(axis=2)
        assert np.median(inside) <= 0.5 and (inside < 4).all()
    flat = whole.render(np.full((90, 96), 7, np.uint16))
    assert (flat == 7).all()
    whole.save(tmp_path / "w.npz")
    again = weftex.Synthesis.load(tmp_path / "w.npz", exemplar)
    assert isinstance(again, WarpedSynthesis)
    assert np.array_equal(again.image, whole.image) and np.array_equal(again.source, source)
    for what in ("sources", "seams", "error"):
        assert np.array_equal(again.draw(what), whole.draw(what))


def test_warped_pixels_are_never_past_the_sample():
    """Nor is what is transparent ever seen."""
    pixels = np.dstack([bent(90, 96), np.full((90, 96), 255, np.uint8)])
    clear = (np.indices((90, 96))[0] % 12) < 2
    pixels[clear] = (0, 255, 0, 0)
    result = (
        weftex.NearRegular(**WARPED | {"warp": 2}).fit(weftex.Exemplar(pixels)).sample(150, seed=1)
    )
    assert isinstance(result, WarpedSynthesis) and result.warps.any()
    seen = result.image[result.image[..., 3] > 0]
    solid = pixels[~clear]
    assert (seen[:, :3] >= solid[:, :3].min(axis=0)).all()
    assert (seen[:, :3] <= solid[:, :3].max(axis=0)).all()
    assert np.ptp(result.image[..., 3]) == 255


def test_holes_are_filled_with_warps():
    pixels = bent(120, 128)
    hole = ellipse((120, 128), (50, 60), (30, 26))
    blank = np.where(hole[..., None], 255, pixels).astype(np.uint8)
    settings = {"method": "near-regular", "lattice": (16, 0, 8, 12), "seed": 3, "block_size": 20}
    result = weftex.fill(blank, hole, warp=2, **settings)
    assert np.array_equal(result.image[~hole], pixels[~hole])
    assert isinstance(result, WarpedSynthesis) and result.warps.any()
    assert not hole[result.source[..., 0], result.source[..., 1]][hole].any()


def test_warps_need_a_border():
    with pytest.raises(weftex.InvalidInputError, match="border_width"):
        model_of(wall(60, 60), lattice=(16, 0, 8, 12), block_size=20, border_width=0, warp=1)


def test_damaged_warps_are_refused(tmp_path):
    result = model_of(bent(60, 64), **WARPED).sample(60, seed=1)
    for key, value in (
        ("warps", np.zeros((len(result.warps), 3, 2, 2), np.int16)),
        ("warps", result.warps[:-1]),
        ("within", np.zeros_like(result.within)),
    ):
        name = tmp_path / "w.npz"
        result.save(name)
        with np.load(name) as file:
            arrays = dict(file) | {key: value}
        np.savez(name, **arrays)
        with pytest.raises(weftex.FileError, match="warps"):
            weftex.Synthesis.load(name)


def test_lattice_mode_keeps_the_rules():
    """What test_invariants holds without a lattice: threads, pickles, masks, samples that tile."""
    pixels = wall(96, 96)
    settings = {"lattice": (16, 0, 8, 12), "block_size": 17}
    model = model_of(pixels, **settings)
    for wrap in ((False, False), (True, False), (True, True)):
        canvas = weftex.Canvas(120, 128, wrap)
        one = model.sample(canvas, seed=5, threads=1)
        for other in (
            model.sample(canvas, seed=5, threads=4),
            pickle.loads(pickle.dumps(model)).sample(canvas, seed=5),
        ):
            assert np.array_equal(one.image, other.image)
            assert np.array_equal(one.source, other.source)
    mask = np.ones((96, 96), bool)
    mask[40:50, 40:60] = False
    masked = weftex.NearRegular(**settings).fit(weftex.Exemplar(pixels, mask=mask))
    source = masked.sample(150, seed=1).source
    assert mask[source[..., 0], source[..., 1]].all()
    tiling = weftex.NearRegular(**settings).fit(weftex.Exemplar(pixels, tileable=True))
    result = tiling.sample(150, seed=1)
    assert np.array_equal(result.image, pixels[result.source[..., 0], result.source[..., 1]])
    assert result.placements[:, 2].max() > 96 - 17  # windows go over the border


def boards(height, width, tone=40):
    """Boards that lie, each with grain and a color of its own."""
    rng = np.random.default_rng(4)
    tones = rng.integers(90, 90 + tone, (height // 16 + 1, 3))[np.arange(height) // 16]
    pixels = tones[:, None] + rng.integers(0, 9, (height, width, 1))
    pixels[np.arange(height) % 16 < 2] = 20
    return pixels.astype(np.uint8)


@pytest.mark.parametrize("stands", [False, True])
def test_boards_go_on(stands):
    """One vector is found, joints stay where they are and boards do not end."""
    pixels = boards(128, 128)
    pixels = pixels.swapaxes(0, 1) if stands else pixels
    model = model_of(np.ascontiguousarray(pixels))
    assert model.blocks.row_axis == int(stands)
    out = model.sample((300, 300), seed=1)
    image = out.image.swapaxes(0, 1) if stands else out.image
    dark = image.max(axis=2) < 60
    assert dark[np.arange(300) % 16 < 2].mean() > 0.98
    # Means over 20 pixels along each board.
    parts = image[:, :300].reshape(300, 15, 20, 3).mean(axis=2)[np.arange(300) % 16 > 4]
    assert np.ptp(parts, axis=1).max() < 9
    assert len(np.unique(parts[::11, 0].round(-1), axis=0)) > 2
    part = model.window(40, 90, 50, 60, seed=1).image
    assert np.array_equal(part, out.image[40:90, 90:150])
    far = model.window(2**40 - 20, -(2**40), 50, 60, seed=1).image
    assert np.array_equal(far[20:, 9:], model.window(2**40, 9 - 2**40, 30, 51, seed=1).image)


def test_rows_of_mixed_colors_are_free():
    """What differs along a row may come from any row."""
    rng = np.random.default_rng(0)
    pixels = boards(128, 128, tone=2).astype(int)
    pixels += rng.integers(-30, 30, (8, 8, 1)).repeat(16, 0).repeat(16, 1)
    pixels[np.arange(128) % 16 < 2] = 20
    mixed = axis_of_rows(pixels.astype(np.uint8), (0, 16, 7, 0))
    assert mixed is None and axis_of_rows(boards(128, 128), (0, 16, 7, 0)) == 0
    assert axis_of_rows(boards(128, 128), (8, 14, -14, 8)) is None
    flat = np.full((128, 128, 3), 9, np.uint8)
    assert axis_of_rows(flat, (0, 16, 7, 0)) is None
