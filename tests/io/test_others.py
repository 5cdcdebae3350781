"""Pictures that others wrote, and that others read; what reading loads and prints."""

import shutil
import struct
import sys
import zlib

import numpy as np
import pytest

from commands import weft_run
from picture_files import PNG, PREMULTIPLIED, STRAIGHT, chunk, fails, noise, oiio_write, smooth
from processes import run
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")
tifffile = pytest.importorskip("tifffile")


@pytest.mark.parametrize("mode", ["L", "LA", "RGB", "RGBA", "1", "P", "I;16"])
def test_png_from_pillow(tmp_path, mode):
    if mode == "I;16":
        expected = noise((9, 7), "uint16")
        peer = Image.fromarray(expected)
    else:
        peer = Image.fromarray(noise((9, 7, 4)), "RGBA")
        peer = peer.convert("RGB").quantize(7) if mode == "P" else peer.convert(mode)
        expected = np.asarray(peer.convert({"1": "L", "P": "RGB"}.get(mode, mode)))
    peer.save(tmp_path / "a.png")
    back = io.read_image(tmp_path / "a.png")
    assert back.pixels.dtype == expected.dtype
    np.testing.assert_array_equal(back.pixels, expected)
    assert back.alpha is (mode in ("LA", "RGBA"))


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_png_of_few_bits_spans_the_range(tmp_path, bits):
    gray = np.tile(np.arange(2**bits, dtype="uint8"), (3, 4))[:, :8]
    rows = np.unpackbits(gray[..., None], axis=2)[..., 8 - bits :].reshape(3, -1)
    lines = b"".join(b"\0" + np.packbits(row).tobytes() for row in rows)
    body = chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 3, bits, 0, 0, 0, 0))
    body += chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(PNG + body)
    back = io.read_image(tmp_path / "a.png").pixels
    np.testing.assert_array_equal(back, gray * (255 // (2**bits - 1)))


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
@pytest.mark.parametrize("kind", [PREMULTIPLIED, STRAIGHT])
def test_tiff_alpha_of_both_kinds(tmp_path, dtype, kind):
    straight = noise((11, 13, 4), dtype) if dtype != "float32" else noise((11, 13, 4)) / 255
    straight = straight.astype(dtype)
    straight[0, 0, 3] = 0
    top = 1 if dtype == "float32" else np.iinfo(dtype).max
    stored = straight
    if kind == PREMULTIPLIED:
        part = straight[..., 3:].astype(float) / top
        stored = straight * np.concatenate([part, part, part, np.ones_like(part)], 2)
        stored = (stored if dtype == "float32" else np.round(stored)).astype(dtype)
    tifffile.imwrite(tmp_path / "a.tif", stored, photometric="rgb", extrasamples=[kind])
    back = io.read_image(tmp_path / "a.tif")
    assert back.alpha
    assert back.pixels.dtype == straight.dtype
    if kind == STRAIGHT:
        np.testing.assert_array_equal(back.pixels, straight)
        return
    np.testing.assert_array_equal(back.pixels[..., 3], straight[..., 3])
    again = back.pixels[..., :3] * (straight[..., 3:].astype(float) / top)
    seen = straight[..., 3] > 0
    if dtype == "float32":
        np.testing.assert_allclose(back.pixels[seen], straight[seen], rtol=1e-6)
    else:
        np.testing.assert_allclose(again[seen], stored[seen][:, :3], atol=0.501)
        opaque = straight[..., 3] == top
        np.testing.assert_array_equal(back.pixels[opaque], straight[opaque])


@pytest.mark.parametrize(
    "options",
    [
        {"compression": "deflate"},
        {"compression": "deflate", "predictor": True},
        {"byteorder": ">"},
        {"bigtiff": True},
        {"bigtiff": True, "byteorder": ">"},
        {"tile": (16, 16)},
        {"rowsperstrip": 3},
    ],
)
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
def test_tiff_from_tifffile(tmp_path, options, dtype):
    if dtype.startswith("float") and "predictor" in options:
        options = {"compression": "deflate"}  # tifffile alone cannot write that predictor
    pixels = noise((37, 29, 3), dtype)
    tifffile.imwrite(tmp_path / "a.tif", pixels, photometric="rgb", **options)
    if dtype == "float64" and "tile" in options:
        fails(tmp_path / "a.tif", "tiled float64")
        return
    back = io.read_image(tmp_path / "a.tif").pixels
    kept = np.dtype(dtype).kind == "u"
    assert back.dtype == (dtype if kept else "float32")
    np.testing.assert_array_equal(back, pixels if kept else pixels.astype("float32"))


def test_exr_first_part_data_window_and_layers(tmp_path):
    import OpenImageIO as oiio

    pixels = np.abs(noise((6, 5, 6), "float32")) + 0.5
    names = ("R", "G", "B", "A", "Z", "mask")
    pixels[..., 3] = np.linspace(0.25, 1, 30).reshape(6, 5)
    oiio_write(tmp_path / "l.exr", "openexr", pixels, names, alpha=3)
    back = io.read_image(tmp_path / "l.exr")
    assert back.alpha
    np.testing.assert_array_equal(back.pixels[..., 5], pixels[..., 3])
    expected = pixels[..., [0, 1, 2, 4, 5]] / pixels[..., 3:4]
    np.testing.assert_allclose(back.pixels[..., :5], expected, rtol=1e-6)
    specs = [oiio.ImageSpec(4, 3, 1, "float") for _ in range(2)]
    for spec, name in zip(specs, ("one", "two"), strict=True):
        spec["oiio:subimagename"] = name
        spec.x, spec.full_width, spec.full_height = 2, 9, 9
    file = oiio.ImageOutput.create("openexr")
    assert file.open(str(tmp_path / "m.exr"), specs), file.geterror()
    assert file.write_image(np.full((3, 4, 1), 0.5, "f4"))
    assert file.open(str(tmp_path / "m.exr"), specs[1], "AppendSubimage"), file.geterror()
    assert file.write_image(np.full((3, 4, 1), 0.75, "f4"))
    assert file.close()
    back = io.read_image(tmp_path / "m.exr").pixels
    np.testing.assert_array_equal(back, np.full((3, 4), 0.5, "f4"))


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_jpeg_xl_is_read(tmp_path, dtype, channels):
    pixels = noise((19, 23, channels), dtype)
    oiio_write(tmp_path / "a.jxl", "jpegxl", pixels, alpha=3 if channels == 4 else -1,
               oiio__UnassociatedAlpha=1)  # fmt: skip
    back = io.read_image(tmp_path / "a.jxl")
    np.testing.assert_array_equal(np.atleast_3d(back.pixels), pixels)
    assert back.alpha is (channels == 4)


def test_bmp_and_webp_and_hdr_of_others(tmp_path):
    rgba = noise((9, 7, 4))
    Image.fromarray(rgba).save(tmp_path / "a.bmp")
    back = io.read_image(tmp_path / "a.bmp")
    assert back.alpha
    np.testing.assert_array_equal(back.pixels, rgba)
    rgba[..., 3] = 0
    Image.fromarray(rgba).save(tmp_path / "z.bmp")
    back = io.read_image(tmp_path / "z.bmp")
    assert not back.alpha
    np.testing.assert_array_equal(back.pixels, rgba[..., :3])
    Image.fromarray(rgba[..., :3].copy()).quantize(5).save(tmp_path / "p.bmp")
    with Image.open(tmp_path / "p.bmp") as peer:
        back = io.read_image(tmp_path / "p.bmp").pixels
        np.testing.assert_array_equal(back, np.asarray(peer.convert("RGB")))
    rgba = noise((9, 7, 4))
    Image.fromarray(rgba).save(tmp_path / "a.webp", lossless=True, exact=True)
    np.testing.assert_array_equal(io.read_image(tmp_path / "a.webp").pixels, rgba)
    light = np.abs(noise((9, 17, 3), "float32"))
    oiio_write(tmp_path / "a.hdr", "hdr", light)
    back = io.read_image(tmp_path / "a.hdr").pixels
    np.testing.assert_allclose(back, light, atol=float(light.max()) / 128)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp", ".tif"])
def test_orientation_is_applied(tmp_path, orientation, suffix):
    from PIL import ImageOps

    exif = Image.Exif()
    exif[0x0112] = orientation
    options = {".jpg": {"quality": 95}, ".webp": {"lossless": True}}.get(suffix, {})
    Image.fromarray(smooth(24, 40)).save(tmp_path / f"a{suffix}", exif=exif, **options)
    with Image.open(tmp_path / f"a{suffix}") as peer:
        expected = np.asarray(ImageOps.exif_transpose(peer))
    back = io.read_image(tmp_path / f"a{suffix}").pixels
    assert back.shape == expected.shape
    assert back.flags.c_contiguous
    np.testing.assert_allclose(back.astype(int), expected, atol=4 if suffix == ".jpg" else 0)


def test_progressive_jpeg_and_trailing_bytes(tmp_path):
    pixels = smooth(40, 50)
    Image.fromarray(pixels).save(tmp_path / "a.jpg", quality=95, progressive=True)
    np.testing.assert_allclose(io.read_image(tmp_path / "a.jpg").pixels.astype(int), pixels, atol=9)
    for suffix in (".jpg", ".png", ".tif", ".bmp", ".webp"):
        io.write_image(tmp_path / f"b{suffix}", pixels)
        whole = io.read_image(tmp_path / f"b{suffix}").pixels
        with open(tmp_path / f"b{suffix}", "ab") as file:
            file.write(b"\0tail" * 9)
        np.testing.assert_array_equal(io.read_image(tmp_path / f"b{suffix}").pixels, whole)


@pytest.mark.parametrize(
    ("suffix", "shape", "alpha"),
    [
        *[(s, shape, shape[2:] in ((2,), (4,))) for s in (".png", ".webp")
          for shape in ((9, 7), (9, 7, 2), (9, 7, 3), (9, 7, 4))],
        (".bmp", (9, 7), False),
        (".bmp", (9, 7, 3), False),
        (".tif", (9, 7), False),
        (".tif", (9, 7, 3), False),
        (".tif", (9, 7, 4), True),
    ],
)  # fmt: skip
def test_pillow_reads_the_same(tmp_path, suffix, shape, alpha):
    pixels = noise(shape) | 1
    io.write_image(tmp_path / f"a{suffix}", pixels, alpha=alpha)
    with Image.open(tmp_path / f"a{suffix}") as peer:
        found = np.asarray(peer)
        assert peer.getexif().get(0x0112, 1) == 1
    if suffix == ".webp" and shape[2:] in ((), (2,)):
        found = found[..., 0] if not alpha else found[..., [0, -1]]
    np.testing.assert_array_equal(found, pixels)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
@pytest.mark.parametrize(("channels", "alpha"), [(1, 0), (2, 1), (3, 0), (4, 1), (5, 0)])
def test_tifffile_reads_the_same(tmp_path, dtype, channels, alpha):
    pixels = noise((19, 17, channels) if channels > 1 else (19, 17), dtype)
    io.write_image(tmp_path / "a.tif", pixels, alpha=bool(alpha))
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        page = file.pages[0]
        assert page.compression in (8, 32946)
        extra = tuple(map(int, page.extrasamples))
        assert (extra == (STRAIGHT,)) if alpha else STRAIGHT not in extra
        assert page.dtype == dtype
        assert page.predictor == 1
    np.testing.assert_array_equal(tifffile.imread(tmp_path / "a.tif"), pixels)


def test_without_the_library(monkeypatch, tmp_path, capsys):
    """As on a free-threaded Python, for which there is none."""
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    assert weft_run("synth", "sample:pebbles", "-o", tmp_path / "a.png", "--size", 8) == 2
    line = "image files need OpenImageIO, which cannot be loaded here"
    assert capsys.readouterr().err.splitlines() == [f"weftex: error: {line}"]


def test_nothing_is_printed_at_the_end(tmp_path):
    """OpenImageIO prints errors that nobody asked for when the process ends."""
    io.write_image(tmp_path / "a.png", noise((20, 20)))
    shutil.copy(tmp_path / "a.png", tmp_path / "a.jpg")
    (tmp_path / "b.png").write_bytes((tmp_path / "a.png").read_bytes()[:-30])
    (tmp_path / "c.webp").write_bytes(b"RIFF1234WEBP and nothing")
    tifffile.imwrite(tmp_path / "d.tif", np.zeros((3, 3), "int16"))
    io.write_image(tmp_path / "e.tif", noise((20, 20)))
    (tmp_path / "f.tif").write_bytes((tmp_path / "e.tif").read_bytes()[:-300])
    code = """
        import sys
        from weftex.io import pictures as io
        for path in sys.argv[1:]:
            try:
                io.read_image(path, max_pixels=399 if "e.tif" in path else 400)
                print("read")
            except io.FileError as error:
                print("failed")
    """
    done = run(code, *sorted(tmp_path.iterdir()))
    assert done.stdout.split() == ["read", "read", "failed", "failed", "failed", "failed", "failed"]
    assert done.stderr == ""
