"""Blocks written in any order come back, also to other readers; pixels are halved by their kind."""

import json

import numpy as np
import pytest
import tifffile

from families import noise, refused
from weftex.cli.commands.planes import parse_part
from weftex.errors import FileError
from weftex.io.pictures import read_image
from weftex.planes.layout import Layout
from weftex.planes.locks import locked
from weftex.planes.record import Record, Run
from weftex.planes.tiff import TiffStore
from weftex.raster.mixing import Kind, Mixing

KINDS = [("uint8", 3, False), ("uint16", 4, True), ("float32", 0, False), ("uint8", 0, False)]


def written(path, shape, dtype, channels, alpha, block=64):
    """A store whose blocks were written from the last to the first, and the pixels of level 0."""
    layout = Layout(*shape, block, dtype, channels, alpha, Mixing(Kind.MEAN), b"profile" * 3)
    store = TiffStore(str(path), layout)
    pixels = noise((*shape, *[channels] * (channels > 0)), dtype=np.dtype(dtype).type)
    store.create()
    assert store.is_sound()
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


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind[0])
def test_what_was_written_is_read(tmp_path, kind):
    store, whole = written(tmp_path / "a.tif", (201, 330), *kind)
    for level, pixels in whole.items():
        assert (store.read(level, (0, 0, *pixels.shape[:2])) == pixels).all()
    assert (store.read(0, (63, 100, 70, 101)) == whole[0][63:133, 100:201]).all()


@pytest.mark.parametrize(
    "kind", [*KINDS, ("uint16", 5, False)], ids=lambda kind: f"{kind[0]}-{kind[1]}"
)
def test_other_readers_of_tiff(tmp_path, kind, monkeypatch):
    monkeypatch.setattr(TiffStore, "smallest", 100)
    store, whole = written(tmp_path / "a.tif", (201, 330), *kind)
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        assert file.is_bigtiff and len(file.pages) == len(whole) == store.levels == 3
        for page, pixels in zip(file.pages, whole.values(), strict=True):
            assert (page.asarray() == pixels).all() and page.is_tiled
        assert [page.is_reduced for page in file.pages] == [False, True, True]
        assert file.pages[0].tags[34675].value == b"profile" * 3
    picture = read_image(tmp_path / "a.tif")
    assert (picture.pixels == whole[0]).all() and picture.alpha == kind[2]


def test_halved():
    clear = np.array([[[9, 0], [90, 255]], [[9, 0], [9, 0]]], np.uint8)
    assert Mixing(Kind.ALPHA).halved(clear).tolist() == [[[90, 64]]]
    up = np.array([[[255, 128, 128], [128, 128, 255]]], np.uint8)
    x, y, z = Mixing(Kind.VECTORS).halved(up)[0, 0] / 127.5 - 1
    assert abs(np.linalg.norm([x, y, z]) - 1) < 0.01 and x == pytest.approx(z)
    labels = np.array([[1, 2], [3, 3]], np.uint8)
    assert Mixing(Kind.LABELS).halved(labels).tolist() == [[1]]


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/99999", "1/2/3"])
def test_parts_that_are_none(text):
    refused("it must be K/N", parse_part, text)


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
    [{"files": ["../a"]}, {"files": ["/etc/a"]}, {"files": "a"}, {"files": ["a/b"]}, {"more": 1}]
    + [{"files": [7]}, {"files": [".."]}, {"name": 7}, {"about": 7}, {"begun": "no"}],
)
def test_runs_that_are_none(tmp_path, change):
    record = begun(tmp_path, "a" * 32)
    file = tmp_path / "a.tif.run" / "run.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    refused(r"run\.json is damaged", record.current, error=FileError)


def test_locks_of_one_process(tmp_path):
    path = str(tmp_path / "lock")
    with locked(path, 1, 5) as got, locked(path, 3) as again:
        assert got and not again
    with locked(path, 3) as got:
        assert got
