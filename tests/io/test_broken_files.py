"""Files that cannot be read: one line each, no crash, no memory."""

import os
import random
import shutil

import numpy as np
import pytest

from picture_files import bomb, fails, noise, oiio_write, run_as_nobody, smooth, store
from processes import run
from weftex.errors import FileError
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")
tifffile = pytest.importorskip("tifffile")


def test_missing(tmp_path):
    fails(tmp_path / "none.png", "No such file")
    fails(tmp_path / "no" / "none.png", "No such file")
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    fails(tmp_path / "loop.png", "symbolic link")
    (tmp_path / "dangling.png").symlink_to(tmp_path / "gone.png")
    fails(tmp_path / "dangling.png", "No such file")
    with pytest.raises(FileError, match="''"):
        io.read_image("")


def test_not_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    fails(tmp_path / "pipe.png", "not a regular file")
    fails("/dev/null", "not a regular file")


def test_names_that_are_no_utf8(tmp_path):
    shutil.copy(io.sample_path("grass"), os.fsencode(tmp_path) + b"/\xff.png")
    for call in (io.read_image, lambda path: io.write_image(path, noise((2, 2)))):
        with pytest.raises(FileError, match="utf-8") as info:
            call(os.fsencode(tmp_path) + b"/\xff.png")
        assert str(info.value).isprintable()


def test_names_print_on_one_line(tmp_path):
    with pytest.raises(FileError) as info:
        io.read_image(tmp_path / "a\nb\x1b[31m.png")
    assert str(info.value).isprintable()


def test_unreadable_file_and_folder(tmp_path):
    io.write_image(tmp_path / "a.png", noise((4, 4)))
    os.chmod(tmp_path / "a.png", 0)
    done = run_as_nobody("said(io.read_image, sys.argv[1])", tmp_path, tmp_path / "a.png")
    assert done.stdout == f"{tmp_path / 'a.png'}: cannot read: Permission denied\n", done.stderr


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.exr", "a.bmp", "a.hdr", "a.null"])
def test_empty_and_text(tmp_path, name, capfd):
    (tmp_path / name).write_bytes(b"")
    fails(tmp_path / name, "the file is empty")
    (tmp_path / name).write_text("this is no picture\n" * 100)
    fails(tmp_path / name, r"not an image that weftex reads \(\.png, ")
    (tmp_path / name).write_bytes(b"P")
    fails(tmp_path / name, "not an image")
    assert capfd.readouterr() == ("", "")


def test_content_counts_not_the_name(tmp_path):
    pixels = smooth(20, 30)
    for kind in (".png", ".jpg", ".tif", ".bmp", ".webp", ".jxl"):
        store(tmp_path / f"a{kind}", pixels)
        expected = io.read_image(tmp_path / f"a{kind}").pixels
        for wrong in (".png", ".jpg", ".tif", ".exr", ".txt", "", ".tga", ".PNG"):
            shutil.copy(tmp_path / f"a{kind}", tmp_path / f"wrong{wrong}")
            found = io.read_image(tmp_path / f"wrong{wrong}").pixels
            np.testing.assert_array_equal(found, expected)
    # OpenImageIO has a reader that makes a black picture of any file of this name.
    shutil.copy(tmp_path / "a.png", tmp_path / "a.null")
    fails(tmp_path / "a.null", "rename")


def cuts(size, count=60):
    ends = [0, 1, 2, 3, 8, 12, 16, 26, 33]
    ends += [*np.linspace(0, size - 1, count).astype(int), *range(size - 12, size)]
    return sorted({int(n) for n in ends if 0 <= n < size})


@pytest.mark.parametrize(
    "name",
    ["a.png", "a16.png", "a.jpg", "prog.jpg", "gray.jpg", "a.tif", "af.tif", "raw.tif", "lzw.tif",
     "first.tif", "a.webp", "lossy.webp", "a.bmp", "a.exr", "half.exr", "a.jxl", "a.hdr"],
)  # fmt: skip
def test_every_truncation_is_an_error(tmp_path, name, capfd):
    pixels = smooth(60, 50)
    path = tmp_path / name
    if name in ("prog.jpg", "lossy.webp"):
        Image.fromarray(pixels).save(path, **({"progressive": True} if "prog" in name else {}))
    elif name in ("raw.tif", "lzw.tif"):
        Image.fromarray(pixels).save(path, compression="raw" if "raw" in name else "tiff_lzw")
    elif name == "first.tif":  # whose directory is before its pixels
        tifffile.imwrite(path, pixels, rowsperstrip=7, photometric="rgb")
    elif name in ("half.exr", "a.hdr"):
        kind = "openexr" if "exr" in name else "hdr"
        oiio_write(path, kind, (pixels / 255).astype("float32"))
    elif name == "gray.jpg":
        io.write_image(path, pixels[..., 0])
    else:
        wide = {"a16.png": "uint16", "af.tif": "float32", "a.exr": "float32"}.get(name, "uint8")
        store(path, pixels.astype(wide))
    data = path.read_bytes()
    io.read_image(path)
    accepted = []
    for end in cuts(len(data)):
        path.write_bytes(data[:end])
        try:
            io.read_image(path)
            accepted.append(end)
        except FileError as error:
            assert "\n" not in str(error)
            assert str(error).startswith(f"{path}: ")
    assert accepted == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp", ".bmp", ".exr", ".jxl"])
