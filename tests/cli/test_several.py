"""synth of several samples of one material, and of a part of a sample."""

import numpy as np

import weftex
from commands import fails, weft_run
from families import noise
from weftex.io.pictures import read_image, write_image

WORDS = ("--method", "quilting", "--patch-size", "10", "--seed", "2", "--size", "70x60")


def test_several_samples(here):
    write_image("other.png", noise((50, 40, 3), seed=9))
    words = ["-o", "a.png", *WORDS, "--save-source", "a.npz"]
    assert weft_run("synth", "sample.png", "other.png", *words) == 0
    whole = weftex.prepare.together(["sample.png", "other.png"])
    made = weftex.synthesize(whole, (60, 70), method=weftex.Quilting(patch_size=10), seed=2)
    assert np.array_equal(read_image("a.png").pixels, made.image)
    assert weft_run("replay", "a.npz", "sample.png", "other.png", "-o", "again.png") == 0
    assert (here / "again.png").read_bytes() == (here / "a.png").read_bytes()


def test_several_sets_of_maps(here):
    (here / "a").mkdir()
    (here / "b").mkdir()
    for k, folder in enumerate("ab"):
        write_image(f"{folder}/x_color.png", noise((40, 40, 3), seed=k))
        write_image(f"{folder}/x_ao.png", noise((40, 40), seed=5 + k))
    assert weft_run("synth", "a", "b", "-o", "out", *WORDS) == 0
    assert sorted(p.name for p in (here / "out").iterdir()) == ["x_ao.png", "x_color.png"]


def test_a_part_of_a_sample(here):
    shape = read_image("sample.png").pixels.shape[:2]
    mask = np.zeros(shape, bool)
    mask[:, 20:] = True
    write_image("m.png", mask.astype(np.uint8) * 255)
    words = [*WORDS, "--sample-mask", "m.png"]
    assert weft_run("synth", "sample.png", "-o", "a.png", *words) == 0
    sample = weftex.load_exemplar("sample.png", mask=mask)
    made = weftex.synthesize(sample, (60, 70), method=weftex.Quilting(patch_size=10), seed=2)
    assert np.array_equal(read_image("a.png").pixels, made.image)
    assert (made.source[..., 1] >= 20).all()


def test_the_alpha_of_a_sample_as_its_mask(here, capsys):
    pixels = noise((50, 60, 4))
    pixels[..., 3] = 255
    pixels[:, :15, 3] = 0
    write_image("clear.png", pixels, alpha=True)
    words = [*WORDS, "--sample-mask", "alpha"]
    assert weft_run("synth", "clear.png", "-o", "a.png", *words) == 0
    assert (read_image("a.png").pixels[..., 3] == 255).all()
    capsys.readouterr()
    assert "no clear pixels" in fails(capsys, here, "synth", "sample.png", "-o", "b.png", *words)
