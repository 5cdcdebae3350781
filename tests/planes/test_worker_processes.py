"""Planes by several processes of one machine: `--workers N`."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from commands import weft_run
from families import noise
from processes import children_of, have_ended, hear_interrupts, weftex_process
from weftex.io.pictures import write_image

HOW = ["--method", "best-tile", "--lattice", "20,0,0,20", "--seed", 4, "--block", 64, "--quiet"]
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


@pytest.fixture(autouse=True)
def words(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_image("sample.png", noise((64, 72, 3)))
    how = ["synth", "sample.png", *HOW, "--size", "2400x1600", "-o"]
    assert weft_run(*how, "whole.tif") == 0
    return how


def listening_sockets(pid):
    """Sockets of a process that others can connect to."""
    open_ones = set()
    for table in ("tcp", "tcp6", "unix"):
        lines = Path(f"/proc/net/{table}").read_text().splitlines()[1:]
        rows = [line.split() for line in lines]
        if table == "unix":
            open_ones |= {row[6] for row in rows if int(row[3], 16) & 0x10000}
        else:
            open_ones |= {row[9] for row in rows if row[3] == "0A"}
    links = []
    for name in Path(f"/proc/{pid}/fd").iterdir():
        try:
            links.append(os.readlink(name))
        except OSError:
            continue
    return [link for link in links if link.startswith("socket:[") and link[8:-1] in open_ones]


def started(target, words, blocks=4):
    """A run by two processes, and their ids, once some blocks are done."""
    run = weftex_process(*words, target, "--workers", 2, preexec_fn=hear_interrupts)
    journals = Path(f"{target}.run")
    deadline = time.monotonic() + 60
    while sum(path.read_bytes().count(b"\n") for path in journals.glob("*.txt")) < blocks:
        assert run.poll() is None and time.monotonic() < deadline, run.communicate()
        time.sleep(0.01)
    return run, children_of(run.pid)


def test_workers_listen_to_nobody_and_make_the_same_bytes(words):
    run, workers = started("p.tif", words)
    assert not [link for pid in (run.pid, *workers) for link in listening_sockets(pid)]
    assert len(workers) == 2
    assert run.communicate(timeout=60)[1] == "" and run.returncode == 0
    assert Path("p.tif").read_bytes() == Path("whole.tif").read_bytes()
    assert weft_run("check", "p.tif", "--read") == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_their_run_and_the_same_command_continues(words, number):
    run, workers = started("p.tif", words)
    run.send_signal(number)
    err = run.communicate(timeout=60)[1]
    assert run.returncode == (-9 if number == signal.SIGKILL else 128 + number)
    assert err.count("\n") == (number != signal.SIGKILL)
    assert have_ended(workers)
    assert weft_run(*words, "p.tif", "--workers", 2) == 0
    assert Path("p.tif").read_bytes() == Path("whole.tif").read_bytes()


def test_a_worker_that_is_killed_is_one_line(words):
    run, workers = started("p.tif", words)
    os.kill(workers[0], signal.SIGKILL)
    err = run.communicate(timeout=60)[1]
    assert run.returncode == 2 and err.count("\n") == 1, err
    assert "a worker process was killed" in err and "repeat the command to continue" in err
    assert have_ended(workers)
    assert weft_run(*words, "p.tif") == 0
    assert Path("p.tif").read_bytes() == Path("whole.tif").read_bytes()
