"""Masks, and folders of maps."""

import numpy as np
import pytest

from commands import read_maps
from picture_files import fails, noise
from weftex.errors import FileError
from weftex.io import pictures as io


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
    for color in (black, white):
        io.write_image(path, np.stack([color] * 3 + [alpha], 2), alpha=True)
        assert io.read_mask(path).tolist() == [[False, False, True, True]]
    io.write_image(path, np.stack([alpha[:, ::-1], alpha], 2), alpha=True)  # both vary
    assert io.read_mask(path).tolist() == [[True, True, False, False]]
    io.write_image(path, np.stack([alpha, white], 2), alpha=True)
    assert io.read_mask(path).tolist() == [[False, False, True, True]]
    for color in (black, white):  # nothing varies
        io.write_image(path, np.stack([color, white], 2), alpha=True)
        assert io.read_mask(path).tolist() == (color > 0).tolist()


def test_maps(tmp_path):
    io.write_image(tmp_path / "normal.PNG", noise((4, 4, 3)))
    io.write_image(tmp_path / "albedo.jpg", noise((4, 4, 3)))
    io.write_image(tmp_path / "height.tif", noise((4, 4), "uint16"))
    io.write_image(tmp_path / "albedo.2.exr", noise((5, 4), "float32"))
    (tmp_path / "readme.txt").write_text("x")
    (tmp_path / ".hidden.png").write_text("x")
    (tmp_path / "folder.png").mkdir()
    maps = read_maps(tmp_path)
    assert list(maps) == ["albedo", "albedo.2", "height", "normal"]
    assert maps["height"].pixels.dtype == np.uint16
    assert maps["normal"].path == str(tmp_path / "normal.PNG")
    fails(tmp_path / "albedo.2.exr", "4 x 5 pixels are more than max_pixels = 16",
          lambda p: read_maps(tmp_path, max_pixels=16))  # fmt: skip
    (tmp_path / "height.tif").write_text("x")
    fails(tmp_path / "height.tif", "not an image", lambda p: read_maps(tmp_path))


def test_maps_that_are_not_there(tmp_path):
    fails(tmp_path, r"has no images \(\.png", read_maps)
    fails(tmp_path / "no", "No such file", read_maps)
    (tmp_path / "file").write_text("x")
    fails(tmp_path / "file", "Not a directory", read_maps)
    with pytest.raises(FileError, match="null"):
        read_maps("a\0b")
