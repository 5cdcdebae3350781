"""What a command leaves when a signal comes: nothing, or all files that appear just then."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from commands import listing
from families import noise
from processes import hear_interrupts, wait_until_it_listens, weftex_process
from weftex.cli import terminal
from weftex.io.pictures import write_image

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are other there")


@pytest.fixture(autouse=True)
def heard():
    before = {number: signal.getsignal(number) for number in terminal._SIGNALS}
    terminal.hear_signals()
    yield
    terminal._heard.clear()
    for number, handler in before.items():
        signal.signal(number, handler)


def signal_main_thread(number):
    signal.pthread_kill(threading.main_thread().ident, number)


@pytest.mark.parametrize("seconds", [0, 2 * terminal._PATIENCE])
@pytest.mark.parametrize("number", terminal._SIGNALS)
def test_files_that_appear_are_not_cut_off(tmp_path, monkeypatch, number, seconds):
    """However long the disk takes, either all of them are there or the exit code says otherwise."""
    sync = os.fsync

    def slow(file):
        signal_main_thread(number)
        time.sleep(seconds)
        sync(file)

    monkeypatch.setattr(os, "fsync", slow)
    monkeypatch.setattr(os, "_exit", lambda code: pytest.fail("cut off"))

    def work(bar, outputs):
        for name in ("a.png", "b.png"):
            outputs.staged_path(tmp_path / name)
        return "made"

    assert terminal.run(work, quiet=True)[0] == "made"
    assert sorted(os.listdir(tmp_path)) == ["a.png", "b.png"]


def test_work_that_fails_after_a_signal_was_stopped(tmp_path):
    def work(bar, outputs):
        outputs.staged_path(tmp_path / "a.png")
        signal_main_thread(signal.SIGTERM)
        while not bar.stopped:
            time.sleep(0.01)
        raise ValueError

    with pytest.raises(terminal.Stopped) as info:
        terminal.run(work, quiet=True)
    assert info.value.code == 143 and not os.listdir(tmp_path)


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (0, 129)])
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