def test_damage_never_crashes(tmp_path, suffix):
    """Flipped bytes give a picture or a FileError: nothing else, no exit, no crash."""
    pixels = smooth(40, 30)
    store(tmp_path / f"a{suffix}", pixels.astype("f4") if suffix == ".exr" else pixels)
    code = """
        import random, sys
        from weftex.io import pictures as io
        path = sys.argv[1]
        data = open(path, "rb").read()
        rng = random.Random(1)
        for turn in range(150):
            bad = bytearray(data)
            for _ in range(rng.choice((1, 1, 3, 20))):
                end = min(len(bad), 200) if turn % 2 else len(bad)
                bad[rng.randrange(8, end)] = rng.randrange(256)
            open(path, "wb").write(bad)
            try:
                io.read_image(path, max_pixels=10**6)
            except io.FileError as error:
                assert "\\n" not in str(error)
        print("done")
    """
    done = run(code, tmp_path / f"a{suffix}")
    assert done.stdout == "done\n", done.stderr[-2000:]


def test_flipped_bytes_in_a_png_are_always_found(tmp_path, capfd):
    path = tmp_path / "a.png"
    io.write_image(path, smooth(40, 30))
    data = path.read_bytes()
    rng = random.Random(0)
    for _ in range(200):
        at = rng.randrange(8, len(data))
        path.write_bytes(data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :])
        fails(path, "damaged|cut short")
    assert capfd.readouterr().err == ""


def test_zero_sized(tmp_path, capfd):
    for width, height in ((0, 5), (5, 0), (0, 0), (2**31, 5), (10**6 + 1, 5)):
        (tmp_path / "a.png").write_bytes(bomb(width, height))
        fails(tmp_path / "a.png", "damaged")
    assert capfd.readouterr().err == ""


def test_bombs_take_no_memory(tmp_path):
    """Real pictures of 16 megapixels in a few kB, for each format."""
    code = """
        import resource, sys
        import OpenImageIO
        from weftex.io import pictures as io
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for path in sys.argv[1:]:
            try:
                io.read_image(path, max_pixels=2**20)
            except io.FileError as error:
                print(error)
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    """
    side = 4096
    flat = np.zeros((side, side), "uint8")
    paths = [tmp_path / f"a{suffix}" for suffix in (".png", ".tif", ".webp", ".jpg", ".jxl")]
    for path in paths:
        store(path, flat)
    done = run(code, *paths)
    *lines, grown = done.stdout.splitlines()
    assert [
        f"{path}: 4096 x 4096 pixels are more than max_pixels = 1048576" for path in paths[:4]
    ] == lines[:4]
    assert "max_pixels = 1048576" in lines[4]
    assert int(grown) < 12_000 + 16_384  # kB; JPEG XL is decoded before its size is known


def test_the_limit_counts_pixels(tmp_path):
    for suffix in (".png", ".tif", ".webp", ".bmp", ".jpg", ".jxl"):
        path = tmp_path / f"a{suffix}"
        store(path, smooth(20, 30))
        assert io.read_image(path, max_pixels=600).pixels.shape == (20, 30, 3)
        assert io.read_image(path, max_pixels=None).pixels.shape == (20, 30, 3)
        fails(path, "30 x 20 pixels are more than max_pixels = 599", max_pixels=599)
    fails(tmp_path / "a.png", "max_pixels", io.read_mask, max_pixels=599)


def test_a_tile_larger_than_its_picture_counts(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", smooth(20, 30), tile=(1024, 1024), photometric="rgb")
    assert io.read_image(tmp_path / "a.tif").pixels.shape == (20, 30, 3)
    fails(tmp_path / "a.tif", "max_pixels", max_pixels=10_000)


@pytest.mark.parametrize("dtype", ["int8", "int16", "int32", "uint32"])
def test_other_integers_are_refused(tmp_path, dtype):
    tifffile.imwrite(tmp_path / "a.tif", np.arange(12, dtype=dtype).reshape(3, 4))
    fails(tmp_path / "a.tif", "weftex reads uint8, uint16 and float")


def test_lab_and_heic_are_refused(tmp_path):
    (tmp_path / "a.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(99))
    fails(tmp_path / "a.heic", "convert it to PNG first")
    tifffile.imwrite(tmp_path / "l.tif", noise((8, 8, 3)), photometric="cielab")
    fails(tmp_path / "l.tif", "LAB")
