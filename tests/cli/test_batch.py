"""weftex batch: many outputs from the samples of a folder."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import weftex
from commands import fails, weft_run
from families import noise, refused
from picture_files import oiio_write
from processes import children_of, have_ended, hear_interrupts, weftex_process
from weftex.errors import WeftexError
from weftex.io.manifest import Manifest, remove
from weftex.io.pictures import read_image, write_image
from weftex.processes import Workers


@pytest.fixture
def samples(here):
    folder = here / "samples"
    (folder / "wall").mkdir(parents=True)
    (folder / "empty").mkdir()
    write_image(folder / "grass.png", noise((40, 44, 3)))
    write_image(folder / "sand.jpg", noise((40, 44, 3), seed=2))
    write_image(folder / "wall" / "wall_color.png", noise((40, 40, 3), seed=3))
    write_image(folder / "wall" / "wall_height.png", noise((40, 40), dtype=np.uint16, seed=4))
    (folder / "readme.txt").write_text("not a picture")
    return folder


WORDS = ("--method", "quilting", "--patch-size", "12", "--size", "50x48", "--seed", "7")


def records(folder):
    lines = (folder / "manifest.jsonl").read_text().splitlines()
    return {one["output"]: one for one in map(json.loads, lines)}


def contents(folder):
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and p.name not in ("manifest.jsonl", "contact.html")
    }


def test_pictures_and_sets(here, samples):
    assert weft_run("batch", "samples", "-o", "out", *WORDS, "--count", "2") == 0
    expected = {
        f"{name}_{seed}.{t}" for name, t in (("grass", "png"), ("sand", "jpg")) for seed in (7, 8)
    }
    expected |= {f"wall_{s}/wall_{m}.png" for s in (7, 8) for m in ("color", "height")}
    assert set(contents(here / "out")) == expected
    method = weftex.Quilting(patch_size=12)
    made = weftex.synthesize("samples/grass.png", (48, 50), method=method, seed=8)
    assert np.array_equal(read_image("out/grass_8.png").pixels, made.image)
    made = weftex.synthesize("samples/wall", (48, 50), method=method, seed=7)
    assert np.array_equal(read_image("out/wall_7/wall_height.png").pixels, made.maps["height"])
    found = records(here / "out")
    outputs = {"grass_7.png", "grass_8.png", "sand_7.jpg", "sand_8.jpg", "wall_7", "wall_8"}
    assert set(found) == outputs
    one = found["grass_8.png"]
    assert one["seed"] == 8 and one["method"] == "quilting" and one["size"] == [50, 48]
    assert one["parameters"]["patch_size"] == 12 and one["seconds"] >= 0
    assert one["sample"] == os.path.join("samples", "grass.png")


def test_what_is_only_read_is_written_as_what_holds_it(here):
    (here / "samples").mkdir()
    floats = noise((40, 40, 3)).astype(np.float32)
    oiio_write(here / "samples" / "a.jxl", "jpegxl", floats)
    oiio_write(here / "samples" / "b.jxl", "jpegxl", noise((40, 40, 3)))
    assert weft_run("batch", "samples", "-o", "out", *WORDS) == 0
    assert set(contents(here / "out")) == {"a.exr", "b.png"}
    assert read_image("out/a.exr").pixels.dtype == np.float32


def test_nothing_is_overwritten_unless_told(here, samples, capsys):
    weft_run("batch", "samples", "-o", "out", *WORDS)
    before = contents(here / "out")
    capsys.readouterr()
    message = fails(capsys, here, "batch", "samples", "-o", "out", *WORDS)
    assert "exists; --skip-existing" in message
    words = ["batch", "samples", "-o", "out", *WORDS, "--skip-existing", "--turn", "flip"]
    assert "made with other options" in fails(capsys, here, *words)
    (here / "out" / "grass.png").unlink()
    assert weft_run("batch", "samples", "-o", "out", *WORDS, "--skip-existing") == 0
    assert contents(here / "out") == before
    other = [*WORDS[:-1], "9"]
    assert weft_run("batch", "samples", "-o", "out", *other, "--force") == 0
    assert contents(here / "out") != before
    assert records(here / "out")["grass.png"]["seed"] == 9


def test_a_file_of_somebody_else_is_kept(here, samples, capsys):
    (here / "out").mkdir()
    (here / "out" / "sand.jpg").write_text("mine")
    fails(capsys, here, "batch", "samples", "-o", "out", *WORDS)
    assert weft_run("batch", "samples", "-o", "out", *WORDS, "--skip-existing") == 0
    capsys.readouterr()
    assert (here / "out" / "sand.jpg").read_text() == "mine"
    assert "sand.jpg" not in records(here / "out")
    (here / "out" / "sand_8.jpg").write_text("mine")
    words = [*WORDS, "--count", 3, "--keep-best", 2, "--skip-existing"]
    assert "sand_8.jpg exists" in fails(capsys, here, "batch", "samples", "-o", "out", *words)


def test_the_best_are_kept(here, samples):
    for folder in ("wall", "sand.jpg"):
        remove(str(samples / folder))
    write_image(samples / "grass.png", read_image("sample:pebbles").pixels[:64, :64])
    words = ["--method", "quilting", "--size", "72", "--count", "3"]
    assert weft_run("batch", "samples", *words, "-o", "all", "--score") == 0
    assert weft_run("batch", "samples", *words, "-o", "best", "--keep-best", "2") == 0
    scores = {one["output"]: one["score"] for one in records(here / "all").values()}
    kept = contents(here / "best")
    assert sorted(kept) == sorted(sorted(scores, key=scores.get)[:2])
    assert all(kept[name] == contents(here / "all")[name] for name in kept)
    words += ["-o", "best", "--keep-best"]
    assert weft_run("batch", "samples", *words, "2", "--skip-existing") == 0
    assert weft_run("batch", "samples", *words, "1", "--force") == 0
    assert sorted(contents(here / "best")) == [min(scores, key=scores.get)]


def test_names_of_a_scheme_and_of_a_template(here, samples):
    words = ["--template", "{seed}-{name}", "--preset", "ambientcg"]
    (samples / "grass.png").unlink()
    (samples / "sand.jpg").unlink()
    assert weft_run("batch", "samples", "-o", "out", *WORDS, *words) == 0
    maps = ("Color", "Displacement")
    assert set(contents(here / "out")) == {f"7-wall/7-wall_{name}.png" for name in maps}


def test_one_bad_sample_does_not_stop_the_others(here, samples, capsys):
    (samples / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n and then nothing")
    assert weft_run("batch", "samples", "-o", "out", *WORDS) == 2
    err = capsys.readouterr().err
    assert "1 of 4 jobs failed" in err and "broken.png" in err
    assert err.endswith("; ignored, neither an image nor a map set: empty, readme.txt\n")
    assert len(records(here / "out")) == 3


@pytest.mark.parametrize(
    "words, message",
    [
        (["--count", "0"], "--count is 0"),
        (["--keep-best", "2"], "--keep-best is 2; it must be from 1 to --count, 1"),
        (["--template", "{other}"], "it may have {name} and {seed}"),
        (["--template", "{name.__class__}"], "it may have {name} and {seed}"),
        (["--template", "../{name}"], "is not a file name"),
        (["--template", ".weftex-{name}"], "is not a file name"),
        (["--template", "{name}" + 252 * "z"], "a name of "),
        (["--count", "2", "--template", "{name}"], "two outputs would be named"),
        (["--skip-existing", "--force"], "not both"),
    ],
)
def test_bad_words(here, samples, capsys, words, message):
    assert message in fails(capsys, here, "batch", "samples", "-o", "out", *words)


def test_folders_that_hold_nothing(here, samples, capsys):
    assert "has no images" in fails(capsys, here, "batch", "samples/empty", "-o", "out")
    assert "cannot read the folder" in fails(capsys, here, "batch", "nowhere", "-o", "out")
    write_image(samples / "wall.png", noise((40, 40, 3)))
    assert "would both make wall" in fails(capsys, here, "batch", "samples", "-o", "out")


def test_samples_and_folders_of_others_are_not_replaced(here, samples, capsys):
    words = [*WORDS, "--force"]
    assert "is an input" in fails(capsys, here, "batch", "samples", "-o", "samples", *words)
    (here / "out" / "wall").mkdir(parents=True)
    (here / "out" / "wall" / "mine.txt").write_text("mine")
    assert "batch did not make" in fails(capsys, here, "batch", "samples", "-o", "out", *words)
    assert weft_run("batch", "samples", "-o", "samples/out", *WORDS) == 0
    assert weft_run("batch", "samples", "-o", "samples/out", *words) == 0
    assert len(records(samples / "out")) == 3


def test_a_cut_off_manifest_is_read(here, samples):
    weft_run("batch", "samples", "-o", "out", *WORDS, "--count", "2")
    before, whole = contents(here / "out"), records(here / "out")
    text = (here / "out" / "manifest.jsonl").read_text()
    (here / "out" / "manifest.jsonl").write_text(text[:-20])
    lost = text.splitlines()[-1]
    remove(str(here / "out" / json.loads(lost)["output"]))
    assert weft_run("batch", "samples", "-o", "out", *WORDS, "--count", "2", "--skip-existing") == 0
    assert contents(here / "out") == before and set(records(here / "out")) == set(whole)


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_killed_at_random_moments_it_goes_on(here, samples):
    """Four times; what is there at the end is what one run makes, and no other file."""
    words = [*WORDS[:4], "--size", "150", "--seed", "1", "--count", "15"]
    assert weft_run("batch", "samples", "-o", "whole", *words, "--threads", 1) == 0
    words += ["--skip-existing", "--threads", "2"]
    command = [sys.executable, "-m", "weftex", "batch", "samples", "-o", "out", *words]
    chance, killed = random.Random(1), 0
    for _ in range(4):
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        while not (here / "out" / "manifest.jsonl").exists() and process.poll() is None:
            time.sleep(0.01)
        time.sleep(chance.uniform(0, 0.5))
        process.send_signal(signal.SIGKILL)
        killed += process.wait() == -signal.SIGKILL
    assert killed > 0
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    assert contents(here / "out") == contents(here / "whole")
    assert set(records(here / "out")) == set(records(here / "whole"))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc")
@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -signal.SIGKILL)],
)
def test_whatever_ends_it_leaves_no_process(here, samples, number, code):
    """Nor anything unfinished, unless it was killed; then the next run removes it."""
    words = ["batch", "samples", "-o", "out", "--method", "wei-levoy", "--size", 300]
    run = weftex_process(*words, "--threads", 2, preexec_fn=hear_interrupts)
    deadline = time.monotonic() + 30
    while len(started := children_of(run.pid)) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.3)
    run.send_signal(number)
    err = run.communicate(timeout=30)[1]
    assert len(started) == 2 and run.returncode == code, err
    assert have_ended(started)
    if number != signal.SIGKILL:
        assert err == "weftex: stopped; --skip-existing continues in out\n"
        assert not list((here / "out").glob(".weftex-*"))


@pytest.mark.skipif(os.name == "nt", reason="needs SIGKILL")
def test_a_job_whose_process_is_killed_fails_alone():
    with Workers(Mortal) as workers:
        assert workers.do(20) == 40
        refused("its process was killed", workers.do, 0, error=WeftexError)
        refused("division by zero", workers.do, "1/0", error=ZeroDivisionError)
        assert workers.do(21) == 42
    refused("was ended", workers.do, 1, error=WeftexError)


class Mortal:
    """Work that may kill its process."""

    def __call__(self, number):
        if number == "1/0":
            return 1 / 0
        if number == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return 2 * number


@pytest.mark.skipif(os.name == "nt", reason="no locks of folders there")
def test_one_batch_at_a_time_has_a_folder(here, samples, capsys):
    (here / "out").mkdir()
    held = Manifest("out")
    asked = "batch", "samples", "-o", "out", *WORDS
    assert "another batch is running" in fails(capsys, here, *asked)
    held.sweep()
    assert weft_run(*asked) == 0
