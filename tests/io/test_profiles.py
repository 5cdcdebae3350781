"""Color profiles: carried where there is a place, and never at the cost of the picture."""

import zlib

import numpy as np
import pytest

from picture_files import GRAY_PROFILE, RGB_PROFILE, chunk, noise, read_back, smooth
from weftex.io import pictures as io

Image = pytest.importorskip("PIL.Image")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp"])
def test_profile_is_carried(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    assert read_back(path, noise((8, 8, 3)), icc=RGB_PROFILE).icc == RGB_PROFILE
    with Image.open(path) as peer:
        assert peer.info["icc_profile"] == RGB_PROFILE


def test_profile_with_alpha_16_bits_and_gray(tmp_path):
    io.write_image(tmp_path / "a.png", noise((8, 8, 4), "uint16"), alpha=True, icc=RGB_PROFILE)
    assert io.read_image(tmp_path / "a.png").icc == RGB_PROFILE
    for suffix in (".png", ".tif", ".jpg"):
        assert (
            read_back(tmp_path / f"g{suffix}", noise((8, 8)), icc=GRAY_PROFILE).icc == GRAY_PROFILE
        )


@pytest.mark.parametrize("suffix", [".bmp", ".exr"])
def test_profile_is_left_out_where_there_is_no_place(tmp_path, suffix):
    pixels = noise((8, 8, 3), "float32" if suffix == ".exr" else "uint8")
    assert read_back(tmp_path / f"a{suffix}", pixels, icc=RGB_PROFILE).icc is None


BROKEN_TAGS = RGB_PROFILE[:128] + b"\xff" * (len(RGB_PROFILE) - 128)


@pytest.mark.parametrize("icc", [b"", b"junk" * 50, RGB_PROFILE[:-4], GRAY_PROFILE, BROKEN_TAGS])
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp"])
def test_a_wrong_profile_does_not_cost_the_picture(tmp_path, suffix, icc):
    pixels = smooth(16, 16)
    back = read_back(tmp_path / f"a{suffix}", pixels, icc=icc)
    assert back.icc is None or icc == BROKEN_TAGS
    np.testing.assert_allclose(back.pixels.astype(int), pixels, atol=6 if suffix == ".jpg" else 0)


def test_png_with_a_broken_profile_is_read(tmp_path, capfd):
    io.write_image(tmp_path / "a.png", noise((8, 8, 3)))
    data = (tmp_path / "a.png").read_bytes()
    junk = chunk(b"iCCP", b"x\0\0" + zlib.compress(b"junk" * 100))
    (tmp_path / "a.png").write_bytes(data[:33] + junk + data[33:])
    assert io.read_image(tmp_path / "a.png").icc is None
    assert capfd.readouterr().err == ""
