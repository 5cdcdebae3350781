"""The state of one studio server: sessions, cache, queue of jobs, downloads."""

from __future__ import annotations

import os
import re
import secrets
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from anyio import CapacityLimiter

from weftex.studio.chains import Chains
from weftex.studio.jobs import Jobs
from weftex.studio.limits import Limits, LruCache
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import IN_USE, Session, Store
from weftex.studio.uploads import StartMaterial

_AT_A_TIME = 4  # pieces of short work, such as pictures to be packed
_SECRET = re.compile(r"[A-Za-z0-9_-]{43}")


class Studio:
    """One start of the studio."""

    def __init__(self, folder: Path, limits: Limits, opened: StartMaterial | None = None) -> None:
        self.limits, self.opened = limits, opened
        self.token = secrets.token_urlsafe(32)
        self.store = Store(folder, limits)
        self.memory = LruCache(limits.memory_bytes)
        self.jobs = Jobs(limits)
        self.downloads = self.store.downloads
        self.chains = Chains(self.store.folder)
        self.limiter = CapacityLimiter(_AT_A_TIME)
        self.decoding = CapacityLimiter(1)
        self.sessions: dict[str, Session] = {}  # by their secrets
        self._lock = threading.Lock()
        self.began = threading.Event()  # once there has been a session

    def open_session(self, old: Any) -> tuple[Session, bool]:
        """Return a new session, or the one with the secret `old`, and whether it is the old one.

        That may be a session of a server that was killed.
        """
        known = isinstance(old, str) and _SECRET.fullmatch(old) is not None
        with self._lock:
            if known and old in self.sessions:
                self.sessions[old].left = False
                return self.sessions[old], True
            session = Session(self.store, self.memory, old) if known else None
            if session is None or not session.existed:  # nothing of it is left
                session = Session(self.store, self.memory, secrets.token_urlsafe(32))
            most = self.limits.sessions
            if len(self.sessions) >= most:
                oldest = min(self.sessions.values(), key=lambda session: session.seen)
                if time.monotonic() - oldest.seen < 60:
                    raise Refusal(429, f"{most} pages are open; close one of them")
                self._end(oldest)
            self.sessions[session.id] = session
            self.began.set()
            return session, session.existed

    def session(self, secret: str | None) -> Session:
        """Return the session of a request, or raise `Refusal`."""
        session = self.sessions.get(secret or "")
        if session is None:
            raise Refusal(401, "this session is not known; load the page again", "session")
        session.seen, session.left = time.monotonic(), False
        return session

    def in_use(self, key: str) -> bool:
        """Return whether a tab of this server, or of another one, may use a session's folder."""
        with self._lock:
            for session in self.sessions.values():
                if session.key == key:
                    return not session.left
        with suppress(OSError):
            return time.time() - (self.store.folder / key).stat().st_mtime < IN_USE
        return False

    def forget(self, key: str) -> None:
        """Forget a session whose page has been left; its folder went to another one."""
        with self._lock:
            for session in [one for one in self.sessions.values() if one.key == key]:
                self._end(session)

    def _end(self, session: Session) -> None:
        """Stop the work of a session, and forget what it made."""
        del self.sessions[session.id]
        self.jobs.end(session)
        self.memory.forget(session.key)
        self.downloads.forget(session.key)

    def mark_used(self) -> None:
        """Mark the folders in use, for servers that share the data folder and remove old ones."""
        for session in list(self.sessions.values()):
            if not session.left:
                session.mark_used()
        self.downloads.mark_used()

    def close(self) -> None:
        """Stop all work, and mark all folders as unused, so that the next server may move them."""
        self.jobs.close()
        for session in self.sessions.values():
            with suppress(OSError):
                os.utime(session.folder, (time.time() - IN_USE,) * 2)
        self.downloads.close()
