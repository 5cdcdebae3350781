"""The progress bar: each stage counts from its own start to its own end."""

from __future__ import annotations

import pytest

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
