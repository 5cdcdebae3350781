"""The progress bar: each stage counts from its own start to its own end."""

import io
import json
import time

import numpy as np
import pytest

import weftex
from commands import weft_run
from weftex import progress
from weftex.cli import terminal

tqdm = pytest.importorskip("tqdm")


def test_a_slow_stage_after_a_fast_one_is_shown(monkeypatch):
    """Its steps are few, and each is to be seen; the work is done beside the bar."""
    screen = io.StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: True)
    monkeypatch.setattr(terminal.sys, "stderr", screen)
    monkeypatch.setattr(progress.Bar.__init__, "__defaults__", (-1.0,))
    monkeypatch.setattr(progress, "_REST", 0)

    def work(bar, outputs):
        for done, total, stage in ((0, 9**6, "pixels"), (9**6, 9**6, "pixels"), (7, 40, "repairs")):
            bar(done, total, stage, lambda: None)
            time.sleep(0.5)  # more than two drawings

    bar = terminal.run(work, quiet=False)[1]
    assert "pixels" in screen.getvalue() and "7/40" in screen.getvalue()
    assert [*bar.seconds] == ["preparing", "pixels", "repairs"] and bar.seconds["repairs"] > 0.1


@pytest.mark.parametrize("total", [0, 5])
def test_work_that_has_not_counted_yet_is_shown(monkeypatch, total):
    """Such as the first analysis, or the first of few steps; its time goes on."""
    screen, clock = io.StringIO(), [100.0]
    monkeypatch.setattr(terminal.sys, "stderr", screen)
    monkeypatch.setattr(progress, "perf_counter", lambda: clock[0])
    bar = progress.Bar()
    if total:
        bar(0, total, "rows", lambda: None)
    for _ in range(4):
        assert bar._is_time(clock[0]) == (clock[0] >= 100.5), clock[0]
        clock[0] += 0.3
    bar.draw()
    assert ("rows" if total else "preparing") in screen.getvalue()
    bar(1, 5, "rows", lambda: None)
    bar.draw()
    bar.close()
    assert "1/5" in screen.getvalue()


def test_a_program_gets_objects(here, capfd):
    words = ("synth", "sample.png", "-o", "a.png", "--size", 300, "--method", "efros-leung")
    assert weft_run("--for-program", *words) == 0
    assert weft_run("--for-program", "synth", "-", "-o", "a.png") == 2
    *steps, made, failed = map(json.loads, capfd.readouterr().err.splitlines())
    assert len(steps) > 1 and all([*one] == ["done", "of", "stage"] for one in steps)
    assert "made 300x300 a.png" in made["message"] and "takes files" in failed["error"]


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
