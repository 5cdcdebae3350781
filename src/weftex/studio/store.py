"""What a session keeps on disk: uploads, named after their content, and the recipes that it keeps.

Names of files are made here; nothing that a client says becomes a part of one.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
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
_DAYS, _DAYS_KEPT = 2, 60  # that a session outlives its last use, without and with kept recipes
_MOST_KEPT = 200
_KEPT = "kept.json"
_ID = re.compile(r"[0-9a-f]{64}")
# Fields that files on disk must have; another version may have written them.
_OF_UPLOAD = {"id": str, "suffix": str, "name": str, "bytes": int}
_OF_KEPT = {"recipe": dict, "result": str}


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

    def __init__(self, folder: Path, most_bytes: int) -> None:
        self.folder, self.most_bytes = folder, most_bytes
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
        return [one for one in self.folder.iterdir() if _ID.fullmatch(one.name) and one.is_dir()]

    def _sweep(self) -> None:
        """Remove unfinished files of a killed server, and sessions that were not used for days.

        A server marks the folders of its open sessions as used, see `Sessions.mark_used`.
        """
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
        """Count the bytes of an upload, or raise `Refusal` if all uploads become too large."""
        with self.lock:
            if self.bytes + count > self.most_bytes:
                line = f"the studio holds {self.bytes >> 20} MiB of pictures, and at most"
                line += f" {self.most_bytes >> 20}; take some away first"
                raise Refusal(413, line)
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


class Shelf:
    """The uploads and the kept recipes of the session whose folder has this name.

    Every method that changes something holds the lock, so each change is whole.
    """

    def __init__(self, store: Store, name: str) -> None:
        assert _ID.fullmatch(name)
        self.store, self.folder = store, store.folder / name
        self.uploads: dict[str, dict[str, Any]] = {}
        self.kept: list[dict[str, Any]] = []
        self._lock = threading.Lock()
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
        self.mark_used()

    def mark_used(self) -> None:
        """Set the folder's time to now, so that no other server removes it as unused."""
        with suppress(OSError):  # a session without files has no folder
            os.utime(self.folder)

    def path(self, about: dict[str, Any]) -> Path:
        """Return where the bytes of an upload are."""
        if not (_ID.fullmatch(about["id"]) and re.fullmatch(r"\.[a-z]{3,4}", about["suffix"])):
            raise ValueError
        return self.folder / f"{about['id']}{about['suffix']}"

    def new_file(self) -> Path:
        """Return a path to which an upload is written while it comes in."""
        self.folder.mkdir(mode=0o700, exist_ok=True)
        return self.folder / f".new-{os.urandom(8).hex()}"

    def upload(self, name: Any) -> dict[str, Any]:
        """Return the description of an upload, or raise `Refusal` if its file is not there."""
        about = self.uploads.get(name) if isinstance(name, str) else None
        if about is None or not self.path(about).is_file():
            raise Refusal(404, "a picture of this is not here; drop it again")
        return about

    def check_room(self, most: int) -> None:
        """Raise `Refusal` if the session has `most` uploads."""
        if len(self.uploads) >= most:
            raise Refusal(413, f"{most} pictures are here; take some away first")

    def take(self, file: Path, about: dict[str, Any], most: int) -> bool:
        """Move a file among the uploads; return False if the same bytes are there already.

        The line about it is written last, so an upload is listed only if all of it is there.
        """
        with self._lock:
            if about["id"] in self.uploads:
                return False
            self.check_room(most)
            path = self.path(about)
            file.replace(path)
            try:
                write_text(path.with_suffix(".json"), json.dumps(about))
            except BaseException:
                path.unlink(missing_ok=True)
                raise
            self.uploads[about["id"]] = about
            return True

    def remove(self, upload: str) -> None:
        """Remove an upload, or raise `Refusal` if there is none."""
        with self._lock:
            about = self.uploads.pop(upload, None)
            if about is None:
                raise Refusal(404, "this picture is not here")
            for path in (self.path(about).with_suffix(".json"), self.path(about)):
                path.unlink(missing_ok=True)
            self.store.reserve(-about["bytes"])

    def keep(self, entry: dict[str, Any]) -> None:
        """Keep a recipe, in place of an older entry of the same result; it is on disk then."""
        with self._lock:
            others = [one for one in self.kept if one["result"] != entry["result"]]
            if len(others) >= _MOST_KEPT:
                raise Refusal(413, f"{_MOST_KEPT} results are kept; let some of them go first")
            self._write_kept([*others, entry])

    def forget(self, result: str) -> None:
        """Forget the kept recipe of a result, or raise `Refusal` if there is none."""
        with self._lock:
            others = [one for one in self.kept if one["result"] != result]
            if len(others) == len(self.kept):
                raise Refusal(404, "this is not kept")
            self._write_kept(others)

    def _write_kept(self, kept: list[dict[str, Any]]) -> None:
        self.folder.mkdir(mode=0o700, exist_ok=True)
        write_text(self.folder / _KEPT, json.dumps(kept))
        self.kept = kept


def _has(found: Any, fields: Mapping[str, type]) -> bool:
    """Return whether JSON is an object with these fields."""
    return isinstance(found, dict) and all(
        isinstance(found.get(name), kind) for name, kind in fields.items()
    )
