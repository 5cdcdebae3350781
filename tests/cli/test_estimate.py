"""weftex estimate."""

import numpy as np

import weftex
from commands import weft_run
from weftex.io.pictures import read_image


def test_the_command(here, capsys):
    words = ["--relief", 9, "--ao-radius", 5]
    assert weft_run("estimate", "sample.png", "-o", "out", *words) == 0
    assert "note: roughness is a guess" in capsys.readouterr().err
    found = weftex.load_exemplar("out")
    assert sorted(found.maps) == ["ao", "height", "normal_gl", "roughness"]
    expected = weftex.prepare.estimate_maps("sample.png", relief=9, radius=5)
    assert np.array_equal(found.pixels, expected.pixels)
    assert all(np.array_equal(found.maps[k], expected.maps[k]) for k in found.maps)
    assert read_image(here / "out" / "height_estimated.png").pixels.dtype == np.uint16


def test_sets_and_several_photos(here, capsys):
    assert weft_run("estimate", "sample.png", "-o", "one", "--maps", "height") == 0
    assert weft_run("estimate", "one", "photo.png", "-o", "all", "--maps", "normal_dx,ao") == 0
    assert "roughness" not in capsys.readouterr().err
    found = weftex.load_exemplar("all/one")
    assert sorted(found.maps) == ["ao", "height", "normal_dx"]
    expected = weftex.prepare.estimate_maps("one", maps=["normal_dx"]).maps["normal_dx"]
    assert np.array_equal(found.maps["normal_dx"], expected)
    assert sorted(weftex.load_exemplar("all/photo").maps) == ["ao", "normal_dx"]


def test_light_joints_are_said(here, capsys):
    words = ["estimate", "sample:bricks", "--maps", "height", "-o"]
    assert weft_run(*words, "ridges") == weft_run(*words, "pits", "--invert") == 0
    assert capsys.readouterr().err.count("use --invert") == 1
