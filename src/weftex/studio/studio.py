"""All that one start of the studio has: sessions, what it remembers, its queue of jobs."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any

from anyio import CapacityLimiter

from weftex.studio.downloads import Downloads
from weftex.studio.jobs import Jobs
from weftex.studio.limits import Limits, Memory
from weftex.studio.sessions import Session, Sessions
from weftex.studio.store import Store

if TYPE_CHECKING:
    from pathlib import Path

    from weftex.studio.opened import Opened

_AT_A_TIME = 4  # pieces of short work, such as pictures to be packed


class Studio:
    """One start of the studio."""

    def __init__(self, folder: Path, limits: Limits, opened: Opened | None = None) -> None:
        self.limits, self.opened = limits, opened
        self.token = secrets.token_urlsafe(32)
        self.store = Store(folder, limits.stored_bytes)
        self.memory = Memory(limits.memory_bytes)
        self.jobs = Jobs(limits)
        self.downloads = Downloads(self.store.folder)
        self.sessions = Sessions(self.store, limits, self._ended)
        self.limiter, self.decoding = CapacityLimiter(_AT_A_TIME), CapacityLimiter(1)

    def _ended(self, session: Session) -> None:
        """A session gives way: its work stops, and what it made is forgotten."""
        for job in self.jobs.of(session):
            job.cancel()

        def is_its_own(key: Any) -> bool:
            return isinstance(key, tuple) and key[0] == session.key

        self.memory.forget(is_its_own)
        self.downloads.forget(session.key)

    def mark_used(self) -> None:
        """Mark the folders in use, for servers that share the data folder and remove old ones."""
        self.sessions.mark_used()
        self.downloads.mark_used()

    def close(self) -> None:
        """Stop all work."""
        self.jobs.close()
        self.downloads.close()
