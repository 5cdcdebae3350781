"""weftex tile of several photos, with --check, --pad and --crop."""

import numpy as np
import pytest

import weftex
from commands import fails, read_maps, weft_run
from families import noise
from weftex.io.pictures import read_image, write_image


@pytest.fixture
def folder(here):
    """A folder with two photos of different kinds, and a set with a larger map."""
    photos = here / "photos"
    (photos / "set").mkdir(parents=True)
    pebbles = weftex.load_exemplar("sample:pebbles").pixels
    write_image(photos / "gray.png", pebbles[:90, :80, 0].astype(np.uint16) * 257)
    write_image(photos / "stones.tif", pebbles[50:150, 60:170])
    write_image(photos / "set" / "color.png", pebbles[:60, :64])
    write_image(photos / "set" / "height.png", pebbles[:60, :64, 1].repeat(2, 0).repeat(2, 1))
    return photos


def test_a_folder_of_photos_is_made_tileable_and_checked(folder, capsys):
    assert weft_run("tile", "--check", folder) == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert "stones.tif: not tileable: top to bottom, values change" in lines[3]
    assert weft_run("tile", folder, "-o", "out", "--seed", 1, "--method", "quilting") == 0
    capsys.readouterr()
    for file, name in (("gray.png", "gray"), ("stones.tif", "stones")):
        expected = weftex.tile(folder / file, seed=1, method="quilting").image
        assert np.array_equal(read_image(f"out/{file}").pixels, expected), name
    assert sorted(read_maps("out/set")) == ["color", "height"]
    assert weft_run("tile", "--check", "out/gray.png", "out/stones.tif") == 0
    assert capsys.readouterr().out == "out/gray.png: tileable\nout/stones.tif: tileable\n"
    assert weft_run("tile", "--check", "out/set", "photos/stones.tif", "--quiet") == 1
    assert capsys.readouterr() == ("", "")


def test_the_worst_border_is_drawn(folder, capsys):
    assert weft_run("tile", "--check", folder, "--picture", "worst.png") == 1
    assert read_image("worst.png").pixels.shape in {(90, 80, 3), (100, 110, 3), (120, 128, 3)}
    capsys.readouterr()
    assert weft_run("tile", "--check", "--tileable", "x", folder / "gray.png") == 1
    assert "top to bottom" not in capsys.readouterr().out
    write_image(folder / "gray.tif", read_image(folder / "gray.png").pixels)  # nothing is written
    assert weft_run("tile", "--check", folder) == 1 and "gray.tif" in capsys.readouterr().out


def test_padding_and_cropping_are_inverse_for_all_kinds(folder, capsys):
    assert weft_run("tile", "--pad", 7, folder, "-o", "padded") == 0
    gray = read_image(folder / "gray.png").pixels
    padded = read_image("padded/gray.png").pixels
    assert np.array_equal(padded, np.pad(gray, 7, "wrap")) and padded.dtype == np.uint16
    assert read_image("padded/set/height.png").pixels.shape == (148, 156)
    assert weft_run("tile", "--crop", 7, "padded", "-o", "back") == 0
    for file in ("gray.png", "stones.tif", "set/color.png", "set/height.png"):
        found, expected = (read_image(root / file) for root in (folder.parent / "back", folder))
        assert np.array_equal(found.pixels, expected.pixels)
        assert found.pixels.dtype == expected.pixels.dtype
    assert weft_run("tile", "--pad=80", "--tileable", "x", folder / "gray.png", "-o", "w.png") == 0
    expected = np.pad(gray, ((0, 0), (80, 80)), "wrap")  # all of it
    assert np.array_equal(read_image("w.png").pixels, expected)


@pytest.mark.parametrize(
    "words, message",
    [
        (["--pad", 0, "sample.png", "-o", "a.png"], "--pad is '0'; it must be 1 or more"),
        (["--pad", 73, "sample.png", "-o", "a.png"], "72x64, so it can be at most 64"),
        (["--crop", 32, "sample.png", "-o", "a.png"], "72x64, so it can be at most 31"),
        (["--check", "--pad", 1, "sample.png"], "give only one of --check and --pad"),
        (["--check", "sample.png", "--border", 3], "--border has no effect on tile --check"),
        (["sample.png", "-o", "a.png", "--picture", "b.png"], "no effect without --check"),
        (["--pad", 3, "photos", "-o", "photos"], "is an input; name another file"),
        (["photos", "-o", "a", "--save-source", "a.npz"], "--save-source works for one photo"),
        (["photos", "sample.png", "photo.png", "photos/set/color.png", "-o", "sample.png"],
         "sample.png is an input; name another file"),
        (["sample.png", "other/sample.png", "-o", "out"], "would both make sample; rename one"),
        (["--check", "photos", "missing.png"], "missing.png: cannot read"),
    ],
)  # fmt: skip
def test_bad_input(folder, here, capsys, words, message):
    (here / "other").mkdir()
    write_image("other/sample.png", noise((40, 40)))
    assert message in fails(capsys, here, "tile", *words)


def test_a_folder_with_a_stray_file_among_maps_stays_one_set(folder, here, capsys):
    write_image(folder / "set" / "notes.png", noise((60, 64)))
    assert "no map (notes)" in fails(capsys, here, "tile", folder / "set", "-o", "a")
