"""A studio for each file of tests, and tabs of it."""

import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pytest

pytest.importorskip("starlette")
sys.path.insert(0, str(Path(__file__).parent))

from pages import Client

import weftex
from weftex.method import Model
from weftex.methods.quilting import Quilting
from weftex.progress import Progress
from weftex.studio.limits import Limits
from weftex.studio.server import listen, server_of
from weftex.studio.studio import Studio

SMALL = Limits(
    upload_bytes=2**20, upload_pixels=2**18, stored_bytes=2**22, uploads=8, output_pixels=2**20,
    memory_bytes=2**27, jobs=6, session_jobs=5, sessions=500, body_bytes=2**14,
)  # fmt: skip


@contextmanager
def serving(folder, **limits):
    """Whoever asks a studio that answers on the loopback, in a thread."""
    studio = Studio(folder / "studio", replace(SMALL, **limits))
    listener = listen(0)
    server = server_of(listener, studio)
    thread = threading.Thread(target=server.run, args=([listener],))
    thread.start()
    yield Client(listener.getsockname()[1], studio)
    server.should_exit = True
    thread.join(60)
    assert not thread.is_alive()


@dataclass(frozen=True)
class Sleepy(Quilting):
    """A method that takes 20 seconds and no processor."""

    slug: ClassVar[str] = "sleepy"

    def fit_exemplar(self, exemplar):
        return SleepyModel(self, exemplar)


class SleepyModel(Model):
    def __init__(self, method, exemplar):
        self.method, self.exemplar = method, exemplar

    def make(self, canvas, seed, threads, progress):
        steps = Progress(progress, 1000, "steps", lambda: self.exemplar.pixels)
        for _ in range(1000):
            time.sleep(0.02)
            steps.advance(1)
        raise AssertionError


@pytest.fixture(scope="module", autouse=True)
def sleepy():
    weftex.METHODS._outside["sleepy"] = SimpleNamespace(load=lambda: Sleepy)  # as entry points
    yield
    del weftex.METHODS._outside["sleepy"]


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with serving(tmp_path_factory.mktemp("data")) as found:
        yield found


@pytest.fixture
def page(client):
    return client.page()


@pytest.fixture
def other(client):
    return client.page()
