"""Limits of the studio, and a cache with a limit of memory."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Limits:
    """Bounds of one server."""

    # Of one file, counted while it comes and before it is decoded.
    upload_bytes: int = 2**28
    upload_pixels: int = 2**26
    stored_bytes: int = 2**31  # of all uploads on disk
    uploads: int = 200  # of one session
    output_pixels: int = 2**25  # of one output
    # Of decoded pictures, results and windows that are remembered; all can be made again.
    memory_bytes: int = 2**30
    # Jobs that wait or run, of all sessions and of one.
    jobs: int = 48
    session_jobs: int = 24
    sessions: int = 64
    strangers: int = 64  # connections that have not sent the token
    # From a connection, or the answer before, to headers, and between two pieces of a body.
    header_seconds: float = 10.0
    body_seconds: float = 600.0  # from headers to a whole body
    body_bytes: int = 2**20  # of a request that is no upload
    away_seconds: float = 10.0  # until a job is cancelled whose page has gone


def usual_limits() -> Limits:
    """Return the limits for this machine: an eighth of its memory is what is remembered."""
    try:
        whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return Limits()
    return Limits(memory_bytes=max(2**28, min(2**31, whole // 8)))


class LruCache:
    """Values in memory up to a limit; the least recently used go first.

    Keys are tuples that begin with the key of a session.
    """

    def __init__(self, most_bytes: int) -> None:
        self.most_bytes, self.bytes = most_bytes, 0
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple[Any, ...], tuple[Any, int]] = OrderedDict()

    def put(self, key: tuple[Any, ...], value: Any, size: int) -> None:
        """Remember a value of `size` bytes; the last is always remembered."""
        with self._lock:
            self._drop(key)
            self._kept[key] = value, size
            self.bytes += size
            while self.bytes > self.most_bytes and len(self._kept) > 1:
                self._drop(next(iter(self._kept)))

    def get(self, key: tuple[Any, ...]) -> Any:
        """Return what is remembered, or None."""
        with self._lock:
            if key not in self._kept:
                return None
            self._kept.move_to_end(key)
            return self._kept[key][0]

    def forget(self, session: str) -> None:
        """Forget what a session has."""
        with self._lock:
            for key in [key for key in self._kept if key[0] == session]:
                self._drop(key)

    def _drop(self, key: tuple[Any, ...]) -> None:
        if key in self._kept:
            self.bytes -= self._kept.pop(key)[1]
