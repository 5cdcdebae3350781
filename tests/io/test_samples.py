"""The package's own samples."""

import csv
from pathlib import Path

import numpy as np
import pytest

from commands import read_maps
from families import refused
from picture_files import fails
from weftex.errors import FileError
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")

PICTURES = ["bricks", "grass", "leaves", "pebbles", "tiles", "weave", "wood"]


def test_samples():
    assert io.sample_names() == sorted([*PICTURES, "stone_wall", "hole"])
    for name in PICTURES:
        picture = io.read_image(f"sample:{name}")
        assert picture.path == f"sample:{name}"
        assert picture.pixels.dtype == np.uint8
        assert not picture.alpha
        assert min(picture.pixels.shape[:2]) >= 192
        assert not io.is_folder(f"sample:{name}")
        assert io.sample_path(name) == io.sample_path(f"sample:{name}")
    assert io.is_folder("sample:stone_wall")
    maps = read_maps("sample:stone_wall")
    assert list(maps) == ["albedo", "ao", "height", "normal", "roughness"]
    one = io.read_image("sample:stone_wall/normal")
    np.testing.assert_array_equal(one.pixels, maps["normal"].pixels)
    assert 0.05 < io.read_mask("sample:hole").mean() < 0.3
    assert {m.pixels.shape[:2] for m in maps.values()} == {(256, 256)}


def test_samples_that_are_not_there(tmp_path):
    with pytest.raises(FileError, match="no sample is named 'brick'; did you mean 'bricks'"):
        io.read_image("sample:brick")
    for name in ("sample:", "sample:../io", "sample:MANIFEST", "sample:bricks.png", "sample:zzz"):
        refused("no sample is named", io.read_image, name, error=FileError)
        assert not io.is_folder(name)
    refused("did you mean 'stone_wall'", read_maps, "sample:stonewall", error=FileError)
    fails("sample:stone_wall", "is a folder")
    fails("sample:bricks", "Not a directory", read_maps)
    assert io.is_folder(tmp_path)
    assert not io.is_folder(tmp_path / "no")
    assert not io.is_folder("a\0b")


def test_samples_are_listed_free_and_small():
    folder = Path(io.sample_path("bricks")).parent
    with open(folder / "MANIFEST.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = sorted(str(p.relative_to(folder)) for p in folder.rglob("*.png"))
    assert sorted(row["file"] for row in rows) == found
    assert list(rows[0]) == ["file", "class", "subject", "width", "height", "source", "author",
                             "licence", "licence_evidence", "processing"]  # fmt: skip
    for row in rows:
        assert "CC0" in row["licence"]
        assert all(row.values()), row
        pixels = io.read_image(folder / row["file"]).pixels
        assert pixels.shape[:2] == (int(row["height"]), int(row["width"]))
        with Image.open(folder / row["file"]) as peer:
            np.testing.assert_array_equal(pixels, np.asarray(peer))
    assert sum(p.stat().st_size for p in folder.rglob("*")) < 1_600_000
