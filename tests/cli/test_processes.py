"""Commands in processes of their own, and signals."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

from commands import listing
from families import noise
from processes import hear_interrupts, wait_until_it_listens, weftex_process
from weftex.io.pictures import write_image


@pytest.mark.skipif(sys.platform == "win32", reason="signals are other there")
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (0, 129)]
)
@pytest.mark.parametrize("kind", ["one", "folder"])
def test_stopping_leaves_nothing(here, number, code, kind):
    """By a signal, or, without one, by the program that closes the other end of standard input."""
    write_image("large.png", noise((700, 700, 3)))
    (here / "maps").mkdir()
    write_image("maps/albedo.png", noise((700, 700, 3)))
    before = listing(here)
    sample, output = ("large.png", "x.png") if kind == "one" else ("maps", "new")
    words = ["--method", "patch-sampling", "--search", "exhaustive", "--patch-size", 64]
    words += ["-o", output, "--size", 6000, "--repeat-distance", 0]
    words = ["synth", sample, *words] if number else ["--for-program", "synth", sample, *words]
    run = weftex_process(*words, stdin=subprocess.PIPE, preexec_fn=hear_interrupts)
    wait_until_it_listens(run)
    time.sleep(1)
    assert run.poll() is None, run.communicate()
    run.send_signal(number)  # 0 is none
    try:
        err = run.communicate(timeout=60)[1]  # closes standard input
    finally:
        run.kill()
    assert run.returncode == code
    said = ["weftex: stopped; nothing was written", '{"stopped": "nothing was written"}']
    assert err.splitlines()[-1] == said[number == 0] and (number == 0 or err.count("\n") == 1)
    assert listing(here) == before
