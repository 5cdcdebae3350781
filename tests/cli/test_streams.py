"""Standard streams that are closed, full or endless, and signals while they are read."""

import os
import signal
import subprocess
import sys
import time

import pytest

from commands import listing, weft_run
from processes import ENVIRONMENT, hear_interrupts, wait_until_it_listens, weftex_process
from weftex.io import streams

QUICK = "--seed 1 --size 48 --method quilting"
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="shells and signals differ there")


def shell(line, **options):
    """Run `weftex` in a shell; exit code, standard output and standard error."""
    line = line.replace("weftex", f"{sys.executable} -m weftex", 1)
    done = subprocess.run(
        ["sh", "-c", line], capture_output=True, env=ENVIRONMENT, check=False, **options
    )
    return done.returncode, done.stdout, done.stderr.decode()


@pytest.mark.parametrize(
    "closed", ["2>&-", ">&-", "<&-", "2>/dev/full", ">&- 2>&- <&-", "--quiet 2>&-"]
)
def test_streams_that_are_not_needed(here, closed):
    assert shell(f"weftex synth sample.png -o a.png {QUICK} {closed}")[0] == 0
    assert weft_run("synth", "sample.png", "-o", "b.png", *QUICK.split()) == 0
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("sample.png -o - >&-", "standard output: cannot write: Bad file"),
        ("sample.png -o - >/dev/full", "standard output: cannot write: No space"),
        ("- -o a.png <&-", "standard input: cannot read: Bad file"),
    ],
)
def test_streams_that_are_needed(here, temporary_folder, line, message):
    before = listing(here), listing(temporary_folder)
    code, _, err = shell(f"weftex synth {QUICK} {line}")
    assert code == 2 and err.count("\n") == 1 and message in err
    assert before == (listing(here), listing(temporary_folder))


def test_what_is_printed_and_cannot_be_written():
    assert shell("weftex --version >/dev/full")[0] == 2
    assert shell("weftex methods >&-")[2].count("\n") == 1


def test_standard_input_has_a_limit(here, temporary_folder, capsys, monkeypatch):
    """Of files that are no larger than pictures may be; --allow-huge lifts it."""
    monkeypatch.setattr(streams, "_MOST_BYTES", 1000)
    before = listing(here), listing(temporary_folder)
    for words, code in (((), 2), (("--allow-huge",), 0)):
        with open("sample.png", "rb") as file:
            monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": file}))
            assert weft_run("synth", "-", "-o", "x.png", *QUICK.split(), *words) == code
        if code:
            err = capsys.readouterr().err
            assert err.count("\n") == 1 and "standard input is over" in err
            assert before == (listing(here), listing(temporary_folder))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_standard_input_is_read(here, temporary_folder, number):
    before = listing(here), listing(temporary_folder)
    words = ("synth", "-", "-o", "a.png")
    run = weftex_process(*words, stdin=subprocess.PIPE, preexec_fn=hear_interrupts)
    wait_until_it_listens(run)
    os.write(run.stdin.fileno(), (here / "sample.png").read_bytes()[:500])
    while not [*temporary_folder.glob(".weftex-*")]:  # Python tries the folder with a file before
        time.sleep(0.01)
    run.send_signal(number)
    assert run.communicate(timeout=30)[1] == "weftex: stopped; nothing was written\n"
    assert run.returncode == 128 + number
    assert before == (listing(here), listing(temporary_folder))


def test_a_signal_that_the_parent_ignores(here):
    """As `nohup` does: the picture is made when the terminal is closed."""

    def ignore():
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    run = weftex_process("synth", "sample.png", "-o", "a.png", *QUICK.split(), preexec_fn=ignore)
    wait_until_it_listens(run)
    run.send_signal(signal.SIGHUP)
    assert "made 48x48 a.png" in run.communicate()[1] and run.returncode == 0
