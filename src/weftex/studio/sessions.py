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
    """What one tab has here.

    Attributes
    ----------
    id : str
        Its secret.
    key : str
        What the secret is known by on disk, from which it cannot be told.
    shelf : Shelf
        Uploads and kept things.
    seen : float
        When it last asked for something, by `time.monotonic`.
    """

    def __init__(self, store: Store, secret: str) -> None:
        self.id, self.key = secret, key_of(secret)
        self.shelf = Shelf(store, self.key)
        self.seen = time.monotonic()

    def upload(self, name: Any) -> dict[str, Any]:
        """Return what is known of an upload of this session.

        Raises
        ------
        Refusal
            If there is none of this id.
        """
        if not isinstance(name, str) or name not in self.shelf.uploads:
            raise Refusal(404, "a picture of this is not here; drop it again")
        return self.shelf.uploads[name]


class Sessions:
    """All sessions of a server.

    Parameters
    ----------
    store : Store
    limits : Limits
    ended : callable
        Called with a session that gives way to another.
    """

    def __init__(self, store: Store, limits: Limits, ended: Callable[[Session], None]) -> None:
        self._store, self._most, self._ended = store, limits.sessions, ended
        self._lock = threading.Lock()
        self._known: dict[str, Session] = {}

    def open(self, old: Any) -> tuple[Session, bool]:
        """Begin a session, or go on with an old one, which may be of a server that was killed.

        Parameters
        ----------
        old : str or None
            What the page knows as its session.

        Returns
        -------
        session : Session
        resumed : bool
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
            return session, session.shelf.existed

    def get(self, name: str | None) -> Session:
        """Return the session of a request.

        Raises
        ------
        Refusal
            If there is none.
        """
        session = self._known.get(name or "")
        if session is None:
            raise Refusal(401, "this session is not known; load the page again", "session")
        session.seen = time.monotonic()
        return session

    def _make_room(self) -> None:
        if len(self._known) >= self._most:
            oldest = min(self._known.values(), key=lambda session: session.seen)
            if time.monotonic() - oldest.seen < 60:
                raise Refusal(429, f"{self._most} pages are open; close one of them")
            del self._known[oldest.id]
            self._ended(oldest)


def key_of(secret: str) -> str:
    """Return what a session's folder is called."""
    return hashlib.sha256(secret.encode()).hexdigest()
