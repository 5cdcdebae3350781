"""What a command leaves when a signal comes while its files appear: all of them or none."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time

import pytest

from weftex.cli import terminal

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
            outputs.reserve(tmp_path / name)
        return "made"

    assert terminal.run(work, quiet=True)[0] == "made"
    assert sorted(os.listdir(tmp_path)) == ["a.png", "b.png"]


def test_work_that_fails_after_a_signal_was_stopped(tmp_path):
    def work(bar, outputs):
        outputs.reserve(tmp_path / "a.png")
        signal_main_thread(signal.SIGTERM)
        while not bar.stopped:
            time.sleep(0.01)
        raise ValueError

    with pytest.raises(terminal.Stopped) as info:
        terminal.run(work, quiet=True)
    assert info.value.code == 143 and not os.listdir(tmp_path)
