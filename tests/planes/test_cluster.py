"""Planes by a scheduler and workers that are processes of their own."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

import weftex
from commands import weft_run
from families import noise
from processes import ENVIRONMENT, weftex_process
from weftex.errors import FileError, InvalidInputError
from weftex.io.pictures import write_image
from weftex.planes import runners
from weftex.planes.dask_array import plane

pytest.importorskip("distributed")
TILE = weftex.BestTile(lattice=(20, 0, 0, 20))
HOW = ["--method", "best-tile", "--lattice", "20,0,0,20", "--seed", 4, "--block", 64, "--quiet"]


@contextlib.contextmanager
def dask_process(*words):
    command = [sys.executable, "-m", "dask", *map(str, words)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, env=ENVIRONMENT, **quiet)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def blocks_of(folder):
    return sum(path.read_bytes().count(b"\n") for path in folder.glob("*.txt"))


def test_workers_that_die_and_join_change_no_byte(tmp_path, monkeypatch):
    """A worker is killed in the middle, and another joins."""
    monkeypatch.chdir(tmp_path)
    write_image("sample.png", noise((64, 72, 3)))
    words = ["synth", "sample.png", *HOW, "--size", "1400x900", "-o"]
    assert weft_run(*words, "whole.tif") == 0
    address = f"tcp://127.0.0.1:{free_port()}"
    worker = ["worker", address, "--nthreads", 1, "--no-nanny", "--no-dashboard"]
    with contextlib.ExitStack() as stack:
        port = address.rpartition(":")[2]
        stack.enter_context(dask_process("scheduler", "--port", port, "--no-dashboard"))
        first = stack.enter_context(dask_process(*worker))
        run = weftex_process(*words, "p.tif", "--cluster", address)
        while blocks_of(tmp_path / "p.tif.run") < 20:
            assert run.poll() is None, run.communicate()
            time.sleep(0.01)
        first.kill()
        stack.enter_context(dask_process(*worker))
        assert run.communicate(timeout=60)[1] == "" and run.returncode == 0
    assert (tmp_path / "p.tif").read_bytes() == (tmp_path / "whole.tif").read_bytes()


def test_no_scheduler(monkeypatch):
    monkeypatch.setattr(runners, "_PATIENCE", "0.2s")
    for address, why in [
        ("tcp://127.0.0.1:1", "no scheduler answers"),
        ("nonsense://x", "nonsense"),
    ]:
        with pytest.raises(FileError, match=why), runners.connected(address):
            pass


def test_another_version(monkeypatch):
    monkeypatch.setattr("distributed.get_worker", lambda: SimpleNamespace(address="a"))
    with pytest.raises(InvalidInputError, match=r"worker a has weftex .*, this process 0\.0\.1"):
        runners.make_block(b"", "", (0, 0, 0), "0.0.1")


def test_a_missing_library(monkeypatch):
    for name in ("distributed", "dask.array"):
        monkeypatch.setitem(sys.modules, name, None)
    with (
        pytest.raises(InvalidInputError, match=r"pip install 'weftex\[dask\]'"),
        runners.connected("tcp://127.0.0.1:1"),
    ):
        pass
    with pytest.raises(InvalidInputError, match=r"pip install 'weftex\[dask\]'"):
        plane("sample:bricks", 100, method=TILE)


def test_a_lazy_plane():
    sample = weftex.Exemplar(
        noise((60, 64, 3)), maps={"height": noise((120, 128), dtype=np.uint16)}
    )
    large = plane(sample, (10**6, 10**5), method=TILE, seed=4, block=64)
    assert large.shape == (10**6, 10**5, 3) and large.chunksize == (64, 64, 3)
    with pytest.raises(InvalidInputError, match="make the block larger"):
        plane(sample, (2**40, 10), method=TILE, seed=4, block=64)
    found = plane(sample, (200, 300), method=TILE, seed=4, block=64)
    model = TILE.fit(sample)
    made = model.window(0, 0, 200, 300, seed=4)
    assert (found[50:150, 120:].compute() == made.image[50:150, 120:]).all()
    height = plane(sample, (200, 300), method=TILE, seed=4, block=64, show="height")
    assert height.dtype == np.uint16 and (height.compute() == made.maps["height"]).all()
    assert found.name != plane(sample, (200, 300), method=TILE, seed=5, block=64).name
    with pytest.raises(InvalidInputError, match="did you mean 'height'"):
        plane(sample, 100, method=TILE, show="heigth")
