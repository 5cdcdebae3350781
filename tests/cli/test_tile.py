"""weftex tile."""

import numpy as np

import weftex
from commands import weft_run
from weftex.io.pictures import read_image


def test_tile(here, capfd):
    assert weft_run("tile", "sample:pebbles", "-o", "t.png", "--seed", "1", "--border", "30") == 0
    assert "made tileable: t.png" in capfd.readouterr().err
    expected = weftex.tile("sample:pebbles", border=30, seed=1).image
    assert np.array_equal(read_image("t.png").pixels, expected)
    assert weft_run("tile", "sample:pebbles", "-o", "x.png", "--seed", "1", "--tileable", "x") == 0
    expected = weftex.tile("sample:pebbles", axes="x", seed=1).image
    assert np.array_equal(read_image("x.png").pixels, expected)


def test_a_border_that_is_too_wide(here, capfd):
    assert weft_run("tile", "sample:pebbles", "-o", "t.png", "--border", "4000") == 2
    assert "border is 4000" in capfd.readouterr().err
    assert not (here / "t.png").exists()
