"""`weftex synth` makes what the library makes."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import weftex
from commands import weft_run
from families import TRIALS, every, method_of, noise
from weftex.io.pictures import read_image, write_image


def test_synth_makes_what_the_library_makes(here, capsys):
    assert weft_run("synth", "sample.png", "-o", "out.png", "--size", "100x90", "--seed", 7) == 0
    made = read_image("out.png").pixels
    assert (made == weftex.synthesize("sample.png", (90, 100), seed=7).image).all()
    err = capsys.readouterr().err
    assert re.fullmatch(
        r"weftex: auto: (graphcut|patch-sampling), because the structure .*\n"
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
    assert weft_run("synth", "--help", "--method", method) == 0
    out = capsys.readouterr().out
    for field in dataclasses.fields(chosen):
        assert "--" + field.name.replace("_", "-") in out


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [(), (2,), (3,), (4,)])
def test_kind_alpha_and_profile_are_kept(here, dtype, channels):
    from PIL import ImageCms

    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    alpha = channels in ((2,), (4,))
    write_image("in.png", noise((50, 50, *channels), dtype=dtype), alpha=alpha, icc=profile)
    given = read_image("in.png")
    assert weft_run("synth", "in.png", "-o", "out.png", "--size", 60) == 0
    made = read_image("out.png")
    assert made.pixels.dtype == dtype and made.pixels.shape == (60, 60, *channels)
    assert (made.alpha, made.icc) == (given.alpha, given.icc)


def test_the_input_may_be_overwritten(here):
    given = read_image("sample.png").pixels
    assert weft_run("synth", "sample.png", "-o", "sample.png", "--seed", 2) == 0
    expected = weftex.synthesize(given, (128, 144), seed=2).image
    assert (read_image("sample.png").pixels == expected).all()
