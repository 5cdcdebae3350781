"""Pictures through pipes: ``-`` is standard input, or output; and sizes, what -v says."""

import subprocess
import sys

import numpy as np
import pytest

from commands import listing, weft_run
from families import noise
from processes import ENVIRONMENT
from weftex.io.pictures import write_image

QUICK = ("--seed", 1, "--size", 48, "--method", "quilting", "--quiet")


def piped(*words, given=b""):
    """Run a command with pipes at both ends."""
    command = [sys.executable, "-m", "weftex", *map(str, words)]
    return subprocess.run(command, input=given, capture_output=True, env=ENVIRONMENT, check=False)


def test_both_ends_have_the_bytes_that_files_have(here):
    assert weft_run("synth", "sample.png", "-o", "a.png", *QUICK) == 0
    done = piped("synth", "-", "-o", "-", *QUICK, given=(here / "sample.png").read_bytes())
    assert done.returncode == 0 and done.stderr == b""
    assert done.stdout == (here / "a.png").read_bytes()


def test_another_format_and_what_is_printed(here, temporary_folder):
    """What a command prints goes to standard error while a picture goes out."""
    write_image("f.exr", noise((40, 40, 3)).astype(np.float32))
    before = listing(here), listing(temporary_folder)
    done = piped("analyze", "-", "--overlay", "-", given=(here / "sample.png").read_bytes())
    assert done.stdout.startswith(b"\x89PNG") and b"standard input" in done.stderr
    done = piped("synth", "-", "-o", "-.exr", *QUICK, given=(here / "f.exr").read_bytes())
    assert done.stdout.startswith(b"v/1\x01"), done.stderr
    assert before == (listing(here), listing(temporary_folder))


@pytest.mark.parametrize(
    ("words", "given", "message"),
    [
        (("synth", "-", "-o", "x.png"), b"no picture", "standard input has no image"),
        (("synth", "-", "-o", "x.png"), b"", "standard input is empty"),
        (("synth", "-", "-o", "x.png"), b"\x89PNG\r\n\x1a\n", "standard input: the file is"),
        (("synth", "-", "-", "-o", "x.png"), b"\x89PNG\r\n\x1a\n" * 9, "be read only once"),
        (("synth", "sample.png", "-o", "-", "--save-source", "-"), b"", "only one file can be"),
        (("synth", "sample:stone_wall", "-o", "-"), b"", "the output has several files"),
    ],
)
def test_what_pipes_refuse(here, capfd, monkeypatch, words, given, message):
    (here / "given").write_bytes(given)
    before = listing(here)
    with open("given", "rb") as file:
        monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": file}))
        assert weft_run(*words) == 2
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 1 and message in err
    assert listing(here) == before


def test_no_terminals(here, capsys, monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    assert weft_run("synth", "sample.png", "-o", "-") == 2
    assert "standard output, which is a terminal here" in capsys.readouterr().err


def test_verbose_says_stages_and_parameters(here, capsys):
    words = ("sample.png", "-o", "x.png", "--method", "quilting", "--size", 300, "--seed", 1, "-v")
    assert weft_run("synth", *words) == 0
    err = capsys.readouterr().err
    assert "stage: patches" in err and "used: tolerance 0.1" in err and "64 x" not in err
    assert weft_run("synth", *words, "--quiet") == 2
