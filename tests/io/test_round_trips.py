"""Pictures that are written and read again: every format, depth and number of channels, alpha."""

import numpy as np
import pytest

from picture_files import files_in, noise, read_back, smooth
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")

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
    back = read_back(path, pixels, alpha=bool(alpha))
    assert back.pixels.dtype == pixels.dtype
    np.testing.assert_array_equal(back.pixels, pixels)
    assert back.alpha is bool(alpha)
    assert back.icc is None
    assert back.path == str(path)
    assert back.pixels.flags.c_contiguous
    assert files_in(tmp_path) == [path.name]


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_large_pngs_are_compressed_in_bands(tmp_path, dtype):
    pixels = noise((500, 720, 4), dtype)
    files = []
    for threads in (1, 2, 3):
        io.write_image(tmp_path / "a.png", pixels, alpha=True, threads=threads)
        files.append((tmp_path / "a.png").read_bytes())
    assert len(set(files)) == 1
    assert files[0].count(b"IDAT") > 1
    np.testing.assert_array_equal(io.read_image(tmp_path / "a.png").pixels, pixels)
    Image.open(tmp_path / "a.png").load()  # another decoder takes them too


def test_webp_keeps_straight_alpha_except_color_under_zero(tmp_path):
    pixels = noise((20, 20, 4))
    pixels[:3, :3, 3] = 0
    back = read_back(tmp_path / "a.webp", pixels, alpha=True).pixels
    np.testing.assert_array_equal(back[..., 3], pixels[..., 3])
    seen = pixels[..., 3] > 0
    np.testing.assert_array_equal(back[seen], pixels[seen])


@pytest.mark.parametrize("channels", [1, 3])
def test_jpeg_is_close(tmp_path, channels):
    pixels = smooth(40, 50, channels)
    pixels = pixels[..., 0] if channels == 1 else pixels
    for suffix in (".jpg", ".jpeg"):
        back = read_back(tmp_path / f"a{suffix}", pixels).pixels
        assert back.shape == pixels.shape
        assert np.abs(back.astype(int) - pixels).max() <= 6
    with Image.open(tmp_path / "a.jpg") as peer:
        np.testing.assert_allclose(np.asarray(peer).astype(int), pixels, atol=6)
        assert channels == 1 or peer.layer[0][1:3] == (1, 1)  # no color subsampling


@pytest.mark.parametrize("suffix", [".tif", ".exr"])
def test_extreme_floats_survive(tmp_path, suffix):
    values = [0, -0.0, 1, -1, 1e-38, -3e38, 3e38, np.inf, -np.inf, np.nan, 1e-45, 65536]
    pixels = np.array(values, np.float32).reshape(3, 4)
    back = read_back(tmp_path / f"a{suffix}", pixels).pixels
    assert back.tobytes() == pixels.tobytes()


@pytest.mark.parametrize("dtype", ["float16", "float64", ">f4"])
def test_other_floats_are_written_as_float32(tmp_path, dtype):
    pixels = noise((5, 6, 3), "float64").astype(dtype)
    for suffix in (".tif", ".exr"):
        back = read_back(tmp_path / f"a{suffix}", pixels).pixels
        assert back.dtype == np.float32
        np.testing.assert_array_equal(back, pixels.astype(np.float32))


def test_views_and_foreign_byte_order(tmp_path):
    base = noise((30, 40, 3), "uint16")
    for k, view in enumerate((base[::-2, ::3], base.transpose(1, 0, 2), base[..., ::-1],
                              np.asfortranarray(base), base.astype(">u2"))):  # fmt: skip
        np.testing.assert_array_equal(read_back(tmp_path / f"{k}.png", view).pixels, view)


def test_exr_premultiplies(tmp_path):
    pixels = np.abs(noise((7, 8, 4), "float32"))
    pixels[0, :, 3] = 0
    pixels.flags.writeable = False  # the given pixels stay as they are
    back = read_back(tmp_path / "a.exr", pixels, alpha=True)
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
        back = read_back(tmp_path / "a.exr", wanted, alpha=True).pixels
        np.testing.assert_array_equal(back[..., 1], single[..., 1])
    with np.errstate(all="ignore"):
        io.write_image(tmp_path / "a.tif", pixels * 1e300)
    io.read_image(tmp_path / "a.tif")


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
