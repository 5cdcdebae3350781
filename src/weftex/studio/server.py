"""The server itself, by uvicorn, which closes connections that send nothing."""

from __future__ import annotations

import asyncio
import socket
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from weftex.studio.app import make_app
from weftex.studio.guard import OWNER
from weftex.studio.limits import Limits
from weftex.studio.listening import hosts_of
from weftex.studio.studio import Studio

_GRACE = 1  # seconds that requests have to end


class Server(uvicorn.Server):
    """A studio that serves at a socket of `listening.listen`, on this machine.

    `run` ends with Ctrl-C or SIGTERM, or once `should_exit` is set; it closes the studio.
    """

    def __init__(self, listener: socket.socket, studio: Studio) -> None:
        self.listener = listener
        config = uvicorn.Config(
            make_app(studio, hosts_of(listener.getsockname()[1])),
            loop="asyncio",
            http=connection_class(studio.limits),
            ws="none",
            lifespan="on",
            log_level="error",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            timeout_graceful_shutdown=_GRACE,
        )
        super().__init__(config)

    async def startup(self, sockets: Any = None) -> None:
        """Begin to answer."""
        await super().startup([self.listener])


def connection_class(limits: Limits) -> type[H11Protocol]:
    """Return the class of a server's connections, which know each other.

    A connection is closed `header_seconds` after it began, or after its last answer, if no headers
    have come; while a body comes, `header_seconds` after its last bytes, and `body_seconds` after
    its headers. A new one closes the oldest that has not sent the token, if they are too many.
    """
    strangers: dict[Connection, None] = {}  # the oldest first

    class Connection(H11Protocol):
        _deadline: asyncio.TimerHandle | None = None
        _body_ends = 0.0  # when a body must have come

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            for one in list(strangers)[: len(strangers) + 1 - limits.strangers]:
                one._know_owner()
                if one in strangers:
                    one._end()
            strangers[self] = None
            self._wait()

        def connection_lost(self, exc: Exception | None) -> None:
            self._stop_waiting()
            strangers.pop(self, None)
            super().connection_lost(exc)

        def handle_events(self) -> None:
            before = self.cycle
            super().handle_events()
            if self.cycle is None or self.cycle.response_complete:
                return  # waits for the next request already
            if self.cycle is not before:
                self._body_ends = self.loop.time() + limits.body_seconds
            if self.cycle.more_body:
                self._wait(self._body_ends - self.loop.time())
            else:
                self._stop_waiting()

        def on_response_complete(self) -> None:
            self._know_owner()
            self._wait()  # before the next request, which may be here already
            super().on_response_complete()

        def _know_owner(self) -> None:
            if OWNER in (self.scope or {}):
                strangers.pop(self, None)

        def _wait(self, most: float = limits.header_seconds) -> None:
            self._stop_waiting()
            seconds = min(limits.header_seconds, most)
            self._deadline = self.loop.call_later(seconds, self._end)

        def _stop_waiting(self) -> None:
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None

        def _end(self) -> None:
            """Close at once, also while an answer is sent that is not read."""
            strangers.pop(self, None)
            self.transport.abort()

    return Connection
