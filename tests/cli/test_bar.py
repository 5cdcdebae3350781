"""The progress bar: each stage counts from its own start to its own end."""

from __future__ import annotations

import io
import sys
import time

import numpy as np
import pytest

import weftex
from weftex import progress
from weftex.cli import terminal

tqdm = pytest.importorskip("tqdm")


@pytest.fixture
def shown(monkeypatch):
    """What a bar on a terminal shows after each call."""
    monkeypatch.setattr(terminal.sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(terminal, "_BAR_AFTER", -1)
    bar, states = terminal.Bar(quiet=False), []

    def call(done, total, stage):
        assert bar(done, total, stage, lambda: None)
        bar.draw()
        states.append((bar._bar.n, bar._bar.total, bar._bar.unit.strip()))
        return states[-1]

    yield call
    bar.close()


def test_stages_begin_anew(shown):
    assert shown(5, 10, "patches") == (5, 10, "patches")
    assert shown(10, 10, "patches") == (10, 10, "patches")
    assert shown(1, 40, "refinements") == (1, 40, "refinements")
    assert shown(40, 40, "refinements") == (40, 40, "refinements")
    assert shown(2, 40, "refinements") == (2, 40, "refinements")  # the same again
    assert shown(3, 8, "refinements") == (3, 8, "refinements")


def test_a_slow_stage_after_a_fast_one_is_shown(monkeypatch):
    """Its steps are few, and each is to be seen."""
    screen = io.StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: True)
    monkeypatch.setattr(terminal.sys, "stderr", screen)
    monkeypatch.setattr(terminal, "_BAR_AFTER", -1)
    bar = terminal.Bar(quiet=False)
    for done, total, stage in ((0, 9**6, "pixels"), (9**6, 9**6, "pixels"), (1, 40, "repairs")):
        bar(done, total, stage, lambda: None)
        bar.draw()
        time.sleep(0.15)  # tqdm shows ten steps a second
    bar(7, 40, "repairs", lambda: None)
    bar.draw()
    bar.close()
    assert "7/40" in screen.getvalue()
    assert [*bar.seconds] == ["preparing", "pixels", "repairs"] and bar.seconds["repairs"] > 0.1


def test_true_is_a_bar(capsys, monkeypatch):
    """Of its own for each stage; it goes when the stage ends."""
    monkeypatch.setattr(progress.Bar.__init__, "__defaults__", (0.0,))
    steps = progress.Progress(True, 3, "rows", lambda: None)
    steps.advance(1)
    assert "1/3" in capsys.readouterr().err
    steps.advance(2)
    assert steps.callback._bar is None
    sample = np.random.default_rng(0).integers(0, 255, (32, 32), np.uint8)
    weftex.synthesize(sample, 48, method="quilting", seed=1, progress=True)
    assert "patches" in capsys.readouterr().err


def test_a_bar_for_long_work_only(capsys, monkeypatch):
    """Loading tqdm takes as long as a hundredth of what is done without a bar."""
    monkeypatch.delitem(sys.modules, "tqdm")
    bar = progress.Bar(after=0)
    bar(1, 100, "rows", lambda: None)
    bar._start = bar._begun = bar._begun - 1
    bar._next = bar._start
    bar(50, 100, "rows", lambda: None)  # a second to go
    assert bar._bar is None and "tqdm" not in sys.modules
    bar._next = bar._start
    bar(10, 100, "rows", lambda: None)  # nine
    assert "10/100" in capsys.readouterr().err
    bar.close()
