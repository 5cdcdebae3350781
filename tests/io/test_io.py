"""Files: every format both ways against independent readers, every error, nothing half written."""

from __future__ import annotations

import csv
import os
import random
import shutil
import signal
import stat
import struct
import subprocess
import sys
import textwrap
import threading
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import weftex.errors
from weftex.errors import FileError, InvalidInputError
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")
ImageCms = pytest.importorskip("PIL.ImageCms")
tifffile = pytest.importorskip("tifffile")

SRC = str(Path(weftex.errors.__file__).parents[1])
RGB_PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
GREY_PROFILE = RGB_PROFILE[:16] + b"GRAY" + RGB_PROFILE[20:]


def noise(shape, dtype="uint8", seed=0):
    rng = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "f":
        return rng.normal(0.5, 1, shape).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


def smooth(height, width, channels=3):
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(y / (7 + k)) + np.cos(x / (5 + k)) for k in range(channels)]
    return np.round(np.stack(waves, 2) * 60 + 128).astype("uint8")


def fails(path, match, call=io.read_image, error=FileError):
    """Assert an error of one line that begins with the path."""
    with pytest.raises(error, match=match) as info:
        call(path)
    text = str(info.value)
    assert "\n" not in text
    assert text.startswith(f"{path}: ")
    return text


def run(code, *args, **options):
    """Run Python code with weftex importable, in a process of its own."""
    env = os.environ | {"PYTHONPATH": SRC}
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, args)]
    return subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, **options)


def files_in(folder):
    return sorted(os.listdir(folder))


# --- round trips -----------------------------------------------------------------------------

EXACT = [
    *[(s, d, n, a) for s in (".png",) for d in ("uint8", "uint16")
      for n, a in ((1, 0), (2, 1), (3, 0), (4, 1))],
    *[(s, d, n, a) for s in (".tif", ".tiff") for d in ("uint8", "uint16", "float32")
      for n, a in ((1, 0), (2, 1), (3, 0), (4, 1), (2, 0), (4, 0), (5, 0), (6, 1), (12, 0))],
    *[(".exr", "float32", n, a)
      for n, a in ((1, 0), (3, 0), (2, 0), (4, 0), (5, 0), (12, 0))],
    (".webp", "uint8", 3, 0),
    (".bmp", "uint8", 1, 0),
    (".bmp", "uint8", 3, 0),
]  # fmt: skip


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (8, 1), (23, 17)])
@pytest.mark.parametrize(("suffix", "dtype", "channels", "alpha"), EXACT)
def test_round_trip_is_exact(tmp_path, suffix, dtype, channels, alpha, size):
    pixels = noise((*size, channels) if channels > 1 else size, dtype)
    path = tmp_path / f"a{suffix}"
    io.write_image(path, pixels, alpha=bool(alpha))
    back = io.read_image(path)
    assert back.pixels.dtype == pixels.dtype
    np.testing.assert_array_equal(back.pixels, pixels)
    assert back.alpha is bool(alpha)
    assert back.icc is None
    assert back.path == str(path)
    assert back.pixels.flags.c_contiguous
    assert files_in(tmp_path) == [path.name]


def test_webp_widens_grey(tmp_path):
    pixels = noise((9, 8, 2)) | 1
    for alpha, index in ((False, [0, 0, 0]), (True, [0, 0, 0, 1])):
        io.write_image(tmp_path / "a.webp", pixels if alpha else pixels[..., 0], alpha=alpha)
        back = io.read_image(tmp_path / "a.webp")
        assert back.alpha is alpha
        np.testing.assert_array_equal(back.pixels, pixels[..., index])


def test_webp_keeps_straight_alpha_except_colour_under_zero(tmp_path):
    pixels = noise((20, 20, 4))
    pixels[:3, :3, 3] = 0
    io.write_image(tmp_path / "a.webp", pixels, alpha=True)
    back = io.read_image(tmp_path / "a.webp").pixels
    np.testing.assert_array_equal(back[..., 3], pixels[..., 3])
    seen = pixels[..., 3] > 0
    np.testing.assert_array_equal(back[seen], pixels[seen])


@pytest.mark.parametrize("channels", [1, 3])
def test_jpeg_is_close(tmp_path, channels):
    pixels = smooth(40, 50, channels)
    pixels = pixels[..., 0] if channels == 1 else pixels
    for suffix in (".jpg", ".jpeg"):
        io.write_image(tmp_path / f"a{suffix}", pixels)
        back = io.read_image(tmp_path / f"a{suffix}").pixels
        assert back.shape == pixels.shape
        assert np.abs(back.astype(int) - pixels).max() <= 6
    with Image.open(tmp_path / "a.jpg") as peer:
        np.testing.assert_allclose(np.asarray(peer).astype(int), pixels, atol=6)
        assert channels == 1 or peer.layer[0][1:3] == (1, 1)  # no colour subsampling


@settings(max_examples=25, deadline=None)
@given(
    hnp.arrays(
        st.sampled_from([np.uint8, np.uint16]),
        hnp.array_shapes(min_dims=2, max_dims=2, max_side=40),
    ),
    st.integers(1, 4),
    st.sampled_from([".png", ".tif"]),
)
def test_any_integers_survive(tmp_path_factory, plane, channels, suffix):
    pixels = plane if channels == 1 else np.stack([np.roll(plane, k) for k in range(channels)], 2)
    path = tmp_path_factory.mktemp("any") / f"a{suffix}"
    io.write_image(path, pixels, alpha=channels in (2, 4))
    np.testing.assert_array_equal(io.read_image(path).pixels, pixels)


@pytest.mark.parametrize("suffix", [".tif", ".exr"])
def test_extreme_floats_survive(tmp_path, suffix):
    values = [0, -0.0, 1, -1, 1e-38, -3e38, 3e38, np.inf, -np.inf, np.nan, 1e-45, 65536]
    pixels = np.array(values, np.float32).reshape(3, 4)
    io.write_image(tmp_path / f"a{suffix}", pixels)
    back = io.read_image(tmp_path / f"a{suffix}").pixels
    assert back.tobytes() == pixels.tobytes()


