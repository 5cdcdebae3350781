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
    expected = weftex.synthesize(weftex.prepare.turned(own, "8"), size, method="quilting", seed=3)
    assert np.array_equal(read_image("a.png").pixels, expected.image)
    assert weft_run("replay", "a.npz", "sample.png", "-o", "again.png") == 0
    assert (here / "again.png").read_bytes() == (here / "a.png").read_bytes()
