"""What a session keeps on disk: uploads, named after their content, and what was kept.

Names of files are made here; nothing that a client says becomes a part of one.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from weftex.errors import FileError
from weftex.io.pictures import write_text
from weftex.studio.refusals import Refusal

DAY = 86400.0
_DAYS, _DAYS_KEPT = 2, 60  # that sessions outlive their last use, without and with kept things
_KEPT = "kept.json"
_ID = re.compile(r"[0-9a-f]{64}")
# What must be known of what lies on disk, which another version may have written.
_OF_UPLOAD = {"id": str, "suffix": str, "name": str, "bytes": int}
_OF_KEPT = {"recipe": dict, "result": str}


def default_folder() -> Path:
    """Return the folder of this person's programs for what they keep."""
    home = Path.home()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "weftex" / "studio"
    if sys.platform == "darwin":
        return home / "Library" / "Application Support" / "weftex" / "studio"
    state = os.environ.get("XDG_STATE_HOME") or ""
    return (Path(state) if state.startswith("/") else home / ".local/state") / "weftex" / "studio"


class Store:
    """The folder of all sessions.

    Parameters
    ----------
    folder : Path
        Made for its owner's eyes only, if it is not there.
    most_bytes : int
        That all uploads may take together.

    Raises
    ------
    FileError
        If it cannot be made, or belongs to somebody else.
    """

    def __init__(self, folder: Path, most_bytes: int) -> None:
        self.folder, self.most_bytes = folder, most_bytes
        self.lock = threading.Lock()
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            about = folder.lstat()
            if hasattr(os, "getuid") and about.st_uid != os.getuid():
                raise FileError(f"{folder}: belongs to somebody else; name another with --data")
            folder.chmod(0o700)
        except OSError as error:
            if isinstance(error, FileError):
                raise
            raise FileError(f"{folder}: cannot make this folder: {error.strerror}") from None
        self._sweep()
        self.bytes = sum(
            one.stat().st_size
            for session in self._sessions()
            for one in session.iterdir()
            if one.suffix != ".json"
        )

    def _sessions(self) -> list[Path]:
        return [one for one in self.folder.iterdir() if _ID.fullmatch(one.name) and one.is_dir()]

    def _sweep(self) -> None:
        """Remove what a killed server left half done, and sessions that nobody came back to."""
        now = time.time()
        for session in self._sessions():
            with suppress(OSError):
                days = _DAYS_KEPT if (session / _KEPT).exists() else _DAYS
                if now - session.stat().st_mtime > days * DAY:
                    shutil.rmtree(session)
                    continue
                for left in (*session.glob(".new-*"), *session.glob(".weftex-*")):
                    if now - left.stat().st_mtime > DAY:
                        left.unlink()

    def reserve(self, count: int) -> None:
        """Count bytes of an upload while it comes.

        Raises
        ------
        Refusal
            If all uploads together become too many.
        """
        with self.lock:
            if self.bytes + count > self.most_bytes:
                line = f"the studio holds {self.bytes >> 20} MiB of pictures, and at most"
                line += f" {self.most_bytes >> 20}; take some away first"
                raise Refusal(413, line)
            self.bytes += count


class Shelf:
    """The uploads and the kept things of one session.

    Parameters
    ----------
    store : Store
    name : str
        Of its folder: 64 hexadecimal digits, made from the session's secret.
    """

    def __init__(self, store: Store, name: str) -> None:
        assert _ID.fullmatch(name)
        self.store, self.folder = store, store.folder / name
        self.uploads: dict[str, dict[str, Any]] = {}
        self.kept: list[dict[str, Any]] = []
        self.existed = self.folder.is_dir()
        for one in sorted(self.folder.glob("*.json")) if self.existed else ():
            with suppress(OSError, ValueError, RecursionError):
                about = json.loads(one.read_text("utf-8"))
                if one.name == _KEPT:
                    entries = about if isinstance(about, list) else []
                    self.kept = [entry for entry in entries if _has(entry, _OF_KEPT)]
                elif _has(about, _OF_UPLOAD) and about["id"] == one.stem:
                    if self.path(about).is_file():
                        self.uploads[one.stem] = about
        if self.existed:
            os.utime(self.folder)

    def path(self, about: dict[str, Any]) -> Path:
        """Return where the bytes of an upload are."""
        if not (_ID.fullmatch(about["id"]) and re.fullmatch(r"\.[a-z]{3,4}", about["suffix"])):
            raise ValueError
        return self.folder / f"{about['id']}{about['suffix']}"

    def new_file(self) -> Path:
        """Return where an upload may be written to while it comes."""
        self.folder.mkdir(mode=0o700, exist_ok=True)
        return self.folder / f".new-{os.urandom(8).hex()}"

    def take(self, file: Path, about: dict[str, Any]) -> None:
        """Give a file its name; the line about it is written last, so that all of it is there."""
        file.replace(self.path(about))
        write_text(self.folder / f"{about['id']}.json", json.dumps(about))
        self.uploads[about["id"]] = about

    def remove(self, upload: str) -> None:
        """Remove an upload."""
        about = self.uploads.pop(upload)
        for path in (self.folder / f"{about['id']}.json", self.path(about)):
            path.unlink(missing_ok=True)
        self.store.reserve(-about["bytes"])

    def keep(self, kept: list[dict[str, Any]]) -> None:
        """Write what is kept; it is on disk when this returns."""
        self.folder.mkdir(mode=0o700, exist_ok=True)
        write_text(self.folder / _KEPT, json.dumps(kept))
        self.kept = kept


def _has(found: Any, fields: Mapping[str, type]) -> bool:
    """Whether JSON is an object with these fields."""
    return isinstance(found, dict) and all(
        isinstance(found.get(name), kind) for name, kind in fields.items()
    )
