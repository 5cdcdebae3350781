"""What is refused before anything is written."""

import os

import numpy as np
import pytest

from picture_files import fails, files_in, noise, run_as_nobody
from weftex.errors import FileError, InvalidInputError
from weftex.io import pictures as io


@pytest.mark.parametrize(
    ("suffix", "dtype", "shape", "alpha", "advice"),
    [
        (".png", "float32", (4, 4, 3), False, ".exr, .tif, .tiff"),
        (".jpg", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".jpg", "uint8", (4, 4, 4), True, ".png, .tif, .tiff, .webp"),
        (".bmp", "uint8", (4, 4, 2), True, ".png, .tif, .tiff, .webp"),
        (".webp", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".exr", "uint8", (4, 4, 3), False, ".bmp, .jpeg, .jpg, .png, .tif, .tiff, .webp"),
        (".exr", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".png", "uint8", (4, 4, 4), False, ".tif, .tiff"),
        (".png", "uint8", (4, 4, 5), True, ".tif, .tiff"),
    ],
)
def test_what_a_format_cannot_hold(tmp_path, suffix, dtype, shape, alpha, advice):
    pixels = np.ones(shape, dtype)
    path = tmp_path / f"a{suffix}"
    for call in (io.write_image, io.check_output):
        text = fails(path, "cannot hold", call, pixels, error=InvalidInputError, alpha=alpha)
        assert text.endswith(f"use {advice}")
    assert files_in(tmp_path) == []
    for other in advice.split(", "):
        io.write_image(tmp_path / f"b{other}", pixels, alpha=alpha)


@pytest.mark.parametrize(
    ("suffix", "side"), [(".webp", 16_383), (".jpg", 65_500), (".bmp", 65_535), (".png", 10**6)]
)
def test_longest_side(tmp_path, suffix, side, capfd):
    io.write_image(tmp_path / f"a{suffix}", np.full((1, side), 9, "uint8"))
    assert io.read_image(tmp_path / f"a{suffix}").pixels.shape[:2] == (1, side)
    long = np.zeros((side + 1, 1), "uint8")
    path, says = tmp_path / f"b{suffix}", f"at most {side} pixels"
    fails(path, says, io.write_image, long, error=InvalidInputError)
    assert capfd.readouterr().err == ""


def test_unknown_suffix_names_the_nearest(tmp_path):
    check = io.check_output
    assert fails(tmp_path / "a.pgn", "cannot write '.pgn'", check).endswith("mean '.png'?")
    assert fails(tmp_path / "a.tiv", "cannot write '.tiv'", check).endswith("mean '.tif'?")
    assert ".bmp, .exr" in fails(tmp_path / "a.doc", "'.doc'", check)
    assert ".bmp, .exr" in fails(tmp_path / "a", "without a suffix", check)
    fails(tmp_path / "a.hdr", "cannot write '.hdr'", check)
    fails(tmp_path / "a.jxl", "cannot write '.jxl'", check)
    fails(tmp_path / "a.npz", "cannot write '.npz'", check)
    check(tmp_path / "a.npz", suffixes=(".npz",))
    text = fails(tmp_path / "a.npy", "cannot write", check, suffixes=(".npz",))
    assert text.endswith("'.npz'?")


def test_output_folder(tmp_path):
    check = io.check_output
    fails(tmp_path / "no" / "a.png", "folder .*no does not exist", check)
    (tmp_path / "file").write_text("x")
    fails(tmp_path / "file" / "a.png", "does not exist", check)
    (tmp_path / "dir.png").mkdir()
    fails(tmp_path / "dir.png", "is a folder", check)
    fails(tmp_path, "is a folder", check)
    with pytest.raises(FileError, match="^'': is a folder"):
        check("")
    os.mkfifo(tmp_path / "pipe.png")
    fails(tmp_path / "pipe.png", "cannot be overwritten", check)
    fails("sample:bricks", "samples cannot be overwritten", check)
    fails("sample:new.png", "samples cannot be overwritten", check)
    fails(tmp_path / "no" / "a.png", "does not exist", io.write_image, noise((3, 3)))
    fails(tmp_path / "dir.png", "is a folder", io.write_image, noise((3, 3)))
    check(tmp_path / "new.png")
    assert files_in(tmp_path) == ["dir.png", "file", "pipe.png"]


def test_read_only_folder_and_file(tmp_path):
    folder = tmp_path / "ro"
    folder.mkdir()
    io.write_image(folder / "old.png", noise((4, 4)))
    io.write_image(tmp_path / "old.png", noise((4, 4)))
    old = (tmp_path / "old.png").read_bytes()
    os.chmod(folder, 0o555)
    os.chmod(tmp_path / "old.png", 0o444)
    os.chmod(tmp_path, 0o777)
    code = """
        for path in sys.argv[1:]:
            said(io.check_output, path)
            said(io.write_image, path, np.zeros((4, 4), "u1"))
        said(io.atomic(sys.argv[1]).__enter__)
    """
    paths = [folder / "new.png", folder / "old.png", tmp_path / "old.png"]
    done = run_as_nobody(code, tmp_path, *paths)
    assert done.stdout.splitlines() == [
        *[f"{folder / 'new.png'}: the folder {folder} is read-only"] * 2,
        *[f"{folder / 'old.png'}: the folder {folder} is read-only"] * 2,
        *[f"{tmp_path / 'old.png'}: exists and cannot be overwritten"] * 2,
        f"{folder / 'new.png'}: cannot write: Permission denied",
    ], done.stderr
    os.chmod(folder, 0o755)
    assert files_in(folder) == ["old.png"]
    assert (tmp_path / "old.png").read_bytes() == old
