"""weftex estimate."""

import numpy as np

import weftex
from commands import fails, weft_run
from weftex.io.pictures import read_image


def test_the_command(here, capsys):
    assert weft_run("estimate", "sample.png", "-o", "out", "--relief", "9") == 0
    found = weftex.load_exemplar("out")
    assert sorted(found.maps) == ["height", "normal_gl"]
    expected = weftex.prepare.estimate_maps("sample.png", relief=9)
    assert np.array_equal(found.pixels, expected.pixels)
    assert all(np.array_equal(found.maps[k], expected.maps[k]) for k in found.maps)
    assert read_image(here / "out" / "height_estimated.png").pixels.dtype == np.uint16
    capsys.readouterr()
    assert "above 0" in fails(capsys, here, "estimate", "sample.png", "-o", "b", "--relief", "-1")
