"""The command line: what it makes, what it says, and what is left when it fails."""

from __future__ import annotations

import dataclasses
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import weftex
from families import TRIALS, every, method_of, noise
from weftex import cli
from weftex.io.pictures import read_image, read_maps, write_image


def listing(folder):
    """Every file below a folder, with its bytes."""
    return {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()} | {
        p: None for p in folder.rglob("*") if p.is_dir()
    }


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a sample, a photo and masks, that is the current one."""
    monkeypatch.chdir(tmp_path)
    write_image("sample.png", noise((64, 72, 3)))
    write_image("photo.png", noise((80, 96, 3), seed=1))
    hole = np.zeros((80, 96), np.uint8)
    hole[30:50, 40:60] = 255
    write_image("hole.png", hole)
    write_image("nothing.png", 0 * hole)
    write_image("all.png", 0 * hole + 255)
    write_image("other.png", noise((40, 40)))
    return tmp_path


def weft_run(*words):
    return cli.main([str(word) for word in words])


ENVIRONMENT = os.environ | {"PYTHONPATH": os.path.dirname(os.path.dirname(weftex.__file__))}


def process(*words, **options):
    command = [sys.executable, "-m", "weftex.cli", *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, **options)


def fails(capsys, folder, *words):
    """Run a command that must fail; return its message."""
    before = listing(folder)
    code = weft_run(*words)
    out, err = capsys.readouterr()
    assert code == 2 and out == ""
    assert err.startswith("weftex: error: ") and err.count("\n") == 1, err
    assert listing(folder) == before
    return err


# What it makes.


def test_synth_makes_what_the_library_makes(here, capsys):
    assert weft_run("synth", "sample.png", "-o", "out.png", "--size", "100x90", "--seed", 7) == 0
    made = read_image("out.png").pixels
    assert (made == weftex.synthesize("sample.png", (90, 100), seed=7).image).all()
    err = capsys.readouterr().err
    assert re.fullmatch(
        r"weftex: auto: .*structure.*: (graphcut|patch-sampling)\n"
        r"weftex: made 100x90 out\.png with \1, patch size \d+, seed 7, "
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


@pytest.mark.parametrize(
    ("words", "wrap"),
    [(["--tileable"], True), (["--tileable", "x"], "x"), (["--tileable", "y"], "y"), ([], False)],
)
def test_tileable(here, words, wrap):
    assert weft_run("synth", *words, "sample.png", "-o", "a.png", "--size", 80, "--seed", 1) == 0
    expected = weftex.synthesize("sample.png", 80, seed=1, tileable=wrap).image
    assert (read_image("a.png").pixels == expected).all()


def test_parameters_come_from_the_method(here):
    words = ["--method", "quilting", "--patch-size", 20, "--tolerance", 0.3, "--blend", "feather"]
    assert weft_run("synth", "sample.png", "-o", "a.png", "--seed", 1, *words, "--size=70") == 0
    expected = weftex.synthesize(
        "sample.png", 70, method="quilting", seed=1, patch_size=20, tolerance=0.3, blend="feather"
    )
    assert (read_image("a.png").pixels == expected.image).all()


def test_a_folder_gives_a_folder(here):
    assert weft_run("synth", "sample:stone_wall", "-o", "big/", "--size", 150, "--seed", 3) == 0
    maps = read_maps("big")
    result = weftex.synthesize("sample:stone_wall", 150, seed=3)
    assert sorted(maps) == ["albedo", "ao", "height", "normal", "roughness"]
    assert (maps.pop("albedo").pixels == result.image).all()
    for name, picture in maps.items():
        assert (picture.pixels == result.maps[name]).all()


def test_a_folder_may_exist_and_keeps_what_else_is_in_it(here):
    (here / "big").mkdir()
    (here / "big" / "notes.txt").write_text("mine")
    assert weft_run("synth", "sample:stone_wall", "-o", "big", "--size", 100) == 0
    assert (here / "big" / "notes.txt").read_text() == "mine"
    assert len(list((here / "big").iterdir())) == 6


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


def test_texture_by_numbers(here):
    """The sample has a map of labels, and the output follows another one."""
    sample = weftex.load_exemplar("sample.png").pixels
    labels = np.zeros(sample.shape[:2], np.uint8)
    labels[:, labels.shape[1] // 2 :] = 200
    write_image("in.png", labels)
    write_image("out.png", np.resize(np.uint8([0] * 9 + [200] * 9), (20, 36)))
    words = ["--method", "refinement", "--guide", "out.png", "--seed", 1]
    assert weft_run("synth", "sample.png", "-o", "a.png", *words, "--sample-guide", "in.png") == 0
    guides = {"guide": "out.png", "sample_guide": labels}
    expected = weftex.synthesize("sample.png", (20, 36), method="refinement", seed=1, **guides)
    assert np.array_equal(weftex.read_image("a.png").pixels, expected.image)
    with pytest.raises(
        weftex.InvalidInputError, match="sample_guide has no effect without a guide"
    ):
        weftex.synthesize("sample.png", 20, method="refinement", sample_guide=labels)
    with pytest.raises(weftex.InvalidInputError, match="the guide of .* lacks"):
        weftex.synthesize(
            "sample.png", 9, method="refinement", guide=np.full((9, 9), 3), sample_guide=labels
        )


def test_a_guide_gives_the_size(here):
    write_image("guide.png", noise((50, 60, 3), seed=4))
    words = ["--method", "ashikhmin", "--guide", "guide.png", "--seed", 1]
    assert weft_run("synth", "sample.png", "-o", "a.png", *words, "--guide-weight", 2) == 0
    expected = weftex.synthesize(
        "sample.png", (50, 60), method="ashikhmin", guide="guide.png", seed=1, guide_weight=2.0
    )
    assert (read_image("a.png").pixels == expected.image).all()
    assert weft_run("synth", "sample.png", "-o", "b.png", *words, "--size", "60x50") == 0


def test_fill(here, capsys):
    words = ["photo.png", "--mask", "hole.png", "-o", "out.png", "--seed", 1]
    assert weft_run("fill", *words) == 0
    assert "filled 400 pixels of out.png with patch-sampling" in capsys.readouterr().err
    assert (
        read_image("out.png").pixels == weftex.fill("photo.png", "hole.png", seed=1).image
    ).all()
    assert weft_run("fill", *words, "--sample", "sample.png") == 0
    expected = weftex.fill("photo.png", "hole.png", seed=1, sample="sample.png").image
    assert (read_image("out.png").pixels == expected).all()


def test_fill_a_folder(here):
    given = read_maps("sample:stone_wall")
    mask = np.zeros(given["albedo"].pixels.shape[:2], np.uint8)
    mask[100:130, 90:140] = 255
    write_image("mask.png", mask)
    assert weft_run("fill", "sample:stone_wall", "--mask", "mask.png", "-o", "new") == 0
    made = read_maps("new")
    assert sorted(made) == sorted(given)
    for name, picture in made.items():
        assert (picture.pixels[mask == 0] == given[name].pixels[mask == 0]).all()


def test_fill_nothing(here, capsys):
    assert weft_run("fill", "photo.png", "--mask", "nothing.png", "-o", "out.png") == 0
    assert "unchanged" in capsys.readouterr().err
    assert (read_image("out.png").pixels == read_image("photo.png").pixels).all()


def test_the_input_may_be_overwritten(here):
    given = read_image("sample.png").pixels
    assert weft_run("synth", "sample.png", "-o", "sample.png", "--seed", 2) == 0
    expected = weftex.synthesize(given, (128, 144), seed=2).image
    assert (read_image("sample.png").pixels == expected).all()


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


# What it says.


def test_methods(capsys):
    assert weft_run("methods") == 0
    table = capsys.readouterr().out
    assert all(slug in table and weftex.METHODS[slug].title in table for slug in weftex.METHODS)
    for slug in weftex.METHODS:
        assert weft_run("methods", slug) == 0
        text = capsys.readouterr().out
        assert weftex.METHODS[slug].paper in text
        for field in dataclasses.fields(weftex.METHODS[slug]):
            assert f"--{field.name.replace('_', '-')}\n    {field.metadata['help']}\n" in text
    assert weft_run("methods", "quilting") == 0
    default = weftex.Quilting().randomness
    assert f"from 0.001 to 1; default: {default:g}" in capsys.readouterr().out


def test_samples_version_and_help(capsys):
    assert weft_run("samples") == 0
    assert "sample:bricks\n" in capsys.readouterr().out
    assert weft_run("--version") == 0
    assert capsys.readouterr().out == f"weftex {weftex.__version__}\n"
    assert weft_run("--help") == 0
    out = capsys.readouterr().out
    assert all(name in out for name in ("synth", "fill", "replay", "methods", "samples"))
    assert weft_run("synth", "--help", "--method", "quilting") == 0
    out = capsys.readouterr().out
    assert "--tolerance" in out and "examples:" in out


# What is left when it fails.

PATCHES = ["synth", "sample.png", "-o", "x.png", "--method", "patch-sampling"]
WRONG = [
    ([], "a command is missing"),
    (["snyth"], "unknown command 'snyth'; did you mean 'synth'"),
    (["--verson"], "unknown option '--verson'"),
    (["synth"], "required: SAMPLE"),
    (["synth", "sample.png"], "-o/--output"),
    (["synth", "sample.png", "-o", "x.png", "more.png"], "unexpected argument 'more.png'"),
    (["synth", "nowhere.png", "-o", "x.png"], "nowhere.png: cannot read"),
    (["synth", "sample:brick", "-o", "x.png"], "did you mean 'bricks'"),
    (["synth", "sample.png", "-o", "nowhere/x.png"], "nowhere does not exist"),
    (["synth", "sample:stone_wall", "-o", "nowhere/x"], "nowhere/x"),
    (["synth", "sample:stone_wall", "-o", "old.png"], "it is a file"),
    (["synth", "sample.png", "-o", "x.pngg"], "did you mean '.png'"),
    (["synth", "sample.png", "-o", "x.exr"], "'.exr' cannot hold uint8"),
    (["synth", "sample.png", "-o", "."], "folder"),
    (["synth", "sample.png", "-o", "x.png", "--save-source", "nowhere/x.npz"], "does not exist"),
    (["synth", "sample.png", "-o", "x.png", "--save-source", "x.png"], "cannot write '.png'"),
    (["synth", "sample.png", "-o", "x.png", "--size", "0"], "1 or more"),
    (["synth", "sample.png", "-o", "x.png", "--size", "-5"], "1 or more"),
    (["synth", "sample.png", "-o", "x.png", "--size=-5x7"], "1 or more"),
    (["synth", "sample.png", "-o", "x.png", "--size", "5x7x9"], "WxH"),
    (["synth", "sample.png", "-o", "x.png", "--size", "big"], "WxH"),
    (["synth", "sample.png", "-o", "x.png", "--size", "99999999"], "--allow-huge"),
    (
        ["synth", "sample.png", "-o", "x.png", "--size", "99999999", "--allow-huge"],
        "pixels at once",
    ),
    (["synth", "sample.png", "-o", "x.png", "--method", "quiltin"], "did you mean 'quilting'"),
    ([*PATCHES, "--patchsize", "9"], "did you mean '--patch-size'"),
    (["synth", "sample.png", "-o", "x.png", "--patch-size", "9"], "--method patch-sampling or"),
    ([*PATCHES, "--patch-size", "0"], "1 or more"),
    ([*PATCHES, "--patch-size", "big"], "invalid int value"),
    ([*PATCHES, "--patch-size", "70"], "largest that fits is 64"),
    ([*PATCHES, "--blend", "cutt"], "did you mean 'cut'"),
    ([*PATCHES, "--epsilon", "nan"], "number"),
    (["synth", "sample.png", "-o", "x.png", "--seed", "-1"], "--seed is -1"),
    (["synth", "sample.png", "-o", "x.png", "--threads", "0"], "--threads is 0"),
    (["synth", "sample.png", "-o", "x.png", "--tileable=z"], "invalid choice"),
    (["synth", "text.png", "-o", "x.png"], "text.png"),
    (["synth", "empty.png", "-o", "old.png"], "empty"),
    (["synth", "cut.png", "-o", "old.png"], "cut short"),
    (["synth", "bomb.png", "-o", "old.png"], "--allow-huge takes it anyway"),
    (["synth", "zero.png", "-o", "old.png"], "damaged"),
    (["synth", "hollow.png", "-o", "old.png"], "damaged"),
    (["synth", "nan.tif", "-o", "x.tif"], "NaN or infinity"),
    (["synth", "void", "-o", "x"], "has no pictures"),
    (["synth", "uneven", "-o", "x"], "one size"),
    (["synth", "sample.png", "-o", "x.png", "--guide", "nowhere.png"], "nowhere.png"),
    (
        [*PATCHES, "--guide", "photo.png"],
        "patch-sampling does not do following a guide; these do: .*ashikhmin",
    ),
    (
        ["synth", "sample.png", "-o", "x.png", "--method", "ashikhmin", "--guide", "other.png"],
        "guide is uint8",
    ),
    (
        [
            "synth",
            "sample.png",
            "-o",
            "x.png",
            "--method",
            "ashikhmin",
            "--guide",
            "photo.png",
            "--size",
            "50",
        ],
        "guide is 96x80, the canvas is 50x50",
    ),
    (
        ["synth", "sample.png", "-o", "x.png", "--method", "ashikhmin", "--guide-weight", "2"],
        "guide_weight has no effect without a guide",
    ),
    (["fill", "photo.png", "-o", "x.png"], "--mask"),
    (["fill", "photo.png", "--mask", "nowhere.png", "-o", "old.png"], "nowhere.png"),
    (["fill", "photo.png", "--mask", "other.png", "-o", "old.png"], "40x40.*96x80"),
    (["fill", "photo.png", "--mask", "all.png", "-o", "old.png"], "nothing to learn from"),
    (
        ["fill", "photo.png", "--mask", "hole.png", "-o", "old.png", "--sample", "other.png"],
        "equal",
    ),
    (["replay", "nowhere.npz", "sample.png", "-o", "x.png"], "nowhere.npz does not exist"),
    (["replay", "photo.png", "sample.png", "-o", "x.png"], "not a saved weftex result"),
    (["replay", "a.npz", "photo.png", "-o", "x.png"], "integer multiple"),
    (["replay", "a.npz", "sample.png", "-o", "old.txt"], "cannot write '.txt'"),
    (["methods", "quiltin"], "did you mean 'quilting'"),
    (["samples", "more"], "unexpected argument"),
]


@pytest.mark.parametrize(("words", "message"), WRONG, ids=[" ".join(w)[:60] for w, _ in WRONG])
def test_bad_input_is_one_line_and_leaves_everything(here, capsys, words, message):
    import struct
    import zlib

    (here / "text.png").write_text("this is no picture")
    (here / "old.txt").write_text("old")
    (here / "empty.png").write_bytes(b"")
    whole = (here / "sample.png").read_bytes()
    (here / "old.png").write_bytes(whole)
    (here / "cut.png").write_bytes(whole[: len(whole) // 2])
    for name, side in (("bomb.png", 100_000), ("zero.png", 0)):
        header = b"IHDR" + struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
        chunks = (header, b"IDAT" + zlib.compress(bytes(1000)), b"IEND")
        packed = [
            struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in chunks
        ]
        (here / name).write_bytes(whole[:8] + b"".join(packed))
    (here / "hollow.png").write_bytes(whole[:33] + packed[-1])
    write_image("nan.tif", np.full((40, 40), np.nan, np.float32))
    (here / "void").mkdir()
    (here / "uneven").mkdir()
    write_image("uneven/a.png", noise((40, 40)))
    write_image("uneven/b.png", noise((40, 41)))
    weftex.synthesize("sample.png", 80, seed=1).save("a.npz")
    assert re.search(message, fails(capsys, here, *words))


def test_not_enough_memory_is_one_line(here, capsys, monkeypatch):
    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr("weftex.tasks.synthesize.synthesize", fail)
    message = fails(capsys, here, "synth", "sample.png", "-o", "x.png")
    assert "not enough memory" in message


def test_a_map_that_cannot_be_written_leaves_no_map(here, capsys, monkeypatch):
    import weftex.io.pictures

    real, seen = weftex.io.pictures.write_image, []

    def fail_third(*words, **options):
        seen.append(words)
        if len(seen) == 3:
            raise weftex.FileError("the disk is full")
        real(*words, **options)

    monkeypatch.setattr(weftex.io.pictures, "write_image", fail_third)
    fails(capsys, here, "synth", "sample:stone_wall", "-o", "new", "--size", 80)
    assert len(seen) == 3
    (here / "old").mkdir()
    real("old/albedo.png", noise((9, 9)))
    seen.clear()
    fails(capsys, here, "synth", "sample:stone_wall", "-o", "old", "--size", 80)


# Whole processes.


def test_a_process_of_its_own(here):
    run = process("synth", "sample.png", "-o", "a.png", "--seed", 1)
    assert "made 144x128 a.png" in run.communicate()[1]
    assert run.returncode == 0
    run = process("synth", "nowhere.png", "-o", "b.png")
    assert run.communicate()[1].count("\n") == 1
    assert run.returncode == 2
    assert not (here / "b.png").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="no limits there")
@pytest.mark.parametrize("output", ["old.png", "x.png", "x.tif", "x.jpg", "x.webp"])
def test_a_full_disk(here, output):
    import resource

    (here / "old.png").write_bytes((here / "sample.png").read_bytes())
    before = listing(here)

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))

    run = process("synth", "sample.png", "-o", output, "--size", 300, preexec_fn=limit)
    err = run.communicate()[1]
    assert run.returncode == 2
    assert err.startswith("weftex: error: ") and err.count("\n") == 1, err
    assert listing(here) == before


@pytest.mark.skipif(sys.platform == "win32", reason="signals are other there")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("kind", ["one", "folder"])
def test_stopping_leaves_nothing(here, number, code, kind):
    write_image("large.png", noise((700, 700, 3)))
    (here / "maps").mkdir()
    write_image("maps/albedo.png", noise((700, 700, 3)))
    before = listing(here)
    sample, output = ("large.png", "x.png") if kind == "one" else ("maps", "new")
    words = ["--method", "patch-sampling", "--search", "exhaustive", "--patch-size", 64]
    words += ["--repeat-distance", 0]
    run = process("synth", sample, "-o", output, "--size", 6000, *words)
    time.sleep(1.5)
    assert run.poll() is None, run.communicate()
    run.send_signal(number)
    try:
        err = run.communicate(timeout=60)[1]
    finally:
        run.kill()
    assert run.returncode == code
    assert err == "weftex: stopped; nothing was written\n"
    assert listing(here) == before


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals there")
def test_a_bar_on_a_terminal(here):
    pytest.importorskip("tqdm")
    import fcntl
    import pty
    import struct
    import termios

    write_image("large.png", noise((400, 400, 3)))
    words = ["--method", "patch-sampling", "--search", "exhaustive", "--size", "600"]
    words += ["--patch-size", "64"]
    command = [sys.executable, "-m", "weftex.cli", "synth", "large.png", "-o", "x.png", *words]
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    run = subprocess.Popen(command, stderr=theirs, env=ENVIRONMENT)
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert run.wait() == 0
    assert b"patches" in shown and b"made 600x600 x.png" in shown
