"""The server: its socket and address, which are there first, and its connections, by uvicorn.

A browser that is told the address waits for the answer, so it can start while uvicorn is imported.
"""

from __future__ import annotations

import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from weftex.errors import FileError
from weftex.studio.downloads import Downloads
from weftex.studio.limits import Limits

if TYPE_CHECKING:
    import asyncio

    import uvicorn

    from weftex.studio.studio import Studio

#: Tried first, so that a page that is open finds the server again after a restart.
PORT = 8427
_HOST = "127.0.0.1"  # nothing but this machine
_GRACE = 1  # seconds that requests have to end


def listen(port: int | None) -> socket.socket:
    """Return a socket that listens to this machine; a `port` of None is `PORT`, or any free one.

    Raises `FileError` if it cannot.
    """
    try:
        return socket.create_server((_HOST, PORT if port is None else port), backlog=128)
    except OSError as error:
        if port is None:
            return listen(0)
        why = os.strerror(error.errno or 0)
        raise FileError(f"cannot listen at {_HOST}:{port}: {why}") from None


def hosts_of(port: int) -> set[str]:
    """Return what the Host header of a request may be."""
    names = {_HOST, "localhost"}
    return {f"{name}:{port}" for name in names} | (names if port == 80 else set())


def address_of(listener: socket.socket, token: str) -> str:
    """Return what is to be opened in a browser."""
    return f"http://{_HOST}:{listener.getsockname()[1]}/#token={token}"


@contextmanager
def redirect_file(address: str, downloads: Downloads) -> Iterator[Path]:
    """Yield a page, for its owner alone, that leads to the address; it is removed afterwards."""
    text = '<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
    text += f'<title>weftex</title><meta http-equiv="refresh" content="0; url={address}">'
    with tempfile.TemporaryDirectory(dir=downloads.folder, ignore_cleanup_errors=True) as folder:
        file = Path(folder) / "open.html"
        file.touch(mode=0o600)
        file.write_text(text, "utf-8")
        yield file


def server_of(listener: socket.socket, studio: Studio) -> uvicorn.Server:
    """Return a server of a studio; `run([listener])` ends with Ctrl-C, and closes the studio."""
    import uvicorn

    from weftex.studio.app import make_app

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
    return uvicorn.Server(config)


def connection_class(limits: Limits) -> type[asyncio.Protocol]:
    """Return the class of a server's connections, which know each other.

    A connection is closed `header_seconds` after it began, or after its last answer, if no headers
    have come; while a body comes, `header_seconds` after its last bytes, and `body_seconds` after
    its headers. A new one closes the oldest that has not sent the token, if they are too many.
    """
    from uvicorn.protocols.http.h11_impl import H11Protocol

    from weftex.studio.guard import OWNER

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
