"""Files that are ready to be downloaded, each under a random name that is given once."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from weftex.errors import FileError
from weftex.studio.refusals import Refusal

_SECONDS = 3600  # that a file waits for its owner
_MOST = 32  # files


class Download(NamedTuple):
    """A file that waits, the name to save it by, the key of its session, and its time."""

    path: Path
    name: str
    owner: str
    time: float


class Downloads:
    """The files that are ready, in a folder of this process that is removed with it."""

    def __init__(self, folder: Path) -> None:
        for left in folder.glob("out-*"):  # of a server that was killed
            with suppress(OSError):
                if time.time() - left.stat().st_mtime > _SECONDS:
                    shutil.rmtree(left)
        try:
            self.folder = Path(tempfile.mkdtemp(prefix="out-", dir=folder))
        except OSError as error:
            raise FileError(f"{folder}: cannot write to this folder: {error.strerror}") from None
        self._lock = threading.Lock()
        self._ready: dict[str, Download] = {}

    def mark_used(self) -> None:
        """Set the folder's time to now, so that no other server removes it."""
        with suppress(OSError):
            os.utime(self.folder)

    @contextmanager
    def new_folder(self) -> Iterator[Path]:
        """Yield an empty folder to write to; it is removed if the block fails."""
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        try:
            yield folder
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise

    def add(self, path: Path, name: str, owner: str) -> dict[str, object]:
        """Make a file, directly in its `new_folder`, ready; return what the page needs for it."""
        ticket, size = secrets.token_urlsafe(24), path.stat().st_size
        with self._lock:
            now = time.monotonic()
            self._ready[ticket] = Download(path, name, owner, now)
            late = [k for k, one in self._ready.items() if now - one.time > _SECONDS]
            for old in {*late, *list(self._ready)[:-_MOST]}:
                self._drop(old)
        return {"ticket": ticket, "name": name, "bytes": size}

    def get(self, ticket: str) -> Download:
        """Return the file of a ticket, or raise `Refusal`."""
        found = self._ready.get(ticket)
        if found is None or not found.path.is_file():
            raise Refusal(404, "this file is no longer there; export it again")
        return found

    def forget(self, owner: str) -> None:
        """Remove the files of a session."""
        with self._lock:
            for ticket in [k for k, one in self._ready.items() if one.owner == owner]:
                self._drop(ticket)

    def close(self) -> None:
        """Remove everything."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _drop(self, ticket: str) -> None:
        shutil.rmtree(self._ready.pop(ticket).path.parent, ignore_errors=True)
