"""Registers the extension once; Blender as a module sometimes does not end by itself."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, os.environ.get("WEFTEX_EXTENSION", str(Path(__file__).resolve().parents[1])))


@pytest.fixture(scope="session", autouse=True)
def _registered():
    import weftex_blender

    weftex_blender.register()
    yield
    weftex_blender.unregister()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session, exitstatus):
    """Leave with the status of the tests, without Blender's own end."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    reporter.summary_failures()
    reporter.summary_errors()
    reporter.summary_stats()
    sys.stdout.flush()
    os._exit(int(exitstatus))
