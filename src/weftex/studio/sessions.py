"""Sessions, one for each browser tab, and the folder in which all of them store files."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import stat
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from weftex.errors import FileError
from weftex.io.pictures import write_text
from weftex.studio.downloads import Downloads
from weftex.studio.limits import Limits, LruCache
from weftex.studio.refusals import Refusal

Value = TypeVar("Value")

DAY = 86400.0
_DAYS, _DAYS_KEPT = 2, 365  # that a session outlives its last use, without and with steps
IN_USE = 180.0  # seconds since a folder was marked in which a server may be using it
STEPS = "steps.json"
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
    """The folder of all sessions, the bytes that their uploads take, and files to download.

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
        except OSError as error:
            raise FileError(f"{folder}: cannot use this folder: {error.strerror}") from None
        _check_private(folder)
        self._sweep()
        self.downloads = Downloads(folder)
        self.bytes = sum(map(_bytes_in, self.sessions()))

    def sessions(self) -> list[Path]:
        """Return the folders of all sessions."""
        return [one for one in self.folder.iterdir() if KEY.fullmatch(one.name) and one.is_dir()]

    def _sweep(self) -> None:
        """Remove unfinished files of a killed server, and sessions that were not used for days.

        A server marks the folders of its open sessions as used, see `Studio.mark_used`.
        """
        now = time.time()
        for session in self.sessions():
            with suppress(OSError):
                days = _DAYS_KEPT if (session / STEPS).exists() else _DAYS
                if now - session.stat().st_mtime > days * DAY:
                    shutil.rmtree(session)
                    continue
                for left in (*session.glob(".new-*"), *session.glob(".weftex-*")):
                    if now - left.stat().st_mtime > DAY:
                        left.unlink()

    def reserve(self, count: int) -> None:
        """Count the bytes of an upload; the oldest sessions that nobody uses give way.

        Raises `Refusal` if all uploads become too large.
        """
        most = self.limits.stored_bytes
        while self.bytes + count > most and (oldest := self._oldest_unused()) is not None:
            self.remove(oldest)
        with self.lock:
            if self.bytes + count > most:
                raise Refusal(
                    413,
                    f"the studio stores {self.bytes >> 20} MiB of uploads, at most {most >> 20}; "
                    "remove earlier work on the start page",
                )
            self.bytes += count

    def release(self, count: int) -> None:
        """Count bytes as no longer there."""
        with self.lock:
            self.bytes -= count

    def _oldest_unused(self) -> Path | None:
        """Return the session folder that was marked as used longest ago, if it is not in use."""
        ages = {one: one.stat().st_mtime for one in self.sessions()}
        oldest = min(ages, key=lambda one: ages[one], default=None)
        return None if oldest is None or ages[oldest] > time.time() - IN_USE else oldest

    def remove(self, folder: Path) -> None:
        """Remove the folder of a session, and count its uploads as no longer there."""
        with self.lock:
            try:
                size = _bytes_in(folder)
                shutil.rmtree(folder)
            except FileNotFoundError:
                return
            self.bytes -= size


def _bytes_in(folder: Path) -> int:
    """Return the bytes of the uploads of a session."""
    return sum(one.stat().st_size for one in folder.iterdir() if one.suffix != ".json")


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


_MOST_STEPS = 300
# Fields that files on disk must have; another version may have written them.
_OF_UPLOAD = {"id": str, "suffix": str, "name": str, "bytes": int}
_OF_STEP = {"id": str, "recipe": dict, "label": str}


def read_steps(folder: Path) -> list[dict[str, Any]]:
    """Return the steps in the folder of a session."""
    with suppress(OSError, ValueError, RecursionError):
        found = json.loads((folder / STEPS).read_text("utf-8"))
        return [one for one in found if _has(one, _OF_STEP)] if isinstance(found, list) else []
    return []


