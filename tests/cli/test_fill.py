"""`weftex fill`: what is a hole, and the filling replayed over a background."""

import numpy as np

import weftex
from commands import weft_run
from weftex.io.pictures import read_image, write_image


def test_fill_nothing(here, capsys):
    assert weft_run("fill", "photo.png", "--mask", "nothing.png", "-o", "out.png") == 0
    assert "unchanged" in capsys.readouterr().err
    assert (read_image("out.png").pixels == read_image("photo.png").pixels).all()


def test_a_hole_from_alpha(here, capsys):
    photo = read_image("photo.png").pixels
    erased = np.dstack([photo, np.full(photo.shape[:2], 255, np.uint8)])
    erased[30:50, 40:60, 3] = 0
    erased[29, 40:60, 3] = 130  # a soft edge is to be filled too
    write_image("erased.png", erased, alpha=True)
    assert weft_run("fill", "erased.png", "-o", "a.png", "--seed", 1) == 0
    assert "filled 420 pixels (5.5 %) of a.png" in capsys.readouterr().err
    made = read_image("a.png").pixels
    assert (made[..., 3] == 255).all()
    hole = erased[..., 3] < 255
    assert (made[~hole] == erased[~hole]).all()
    assert weft_run("fill", "erased.png", "--mask", "erased.png", "-o", "b.png", "--seed", 1) == 0
    assert (read_image("b.png").pixels == made).all()
    # The photo itself with its hole cut out is a mask of the photo.
    assert weft_run("fill", "photo.png", "--mask", "erased.png", "-o", "c.png", "--seed", 1) == 0
    expected = weftex.fill("photo.png", hole, seed=1).image
    assert (read_image("c.png").pixels == expected).all()


def test_replay_over_a_background(here):
    words = ["--sample", "sample.png", "--save-source", "f.npz"]
    weft_run("fill", "photo.png", "--mask", "hole.png", "-o", "f.png", *words)
    words = ["-o", "g.png", "--background", "photo.png"]
    assert weft_run("replay", "f.npz", "sample.png", *words) == 0
    assert (here / "f.png").read_bytes() == (here / "g.png").read_bytes()


def test_pixels_that_may_be_copied(here):
    """Of the photo, or of the sample if there is one."""
    usable = np.zeros((80, 96), np.uint8)
    usable[:, :30] = 255
    write_image("usable.png", usable)
    words = ["photo.png", "--mask", "hole.png", "--sample-mask", "usable.png", "-o", "f.png"]
    for sample in ([], ["--sample", "photo.png"]):
        assert weft_run("fill", *words, *sample, "--save-source", "f.npz") == 0
        source = weftex.Synthesis.load("f.npz").source[30:50, 40:60, 1]
        assert source.min() >= 0 and source.max() < 30
