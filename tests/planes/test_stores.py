"""Blocks written in any order come back, also to other readers; pixels are halved by their kind."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import tifffile

from families import noise
from weftex.cli.planes import parse_part
from weftex.errors import FileError, InvalidInputError
from weftex.io.pictures import read_image
from weftex.planes import packing
from weftex.planes.files import open_stores
from weftex.planes.layout import Layout, check_block
from weftex.planes.locks import locked
from weftex.planes.owned import remove, sweep
from weftex.planes.record import Record, Run
from weftex.raster.mixing import Kind, Mixing

KINDS = [("uint8", 3, False), ("uint16", 4, True), ("float32", 0, False), ("uint8", 0, False)]


def written(path, shape, dtype, channels, alpha, block=64):
    """A store whose blocks were written from the last to the first, and the pixels of level 0."""
    layout = Layout(*shape, block, dtype, channels, alpha, Mixing(Kind.MEAN), b"profile" * 3)
    (store,) = open_stores(str(path), {"color": layout}, {}, {}).values()
    pixels = noise((*shape, *[channels] * (channels > 0)), dtype=np.dtype(dtype).type)
    store.create()
    assert not store.flaws()
    whole = {0: pixels}
    for level in range(1, store.levels):
        whole[level] = layout.mixing.halved(whole[level - 1])
    for place in reversed([*layout.places(0)]):
        top, left, height, width = layout.window(place)
        store.write(place, pixels[top : top + height, left : left + width])
    for level in range(1, store.levels):
        for place in layout.places(level):
            sums = {one: store.sum_of(one) for one in layout.below(place)}
            store.write(place, store.reduced(place, sums))
    return store, whole


@pytest.mark.parametrize("suffix", [".tif", ".zarr", ".dzi"])
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind[0])
def test_what_was_written_is_read(tmp_path, suffix, kind):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    if suffix == ".dzi" and kind[0] == "float32":
        with pytest.raises(InvalidInputError, match=r"PNG tiles, which do not hold float32"):
            written(tmp_path / "a.dzi", (10, 10), *kind)
        return
    store, whole = written(tmp_path / f"a{suffix}", (201, 330), *kind)
    assert store.levels == {".dzi": 10}.get(suffix, 1)
    for level, pixels in whole.items():
        assert (store.read(level, (0, 0, *pixels.shape[:2])) == pixels).all()
    assert (store.read(0, (63, 100, 70, 101)) == whole[0][63:133, 100:201]).all()
    for root in store.roots:
        remove(root, store.grid)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "kind", [*KINDS, ("uint16", 5, False)], ids=lambda kind: f"{kind[0]}-{kind[1]}"
)
def test_other_readers_of_tiff(tmp_path, kind, monkeypatch):
    monkeypatch.setattr("weftex.planes.store.Store.smallest", 100)
    store, whole = written(tmp_path / "a.tif", (201, 330), *kind)
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.is_bigtiff and len(file.pages) == len(whole) == store.levels == 3
        for page, pixels in zip(file.pages, whole.values(), strict=True):
            assert (page.asarray() == pixels).all() and page.is_tiled
        assert [page.is_reduced for page in file.pages] == [False, True, True]
        assert file.pages[0].tags[34675].value == b"profile" * 3
    picture = read_image(tmp_path / "a.tif")
    assert (picture.pixels == whole[0]).all() and picture.alpha == kind[2]


def test_other_readers_of_zarr(tmp_path, monkeypatch):
    zarr = pytest.importorskip("zarr")
    monkeypatch.setattr("weftex.planes.store.Store.smallest", 100)
    _, whole = written(tmp_path / "a.zarr", (201, 330), "uint8", 3, False)
    group = zarr.open_group(tmp_path / "a.zarr", mode="r")
    about = group.attrs["ome"]
    (pyramid,) = about["multiscales"]
    assert about["version"] == "0.5"
    assert [axis["name"] for axis in pyramid["axes"]] == ["c", "y", "x"]
    assert [level["path"] for level in pyramid["datasets"]] == ["0", "1", "2"]
    assert len(about["omero"]["channels"]) == 3
    for level, pixels in whole.items():
        array = group[str(level)]
        assert (np.moveaxis(array[:], 0, -1) == pixels).all() and array.shards == (3, 64, 64)
        scale, moved = pyramid["datasets"][level]["coordinateTransformations"]
        assert scale["scale"] == [1, 2**level, 2**level]
        assert moved["translation"] == [0, (2**level - 1) / 2, (2**level - 1) / 2]


def test_black_blocks_are_written_too(tmp_path):
    pytest.importorskip("zarr")
    (store,) = open_stores(str(tmp_path / "a.zarr"), {"a": Layout(64, 64, 64)}, {}, {}).values()
    store.create()
    store.write((0, 0, 0), np.zeros((64, 64), np.uint8))
    assert (tmp_path / "a.zarr" / "0" / "c" / "0" / "0").exists()


def test_deep_zoom_is_what_viewers_expect(tmp_path):
    _, whole = written(tmp_path / "a.dzi", (201, 330), "uint8", 3, False)
    text = (tmp_path / "a.dzi").read_text("utf-8")
    assert 'TileSize="64"' in text and '<Size Width="330" Height="201"/>' in text
    tile = read_image(tmp_path / "a_files" / "9" / "5_3.png").pixels
    assert (tile == whole[0][192:, 320:]).all()
    assert read_image(tmp_path / "a_files" / "0" / "0_0.png").pixels.shape == (1, 1, 3)


def test_halved():
    clear = np.array([[[9, 0], [90, 255]], [[9, 0], [9, 0]]], np.uint8)
    assert Mixing(Kind.ALPHA).halved(clear).tolist() == [[[90, 64]]]
    up = np.array([[[255, 128, 128], [128, 128, 255]]], np.uint8)
    x, y, z = Mixing(Kind.VECTORS).halved(up)[0, 0] / 127.5 - 1
    assert abs(np.linalg.norm([x, y, z]) - 1) < 0.01 and x == pytest.approx(z)
    labels = np.array([[1, 2], [3, 3]], np.uint8)
    assert Mixing(Kind.LABELS).halved(labels).tolist() == [[1]]


def test_parts_are_the_whole():
    layout = Layout(1000, 600, 64)
    parts = [list(layout.places(0, (k, 7))) for k in range(1, 8)]
    assert [place for part in parts for place in part] == list(layout.places(0))
    assert {len(part) for part in parts} <= {22, 23}


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/99999", "1/2/3"])
def test_parts_that_are_none(text):
    with pytest.raises(InvalidInputError, match="it must be K/N"):
        parse_part(text)


@pytest.mark.parametrize("block", [100, 32, 8192, True, "64", 64.0])
def test_blocks_that_are_none(block):
    with pytest.raises(InvalidInputError, match="a power of two from 64 to 4096"):
        check_block(block)


def test_a_full_disk_is_said_in_one_line(tmp_path):
    store, _ = written(tmp_path / "a.tif", (64, 64), "uint8", 3, False)
    (tmp_path / "a.tif").unlink()
    with pytest.raises(FileError, match="cannot write: No such file.*the same command continues"):
        store.write((0, 0, 0), np.zeros((64, 64, 3), np.uint8))


def test_a_journal_that_was_cut_off(tmp_path):
    record = begun(tmp_path, "a" * 32)
    record.add((0, 1, 2), (7, 8))
    journal = tmp_path / "a.tif.run" / "done.txt"
    line = journal.read_bytes()
    journal.write_bytes(line + b"\nnonsense" + line[:-3])
    record.add((0, 1, 3), (5, 6))
    assert record.done() == {(0, 1, 2): (7, 8), (0, 1, 3): (5, 6)}
    for k in range(len(line)):  # a flipped bit makes a block again, and never another one
        journal.write_bytes(line[:k] + bytes([line[k] ^ 1]) + line[k + 1 :])
        assert record.done() in ({}, {(0, 1, 2): (7, 8)})


def begun(folder, run):
    """The record of a plane that a run of that name has begun."""
    record = Record(str(folder / "a.tif"))
    with record.held(), record.beginning():
        record.begin(Run(run, True, ["a.tif"]))
    return record


@pytest.mark.parametrize(
    "change",
    [{"files": ["../a"]}, {"files": ["/etc/a"]}, {"files": "a"}, {"files": ["a/b/c"]}, {"more": 1}]
    + [
        {"files": [7]},
        {"files": [".."]},
        {"name": 7},
        {"about": 7},
        {"begun": "no"},
        {"grids": {"a.tif": [1, 2, 3]}},
    ],
)
def test_runs_that_are_none(tmp_path, change):
    record = begun(tmp_path, "a" * 32)
    file = tmp_path / "a.tif.run" / "run.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(FileError, match=r"run\.json is damaged"):
        record.current()


def test_only_what_is_of_a_store_is_removed(tmp_path):
    store, _ = written(tmp_path / "a.dzi", (201, 330), "uint8", 3, False)
    names = ("notes.txt", "9/notes.txt", "more/0_0.png", "8/0_99.png", "20/0_0.png")
    mine = [tmp_path / "a_files" / name for name in names]
    for path in mine:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"mine")
    (tmp_path / "a_files" / "empty").mkdir()
    stale = tmp_path / "a_files" / "9" / ".weftex-12-00000000-0123abcd.png"
    stale.touch()
    sweep(str(tmp_path / "a_files"))
    assert not stale.exists() and (tmp_path / "a_files" / "9" / "0_0.png").exists()
    for root in store.roots:
        remove(root, store.grid)
    left = {path for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {*mine} and (tmp_path / "a_files" / "empty").exists()


def test_metadata_that_is_damaged_is_made_again(tmp_path):
    for suffix in (".tif", ".dzi", ".zarr"):
        if suffix == ".zarr":
            pytest.importorskip("zarr")
        store, whole = written(tmp_path / f"a{suffix}", (201, 330), "uint8", 3, False)
        path = Path(next(iter(store.frame())).path)
        good = path.read_bytes()
        for bad in (good[:30], good[:40] + b"x" + good[41:], good + b"x", b"", None):
            path.unlink()
            if bad is not None:
                path.write_bytes(bad)
            assert store.flaws() == [str(path)]
            store.create()
            assert store.flaws() == []
            if suffix != ".tif":
                assert path.read_bytes() == good
            path.write_bytes(good)
        assert (store.read(0, (0, 0, 201, 330)) == whole[0]).all()


@pytest.mark.parametrize("suffix", [".tif", ".zarr", ".dzi"])
def test_damaged_blocks_are_one_line(tmp_path, suffix):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    store, _ = written(tmp_path / f"a{suffix}", (64, 64), "uint8", 3, False)
    (file,) = store.files((0, 0, 0))
    data = Path(file).read_bytes()
    for bad in (data[: len(data) // 2], data[:-9] + bytes(9), b""):
        Path(file).write_bytes(bad)
        try:
            store.read(0, (0, 0, 64, 64))
        except FileError as error:
            assert "\n" not in str(error)
        else:
            assert suffix == ".tif" and len(bad) == len(data)
        store.create()
        store.write((0, 0, 0), np.zeros((64, 64, 3), np.uint8))
        assert (store.read(0, (0, 0, 64, 64)) == 0).all()
    Path(file).unlink()
    with pytest.raises(FileError, match="row 0, column 0 is missing"):
        store.read(0, (0, 0, 64, 64))


def test_locks_of_one_process(tmp_path):
    path = str(tmp_path / "lock")
    with locked(path, 1, 5) as got, locked(path, 3) as again:
        assert got and not again
    with locked(path, 3) as got:
        assert got


def test_archives_of_others(tmp_path):
    np.savez(tmp_path / "a.npz", about=np.array(json.dumps({"format": 1})))
    assert not packing.is_saved(str(tmp_path / "a.npz"))
    with pytest.raises(FileError, match="does not exist"):
        packing.load(str(tmp_path / "b.npz"))


def test_a_missing_library(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(InvalidInputError, match=r"pip install 'weftex\[zarr\]'"):
        open_stores(str(tmp_path / "a.zarr"), {"a": Layout(64, 64, 64)}, {}, {})