def read_uploads(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the descriptions of the uploads in the folder of a session, by their ids."""
    found = {}
    for one in sorted(folder.glob("*.json")):
        with suppress(OSError, ValueError, RecursionError):
            about = json.loads(one.read_text("utf-8"))
            if _has(about, _OF_UPLOAD) and about["id"] == one.stem:
                if path_of(folder, about).is_file():
                    found[one.stem] = about
    return found


def path_of(folder: Path, about: Mapping[str, Any]) -> Path:
    """Return where the bytes of an upload are."""
    if not (KEY.fullmatch(about["id"]) and re.fullmatch(r"\.[a-z]{3,4}", about["suffix"])):
        raise ValueError
    return folder / f"{about['id']}{about['suffix']}"


class Session:
    """One tab: its uploads and steps, which are on disk, and what it has in memory.

    `id` is its secret and `key` names its folder. Uploads are named after their content, and
    nothing that a client says becomes a part of a path. A lock makes each change on disk whole.
    """

    def __init__(self, store: Store, memory: LruCache, secret: str) -> None:
        self.store, self.memory, self.limits = store, memory, store.limits
        self.id, self.key = secret, key_of(secret)
        self.folder = store.folder / self.key
        self.seen = time.monotonic()
        self.left = False  # whether its page has been left
        self._lock = threading.Lock()
        self.existed = self.folder.is_dir()
        self.uploads = read_uploads(self.folder)
        self.steps = read_steps(self.folder)
        self.mark_used()

    def mark_used(self) -> None:
        """Set the folder's time to now, so that no other server removes it as unused."""
        with suppress(OSError):  # a session without files has no folder
            os.utime(self.folder)

    def recall(self, *key: Any, gone: Refusal | None = None) -> Any:
        """Return what is in memory under this key; without it None, or raise `gone`."""
        found = self.memory.get((self.key, *key))
        if found is None and gone is not None:
            raise gone
        return found

    def remember(self, value: Any, size: int, *key: Any) -> None:
        """Keep a value of `size` bytes in memory, within the limit."""
        self.memory.put((self.key, *key), value, size)

    def find(self, make: Callable[[], Value], size: Callable[[Value], int], *key: Any) -> Value:
        """Return what is in memory, or make and remember it; `size` returns its bytes."""
        found: Value | None = self.recall(*key)
        if found is None:
            found = make()
            self.remember(found, size(found), *key)
        return found

    def new_file(self) -> Path:
        """Return a path to which an upload is written while it comes in."""
        self.folder.mkdir(mode=0o700, exist_ok=True)
        return self.folder / f".new-{os.urandom(8).hex()}"

    def upload(self, name: Any) -> dict[str, Any]:
        """Return the description of an upload, or raise `Refusal` if its file is not there."""
        about = self.uploads.get(name) if isinstance(name, str) else None
        if about is None or not path_of(self.folder, about).is_file():
            raise Refusal(404, "a picture of this material is missing; drop it again")
        return about

    def check_room(self) -> None:
        """Raise `Refusal` if the session has as many uploads as it may."""
        if len(self.uploads) >= self.limits.uploads:
            line = f"this tab has {self.limits.uploads} pictures, the limit; continue in a new tab"
            raise Refusal(413, line)

    def take(self, file: Path, about: dict[str, Any]) -> bool:
        """Move a file among the uploads; return False if the same bytes are stored already.

        The line about it is written last, so an upload is listed only if all of it is there.
        """
        with self._lock:
            if about["id"] in self.uploads:
                return False
            self.check_room()
            path = path_of(self.folder, about)
            file.replace(path)
            try:
                write_text(path.with_suffix(".json"), json.dumps(about))
            except BaseException:
                path.unlink(missing_ok=True)
                raise
            self.uploads[about["id"]] = about
            return True

    def add_steps(self, steps: list[dict[str, Any]]) -> None:
        """Add steps, in place of those with the same id; they are on disk then.

        Of more than the limit the oldest are dropped.
        """
        new = {one["id"] for one in steps}
        with self._lock:
            kept = [*(one for one in self.steps if one["id"] not in new), *steps][-_MOST_STEPS:]
            self.folder.mkdir(mode=0o700, exist_ok=True)
            write_text(self.folder / STEPS, json.dumps(kept))
            self.steps = kept


def key_of(secret: str) -> str:
    """Return the name of a session's folder, which does not reveal its secret."""
    return hashlib.sha256(secret.encode()).hexdigest()


def _has(found: Any, fields: Mapping[str, type]) -> bool:
    """Return whether JSON is an object with these fields."""
    return isinstance(found, dict) and all(
        isinstance(found.get(name), kind) for name, kind in fields.items()
    )