@pytest.mark.parametrize("dtype", ["float16", "float64", ">f4"])
def test_other_floats_are_written_as_float32(tmp_path, dtype):
    pixels = noise((5, 6, 3), "float64").astype(dtype)
    for suffix in (".tif", ".exr"):
        io.write_image(tmp_path / f"a{suffix}", pixels)
        back = io.read_image(tmp_path / f"a{suffix}").pixels
        assert back.dtype == np.float32
        np.testing.assert_array_equal(back, pixels.astype(np.float32))


def test_views_and_foreign_byte_order(tmp_path):
    base = noise((30, 40, 3), "uint16")
    for k, view in enumerate((base[::-2, ::3], base.transpose(1, 0, 2), base[..., ::-1],
                              np.asfortranarray(base), base.astype(">u2"))):  # fmt: skip
        io.write_image(tmp_path / f"{k}.png", view)
        np.testing.assert_array_equal(io.read_image(tmp_path / f"{k}.png").pixels, view)


def test_input_is_not_changed(tmp_path):
    pixels = noise((6, 6, 4), "float32")
    before = pixels.copy()
    pixels.flags.writeable = False
    for suffix in (".exr", ".tif"):
        io.write_image(tmp_path / f"a{suffix}", pixels, alpha=True)
    np.testing.assert_array_equal(pixels, before)


def test_exr_premultiplies(tmp_path):
    pixels = np.abs(noise((7, 8, 4), "float32"))
    pixels[0, :, 3] = 0
    io.write_image(tmp_path / "a.exr", pixels, alpha=True)
    back = io.read_image(tmp_path / "a.exr")
    assert back.alpha
    np.testing.assert_allclose(back.pixels[1:], pixels[1:], rtol=1e-6)
    assert (back.pixels[0] == 0).all()
    for channels in (2, 6):
        many = np.abs(noise((7, 8, channels), "float32")) + 0.1
        io.write_image(tmp_path / "b.exr", many, alpha=True)
        np.testing.assert_allclose(io.read_image(tmp_path / "b.exr").pixels, many, rtol=1e-6)


@pytest.mark.filterwarnings("error")
def test_infinities_make_no_warnings(tmp_path):
    values = np.array([0, 1e-45, 1e-38, 0.5, 3e38, np.inf, -np.inf, np.nan])
    pixels = np.stack(np.meshgrid(values, values), 2)
    for kind in ("float64", "float32"):
        with np.errstate(all="ignore"):
            wanted = pixels.astype(kind) * 1.1
            single = wanted.astype("float32")
        io.write_image(tmp_path / "a.exr", wanted, alpha=True)
        back = io.read_image(tmp_path / "a.exr").pixels
        np.testing.assert_array_equal(back[..., 1], single[..., 1])
    with np.errstate(all="ignore"):
        io.write_image(tmp_path / "a.tif", pixels * 1e300)
    io.read_image(tmp_path / "a.tif")


def kind_of(pixels):
    return {"float32": "float", "float16": "half"}.get(pixels.dtype.name, pixels.dtype.name)


def oiio_write(path, kind, pixels, names=None, alpha=-1, **options):
    import OpenImageIO as oiio

    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind_of(pixels))
    spec.channelnames = names or spec.channelnames
    spec.alpha_channel = alpha
    for key, value in options.items():
        spec[key.replace("__", ":")] = value
    file = oiio.ImageOutput.create(kind)
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(pixels), file.geterror()
    assert file.close()


def oiio_names(path):
    import OpenImageIO as oiio

    spec = oiio.ImageInput.open(str(path)).spec()
    return tuple(spec.channelnames), str(spec.format), spec.get_string_attribute("compression")


@pytest.mark.parametrize(
    ("channels", "alpha", "names"),
    [(1, False, "Y"), (2, True, "YA"), (3, False, "RGB"), (4, True, "RGBA")],
)
def test_exr_channel_names(tmp_path, channels, alpha, names):
    io.write_image(tmp_path / "a.exr", noise((4, 4, channels), "float32"), alpha=alpha)
    found, kind, packed = oiio_names(tmp_path / "a.exr")
    assert (found, kind, packed) == (tuple(names), "float", "zip")


def test_exr_half_becomes_float(tmp_path):
    pixels = np.abs(noise((5, 6, 3), "float16"))
    oiio_write(tmp_path / "half.exr", "openexr", pixels)
    back = io.read_image(tmp_path / "half.exr").pixels
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, pixels.astype(np.float32))


