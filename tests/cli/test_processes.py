"""Commands in processes of their own: full disks, signals and terminals."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from commands import listing
from families import noise
from processes import ENVIRONMENT, hear_interrupts, wait_until_it_listens, weftex_process
from weftex.io.pictures import write_image


@pytest.mark.skipif(sys.platform == "win32", reason="no limits there")
@pytest.mark.parametrize("output", ["old.png", "x.png", "x.tif", "x.jpg", "x.webp"])
def test_a_full_disk(here, output):
    import resource

    (here / "old.png").write_bytes((here / "sample.png").read_bytes())
    before = listing(here)

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))

    words = ["--size", 300, "--method", "quilting"]
    run = weftex_process("synth", "sample.png", "-o", output, *words, preexec_fn=limit)
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
    run = weftex_process(
        "synth", sample, "-o", output, "--size", 6000, *words, preexec_fn=hear_interrupts
    )
    wait_until_it_listens(run)
    time.sleep(1)
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
    loaded = "import tqdm; from weftex.cli import entry; entry()"  # so that short work has a bar
    command = [sys.executable, "-c", loaded, "synth", "large.png", "-o", "x.png", *words]
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
