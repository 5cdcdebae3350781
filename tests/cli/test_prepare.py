"""`weftex prepare`, and the same options of `weftex synth`."""

from __future__ import annotations

import numpy as np
import pytest

import weftex
from commands import weft_run
from weftex.io.pictures import read_image, write_image


@pytest.fixture
def photo(here):
    """Tiles in falling light, slightly askew."""
    y, x = np.indices((96, 120))
    joint = ((x + 0.05 * y) % 24 < 3) | ((y - 0.05 * x) % 16 < 3)
    noise = np.random.default_rng(0).integers(0, 20, joint.shape)
    pixels = np.where(joint, 230, 100 + noise) * np.linspace(0.5, 1, 120)
    write_image("tiles.png", pixels.astype(np.uint8))
    return here


def test_prepare_writes_what_python_returns(photo):
    words = ["prepare", "--straighten", "--even-light", "tiles.png", "-o", "p.png"]
    assert weft_run(*words) == 0  # the file is no value of the option before it
    expected = weftex.prepare.even_light(weftex.prepare.straighten("tiles.png"))
    assert np.array_equal(read_image("p.png").pixels, expected.pixels)


def test_maps_are_straightened_and_keep_their_light(here):
    rng = np.random.default_rng(1)
    (here / "set").mkdir()
    for name in ("albedo", "height"):
        write_image(f"set/{name}.png", rng.integers(0, 255, (64, 64, 3)).astype(np.uint8))
    corners = "8,8,56,8,56,40,8,40"
    assert weft_run("prepare", "set", "-o", "out", "--straighten", corners, "--even-light") == 0
    height = read_image("out/height.png").pixels
    assert np.array_equal(height, read_image("set/height.png").pixels[8:40, 8:56])
    assert read_image("out/albedo.png").pixels.shape == height.shape
    assert weft_run("synth", "set", "-o", "out2", "--straighten", corners, "--size", "40") == 0
    assert read_image("out2/height.png").pixels.shape == (40, 40, 3)
