"""Odd names and kinds of paths."""

import os
from pathlib import Path

import numpy as np
import pytest

from picture_files import fails, files_in, noise, read_back
from weftex.io import pictures as io

NAMES = ["a b", "100%", "%d", "%04d", "a#", "a####", "Ünï漢字🙂", "a?b=1&c=2", "[1]{2}", "a'b\"c",
         "-", "a,b;c", "$HOME", "~", "a\\b", "..a", " "]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_odd_names(tmp_path, name):
    pixels = noise((5, 4, 3))
    folder = tmp_path / name
    folder.mkdir()
    for suffix in (".png", ".tif", ".bmp", ".webp"):
        np.testing.assert_array_equal(read_back(folder / (name + suffix), pixels).pixels, pixels)
    io.write_image(folder / (name + ".exr"), pixels.astype("f4"))
    np.testing.assert_array_equal(io.read_image(folder / (name + ".exr")).pixels, pixels)
    io.write_image(folder / (name + ".jpg"), pixels)
    assert len(files_in(folder)) == 6


def test_kinds_of_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pixels = noise((5, 4))
    for path in ("a.png", b"b.png", Path("c.PNG"), "./d.TIFF", str(tmp_path / "e.png")):
        back = read_back(path, pixels)
        np.testing.assert_array_equal(back.pixels, pixels)
        assert back.path == os.fsdecode(path)


def test_the_longest_name(tmp_path):
    path = tmp_path / ("n" * 251 + ".png")
    assert read_back(path, noise((4, 4))).pixels.shape == (4, 4)
    fails(tmp_path / ("n" * 252 + ".png"), "too long", io.write_image, noise((4, 4)))
    assert files_in(tmp_path) == [path.name]