# --- what others wrote -----------------------------------------------------------------------


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
    grey = np.tile(np.arange(2**bits, dtype="uint8"), (3, 4))[:, :8]
    rows = np.unpackbits(grey[..., None], axis=2)[..., 8 - bits :].reshape(3, -1)
    lines = b"".join(b"\0" + np.packbits(row).tobytes() for row in rows)
    body = chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 3, bits, 0, 0, 0, 0))
    body += chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(PNG + body)
    np.testing.assert_array_equal(
        io.read_image(tmp_path / "a.png").pixels, grey * (255 // (2**bits - 1))
    )


def test_png_transparency_becomes_alpha(tmp_path):
    pixels = noise((6, 6, 3))
    Image.fromarray(pixels).save(tmp_path / "a.png", transparency=tuple(map(int, pixels[2, 3])))
    back = io.read_image(tmp_path / "a.png")
    assert back.alpha
    np.testing.assert_array_equal(back.pixels[..., :3], pixels)
    assert back.pixels[2, 3, 3] == 0
    assert (back.pixels[..., 3] == 0).sum() == 1


PREMULTIPLIED, STRAIGHT = 1, 2


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


@pytest.mark.parametrize("packing", ["tiff_lzw", "tiff_adobe_deflate", "packbits", "raw"])
def test_tiff_from_pillow(tmp_path, packing):
    pixels = smooth(40, 30)
    Image.fromarray(pixels).save(tmp_path / "a.tif", compression=packing)
    np.testing.assert_array_equal(io.read_image(tmp_path / "a.tif").pixels, pixels)


@pytest.mark.parametrize("packing", ["zstd", "lzw", "zip", "none"])
def test_tiff_packings_read(tmp_path, packing):
    pixels = noise((40, 30, 3), "uint16")
    oiio_write(tmp_path / "a.tif", "tiff", pixels, compression=packing)
    np.testing.assert_array_equal(io.read_image(tmp_path / "a.tif").pixels, pixels)


def test_tiff_planes_pages_and_bilevel(tmp_path):
    pixels = noise((12, 10, 3))
    planes = np.ascontiguousarray(np.moveaxis(pixels, 2, 0))
    tifffile.imwrite(tmp_path / "p.tif", planes, photometric="rgb", planarconfig="separate")
    np.testing.assert_array_equal(io.read_image(tmp_path / "p.tif").pixels, pixels)
    with tifffile.TiffWriter(tmp_path / "m.tif") as file:
        for k in range(3):
            file.write(np.full((6, 5), k, "uint8"))
    np.testing.assert_array_equal(io.read_image(tmp_path / "m.tif").pixels, np.zeros((6, 5)))
    tifffile.imwrite(tmp_path / "b.tif", pixels[..., 0] > 100, photometric="minisblack")
    np.testing.assert_array_equal(
        io.read_image(tmp_path / "b.tif").pixels, np.where(pixels[..., 0] > 100, 255, 0)
    )
    tifffile.imwrite(tmp_path / "w.tif", pixels[..., 0], photometric="miniswhite")
    np.testing.assert_array_equal(io.read_image(tmp_path / "w.tif").pixels, 255 - pixels[..., 0])


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
    np.testing.assert_array_equal(
        io.read_image(tmp_path / "m.exr").pixels, np.full((3, 4), 0.5, "f4")
    )


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
        np.testing.assert_array_equal(
            io.read_image(tmp_path / "p.bmp").pixels, np.asarray(peer.convert("RGB"))
        )
    rgba = noise((9, 7, 4))
    Image.fromarray(rgba).save(tmp_path / "a.webp", lossless=True, exact=True)
    np.testing.assert_array_equal(io.read_image(tmp_path / "a.webp").pixels, rgba)
    light = np.abs(noise((9, 17, 3), "float32"))
    oiio_write(tmp_path / "a.hdr", "hdr", light)
    np.testing.assert_allclose(
        io.read_image(tmp_path / "a.hdr").pixels, light, atol=float(light.max()) / 128
    )


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


# --- read by others --------------------------------------------------------------------------


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


def test_sixteen_bit_png_by_hand(tmp_path):
    """Pillow reduces 16-bit RGB to 8 bits, so the bytes are unpacked here."""
    pixels = noise((9, 7, 3), "uint16")
    io.write_image(tmp_path / "a.png", pixels)
    chunks = png_chunks((tmp_path / "a.png").read_bytes())
    width, height, bits, colour = struct.unpack(">IIBB", chunks[b"IHDR"][:10])
    assert (width, height, bits, colour) == (7, 9, 16, 2)
    np.testing.assert_array_equal(
        unfilter(zlib.decompress(chunks[b"IDAT"]), 9, 42, 6).view(">u2").reshape(9, 7, 3), pixels
    )
    assert set(chunks) == {b"IHDR", b"eXIf", b"oFFs", b"IDAT", b"IEND"}


PNG = b"\x89PNG\r\n\x1a\n"


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png_chunks(data):
    found, at = {}, 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        found[kind] = found.get(kind, b"") + data[at + 8 : at + 8 + length]
        at += 12 + length
    return found


def unfilter(data, rows, stride, step):
    """Undo PNG's filters, slowly."""
    out = np.zeros((rows + 1, stride + step), int)
    for y in range(rows):
        line = data[y * (stride + 1) : (y + 1) * (stride + 1)]
        for x in range(stride):
            a, b, c = out[y + 1, x], out[y, x + step], out[y, x]
            paeth = min((a, b, c), key=lambda v: abs(a + b - c - v))
            guess = (0, a, b, (a + b) // 2, paeth)[line[0]]
            out[y + 1, x + step] = (line[x + 1] + guess) % 256
    return out[1:, step:].astype("uint8")


# --- colour profiles -------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp"])
def test_profile_is_carried(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    io.write_image(path, noise((8, 8, 3)), icc=RGB_PROFILE)
    assert io.read_image(path).icc == RGB_PROFILE
    with Image.open(path) as peer:
        assert peer.info["icc_profile"] == RGB_PROFILE


def test_profile_with_alpha_16_bits_and_grey(tmp_path):
    io.write_image(tmp_path / "a.png", noise((8, 8, 4), "uint16"), alpha=True, icc=RGB_PROFILE)
    assert io.read_image(tmp_path / "a.png").icc == RGB_PROFILE
    for suffix in (".png", ".tif", ".jpg"):
        io.write_image(tmp_path / f"g{suffix}", noise((8, 8)), icc=GREY_PROFILE)
        assert io.read_image(tmp_path / f"g{suffix}").icc == GREY_PROFILE


@pytest.mark.parametrize("suffix", [".bmp", ".exr"])
def test_profile_is_left_out_where_there_is_no_place(tmp_path, suffix):
    pixels = noise((8, 8, 3), "float32" if suffix == ".exr" else "uint8")
    io.write_image(tmp_path / f"a{suffix}", pixels, icc=RGB_PROFILE)
    assert io.read_image(tmp_path / f"a{suffix}").icc is None


BROKEN_TAGS = RGB_PROFILE[:128] + b"\xff" * (len(RGB_PROFILE) - 128)


@pytest.mark.parametrize("icc", [b"", b"junk" * 50, RGB_PROFILE[:-4], GREY_PROFILE, BROKEN_TAGS])
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp"])
def test_a_wrong_profile_does_not_cost_the_picture(tmp_path, suffix, icc):
    pixels = smooth(16, 16)
    io.write_image(tmp_path / f"a{suffix}", pixels, icc=icc)
    back = io.read_image(tmp_path / f"a{suffix}")
    assert back.icc is None or icc == BROKEN_TAGS
    np.testing.assert_allclose(back.pixels.astype(int), pixels, atol=6 if suffix == ".jpg" else 0)


def test_png_with_a_broken_profile_is_read(tmp_path, capfd):
    io.write_image(tmp_path / "a.png", noise((8, 8, 3)))
    data = (tmp_path / "a.png").read_bytes()
    junk = chunk(b"iCCP", b"x\0\0" + zlib.compress(b"junk" * 100))
    (tmp_path / "a.png").write_bytes(data[:33] + junk + data[33:])
    assert io.read_image(tmp_path / "a.png").icc is None
    assert capfd.readouterr().err == ""


# --- reading what cannot be read -------------------------------------------------------------


def test_missing(tmp_path):
    fails(tmp_path / "none.png", "No such file")
    fails(tmp_path / "no" / "none.png", "No such file")
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    fails(tmp_path / "loop.png", "symbolic link")
    (tmp_path / "dangling.png").symlink_to(tmp_path / "gone.png")
    fails(tmp_path / "dangling.png", "No such file")
    with pytest.raises(FileError, match="''"):
        io.read_image("")


def test_folder(tmp_path):
    fails(tmp_path, "is a folder")


def test_not_a_regular_file(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    fails(tmp_path / "pipe.png", "not a regular file")
    fails("/dev/null", "not a regular file")


def test_null_byte_and_bad_utf8(tmp_path):
    with pytest.raises(FileError, match="null"):
        io.read_image("a\0b.png")
    with pytest.raises(FileError, match="null"):
        io.write_image("a\0b.png", noise((2, 2)))
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
    code = """
        import os, sys
        from weftex.io import pictures as io
        if os.getuid() == 0:
            os.setgid(65534); os.setuid(65534)
        try:
            io.read_image(sys.argv[1])
        except io.FileError as error:
            print(error)
    """
    open_way(tmp_path)
    done = run(code, tmp_path / "a.png")
    assert done.stdout == f"{tmp_path / 'a.png'}: cannot read: Permission denied\n", done.stderr


def open_way(folder):
    """Let another user come to this folder of pytest's."""
    while str(folder) not in ("/", "/tmp"):
        os.chmod(folder, os.stat(folder).st_mode | 0o111)
        folder = os.path.dirname(folder)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.tif", "a.exr", "a.bmp", "a.hdr", "a.null"])
def test_empty_and_text(tmp_path, name, capfd):
    (tmp_path / name).write_bytes(b"")
    fails(tmp_path / name, "the file is empty")
    (tmp_path / name).write_text("this is no picture\n" * 100)
    fails(tmp_path / name, r"not a picture that weftex reads \(\.png, ")
    (tmp_path / name).write_bytes(b"P")
    fails(tmp_path / name, "not a picture")
    captured = capfd.readouterr()
    assert captured.out + captured.err == ""


def test_content_counts_not_the_name(tmp_path):
    pixels = smooth(20, 30)
    for kind in (".png", ".jpg", ".tif", ".bmp", ".webp", ".jxl"):
        store(tmp_path / f"a{kind}", pixels)
        expected = io.read_image(tmp_path / f"a{kind}").pixels
        for wrong in (".png", ".jpg", ".tif", ".exr", ".txt", "", ".tga", ".PNG"):
            shutil.copy(tmp_path / f"a{kind}", tmp_path / f"wrong{wrong}")
            np.testing.assert_array_equal(
                io.read_image(tmp_path / f"wrong{wrong}").pixels, expected
            )
    # OpenImageIO has a reader that makes a black picture of any file of this name.
    shutil.copy(tmp_path / "a.png", tmp_path / "a.null")
    fails(tmp_path / "a.null", "rename")


def store(path, pixels):
    """Write a picture, also in the format that weftex only reads."""
    if path.suffix == ".jxl":
        oiio_write(path, "jpegxl", np.atleast_3d(pixels))
    else:
        io.write_image(path, pixels)


def cuts(size, count=60):
    ends = [0, 1, 2, 3, 8, 12, 16, 26, 33]
    ends += [*np.linspace(0, size - 1, count).astype(int), *range(size - 12, size)]
    return sorted({int(n) for n in ends if 0 <= n < size})


@pytest.mark.parametrize(
    "name",
    ["a.png", "a16.png", "a.jpg", "prog.jpg", "grey.jpg", "a.tif", "af.tif", "raw.tif", "lzw.tif",
     "a.webp", "lossy.webp", "a.bmp", "a.exr", "half.exr", "a.jxl", "a.hdr"],
)  # fmt: skip
def test_every_truncation_is_an_error(tmp_path, name, capfd):
    pixels = smooth(60, 50)
    path = tmp_path / name
    if name in ("prog.jpg", "lossy.webp"):
        Image.fromarray(pixels).save(path, **({"progressive": True} if "prog" in name else {}))
    elif name in ("raw.tif", "lzw.tif"):
        Image.fromarray(pixels).save(path, compression="raw" if "raw" in name else "tiff_lzw")
    elif name in ("half.exr", "a.hdr"):
        kind = "openexr" if "exr" in name else "hdr"
        oiio_write(path, kind, (pixels / 255).astype("float32"))
    elif name == "grey.jpg":
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
    captured = capfd.readouterr()
    assert captured.out + captured.err == ""


def test_a_tiff_with_its_directory_first_is_not_half_read(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", smooth(60, 50), rowsperstrip=7, photometric="rgb")
    data = (tmp_path / "a.tif").read_bytes()
    for end in cuts(len(data)):
        (tmp_path / "a.tif").write_bytes(data[:end])
        fails(tmp_path / "a.tif", "cannot read|damaged|not a picture|empty")


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
    assert (done.returncode, done.stdout) == (0, "done\n"), done.stderr[-2000:]


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


def bomb(width, height):
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return PNG + header + chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")


def test_zero_sized(tmp_path, capfd):
    for width, height in ((0, 5), (5, 0), (0, 0), (2**31, 5), (10**6 + 1, 5)):
        (tmp_path / "a.png").write_bytes(bomb(width, height))
        fails(tmp_path / "a.png", "damaged")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("side", [20_000, 30_000, 200_000, 1_000_000])
def test_decompression_bomb_is_refused_from_its_header(tmp_path, side):
    (tmp_path / "a.png").write_bytes(bomb(side, side))
    before = time.perf_counter()
    fails(tmp_path / "a.png", "max_pixels = 268435456|corrupt")
    assert time.perf_counter() - before < 1


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
    assert done.returncode == 0, done.stderr
    *lines, grown = done.stdout.splitlines()
    assert [
        f"{path}: 4096 x 4096 pixels are more than max_pixels = 1048576" for path in paths[:4]
    ] == lines[:4]
    assert "max_pixels = 1048576" in lines[4]
    assert int(grown) < 12_000 + 16_384  # kB; JPEG XL is decoded before its size is known


def test_the_limit_counts_pixels(tmp_path):
    for suffix in (".png", ".tif", ".webp", ".bmp", ".jpg", ".jxl"):
        store(tmp_path / f"a{suffix}", smooth(20, 30))
        path = tmp_path / f"a{suffix}"
        assert io.read_image(path, max_pixels=600).pixels.shape == (20, 30, 3)
        assert io.read_image(path, max_pixels=None).pixels.shape == (20, 30, 3)
        fails(path, "30 x 20 pixels are more than max_pixels = 599",
              lambda p: io.read_image(p, max_pixels=599))  # fmt: skip
    fails(tmp_path / "a.png", "max_pixels", lambda p: io.read_mask(p, max_pixels=599))


def test_a_tile_larger_than_its_picture_counts(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", smooth(20, 30), tile=(1024, 1024), photometric="rgb")
    assert io.read_image(tmp_path / "a.tif").pixels.shape == (20, 30, 3)
    fails(tmp_path / "a.tif", "max_pixels", lambda p: io.read_image(p, max_pixels=10_000))


@pytest.mark.parametrize("dtype", ["int8", "int16", "int32", "uint32"])
def test_other_integers_are_refused(tmp_path, dtype):
    tifffile.imwrite(tmp_path / "a.tif", np.arange(12, dtype=dtype).reshape(3, 4))
    fails(tmp_path / "a.tif", "weftex reads uint8, uint16 and float")


def test_cmyk_and_lab_are_refused(tmp_path):
    Image.fromarray(noise((8, 8, 4)), "CMYK").save(tmp_path / "a.jpg")
    fails(tmp_path / "a.jpg", "CMYK colours; convert it to RGB")
    tifffile.imwrite(tmp_path / "a.tif", noise((8, 8, 4)), photometric="separated")
    fails(tmp_path / "a.tif", "CMYK")
    tifffile.imwrite(tmp_path / "l.tif", noise((8, 8, 3)), photometric="cielab")
    fails(tmp_path / "l.tif", "LAB")


# --- names -----------------------------------------------------------------------------------

NAMES = ["a b", "100%", "%d", "%04d", "a#", "a####", "Ünï漢字🙂", "a?b=1&c=2", "[1]{2}", "a'b\"c",
         "-", "a,b;c", "$HOME", "~", "a\\b", "..a", " "]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_odd_names(tmp_path, name):
    pixels = noise((5, 4, 3))
    folder = tmp_path / name
    folder.mkdir()
    for suffix in (".png", ".tif", ".bmp", ".webp"):
        io.write_image(folder / (name + suffix), pixels)
        np.testing.assert_array_equal(io.read_image(folder / (name + suffix)).pixels, pixels)
    io.write_image(folder / (name + ".exr"), pixels.astype("f4"))
    np.testing.assert_array_equal(io.read_image(folder / (name + ".exr")).pixels, pixels)
    io.write_image(folder / (name + ".jpg"), pixels)
    assert len(files_in(folder)) == 6


def test_kinds_of_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pixels = noise((5, 4))
    for path in ("a.png", b"b.png", Path("c.PNG"), "./d.TIFF", str(tmp_path / "e.png")):
        io.write_image(path, pixels)
        back = io.read_image(path)
        np.testing.assert_array_equal(back.pixels, pixels)
        assert back.path == os.fsdecode(path)


def test_the_longest_name(tmp_path):
    path = tmp_path / ("n" * 251 + ".png")
    io.write_image(path, noise((4, 4)))
    assert io.read_image(path).pixels.shape == (4, 4)
    fails(tmp_path / ("n" * 252 + ".png"), "too long", lambda p: io.write_image(p, noise((4, 4))))
    assert files_in(tmp_path) == [path.name]


# --- refusing to write -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("suffix", "dtype", "shape", "alpha", "advice"),
    [
        (".png", "float32", (4, 4, 3), False, ".exr, .tif, .tiff"),
        (".png", "float64", (4, 4), False, ".exr, .tif, .tiff"),
        (".jpg", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".jpg", "uint8", (4, 4, 4), True, ".png, .tif, .tiff, .webp"),
        (".bmp", "uint8", (4, 4, 2), True, ".png, .tif, .tiff, .webp"),
        (".webp", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".exr", "uint8", (4, 4, 3), False, ".bmp, .jpeg, .jpg, .png, .tif, .tiff, .webp"),
        (".exr", "uint16", (4, 4, 3), False, ".png, .tif, .tiff"),
        (".png", "uint8", (4, 4, 4), False, ".tif, .tiff"),
        (".png", "uint8", (4, 4, 5), True, ".tif, .tiff"),
        (".png", "uint8", (4, 4, 2), False, ".tif, .tiff"),
    ],
)
def test_what_a_format_cannot_hold(tmp_path, suffix, dtype, shape, alpha, advice):
    pixels = np.ones(shape, dtype)
    path = tmp_path / f"a{suffix}"
    for call in (io.write_image, io.check_output):
        text = fails(path, "cannot hold", lambda p, c=call: c(p, pixels, alpha=alpha),
                     InvalidInputError)  # fmt: skip
        assert text.endswith(f"use {advice}")
    assert files_in(tmp_path) == []
    for other in advice.split(", "):
        io.write_image(tmp_path / f"b{other}", pixels, alpha=alpha)


@pytest.mark.parametrize(
    ("pixels", "alpha", "match"),
    [
        (np.zeros((0, 5), "uint8"), False, "not empty"),
        (np.zeros((5, 0, 3), "uint8"), False, "not empty"),
        (np.zeros((5, 5, 0), "uint8"), False, "not empty"),
        (np.zeros(5, "uint8"), False, "shape"),
        (np.zeros((2, 2, 2, 2), "uint8"), False, "shape"),
        (np.zeros((5, 5), "uint8"), True, "alpha needs"),
        (np.zeros((5, 5, 1), "uint8"), True, "alpha needs"),
        (np.zeros((5, 5), "int64"), False, "int64 pixels"),
        (np.zeros((5, 5), "int16"), False, "int16 pixels"),
        (np.zeros((5, 5), bool), False, "bool pixels"),
        (np.zeros((5, 5), complex), False, "complex128 pixels"),
        (np.full((5, 5), "a"), False, "str"),
    ],
)
def test_what_is_no_picture(tmp_path, pixels, alpha, match):
    for suffix in (".png", ".tif", ".exr"):
        fails(tmp_path / f"a{suffix}", match, lambda p: io.write_image(p, pixels, alpha=alpha),
              InvalidInputError)  # fmt: skip
    assert files_in(tmp_path) == []


@pytest.mark.parametrize(
    ("suffix", "side"), [(".webp", 16_383), (".jpg", 65_500), (".bmp", 65_535), (".png", 10**6)]
)
def test_longest_side(tmp_path, suffix, side, capfd):
    io.write_image(tmp_path / f"a{suffix}", np.full((1, side), 9, "uint8"))
    assert io.read_image(tmp_path / f"a{suffix}").pixels.shape[:2] == (1, side)
    long = np.zeros((side + 1, 1), "uint8")
    fails(
        tmp_path / f"b{suffix}",
        f"at most {side} pixels",
        lambda p: io.write_image(p, long),
        InvalidInputError,
    )
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
    assert fails(
        tmp_path / "a.npy", "cannot write", lambda p: check(p, suffixes=(".npz",))
    ).endswith("'.npz'?")


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
    for call in (lambda p: io.write_image(p, noise((3, 3))),):
        fails(tmp_path / "no" / "a.png", "does not exist", call)
        fails(tmp_path / "dir.png", "is a folder", call)
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
    open_way(tmp_path)
    code = """
        import os, sys
        import numpy as np
        import OpenImageIO
        from weftex.io import pictures as io
        if os.getuid() == 0:
            os.setgid(65534); os.setuid(65534)
        for path in sys.argv[1:]:
            for call in (io.check_output, lambda p: io.write_image(p, np.zeros((4, 4), "u1"))):
                try:
                    call(path)
                except io.FileError as error:
                    print(error)
        try:
            with io.atomic(sys.argv[1]):
                print("not here")
        except io.FileError as error:
            print(error)
    """
    paths = [folder / "new.png", folder / "old.png", tmp_path / "old.png"]
    done = run(code, *paths)
    assert done.stdout.splitlines() == [
        *[f"{folder / 'new.png'}: the folder {folder} is read-only"] * 2,
        *[f"{folder / 'old.png'}: the folder {folder} is read-only"] * 2,
        *[f"{tmp_path / 'old.png'}: exists and cannot be overwritten"] * 2,
        f"{folder / 'new.png'}: cannot write: Permission denied",
    ], done.stderr
    os.chmod(folder, 0o755)
    assert files_in(folder) == ["old.png"]
    assert (tmp_path / "old.png").read_bytes() == old


# --- whole or not at all ---------------------------------------------------------------------

FULL = [".png", ".jpg", ".tif", ".webp", ".bmp", ".exr"]


@pytest.mark.parametrize("suffix", FULL)
def test_no_room_to_write(tmp_path, suffix):
    """A limit on file sizes stands in for a full disk where none can be mounted."""
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"old")
    code = """
        import resource, sys
        import numpy as np
        from weftex.io import pictures as io
        pixels = np.random.default_rng(0).integers(0, 256, (200, 200, 3), "u1")
        pixels = pixels.astype("f4") if ".exr" in sys.argv[1] else pixels
        for room in (1, 30_000, 100_000):
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
            try:
                io.write_image(sys.argv[1], pixels)
            except io.FileError as error:
                print(error)
    """
    done = run(code, path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{path}: cannot write: File too large\n" * 3
    assert files_in(tmp_path) == [path.name]
    assert path.read_bytes() == b"old"


@pytest.fixture
def small_disk(tmp_path):
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=128k,mode=777", "tmpfs", str(folder)]
    if os.getuid() or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("a small disk can be mounted by root only")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("suffix", FULL)
def test_full_disk(small_disk, suffix):
    path = small_disk / f"a{suffix}"
    path.write_bytes(b"old")
    pixels = noise((250, 250, 3), "float32" if suffix == ".exr" else "uint8")
    fails(path, "No space left on device$", lambda p: io.write_image(p, pixels))
    assert files_in(small_disk) == [path.name]
    assert path.read_bytes() == b"old"
    (small_disk / "fill").write_bytes(os.urandom(100_000))
    fails(path, "No space left on device$", lambda p: io.write_image(p, pixels[:2, :2]))
    (small_disk / "fill").unlink()
    io.write_image(path, pixels[:20, :20])
    assert io.read_image(path).pixels.shape == (20, 20, 3)


@pytest.mark.parametrize("suffix", FULL)
def test_the_room_made_sure_of_is_enough(tmp_path, suffix):
    """Noise is the worst case of every encoder."""
    dtype = {".png": "uint16", ".tif": "uint16", ".exr": "float32"}
    for size in ((1, 1), (1, 3000), (3000, 1), (300, 300)):
        kind = dtype.get(suffix, "uint8")
        pixels = noise((*size, 3)) if kind == "uint8" else (
            np.frombuffer(os.urandom(size[0] * size[1] * 12), "u4").astype("u2").reshape(*size, 3)
            if kind == "uint16" else noise((*size, 3), "float32"))  # fmt: skip
        io.write_image(tmp_path / f"a{suffix}", pixels, icc=RGB_PROFILE)
        used = os.path.getsize(tmp_path / f"a{suffix}")
        assert used < pixels.nbytes * 5 // 4 + len(RGB_PROFILE) + 2**16


def test_atomic_replaces_and_removes(tmp_path):
    path = tmp_path / "a.npz"
    with io.atomic(path) as temporary:
        assert os.path.dirname(temporary) == str(tmp_path)
        assert temporary.endswith(".npz")
        assert not path.exists()
        np.savez(temporary, a=np.arange(3))
    assert files_in(tmp_path) == ["a.npz"]
    old = path.read_bytes()
    for error in (ValueError, KeyboardInterrupt, SystemExit, GeneratorExit, MemoryError):
        with pytest.raises(error), io.atomic(path) as temporary:
            Path(temporary).write_bytes(b"half")
            raise error
        assert files_in(tmp_path) == ["a.npz"]
        assert path.read_bytes() == old
    with pytest.raises(FileError, match="a.npz: cannot write: No space"), io.atomic(path):
        raise OSError(28, "No space left on device")
    mine = FileError("mine")
    with pytest.raises(FileError) as info, io.atomic(path):
        raise mine
    assert info.value is mine
    with pytest.raises(FileError, match="No such file"), io.atomic(tmp_path / "no" / "a.npz"):
        pass


def test_a_failing_encoder_leaves_no_trace(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    monkeypatch.setattr(io, "encode", lambda *_: "it broke\nand more")
    text = fails(path, "cannot write", lambda p: io.write_image(p, noise((4, 4))))
    assert text.endswith("cannot write: it broke")
    assert files_in(tmp_path) == ["a.png"]
    assert path.read_bytes() == b"old"


def test_two_writers_at_once(tmp_path):
    path = tmp_path / "a.png"
    pictures = [np.full((200, 200, 3), k, "uint8") for k in range(4)]
    threads = [
        threading.Thread(target=lambda p=p: [io.write_image(path, p) for _ in range(8)])
        for p in pictures
    ]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        if path.exists():
            assert np.ptp(io.read_image(path).pixels) == 0
    for thread in threads:
        thread.join()
    assert files_in(tmp_path) == ["a.png"]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL")
@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_kill_leaves_the_old_file(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    old = np.full((8, 8, 3), 7, "uint8")
    code = """
        import sys
        import numpy as np
        from weftex.io import pictures as io
        pixels = np.random.default_rng(0).integers(0, 256, (1500, 1500, 3), "u1")
        print("go", flush=True)
        io.write_image(sys.argv[1], pixels)
        print("done", flush=True)
    """
    caught = 0
    for delay in (0.001, 0.01, 0.03, 0.06):
        io.write_image(path, old)
        command = [sys.executable, "-c", textwrap.dedent(code), str(path)]
        env = os.environ | {"PYTHONPATH": SRC}
        with subprocess.Popen(command, env=env, stdout=subprocess.PIPE) as process:
            assert process.stdout.readline() == b"go\n"
            deadline = time.perf_counter() + 10
            while not any(f.startswith(".weftex-") for f in os.listdir(tmp_path)):
                assert time.perf_counter() < deadline
                if process.poll() is not None:
                    break
            time.sleep(delay)
            process.send_signal(signal.SIGKILL)
            finished = process.stdout.read() == b"done\n"
        back = io.read_image(path).pixels
        if not finished and back.shape == old.shape:
            caught += 1
            np.testing.assert_array_equal(back, old)
        else:
            assert back.shape == (1500, 1500, 3)
        for file in tmp_path.glob(".weftex-*"):
            file.unlink()
    assert caught


def test_interrupt_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    code = """
        import os, signal, sys
        import numpy as np
        from weftex.io import pictures as io
        real = io.encode
        def encode(*args):
            os.kill(os.getpid(), signal.SIGINT)
            return real(*args)
        io.encode = encode
        try:
            io.write_image(sys.argv[1], np.zeros((50, 50), "u1"))
        except KeyboardInterrupt:
            print("interrupted")
    """
    done = run(code, path)
    assert done.stdout == "interrupted\n", done.stderr
    assert files_in(tmp_path) == ["a.png"]
    assert path.read_bytes() == b"old"


def test_permissions(tmp_path):
    path = tmp_path / "a.png"
    for mask, mode in ((0o022, 0o644), (0o077, 0o600), (0o002, 0o664)):
        before = os.umask(mask)
        try:
            io.write_image(path, noise((4, 4)))
        finally:
            os.umask(before)
        assert stat.S_IMODE(os.stat(path).st_mode) == mode
        path.unlink()
    path.write_bytes(b"old")
    os.chmod(path, 0o640)
    io.write_image(path, noise((4, 4)))
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o640


def test_symbolic_links_are_written_through(tmp_path):
    (tmp_path / "real").mkdir()
    link = tmp_path / "link.png"
    link.symlink_to(tmp_path / "real" / "a.png")
    for value in (1, 2):  # the first finds the link dangling
        io.write_image(link, np.full((3, 3), value, "uint8"))
        assert link.is_symlink()
        assert io.read_image(tmp_path / "real" / "a.png").pixels[0, 0] == value
    assert files_in(tmp_path) == ["link.png", "real"]
    assert files_in(tmp_path / "real") == ["a.png"]
    (tmp_path / "lost.png").symlink_to(tmp_path / "gone" / "a.png")
    fails(tmp_path / "lost.png", "does not exist", io.check_output)
    (tmp_path / "loop.png").symlink_to(tmp_path / "loop.png")
    fails(tmp_path / "loop.png", "cannot be overwritten", io.check_output)


def test_the_same_pixels_give_the_same_bytes(tmp_path):
    pixels = smooth(30, 40)
    for suffix in FULL:
        path = tmp_path / f"a{suffix}"
        io.write_image(path, pixels.astype("f4") if suffix == ".exr" else pixels, icc=RGB_PROFILE)
    first = {suffix: (tmp_path / f"a{suffix}").read_bytes() for suffix in FULL}
    time.sleep(1.1)  # dates are written in seconds
    (tmp_path / "other").mkdir()
    for suffix in FULL:
        path = tmp_path / "other" / f"b{suffix}"
        io.write_image(path, pixels.astype("f4") if suffix == ".exr" else pixels, icc=RGB_PROFILE)
        assert path.read_bytes() == first[suffix], suffix


# --- masks and maps --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("suffix", "values"),
    [
        (".png", np.array([[0, 127, 128, 255]], "uint8")),
        (".png", np.array([[0, 32767, 32768, 65535]], "uint16")),
        (".tif", np.array([[-1, 0.4999, 0.5, 9]], "float32")),
    ],
)
def test_mask_at_half_of_the_range(tmp_path, suffix, values):
    expected = [[False, False, True, True]]
    path = tmp_path / f"a{suffix}"
    io.write_image(path, values)
    mask = io.read_mask(path)
    assert mask.dtype == bool
    assert mask.tolist() == expected
    for channel in range(3):
        pixels = np.zeros((*values.shape, 3), values.dtype)
        pixels[..., channel] = values
        io.write_image(path, pixels)
        assert io.read_mask(path).tolist() == expected


def test_mask_of_nan_is_false(tmp_path):
    io.write_image(tmp_path / "a.tif", np.array([[np.nan, 1]], "f4"))
    assert io.read_mask(tmp_path / "a.tif").tolist() == [[False, True]]


def test_mask_from_alpha(tmp_path):
    path = tmp_path / "a.png"
    alpha = np.array([[0, 100, 200, 255]], "uint8")
    black, white = np.zeros_like(alpha), np.full_like(alpha, 255)
    for colour in (black, white):
        io.write_image(path, np.stack([colour] * 3 + [alpha], 2), alpha=True)
        assert io.read_mask(path).tolist() == [[False, False, True, True]]
    io.write_image(path, np.stack([alpha[:, ::-1], alpha], 2), alpha=True)  # both vary
    assert io.read_mask(path).tolist() == [[True, True, False, False]]
    io.write_image(path, np.stack([alpha, white], 2), alpha=True)
    assert io.read_mask(path).tolist() == [[False, False, True, True]]
    for colour in (black, white):  # nothing varies
        io.write_image(path, np.stack([colour, white], 2), alpha=True)
        assert io.read_mask(path).tolist() == (colour > 0).tolist()


def test_mask_from_one_bit(tmp_path):
    expected = noise((9, 11)) > 100
    Image.fromarray(expected).save(tmp_path / "a.png")
    np.testing.assert_array_equal(io.read_mask(tmp_path / "a.png"), expected)


def test_maps(tmp_path):
    io.write_image(tmp_path / "normal.PNG", noise((4, 4, 3)))
    io.write_image(tmp_path / "albedo.jpg", noise((4, 4, 3)))
    io.write_image(tmp_path / "height.tif", noise((4, 4), "uint16"))
    io.write_image(tmp_path / "albedo.2.exr", noise((5, 4), "float32"))
    (tmp_path / "readme.txt").write_text("x")
    (tmp_path / ".hidden.png").write_text("x")
    (tmp_path / "folder.png").mkdir()
    maps = io.read_maps(tmp_path)
    assert list(maps) == ["albedo", "albedo.2", "height", "normal"]
    assert maps["height"].pixels.dtype == np.uint16
    assert maps["normal"].path == str(tmp_path / "normal.PNG")
    fails(tmp_path / "albedo.2.exr", "4 x 5 pixels are more than max_pixels = 16",
          lambda p: io.read_maps(tmp_path, max_pixels=16))  # fmt: skip
    io.write_image(tmp_path / "height.png", noise((4, 4)))
    fails(tmp_path, "two pictures named 'height'", io.read_maps)
    (tmp_path / "height.png").write_text("x")
    os.unlink(tmp_path / "height.tif")
    fails(tmp_path / "height.png", "not a picture", lambda p: io.read_maps(tmp_path))


def test_maps_that_are_not_there(tmp_path):
    fails(tmp_path, r"has no pictures \(\.png", io.read_maps)
    fails(tmp_path / "no", "No such file", io.read_maps)
    (tmp_path / "file").write_text("x")
    fails(tmp_path / "file", "Not a directory", io.read_maps)
    with pytest.raises(FileError, match="null"):
        io.read_maps("a\0b")


# --- samples ---------------------------------------------------------------------------------

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
    maps = io.read_maps("sample:stone_wall")
    assert list(maps) == ["albedo", "ao", "height", "normal", "roughness"]
    one = io.read_image("sample:stone_wall/normal")
    np.testing.assert_array_equal(one.pixels, maps["normal"].pixels)
    assert 0.05 < io.read_mask("sample:hole").mean() < 0.3
    assert {m.pixels.shape[:2] for m in maps.values()} == {(256, 256)}


def test_samples_that_are_not_there(tmp_path):
    with pytest.raises(FileError, match="no sample is named 'brick'; did you mean 'bricks'"):
        io.read_image("sample:brick")
    for name in ("sample:", "sample:../io", "sample:MANIFEST", "sample:bricks.png", "sample:zzz"):
        with pytest.raises(FileError, match="no sample is named"):
            io.read_image(name)
        assert not io.is_folder(name)
    with pytest.raises(FileError, match="did you mean 'stone_wall'"):
        io.read_maps("sample:stonewall")
    fails("sample:stone_wall", "is a folder")
    fails("sample:bricks", "Not a directory", io.read_maps)
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


# --- small things ----------------------------------------------------------------------------


def test_picture_prints_without_its_pixels():
    assert repr(io.read_image("sample:grass")) == "Picture(alpha=False, path='sample:grass')"


def test_importing_does_not_load_the_library():
    code = """
        import sys
        import numpy
        before = set(sys.modules)
        from weftex.io import pictures as io
        io.check_output("a.png")
        io.sample_names()
        print(*(m for m in set(sys.modules) - before if not m.startswith("weftex")))
    """
    done = run(code)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) <= {"__future__", "copy", "dataclasses", "zlib"}


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
    assert (done.returncode, done.stderr) == (0, "")
