"""The answer and its renderings: replay, windows, layers, drawing, saving."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import weftex
from families import noise
from twins import compositing as reference
from weftex.errors import FileError, InvalidInputError

SAMPLE = np.random.default_rng(5).integers(0, 256, (30, 34, 3)).astype(np.uint8)
BLENDS = ("feather", "feather-at-end", "cut", "none")


def make(blend="feather", wrap=(False, False), patch_size=10, sample=SAMPLE, **more):
    method = weftex.PatchSampling(patch_size=patch_size, boundary_width=3, blend=blend)
    exemplar = weftex.Exemplar(sample, **more)
    return method.fit(exemplar).sample(weftex.Canvas(40, 45, wrap), seed=9)


def filled(known_from=(2, 3), patch_size=8):
    known = SAMPLE[2:28, 3:33].copy()
    hole = np.zeros(known.shape[:2], bool)
    hole[8:15, 10:22] = True
    known[hole] = 0
    mask = np.ones(SAMPLE.shape[:2], bool)
    mask[2:28, 3:33] = ~hole
    method = weftex.PatchSampling(patch_size=patch_size, boundary_width=2)
    canvas = weftex.Canvas(*hole.shape, known=known, hole=hole, known_from=known_from)
    return method.fit(weftex.Exemplar(SAMPLE, mask=mask)).sample(canvas, seed=4)


@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("wrap", [(False, False), (True, False), (True, True)])
def test_rendering_the_sample_is_the_image(blend, wrap):
    result = make(blend, wrap)
    assert np.array_equal(result.render(), result.image)
    assert np.array_equal(result.render(SAMPLE), result.image)
    assert np.array_equal(result.render(weftex.Exemplar(SAMPLE)), result.image)


@pytest.mark.parametrize("blend", BLENDS)
def test_the_slow_twin_renders_the_same(blend):
    result = make(blend, (True, True))
    out = np.zeros_like(result.image)
    arrays = result.placements, result.weights, result.cuts
    reference.paste_all(out, SAMPLE, 0, 0, result.shape, *arrays)
    assert np.array_equal(out, result.image)


@pytest.mark.parametrize("blend", BLENDS)
@pytest.mark.parametrize("scale", [1, 2, 3])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_maps_at_multiples_and_depths(rng, blend, scale, dtype):
    result = make(blend)
    for channels in ((), (1,), (3,), (5,)):
        big = (rng.random((30 * scale, 34 * scale, *channels)) * 250).astype(dtype)
        got = result.render(big)
        assert got.dtype == dtype
        assert got.shape == (40 * scale, 45 * scale, *channels)
        # Each phase of a larger map is a map of the sample's own size.
        for v in range(scale):
            for u in range(scale):
                one = result.render(np.ascontiguousarray(big[v::scale, u::scale]))
                assert np.array_equal(got[v::scale, u::scale], one)


@pytest.mark.parametrize("make_one", [lambda: make("cut"), lambda: make(wrap=(True, True)), filled])
def test_windows_are_parts_of_the_whole(rng, make_one):
    result = make_one()
    height, width = result.shape
    coordinates, shares = result.layers()
    windows = [(0, 0, 1, 1), (height - 1, width - 1, 1, 1), (0, 0, height, width), (5, 7, 11, 3)]
    big = rng.integers(0, 65536, (60, 68)).astype(np.uint16)
    for top, left, rows, columns in windows:
        part = slice(top, top + rows), slice(left, left + columns)
        window = (top, left, rows, columns)
        assert np.array_equal(result.render(window=window), result.image[part])
        got = result.layers(window)
        assert np.array_equal(got[0], coordinates[part])
        assert np.array_equal(got[1], shares[part])
        twice = slice(2 * top, 2 * (top + rows)), slice(2 * left, 2 * (left + columns))
        assert np.array_equal(result.render(big, window=window), result.render(big)[twice])


def test_a_window_leaves_the_image_alone():
    result = make("feather-at-end")
    part = result.render(window=(3, 4, 5, 6))
    assert result.image.shape == (40, 45, 3)
    assert np.array_equal(result.image[3:8, 4:10], part)


@pytest.mark.parametrize(
    "window", [(-1, 0, 5, 5), (0, -1, 5, 5), (0, 0, 0, 5), (0, 0, 5, -1), (36, 0, 5, 5),
               (0, 41, 5, 5), (0, 0, 41, 1)],
)  # fmt: skip
def test_windows_outside_are_refused(window):
    result = make()
    for ask in (lambda: result.render(window=window), lambda: result.layers(window)):
        with pytest.raises(InvalidInputError, match="window"):
            ask()


@pytest.mark.parametrize("blend", BLENDS)
def test_layers_say_what_the_picture_is_made_of(blend):
    """The weighted mean of the layers is the picture, up to its rounding at each patch."""
    result = make(blend, (False, True))
    coordinates, shares = result.layers()
    assert coordinates.shape == (40, 45, 4, 2) and coordinates.dtype == np.int32
    assert shares.shape == (40, 45, 4) and shares.dtype == np.float32
    assert np.allclose(shares.sum(axis=2), 1, atol=1e-6)
    assert (np.diff(shares, axis=2) <= 0).all()
    assert ((coordinates[..., 0] == -1) == (shares == 0)).all()
    there = coordinates[shares > 0]
    assert (there >= 0).all() and (there < SAMPLE.shape[:2]).all()
    values = SAMPLE[coordinates[..., 0], coordinates[..., 1]] * shares[..., None]
    assert np.abs(values.sum(axis=2) - result.image).max() <= 2
    if blend in ("cut", "none"):
        assert set(np.unique(shares)) == {0.0, 1.0}


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
@pytest.mark.parametrize("size", [(24, 41), (31, 45)])
def test_shares_sum_to_one_with_the_widest_boundary(wrap, size):
    """Half of a patch: three patches meet along each axis, nine in a corner."""
    method = weftex.PatchSampling(patch_size=16, boundary_width=8)
    result = method.fit(weftex.Exemplar(SAMPLE)).sample(weftex.Canvas(*size, wrap), seed=1)
    assert np.allclose(result.layers()[1].sum(axis=2), 1, atol=1e-6)


@pytest.mark.parametrize("blend", ["feather", "cut"])
@pytest.mark.parametrize("boundary_width", [3, 5])
def test_layers_are_the_slow_twins(blend, boundary_width):
    """Where half of a patch is its boundary up to nine patches meet, and four are kept."""
    method = weftex.PatchSampling(patch_size=10, boundary_width=boundary_width, blend=blend)
    result = method.fit(weftex.Exemplar(SAMPLE)).sample((40, 45), seed=9)
    window = (6, 4, 20, 23)
    coordinates, shares = result.layers(window)
    plan = result.placements, result.weights, result.cuts
    for (i, j), entries in reference.layers(window, result.shape, *plan).items():
        whole = sum(share for _, share in entries)  # less than 1 where a fifth was dropped
        for n, (p, share) in enumerate(entries):
            y, x, sy, sx, _ = result.placements[p].tolist()
            at = ((6 + i - y) % 40 + sy) % 30, ((4 + j - x) % 45 + sx) % 34
            assert tuple(coordinates[i, j, n]) == at
            assert shares[i, j, n] == pytest.approx(share / whole, abs=1e-6)


def test_source_is_the_heaviest_layer():
    result = make()
    assert result.source.dtype == np.int32
    assert np.array_equal(result.source, result.layers()[0][:, :, 0])


def test_source_of_a_tall_result_is_put_together_from_bands():
    result = weftex.synthesize(SAMPLE, (600, 20), seed=1, method="patch-sampling", patch_size=10)
    assert np.array_equal(result.source, result.layers()[0][:, :, 0])


def test_known_pixels_of_a_filled_photo():
    result = filled()
    hole = result.canvas.hole
    assert np.array_equal(result.image[~hole], SAMPLE[2:28, 3:33][~hole])
    y, x = np.nonzero(~hole)
    assert np.array_equal(result.source[y, x], np.stack([y + 2, x + 3], axis=1))
    _coordinates, shares = result.layers()
    assert (shares[y, x, 0] == 1).all() and (shares[y, x, 1:] == 0).all()
    assert np.allclose(shares.sum(axis=2), 1, atol=1e-6)
    normals = np.arange(30 * 34, dtype=np.uint16).reshape(30, 34)
    assert np.array_equal(result.render(normals)[~hole], normals[2:28, 3:33][~hole])


def test_known_pixels_from_elsewhere():
    result = filled(known_from=None)
    hole = result.canvas.hole
    assert (result.source[~hole] == -1).all() and (result.source[hole] >= 0).all()
    normals = np.zeros((60, 68), np.uint16)
    with pytest.raises(InvalidInputError, match="give their map as background"):
        result.render(normals)
    background = np.full((52, 60), 7, np.uint16)
    assert (
        result.render(normals, background=background)[~hole.repeat(2, 0).repeat(2, 1)] == 7
    ).all()
    for bad in (
        background[:-1],
        background[:26, :30],
        background.astype(np.uint8),
        background[..., None],
    ):
        with pytest.raises(InvalidInputError, match="background is"):
            result.render(normals, background=bad)


@pytest.mark.parametrize(
    "shape", [(29, 34), (15, 17), (60, 34), (30, 68), (61, 68), (30, 35), (1, 1)]
)
def test_maps_of_another_size_are_refused(shape):
    with pytest.raises(InvalidInputError, match="integer multiple"):
        make().render(np.zeros(shape, np.uint8))


def test_maps_that_cannot_be_used_are_refused():
    for bad in (np.zeros((30, 34), bool), np.full((30, 34), np.nan), np.zeros((30, 34), int)):
        with pytest.raises(InvalidInputError):
            make().render(bad)


def test_maps_come_along():
    height = np.arange(30 * 34, dtype=np.uint16).reshape(30, 34)
    result = make(maps={"height": height})
    assert set(result.maps) == {"height"}
    assert np.array_equal(result.maps["height"], result.render(height))
    assert make().maps == {}


def test_pictures_with_alpha():
    sample = np.concatenate([SAMPLE, SAMPLE[..., :1]], axis=2)
    result = make(sample=sample)
    assert result.image.shape == (40, 45, 4)
    out = np.zeros_like(result.image)
    arrays = result.placements, result.weights, result.cuts
    reference.paste_all(out, sample, 0, 0, result.shape, *arrays, alpha=True)
    assert np.array_equal(out, result.image)
    straight = result.render(weftex.Exemplar(sample, alpha=False))
    assert not np.array_equal(straight, result.image)


@pytest.mark.parametrize("make_one", [make, lambda: make("cut", (True, False)), filled])
def test_saved_and_loaded(tmp_path, make_one):
    result = make_one()
    path = tmp_path / "result.npz"
    result.save(path)
    known = result.canvas.known
    loaded = weftex.Synthesis.load(path, exemplar=result.exemplar, known=known)
    assert np.array_equal(loaded.image, result.image)
    assert np.array_equal(loaded.source, result.source)
    assert loaded.canvas.wrap == result.canvas.wrap and loaded.shape == result.shape
    assert loaded.provenance == result.provenance
    assert loaded.provenance["method"] == "patch-sampling" and "seed" in loaded.provenance
    again = tmp_path / "again.npz"
    loaded.save(again)
    assert again.stat().st_size == pytest.approx(path.stat().st_size, abs=64)
    alone = weftex.Synthesis.load(path)
    normals = np.arange(60 * 68, dtype=np.float32).reshape(60, 68)
    assert np.array_equal(alone.render(normals), result.render(normals))
    for ask in (lambda: alone.image, lambda: alone.maps, alone.draw, alone.render):
        if ask == alone.draw:
            assert np.array_equal(alone.draw(), result.draw())
            continue
        with pytest.raises(InvalidInputError, match="without its sample"):
            ask()


def test_a_saved_result_is_small(tmp_path):
    result = weftex.synthesize("sample:pebbles", (1024, 1024), method="patch-sampling", seed=1)
    result.save(tmp_path / "wall.npz")
    assert (tmp_path / "wall.npz").stat().st_size < result.image.nbytes / 50


def damage(path, **changes):
    with np.load(path) as file:
        arrays = dict(file)
    about = json.loads(str(arrays["about"]))
    for key, value in changes.items():
        if key in arrays:
            arrays[key] = value(arrays[key])
        else:
            about[key] = value(about.get(key))
    arrays["about"] = np.array(json.dumps(about))
    np.savez(path, **arrays)


def put(index, value):
    def change(array):
        array = array.copy()
        array[index] = value
        return array

    return change


DAMAGE = {
    "zone beyond the weights": {"placements": put((0, 4), 99)},
    "negative zone": {"placements": put((0, 4), -1)},
    "negative position": {"placements": put((0, 0), -7)},
    "negative source": {"placements": put((0, 3), -(10**6))},
    "placements cut short": {"placements": lambda a: a[:, :3].copy()},
    "floating placements": {"placements": lambda a: a.astype(float)},
    "weights of another kind": {"weights": lambda a: a.astype(np.float32)},
    "weights past 256": {"weights": put((0, 0, 0), 60000)},
    "flat weights": {"weights": lambda a: a.ravel()},
    "cuts of another width": {"cuts": lambda a: np.zeros((1, 3), np.uint16)},
    "no sample": {"sample_shape": lambda _: [0, 0]},
    "another format": {"format": lambda _: 99},
    "a size that is none": {"shape": lambda _: [0, -4]},
    "three sides": {"shape": lambda _: [1, 2, 3]},
    "a side of half a pixel": {"shape": lambda _: [30.5, 34]},
    "sides of truth": {"shape": lambda _: [True, True]},
    "a negative sample": {"sample_shape": lambda _: [-30, -34]},
    "three sides of the sample": {"sample_shape": lambda _: [30, 34, 3]},
    "a sample that is a text": {"sample_shape": lambda _: "30x34"},
    "a huge sample": {"sample_shape": lambda _: [2**20, 2**20]},
    "a huge output": {"shape": lambda _: [2**20, 2**20]},
    "places that are none": {"origin": lambda _: [0.5, None]},
    "known from nowhere": {"known_from": lambda _: ["a", "b"]},
    "wrap of numbers": {"wrap": lambda _: [0, 1]},
    "no provenance": {"provenance": lambda _: [1]},
    "arrays of the other byte order": {"placements": lambda a: a.astype(">i4")},
    "objects": {"weights": lambda a: a.astype("datetime64[D]")},
    "more than its sizes need": {"cuts": lambda a: np.zeros((2**16, 2**10), np.uint16)},
}
LOAD = """
import sys, numpy as np, weftex
try:
    result = weftex.Synthesis.load(sys.argv[1])
    result.render(np.zeros((30, 34), np.uint8)); result.source
