"""`weftex synth` block by block, killed and in parts; `check` of the image."""

import random
import signal
import sys
import time

import pytest

from commands import fails, listing, weft_run
from processes import hear_interrupts, weftex_process
from weftex.io.pictures import read_image

HOW = ["--method", "best-tile", "--lattice", "20,0,0,20", "--seed", 4, "--block", 64]
SYNTH = ["synth", "sample.png", *HOW, "--quiet", "-o"]


def files(folder, name="p"):
    """What a plane consists of."""
    return {
        path.relative_to(folder).as_posix().removeprefix(name): data
        for path, data in listing(folder).items()
        if path.name == f"{name}.tif"
    }


@pytest.mark.skipif(sys.platform == "win32", reason="signals are other there")
def test_killed_at_any_moment(here):
    """A second run is refused meanwhile; the bytes are those of one run."""
    assert weft_run(*SYNTH, "whole.tif", "--size", 700) == 0
    words = [*SYNTH, "p.tif", "--size", 700, "--threads", 1]
    kills, moments = 0, random.Random(4)
    for number in (signal.SIGKILL, signal.SIGTERM):
        run = weftex_process(*words, preexec_fn=hear_interrupts)
        journal = here / "p.tif.run" / "done.txt"
        before = journal.stat().st_size if journal.exists() else 0
        while not journal.exists() or journal.stat().st_size <= before:
            time.sleep(0.005)
        assert weft_run(*words) == 2  # another process makes it
        time.sleep(moments.uniform(0, 0.15))
        run.send_signal(number)
        err = run.communicate(timeout=60)[1]
        kills += run.returncode != 0
        if number == signal.SIGTERM and run.returncode:
            assert run.returncode == 143
            assert err.endswith("finished blocks are kept; repeat the command to continue\n")
    assert kills
    assert weft_run(*words) == 0
    assert files(here) == files(here, "whole")


def test_parts_and_check(here, capsys):
    """Two parts that start at the same moment."""
    target = "p.tif"
    words = [*SYNTH, target, "--size", 600]
    parts = [weftex_process(*words, "--part", part) for part in ("1/2", "2/2")]
    assert [(part.communicate(timeout=60)[1], part.returncode) for part in parts] == [("", 0)] * 2
    fails(capsys, here, "check", target)
    assert weft_run(*SYNTH, target, "--size", 600) == 0
    assert weft_run("check", target, "--read") == 0
    said = "p.tif is complete, all checksums match: 600x600 with best-tile, seed 4\n"
    assert capsys.readouterr().out == said
    whole = files(here)
    with open(target, "r+b") as file:
        file.seek(2**16)
        file.write(b"other")
    err = fails(capsys, here, "check", target, "--read")
    assert "1 blocks differ from their checksums" in err
    assert weft_run("check", target, "--repair") == 0
    assert "seed 4; 2 blocks were made again\n" in capsys.readouterr().out
    assert files(here) == whole
    (here / target).unlink()
    assert "missing or damaged; --repair makes it again" in fails(capsys, here, "check", target)


def test_small_tiffs_are_as_ever(here):
    weft_run("synth", "sample.png", "-o", "a.tif", "--size", 100, *HOW[:-2])
    weft_run("synth", "sample.png", "-o", "b.png", "--size", 100, *HOW[:-2])
    assert (read_image("a.tif").pixels == read_image("b.png").pixels).all()
    assert not (here / "a.tif.run").exists()


def test_large_tiffs_are_planes(here, capsys):
    words = ["synth", "sample.png", *HOW[:-2], "-o", "a.tif", "--size"]
    assert "may take 4.19 TB more" in fails(capsys, here, *words, "1000kx1000k", "--quiet")
    err = fails(capsys, here, *words[:-2], "a.png", "--size", "100000")
    assert "OUT.tif may have 1,048,576 pixels a side" in err


def test_bad_input_of_others(here, capsys):
    weft_run(*SYNTH, "p.tif", "--size", 200)
    for words, why in [
        (["tile", "p.tif", "-o", "t.png"], "only 'weftex check' reads it"),
        (["synth", "p.tif", "-o", "t.png"], "only 'weftex check' reads it"),
        (["check", "sample.png"], "there is no plane in sample.png.run beside it"),
        (["report", "sample.png", "p.tif", "--json"], "only 'weftex check' reads it"),
        ([*SYNTH, "q.tif", "--size", 200, "--save-source", "q.npz"], "needs the whole image"),
        (["synth", "sample.png", *HOW[:-4], "--part", "1/2", "-o", "q.tif"], "--part needs --seed"),
    ]:
        assert why in fails(capsys, here, *words)


def test_a_seed_that_is_not_given_is_that_of_the_run(here):
    words = ["synth", "sample.png", *HOW[:4], "--block", 64, "--quiet", "-o", "p.tif"]
    words += ["--size", 200]
    assert weft_run(*words) == weft_run(*words) == 0
    assert weft_run(*words, "--seed", 4) == 2
