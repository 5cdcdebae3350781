"""Tests that start processes of their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import weftex

SRC = str(Path(weftex.__file__).parents[1])
#: The package that is tested, for a process started from any folder.
ENVIRONMENT = os.environ | {"PYTHONPATH": SRC}


def hear_interrupts():
    """In a child: Ctrl-C counts, though runners in the background start with it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def wait_until_it_listens(process):
    """Until a command catches SIGTERM, however busy the machine is; seen on Linux only."""
    status, caught = Path(f"/proc/{process.pid}/status"), 0
    while status.exists() and process.poll() is None and not caught >> signal.SIGTERM - 1 & 1:
        time.sleep(0.05)
        caught = int(status.read_text().split("SigCgt:")[1].split()[0], 16)


def run(code, *args, **options):
    """Run Python code with weftex importable, in a process of its own."""
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, args)]
    options = {"env": ENVIRONMENT, "timeout": 60} | options
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def weftex_process(*words, **options):
    """Start a command of weftex."""
    command = [sys.executable, "-m", "weftex", *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, **options)
