"""The folder of all sessions: whose it is, what is removed from it, and how large it may become."""

from __future__ import annotations

import os
import re
import shutil
import stat
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from weftex.errors import FileError
from weftex.studio.refusals import Refusal

if TYPE_CHECKING:
    from weftex.studio.limits import Limits

DAY = 86400.0
_DAYS, _DAYS_KEPT = 2, 60  # that a session outlives its last use, without and with kept recipes
KEPT = "kept.json"
KEY = re.compile(r"[0-9a-f]{64}")  # the name of a session's folder, and of an upload


def default_folder() -> Path:
    """Return the folder where this user's programs keep their state."""
    home = Path.home()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "weftex" / "studio"
    if sys.platform == "darwin":
        return home / "Library" / "Application Support" / "weftex" / "studio"
    state = os.environ.get("XDG_STATE_HOME") or ""
    return (Path(state) if state.startswith("/") else home / ".local/state") / "weftex" / "studio"


class Store:
    """The folder of all sessions, and the number of bytes that their uploads take.

    New folders are readable by their owner alone. An existing one keeps its permissions, and is
    refused with `FileError` if another user owns it, or can write to it or replace it.
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self.folder, self.limits = folder, limits
        self.lock = threading.Lock()
        #: Held while a picture is decoded: the largest one takes 1.4 GiB for a moment.
        self.decoding = threading.Lock()
        try:
            for path in reversed([folder, *folder.parents]):
                path.mkdir(mode=0o700, exist_ok=True)
            _check_private(folder)
            self._sweep()
        except FileError:
            raise
        except OSError as error:
            raise FileError(f"{folder}: cannot use this folder: {error.strerror}") from None
        self.bytes = sum(
            one.stat().st_size
            for session in self._sessions()
            for one in session.iterdir()
            if one.suffix != ".json"
        )

    def _sessions(self) -> list[Path]:
        return [one for one in self.folder.iterdir() if KEY.fullmatch(one.name) and one.is_dir()]

    def _sweep(self) -> None:
        """Remove unfinished files of a killed server, and sessions that were not used for days.

        A server marks the folders of its open sessions as used, see `Studio.mark_used`.
        """
        now = time.time()
        for session in self._sessions():
            with suppress(OSError):
                days = _DAYS_KEPT if (session / KEPT).exists() else _DAYS
                if now - session.stat().st_mtime > days * DAY:
                    shutil.rmtree(session)
                    continue
                for left in (*session.glob(".new-*"), *session.glob(".weftex-*")):
                    if now - left.stat().st_mtime > DAY:
                        left.unlink()

    def reserve(self, count: int) -> None:
        """Count the bytes of an upload, or raise `Refusal` if all uploads become too large."""
        most = self.limits.stored_bytes
        with self.lock:
            if self.bytes + count > most:
                line = f"the studio stores {self.bytes >> 20} MiB of uploads, at most {most >> 20}"
                raise Refusal(413, f"{line}; start it with another folder: --data")
            self.bytes += count


def _check_private(folder: Path) -> None:
    """Raise `FileError` if another user owns the folder, can write to it or can replace it."""
    about = folder.stat()
    if not hasattr(os, "getuid"):
        return
    if about.st_uid != os.getuid():
        raise FileError(f"{folder}: belongs to another user; name another folder with --data")
    if about.st_mode & 0o022:
        line = f"{folder}: other users can write to this folder (mode {about.st_mode & 0o777:o})"
        raise FileError(f"{line}; name another with --data, or chmod go-w it")
    parent = folder.resolve().parent
    above = parent.stat()
    own_group = above.st_gid == os.getuid()  # a group of this user alone, as Linux makes them
    others = above.st_mode & (0o002 if own_group else 0o022)
    if others and not above.st_mode & stat.S_ISVTX:
        line = f"{folder}: other users can replace this folder, since they can write to {parent}"
        line += f" (mode {above.st_mode & 0o777:o})"
        raise FileError(f"{line}; name another with --data, or chmod go-w {parent}")
