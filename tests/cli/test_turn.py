"""--turn: more from less."""

import numpy as np

import weftex
from commands import weft_run
from weftex.io.pictures import read_image


def test_a_sample_with_its_copies(here):
    words = ["-o", "a.png", "--seed", "3", "--method", "quilting", "--save-source", "a.npz"]
    assert weft_run("synth", "sample.png", *words, "--turn", "8") == 0
    own = weftex.load_exemplar("sample.png")
    size = (2 * own.shape[0], 2 * own.shape[1])
    expected = weftex.synthesize(weftex.turned(own, "8"), size, method="quilting", seed=3)
    assert np.array_equal(read_image("a.png").pixels, expected.image)
    assert weft_run("replay", "a.npz", "sample.png", "-o", "again.png") == 0
    assert (here / "again.png").read_bytes() == (here / "a.png").read_bytes()


def test_copies_need_a_way_that_there_is(here, capfd):
    assert weft_run("synth", "sample.png", "-o", "a.png", "--turn", "2") == 2
    assert "turn is '2'; it must be one of flip, half, 4, 8" in capfd.readouterr().err


def test_copies_share_no_lattice(here, capfd):
    words = ["--method", "near-regular", "--lattice", "8,0,0,8"]
    assert weft_run("synth", "sample.png", "-o", "a.png", "--turn", "4", *words) == 2
    assert "goes by one lattice" in capfd.readouterr().err
