"""Sessions: a tab of a browser, which sees its own work and nobody else's."""

from __future__ import annotations

import hashlib
import re
import secrets
import threading
import time
from typing import TYPE_CHECKING, Any

from weftex.studio.refusals import Refusal
from weftex.studio.store import Shelf, Store

if TYPE_CHECKING:
    from collections.abc import Callable

    from weftex.studio.limits import Limits

_ID = re.compile(r"[A-Za-z0-9_-]{43}")


class Session:
    """One tab: its secret `id`, the `key` that names its folder, its `shelf`, the time `seen`."""

    def __init__(self, store: Store, secret: str) -> None:
        self.id, self.key = secret, key_of(secret)
        self.shelf = Shelf(store, self.key)
        self.seen = time.monotonic()

    def upload(self, name: Any) -> dict[str, Any]:
        """Return the description of an upload of this session, or raise `Refusal`."""
        return self.shelf.upload(name)


class Sessions:
    """All sessions of a server; `ended` is called with a session that is closed for another."""

    def __init__(self, store: Store, limits: Limits, ended: Callable[[Session], None]) -> None:
        self._store, self._most, self._ended = store, limits.sessions, ended
        self._lock = threading.Lock()
        self._known: dict[str, Session] = {}
        self.began = threading.Event()  # once there has been a session

    def open(self, old: Any) -> tuple[Session, bool]:
        """Return a new session, or the one with the secret `old`, and whether it is the old one.

        That may be a session of a server that was killed.
        """
        known = isinstance(old, str) and _ID.fullmatch(old) is not None
        with self._lock:
            if known and old in self._known:
                return self._known[old], True
            session = Session(self._store, old if known else secrets.token_urlsafe(32))
            if known and not session.shelf.existed:  # nothing of it is left
                session = Session(self._store, secrets.token_urlsafe(32))
            self._make_room()
            self._known[session.id] = session
            self.began.set()
            return session, session.shelf.existed

    def get(self, name: str | None) -> Session:
        """Return the session of a request, or raise `Refusal`."""
        session = self._known.get(name or "")
        if session is None:
            raise Refusal(401, "this session is not known; load the page again", "session")
        session.seen = time.monotonic()
        return session

    def mark_used(self) -> None:
        """Mark the folders of all open sessions as used, for servers that share the folder."""
        for session in list(self._known.values()):
            session.shelf.mark_used()

    def _make_room(self) -> None:
        if len(self._known) >= self._most:
            oldest = min(self._known.values(), key=lambda session: session.seen)
            if time.monotonic() - oldest.seen < 60:
                raise Refusal(429, f"{self._most} pages are open; close one of them")
            del self._known[oldest.id]
            self._ended(oldest)


def key_of(secret: str) -> str:
    """Return the name of a session's folder, from which its secret cannot be told."""
    return hashlib.sha256(secret.encode()).hexdigest()
