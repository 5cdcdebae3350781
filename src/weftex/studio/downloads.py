"""Files that are ready to be taken, each under a random name that is given once."""

from __future__ import annotations

import re
import secrets
import shutil
import tempfile
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from weftex.studio.refusals import Refusal

_TICKET = re.compile(r"[A-Za-z0-9_-]{32}")
_SECONDS = 3600  # that a file waits for its owner
_MOST = 32  # files


@dataclass(frozen=True)
class Download:
    """A file that waits.

    Attributes
    ----------
    path : Path
    name : str
        What it is to be called.
    owner : str
        The key of its session.
    time : float
    """

    path: Path
    name: str
    owner: str
    time: float


class Downloads:
    """What is ready to be taken.

    Parameters
    ----------
    folder : Path
        Of the studio; files go to one of this process, which goes with it.
    """

    def __init__(self, folder: Path) -> None:
        for left in folder.glob("out-*"):  # of a server that was killed
            with suppress(OSError):
                if time.time() - left.stat().st_mtime > _SECONDS:
                    shutil.rmtree(left)
        self.folder = Path(tempfile.mkdtemp(prefix="out-", dir=folder))
        self._lock = threading.Lock()
        self._ready: dict[str, Download] = {}

    def new_folder(self) -> Path:
        """Return an empty folder to write to."""
        return Path(tempfile.mkdtemp(dir=self.folder))

    def add(self, path: Path, name: str, owner: str) -> dict[str, object]:
        """Have a file ready; what the page is told of it."""
        ticket = secrets.token_urlsafe(24)
        with self._lock:
            self._ready[ticket] = Download(path, name, owner, time.monotonic())
            for old in list(self._ready)[:-_MOST]:
                self._drop(old)
            for old in [
                k for k, one in self._ready.items() if time.monotonic() - one.time > _SECONDS
            ]:
                self._drop(old)
        return {"ticket": ticket, "name": name, "bytes": path.stat().st_size}

    def get(self, ticket: str) -> Download:
        """Return what a ticket is for.

        Raises
        ------
        Refusal
            If it is none.
        """
        found = self._ready.get(ticket) if _TICKET.fullmatch(ticket) else None
        if found is None:
            raise Refusal(404, "there is no such file any more; make it again")
        return found

    def forget(self, owner: str) -> None:
        """Remove what waits for a session."""
        with self._lock:
            for ticket in [k for k, one in self._ready.items() if one.owner == owner]:
                self._drop(ticket)

    def close(self) -> None:
        """Remove everything."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _drop(self, ticket: str) -> None:
        shutil.rmtree(self._ready.pop(ticket).path.parent, ignore_errors=True)
