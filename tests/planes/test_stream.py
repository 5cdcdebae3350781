"""Planes on disk: the same bytes in one run, in threads, in parts, and after it was cut off."""

import errno
import os

import numpy as np
import pytest

import weftex
from commands import listing
from families import noise, refused
from weftex.errors import CancelledError, FileError
from weftex.planes import check, open_plane, stream
from weftex.planes.definition import Definition, define
from weftex.planes.plane_file import PlaneFile
from weftex.planes.tiff import TiffStore
from weftex.planes.writing import write_plane

SIZE = (300, 333)
TILE = weftex.BestTile(lattice=(20, 0, 0, 20))
HOW = {"method": TILE, "seed": 4, "block": 64}


@pytest.fixture(scope="module")
def sample():
    height = noise((120, 128), seed=1, dtype=np.uint16)
    maps = {"height": height, "normal": noise((60, 64, 3), seed=2)}
    return weftex.Exemplar(noise((60, 64, 3)), maps=maps)


def plain(folder):
    """The bytes of a plane's files by their names; journals tell who wrote what."""
    return {p.relative_to(folder).as_posix(): data for p, data in listing(folder).items()
            if data is not None and ".run" not in p.as_posix()}  # fmt: skip


@pytest.fixture(scope="module")
def whole(sample, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    found = stream(sample, folder / "p.tif", SIZE, threads=1, **HOW)
    assert (found.blocks, found.made, found.pixels) == (39, 39, 300 * 333)
    return plain(folder)


def test_the_pixels_are_those_of_windows(sample, whole, tmp_path):
    assert sorted(whole) == ["p_color.tif", "p_height.tif", "p_normal.tif"]
    made = TILE.fit(sample).window(0, 0, *SIZE, seed=4)
    for name, pixels in {"color": made.image, **made.maps}.items():
        (tmp_path / "a.tif").write_bytes(whole[f"p_{name}.tif"])
        assert (weftex.read_image(tmp_path / "a.tif").pixels == pixels).all()


def test_threads_and_a_second_run(sample, whole, tmp_path):
    stream(sample, tmp_path / "p.tif", SIZE, threads=3, **HOW)
    again = stream(sample, tmp_path / "p.tif", SIZE, **HOW | {"seed": None})
    assert (again.blocks, again.made) == (39, 0) and plain(tmp_path) == whole
    assert check(tmp_path / "p.tif", read=True).definition.seed == 4


def test_a_run_that_was_cut_off_goes_on(sample, whole, tmp_path):
    with pytest.raises(CancelledError):
        stream(sample, tmp_path / "p.tif", SIZE, progress=lambda n, *_: n < 7, threads=1, **HOW)
    plane = open_plane(tmp_path / "p.tif")
    assert plane.missing() == 32
    refused("is not complete: .* blocks are missing", check, plane.path, error=FileError)
    assert stream(sample, tmp_path / "p.tif", SIZE, **HOW).made == 32
    assert plain(tmp_path) == whole


def test_parts_are_the_whole(sample, whole, tmp_path):
    target = str(tmp_path / "p.tif")
    made_of = define(sample, SIZE, TILE, {}, seed=4, block=64)
    made = [write_plane(PlaneFile(made_of, target, (k, 3))).made for k in (3, 1, 1)]
    assert made == [10, 10, 0]
    refused(r"10 blocks are missing; parts .* 2/3 \(10 blocks\)", check, target, error=FileError)
    assert write_plane(PlaneFile(made_of, target, (2, 3))).made == 10
    refused("only overviews are missing", check, target, error=FileError)
    assert write_plane(PlaneFile(made_of, target)).made == 9
    assert plain(tmp_path) == whole


def test_other_runs_are_refused(sample, tmp_path):
    target = tmp_path / "p.tif"
    stream(sample, target, 100, **HOW)
    before = listing(tmp_path)
    for change, why in [
        ({"seed": 5}, "its seed is 4, here 5"),
        ({"block": 128}, "its block is 64, here 128"),
        ({"method": weftex.BestTile(lattice=(30, 0, 0, 20))}, "its lattice is"),
    ]:
        refused(why, stream, sample, target, 100, **HOW | change)
    refused("its sample is different", stream, noise((60, 64, 3)), target, 100, **HOW)
    assert listing(tmp_path) == before
    stream(sample, target, 100, restart=True, **HOW | {"seed": 5})
    assert open_plane(target).definition.seed == 5


def test_without_its_file_nothing_counts_as_done(sample, tmp_path):
    one = weftex.Exemplar(sample.pixels)
    stream(one, tmp_path / "p.tif", 100, restart=True, **HOW)
    (tmp_path / "p.tif").unlink()
    assert stream(one, tmp_path / "p.tif", 100, **HOW).made == 4


def test_a_disk_that_fills(sample, whole, tmp_path, monkeypatch):
    put, calls = TiffStore.put, []

    def fill(self, place, pixels):
        calls.append(place)
        if len(calls) > 20:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(self, place, pixels)

    monkeypatch.setattr(TiffStore, "put", fill)
    with pytest.raises(FileError, match="No space left on device; finished blocks are kept"):
        stream(sample, tmp_path / "p.tif", SIZE, threads=1, **HOW)
    monkeypatch.undo()
    assert stream(sample, tmp_path / "p.tif", SIZE, **HOW).made == 33
    assert plain(tmp_path) == whole


def test_a_run_that_fails_at_once_leaves_nothing(sample, tmp_path, monkeypatch):
    monkeypatch.setattr(TiffStore, "put", lambda *_: (_ for _ in ()).throw(OSError(5, "broken")))
    refused("cannot write: broken", stream, sample, tmp_path / "p.tif", 100, **HOW, error=FileError)
    assert list(tmp_path.iterdir()) == []


def test_recipes_on_disk(sample, tmp_path):
    plain = sample.changed(weights={"height": 2.0}, mask=np.ones((60, 64), bool), icc=b"i")
    copies = weftex.prepare.turned(plain, "4")
    patches = weftex.Quilting(patch_size=20)
    for weights, method in ((plain, TILE), (plain, patches), (copies, patches)):
        axes = "x" if method is not TILE else False
        recipe = define(weights, SIZE, method, {}, seed=4, tileable=axes)
        recipe.save(str(tmp_path / "r.npz"))
        found = Definition.load(str(tmp_path / "r.npz"))
        assert found.about == recipe.about and found.method == method
        assert found.exemplar.weights == weights.weights and found.exemplar.icc == b"i"
        assert found.exemplar.copy_shape == weights.copy_shape


def test_auto_is_the_method_that_it_names(tmp_path):
    stream("sample:bricks", tmp_path / "a.tif", (70, 90), seed=1, block=64)
    model = weftex.Auto().fit("sample:bricks")
    expected = model.window(0, 0, 70, 90, seed=1).image
    assert (weftex.read_image(tmp_path / "a.tif").pixels == expected).all()
    recipe = open_plane(tmp_path / "a.tif").definition
    assert recipe.method.slug == "graphcut" and "lattice" in recipe.reason
    strained = define("sample:bricks", (256, 260), "auto", {}, seed=1, tileable=True)
    assert "\nnote: the lattice has to be stretched by " in strained.reason


def test_a_plane_that_repeats(sample, tmp_path):
    one = weftex.Exemplar(sample.pixels)
    stream(one, tmp_path / "a.tif", (128, 192), method="quilting", seed=1, tileable="x", block=64)
    pixels = weftex.read_image(tmp_path / "a.tif").pixels
    made = weftex.Quilting().fit(one).window(0, -96, 128, 192, seed=1, period=(256, 192)).image
    assert (np.roll(pixels, 96, axis=1) == made).all()


def test_arguments_that_are_none(sample, tmp_path):
    for change, why in [
        ({"size": (0, 5)}, "size is"),
        ({"size": 2**41}, "from 1 to 2"),
        ({"tileable": "z"}, "tileable is"),
        ({"block": 65}, "block is 65; it must be a power of two from 64 to 4096"),
        ({"block": True}, "block is True"),
    ]:
        how = {"size": 100} | HOW | change
        refused(why, stream, sample, tmp_path / "p.tif", **how)
    strained = HOW | {"method": weftex.BestTile(lattice=(12, 0, 0, 12)), "tileable": True}
    refused("stretched by .* fits", stream, sample, tmp_path / "p.tif", 67, **strained)
    assert not list(tmp_path.iterdir())