except weftex.WeftexError as error:
    print("refused:", error)
"""


@pytest.mark.parametrize("what", DAMAGE)
def test_damaged_files_are_refused(tmp_path, what):
    """In a process of its own, for a kernel that trusts a bad file brings the whole one down."""
    path = tmp_path / "result.npz"
    make().save(path)
    damage(path, **DAMAGE[what])
    done = subprocess.run(
        [sys.executable, "-c", LOAD, str(path)],
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-300:] or f"died of signal {-done.returncode}"
    assert done.stdout.startswith("refused:")


@pytest.mark.parametrize("order", ["F", "view"])
def test_the_order_of_bytes_in_arrays_does_not_matter(tmp_path, order):
    result = make()
    path = tmp_path / "result.npz"
    result.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    for name in ("placements", "weights", "cuts"):
        arrays[name] = np.asfortranarray(arrays[name])
        if order == "view":
            arrays[name] = np.repeat(arrays[name], 2, axis=0)[::2]
    np.savez(path, **arrays)
    again = weftex.Synthesis.load(path, result.exemplar)
    assert np.array_equal(again.image, result.image)


def test_a_hole_of_another_type_is_refused(tmp_path):
    hole = np.zeros((12, 13), bool)
    hole[3:6, 4:9] = True
    path = tmp_path / "result.npz"
    weftex.fill(noise((12, 13, 3)), hole, seed=1).save(path)
    for change in (lambda a: a.astype(np.int64), lambda a: a.astype(float), np.ravel):
        weftex.fill(noise((12, 13, 3)), hole, seed=1).save(path)
        damage(path, hole=change)
        with pytest.raises(FileError, match="its hole does not fit"):
            weftex.Synthesis.load(path)


def test_a_bomb_is_refused_from_its_header(tmp_path):
    """Few kilobytes that unpack to 8 GB, of which not one is unpacked."""
    import tracemalloc
    import zipfile

    path = tmp_path / "result.npz"
    make().save(path)
    header = {"descr": "<i4", "fortran_order": False, "shape": (2**31, 1)}
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file,
        file.open("bomb.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(member, header)
        member.write(bytes(2**20))
    tracemalloc.start()
    with pytest.raises(FileError, match="its arrays are larger than its sizes need"):
        weftex.Synthesis.load(path)
    assert tracemalloc.get_traced_memory()[1] < 2**22
    tracemalloc.stop()


@pytest.mark.parametrize("size", [0, 1, 50, -1])
def test_truncated_files_are_refused(tmp_path, size):
    path = tmp_path / "result.npz"
    make().save(path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(FileError, match=r"result\.npz is not a saved weftex result"):
        weftex.Synthesis.load(path)


def test_files_of_another_kind_are_refused(tmp_path):
    with pytest.raises(FileError, match="does not exist"):
        weftex.Synthesis.load(tmp_path / "nothing.npz")
    text = tmp_path / "text.npz"
    text.write_text("hello")
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(text)
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(other)
    with pytest.raises(FileError):
        weftex.Synthesis.load(tmp_path)
    np.savez(other, about=np.array("[1]"), placements=0, weights=0, cuts=0)
    with pytest.raises(FileError, match="is not a saved weftex result"):
        weftex.Synthesis.load(other)


@pytest.mark.parametrize("blend", BLENDS)
def test_drawings(blend):
    result = make(blend)
    for what in ("sources", "seams", "error"):
        drawing = result.draw(what)
        assert drawing.shape == (40, 45, 3) and drawing.dtype == np.uint8
    sources = result.draw("sources")
    y, x = np.moveaxis(result.source, -1, 0)
    assert np.array_equal(sources[..., 0], np.rint(x * (255 / 33)))
    assert np.array_equal(sources[..., 1], np.rint(y * (255 / 29)))
    red = (result.draw("seams") == (255, 0, 0)).all(axis=2)
    assert 0 < red.sum() < red.size
    # No seam inside a patch: every second neighbor pair that goes on is not red.
    step = np.diff(result.source, axis=1)
    goes_on = (step == (0, 1)).all(axis=2)
    goes_down = (np.diff(result.source, axis=0) == (1, 0)).all(axis=2)
    assert not red[1:, 1:][goes_on[1:] & goes_down[:, 1:]].any()
    assert red[:, 1:][~goes_on].all()


def test_error_is_where_patches_overlap():
    result = make("cut")
    error = result.draw("error")[..., 0]
    assert error.max() > 20
    share = make("feather").layers()[1]
    alone = share[..., 0] == 1
    assert alone.any() and error[alone].max() == 0
    flat = make(sample=np.full((30, 34), 9, np.uint8)).draw("error")
    assert flat.max() == 0


def test_drawing_a_filled_photo():
    result = filled(known_from=None)
    assert (result.draw("sources")[~result.canvas.hole] == 0).all()
    for what in ("seams", "error"):
        assert result.draw(what).shape == (*result.shape, 3)


def test_unknown_drawings_are_refused():
    with pytest.raises(InvalidInputError, match="cannot draw 'colors'"):
        make().draw("colors")


def test_results_can_be_pickled():
    result = make("cut")
    copy = pickle.loads(pickle.dumps(result))
    assert np.array_equal(copy.image, result.image)
    assert np.array_equal(copy.source, result.source)


@given(st.integers(1, 60), st.integers(1, 60), st.sampled_from(BLENDS), st.integers(0, 99))
def test_any_size_is_covered(height, width, blend, seed):
    method = weftex.PatchSampling(patch_size=8, boundary_width=2, blend=blend)
    result = method.fit(weftex.Exemplar(SAMPLE)).sample((height, width), seed=seed)
    assert result.image.shape == (height, width, 3)
    assert (result.source >= 0).all()
    assert np.allclose(result.layers()[1].sum(axis=2), 1, atol=1e-6)
