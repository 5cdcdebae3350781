"""Windows of endless planes: the bytes of a pixel hang on nothing but its place."""

import pickle
import random
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import weftex
from families import METHODS, method_of, noise, refused
from twins.planes import whole_plane
from weftex.endless.grid import Sizes
from weftex.endless.plane import BlockCache
from weftex.method import Model

FAR = 2**40


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of 40 pixels, for methods that take long."""
    monkeypatch.setattr(Model, "block_sizes", lambda _: Sizes(pitch=40, belt=12))


def fitted(slug, **parameters):
    sample = noise((30, 31, 3), values=5)
    return method_of(slug, **parameters).fit(weftex.Exemplar(sample, maps={"same": sample}))


@pytest.mark.parametrize("slug", METHODS)
def test_windows_agree_in_any_order_on_any_thread(slug, small_blocks):
    model = fitted(slug)
    top, left = FAR - 20, -FAR
    whole = model.window(top, left, 50, 64, seed=3, threads=1)
    assert whole.is_window and whole.canvas.origin == (top, left)
    assert (whole.source >= 0).all() and (whole.source < (30, 31)).all()
    assert np.array_equal(whole.render(), whole.image)
    assert np.array_equal(whole.maps["same"], whole.image)
    corners = [(y, x) for y in (0, 9, 20) for x in (0, 25)]
    random.Random(7).shuffle(corners)
    other = pickle.loads(pickle.dumps(model))

    def part(corner):
        y, x = corner
        return other.window(top + y, left + x, 30, 39, seed=3, threads=2)

    with ThreadPoolExecutor(3) as pool:
        for (y, x), found in zip(corners, pool.map(part, corners), strict=True):
            assert np.array_equal(found.image, whole.image[y : y + 30, x : x + 39])
            assert np.array_equal(found.source, whole.source[y : y + 30, x : x + 39])
    assert not np.array_equal(other.window(top, left, 50, 64, seed=4).source, whole.source) or (
        slug == "best-tile"
    )


@pytest.mark.parametrize("period", [None, 331])
@pytest.mark.parametrize("slug", ["graphcut", "refinement"])
def test_blocks_are_those_of_the_slow_twin(slug, period, monkeypatch):
    sizes = Sizes(80, 30, loose=10) if slug == "graphcut" else Sizes(80, 24, around=12)
    small = {"patch_size": 24, "candidates": 2} if slug == "graphcut" else {"iterations": 2}
    model = weftex.METHODS[slug](**small).fit("sample:pebbles")
    monkeypatch.setattr(type(model), "block_sizes", lambda _: sizes)
    area = whole_plane(model, 5, [-1, 0, 1], period)
    shown, (top, left) = area.shown, area.corner
    slack = 2 * sizes.belt
    height, width = (n - 2 * slack for n in shown.shape)
    made = model.window(top + slack, left + slack, height, width, seed=5, period=period)
    found = made.source[..., 0] * 192 + made.source[..., 1]
    assert np.array_equal(found, shown[slack:-slack, slack:-slack])


@pytest.mark.parametrize("slug", ["patch-sampling", "quilting", "graphcut", "near-regular"])
def test_a_plane_with_a_period_comes_back_to_itself(slug, small_blocks):
    model, period = fitted(slug), (97, 112)
    start = model.window(0, 0, 40, 50, seed=3, period=period)
    across = model.window(97 - 10, -112 * 2**20 - 7, 50, 57, seed=3, period=period)
    assert np.array_equal(across.image[10:, 7:], start.image)
    assert start.provenance["period"] == [97, 112]
    huge = model.window(FAR - 9, -9, 9, 9, seed=3, period=FAR)
    assert np.array_equal(huge.image, model.window(-9, FAR - 9, 9, 9, seed=3, period=FAR).image)


def test_patches_that_lie_on_a_lattice_come_back_too():
    model = weftex.Quilting().fit("sample:bricks")  # whose vectors do not divide the period
    start = model.window(0, 0, 90, 80, seed=3, period=(170, 200)).source
    there = model.window(170 * 2**20 - 20, -400 - 9, 110, 89, seed=3, period=(170, 200)).source
    assert np.array_equal(there[20:, 9:], start)


def test_entire_patches_leave_no_straight_seams_between_blocks():
    """They may reach as far into the blocks around as these may be cut again."""
    sample = weftex.load_exemplar("sample:leaves").pixels[:96, :96]
    model = weftex.GraphCut(placement="entire").fit(sample)
    source = model.window(1000, 1000, 260, 260, seed=1).source
    for axis in (0, 1):
        step = np.arange(2) == axis
        cut = (np.roll(source, -1, axis) != source + step).any(axis=2)
        for line in (cut if axis == 0 else cut.T)[:-1]:
            runs = "".join(".#"[int(c)] for c in line).split(".")
            assert max(map(len, runs)) < 80


def test_steps_are_spread_between_the_nodes_of_a_plane(tmp_path):
    sample = weftex.load_exemplar("sample:leaves")
    model = weftex.GraphCut(placement="entire").fit(sample)
    whole = model.window(-40, -300, 260, 300, seed=1)
    part, between = (model.window(y, -99, n, 60, seed=1) for y, n in ((3, 50), (-1, 2)))
    assert np.array_equal(between.image, whole.image[39:41, 201:261])  # on a line of nodes
    part.save(path := tmp_path / "part.npz")
    large = sample.pixels.repeat(2, 0).repeat(2, 1)
    for one in (part, weftex.Synthesis.load(path, sample)):
        assert np.array_equal(one.image, whole.image[43:93, 201:261])
        assert np.array_equal(one.render(large), whole.render(large)[86:186, 402:522])
    spread = (whole.image != sample.pixels[tuple(np.moveaxis(whole.source, 2, 0))]).any(axis=2)
    assert spread[40].any() and spread[:, 44].any() and not spread[39:41, 43:45].any()
    for wrong in (part.cells + [0, 99], part.cells * [1, -1], part.cells[1:], part.cells[:, 1:]):
        part.cells = wrong
        part.save(path)
        refused("is (damaged|not a saved)", weftex.Synthesis.load, path, error=weftex.FileError)


def test_auto_settles_on_one_method_for_all_windows():
    model = weftex.Auto().fit("sample:tiles")
    made = model.window(-5, 7, 30, 40, seed=1)
    assert made.provenance["method"] == "graphcut" and made.provenance["lattice"]
    assert "has a lattice" in made.provenance["reason"]
    assert np.array_equal(made.image[2:], model.window(-3, 7, 28, 40, seed=1).image)
    around = model.window(0, 0, 30, 40, seed=1, period=2**20)
    assert around.provenance["method"] == "near-regular"
    strained = model.window(0, 0, 30, 40, seed=1, period=250)
    assert strained.provenance["method"] == "quilting"
    assert "does not fit a tileable 250x250" in strained.provenance["reason"]


def test_a_masked_sample_is_used_where_it_may_be():
    mask = np.zeros((192, 192), bool)
    mask[:, :90] = True
    sample = weftex.load_exemplar("sample:pebbles").changed(mask=mask)
    for method in (weftex.GraphCut(patch_size=30), weftex.Quilting(patch_size=30)):
        made = method.fit(sample).window(10, 20, 150, 120, seed=1)
        assert mask[made.source[..., 0], made.source[..., 1]].all()


@pytest.mark.parametrize(
    "period, said",
    [
        (50, "period has the height 50; it must be"),
        ((10**6, 50), "period has the width 50; it must be"),
        (0, "period is 0; it must be a whole number"),
        (2.5, "period is 2.5; it must be"),
        (True, "period is True; it must be"),
        ((1, 2, 3), r"period is \(1, 2, 3\); it must be"),
        (2**41, "it must be a whole number of pixels from 1 to"),
    ],
)
@pytest.mark.parametrize("slug", ["quilting", "graphcut"])
def test_bad_periods_are_refused_in_one_line(period, said, slug):
    model = weftex.METHODS[slug]().fit("sample:pebbles")
    refused(said, model.window, 0, 0, 9, 9, seed=1, period=period)


@pytest.mark.parametrize("slug", ["near-regular", "best-tile", "refinement"])
def test_lattices_are_stretched_to_come_back(slug):
    model = weftex.METHODS[slug]().fit("sample:tiles")
    around = (613, 621) if slug == "refinement" else (401, 409)
    start = model.window(-9, -9, 29, 39, seed=3, period=around).source
    down, across = 3 * around[0] - 9, -(2**21) * around[1] - 20
    there = model.window(down, across, 29, 50, seed=3, period=around).source
    assert np.array_equal(there[:, 11:], start)
    huge = model.window(FAR - 9, -9, 9, 9, seed=3, period=FAR).source
    assert np.array_equal(huge, model.window(-9, FAR - 9, 9, 9, seed=3, period=FAR).source)


def test_a_best_tile_with_a_period_is_the_tileable_picture():
    model = weftex.BestTile(lattice=(20, 3, -4, 24)).fit("sample:tiles")
    whole = model.sample((170, 146), seed=1, tileable=True).image
    made = model.window(-170, 292, 200, 190, seed=1, period=(170, 146)).image
    assert np.array_equal(made, np.tile(whole, (2, 2, 1))[:200, :190])


def test_methods_that_cannot_refuse_in_one_line(monkeypatch):
    for slug in ("near-regular", "best-tile"):
        model = weftex.METHODS[slug]().fit("sample:tiles")
        refused("stretched by .* fits$", model.window, 0, 0, 9, 9, seed=1, period=250)
    monkeypatch.setattr(weftex.GraphCut, "supports", frozenset({"wrap"}))
    window, error = fitted("graphcut").window, weftex.UnsupportedError
    refused("support parts of an endless", window, 0, 0, 9, 9, seed=1, error=error)


def test_a_window_is_cancelled_by_its_progress():
    model = weftex.GraphCut().fit("sample:pebbles")
    with pytest.raises(weftex.CancelledError):
        model.window(0, 0, 300, 300, seed=1, progress=lambda *_: False)
    seen = []
    model.window(0, 0, 300, 300, seed=1, progress=lambda *now: seen.append(now))
    assert seen[-1][0] == seen[-1][1] and seen[-1][2] == "blocks"
    assert seen[-1][3]().shape == (300, 300, 3)


def test_two_threads_make_a_block_once_and_errors_go_to_both():
    cache, made, gate = BlockCache(1000), [], threading.Event()

    def make():
        made.append(1)
        gate.wait(5)
        return np.zeros(10)

    with ThreadPoolExecutor(2) as pool:
        both = [pool.submit(cache.get, "a", make) for _ in range(2)]
        while not made:
            pass
        gate.set()
        assert both[0].result() is both[1].result() and len(made) == 1
    refused("by zero", cache.get, "b", lambda: np.zeros(1 // 0), error=ZeroDivisionError)
    assert cache.get("b", lambda: np.ones(3)).sum() == 3  # is tried again
    for k in range(30):
        cache.get(k, lambda: np.zeros(20))
    assert cache.size <= 1000 and 29 in cache and "a" not in cache


def test_entire_patches_keep_the_phase_of_their_lattice_in_all_blocks():
    tile = np.random.default_rng(0).integers(0, 255, (12, 10, 3), np.uint8)
    model = weftex.GraphCut(placement="entire", lattice=(10, 0, 0, 12)).fit(
        weftex.Exemplar(np.tile(tile, (6, 7, 1)))
    )
    made = model.window(-50, 70, 130, 120, seed=3).image
    y, x = np.ogrid[-50:80, 70:190]
    assert np.array_equal(made, tile[y % 12, x % 10])
