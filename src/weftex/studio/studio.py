"""The state of one studio server: sessions, cache, queue of jobs, downloads."""

from __future__ import annotations

import secrets
from pathlib import Path

from anyio import CapacityLimiter

from weftex.studio.chains import Chains
from weftex.studio.jobs import Jobs
from weftex.studio.limits import Limits, LruCache
from weftex.studio.sessions import Session, Sessions, Store
from weftex.studio.uploads import StartMaterial

_AT_A_TIME = 4  # pieces of short work, such as pictures to be packed


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
        self.sessions = Sessions(self.store, self.memory, self._ended)
        self.limiter = CapacityLimiter(_AT_A_TIME)
        self.decoding = CapacityLimiter(1)

    def _ended(self, session: Session) -> None:
        """A session gives way: its work stops, and what it made is forgotten."""
        self.jobs.end(session)
        self.memory.forget(session.key)
        self.downloads.forget(session.key)

    def mark_used(self) -> None:
        """Mark the folders in use, for servers that share the data folder and remove old ones."""
        self.sessions.mark_used()
        self.downloads.mark_used()

    def close(self) -> None:
        """Stop all work."""
        self.jobs.close()
        self.sessions.close()
        self.downloads.close()
