"""Processes that work beside this one, and end with it however it ends."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from typing import Any

from weftex.errors import WeftexError

__all__ = ["LostError", "Workers"]

_CHILD = "from weftex.processes import serve; serve()"


class LostError(WeftexError):
    """A process ended before its work: it was killed, perhaps for lack of memory, or by `end`."""


class Workers:
    """Processes that start on demand and run `begin(*about)` once, then work through its result.

    They are fresh interpreters, ignore Ctrl-C, and end when this process does. All is pickled.
    """

    def __init__(self, begin: Callable[..., Callable[[Any], Any]], *about: Any) -> None:
        self._begin = pickle.dumps((begin, about))
        self._lock, self._ended = threading.Lock(), False
        self._all: list[_Process] = []
        self._idle: list[_Process] = []

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def do(self, work: Any) -> Any:
        """The result of a piece of work in an idle process; threads may call it and wait.

        Raises `LostError` if the process ended, and the work's own errors.
        """
        with self._lock:
            if self._ended:
                raise LostError("its process was ended")
            if not self._idle:
                self._idle.append(_Process(self._begin))
                self._all.append(self._idle[-1])
            process = self._idle.pop()
        failed, result = process.ask(work)
        with self._lock:
            self._idle.append(process)
        if failed:
            raise result
        return result

    def end(self) -> None:
        """Kill all of them."""
        with self._lock:
            self._ended = True
            for process in self._all:
                process.kill()
            for process in self._idle:
                process.close()


class _Process:
    """A process, and the pipes to it and from it."""

    def __init__(self, begin: bytes) -> None:
        apart: dict[str, Any] = {"start_new_session": True}
        if os.name == "nt":
            apart = {"creationflags": 0x200}  # a group of its own
        path = os.pathsep.join(place for place in sys.path if place)
        self._running: subprocess.Popen[bytes] = subprocess.Popen(
            [sys.executable, "-c", _CHILD],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": path, "PYTHONSAFEPATH": "1"},
            **apart,
        )
        self._begin = begin

    def ask(self, work: Any) -> Any:
        process = self._running
        assert process.stdin is not None and process.stdout is not None
        try:
            for data in (self._begin, pickle.dumps(work)):
                process.stdin.write(data)
            process.stdin.flush()
            self._begin = b""
            return pickle.load(process.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            self.kill()
            self.close()
            raise LostError("its process was killed, perhaps because memory ran out") from None

    def kill(self) -> None:
        self._running.kill()
        self._running.wait()

    def close(self) -> None:
        """Close the pipes, which nobody may be waiting at."""
        for pipe in (self._running.stdin, self._running.stdout):
            with suppress(OSError):  # what it was to get may still be on its way
                pipe.close()  # type: ignore[union-attr]


def serve() -> None:
    """Be one of the processes of `Workers`: read work, write results, end when nobody asks."""
    # What libraries print must not get between results.
    results = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    work: SimpleQueue[Any] = SimpleQueue()

    def listen() -> None:
        try:
            while True:
                work.put(pickle.load(sys.stdin.buffer))
        except BaseException:  # the other end is gone
            os._exit(1)

    threading.Thread(target=listen, daemon=True).start()
    begin, about = work.get()
    do: Callable[[Any], Any] | None = None
    while True:
        piece = work.get()
        try:
            do = do or begin(*about)
            reply = pickle.dumps((False, do(piece)))
        except BaseException as error:
            reply = pickle.dumps((True, error))
        try:
            results.write(reply)
            results.flush()
        except OSError:
            os._exit(1)
