"""`weftex replay`: maps after the picture, and over a background."""

from __future__ import annotations

import numpy as np

import weftex
from commands import weft_run
from families import noise
from weftex.io.pictures import read_image, write_image


def test_replay(here):
    weft_run("synth", "sample.png", "-o", "a.png", "--save-source", "a.npz", "--size", "90x80")
    write_image("normal.png", noise((128, 144, 3), dtype=np.uint16))
    assert weft_run("replay", "a.npz", "normal.png", "-o", "n.png") == 0
    expected = weftex.Synthesis.load("a.npz").render(read_image("normal.png").pixels)
    assert expected.shape == (160, 180, 3)
    assert (read_image("n.png").pixels == expected).all()
    assert weft_run("replay", "a.npz", "sample.png", "-o", "again.png") == 0
    assert (here / "again.png").read_bytes() == (here / "a.png").read_bytes()


def test_replay_over_a_background(here):
    words = ["--sample", "sample.png", "--save-source", "f.npz"]
    weft_run("fill", "photo.png", "--mask", "hole.png", "-o", "f.png", *words)
    words = ["-o", "g.png", "--background", "photo.png"]
    assert weft_run("replay", "f.npz", "sample.png", *words) == 0
    assert (here / "f.png").read_bytes() == (here / "g.png").read_bytes()
