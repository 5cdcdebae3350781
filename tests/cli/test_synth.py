"""`weftex synth` makes what the library makes."""

import re

import numpy as np
import pytest
from PIL import Image

import weftex
from commands import weft_run
from families import TRIALS, every, method_of, noise
from picture_files import RGB_PROFILE
from weftex.io.pictures import read_image, write_image


def test_synth_makes_what_the_library_makes(here, capsys):
    assert weft_run("synth", "sample.png", "-o", "out.png", "--size", "100x90", "--seed", 7) == 0
    made = read_image("out.png").pixels
    assert (made == weftex.synthesize("sample.png", (90, 100), seed=7).image).all()
    err = capsys.readouterr().err
    assert re.fullmatch(
        r"weftex: auto: (graphcut|patch-sampling), because the features .*\n"
        r"weftex: made 100x90 out\.png with \1(, patch size \d+)?, seed 7, "
        r"in [\d.]+ s \([\d.e-]+ megapixels/s\)\n",
        err,
    ), err


def test_a_seed_that_was_drawn_can_be_had_again(here, capsys):
    weft_run("synth", "sample.png", "-o", "a.png")
    seed = re.search(r"seed (\d+)", capsys.readouterr().err).group(1)
    weft_run("synth", "sample.png", "-o", "b.png", "--seed", seed, "--quiet")
    assert capsys.readouterr().err == ""
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()
    assert read_image("a.png").pixels.shape == (128, 144, 3)


@every("method")
def test_every_method_has_its_options(here, capsys, method):
    chosen = method_of(method)
    words = ["--method", method, "--size", 50, "--seed", 1]
    for name, value in TRIALS[method].small.items():
        text = ",".join(map(str, value)) if isinstance(value, tuple) else value
        words += ["--" + name.replace("_", "-"), text]
    assert weft_run("synth", "sample.png", "-o", "a.png", *words) == 0
    assert f"with {method}, " in capsys.readouterr().err
    expected = weftex.synthesize("sample.png", 50, method=chosen, seed=1).image
    assert (read_image("a.png").pixels == expected).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [(), (2,), (3,), (4,)])
def test_kind_alpha_and_profile_are_kept(here, dtype, channels):
    alpha = channels in ((2,), (4,))
    write_image("in.png", noise((50, 50, *channels), dtype=dtype), alpha=alpha, icc=RGB_PROFILE)
    given = read_image("in.png")
    assert weft_run("synth", "in.png", "-o", "out.png", "--size", 60) == 0
    made = read_image("out.png")
    assert made.pixels.dtype == dtype and made.pixels.shape == (60, 60, *channels)
    assert (made.alpha, made.icc) == (given.alpha, given.icc)


CONVERTED = {
    "CMYK in TIFF": ("ink.tif", "x.png", "CMYK became RGB"),
    "CMYK in JPEG": ("ink.jpg", "x.png", "CMYK became RGB"),
    "GIF": ("one.gif", "x.png", None),
    "TGA": ("one.tga", "x.jpg", None),
    "16 bits to JPEG": ("deep.png", "x.jpg", "note: uint16 became 8 bits, as .jpg does not hold"),
    "8 bits to EXR": ("sample.png", "x.exr", "note: uint8 became float32 (linear light)"),
    "floats to PNG": ("one.exr", "x.png", "note: float32 became 16 bits"),
    "alpha to JPEG": ("clear.png", "x.jpg", "note: alpha is left out"),
}


@pytest.mark.parametrize("case", CONVERTED)
def test_formats_are_converted_and_losses_are_noted(here, capsys, case):
    flat = Image.new("RGB", (40, 40), (60, 120, 200))
    flat.save("one.tga")
    flat.save("one.gif")
    flat.convert("CMYK").save("ink.tif")
    flat.convert("CMYK").save("ink.jpg", quality=95)
    flat.convert("RGBA").save("clear.png")
    levels = np.broadcast_to(np.uint16([60 * 257, 120 * 257, 200 * 257]), (40, 40, 3))
    write_image("deep.png", levels)
    stored = np.float32([60, 120, 200]) / 255
    write_image("one.exr", np.broadcast_to(((stored + 0.055) / 1.055) ** 2.4, (40, 40, 3)))
    given, output, note = CONVERTED[case]
    assert weft_run("synth", given, "-o", output, "--method", "quilting", "--size", 30) == 0
    said, made = capsys.readouterr().err, read_image(output)
    assert said.count("note: ") == bool(note) and (note or "") in said
    if given != "sample.png":
        assert not made.alpha and made.pixels.shape[2] == 3
        whole = made.pixels // (257 if made.pixels.dtype == np.uint16 else 1)
        assert abs(whole.astype(int) - [60, 120, 200]).max() <= 4, whole[0, 0]
