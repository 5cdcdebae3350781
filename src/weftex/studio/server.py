"""Starting and stopping the server."""

from __future__ import annotations

import socket
import threading
from typing import TYPE_CHECKING, Any

import uvicorn

from weftex.errors import FileError
from weftex.studio.app import make_app

if TYPE_CHECKING:
    from collections.abc import Callable

    from weftex.studio.studio import Studio

#: Tried first, so that a page that is open finds the server again after a restart.
PORT = 8427
LOOPBACK = ("127.0.0.1", "localhost", "::1")
_GRACE = 1  # seconds that requests have to end


def listen(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens.

    Parameters
    ----------
    host : str
    port : int or None
        None takes `PORT`, or any other that is free.

    Raises
    ------
    FileError
        If it cannot.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    tried = [PORT, 0] if port is None else [port]
    for one in tried:
        found = socket.socket(family, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((host, one))
            found.listen(128)
        except (OSError, OverflowError) as error:
            found.close()
            if one == tried[-1]:
                why = getattr(error, "strerror", None) or error
                raise FileError(f"cannot listen at {host}:{one}: {why}") from None
        else:
            return found
    raise AssertionError


def hosts_of(host: str, port: int) -> set[str]:
    """Return what the Host header of a request may be.

    Examples
    --------
    >>> sorted(hosts_of("127.0.0.1", 8427))
    ['127.0.0.1:8427', '[::1]:8427', 'localhost:8427']
    """
    names = {*LOOPBACK, host} - {"0.0.0.0", "::"}
    if host in ("0.0.0.0", "::"):
        names |= {socket.gethostname(), *_addresses()}
    named = {f"[{name}]" if ":" in name else name for name in names}
    return {f"{name}:{port}" for name in named} | (named if port == 80 else set())


def _addresses() -> set[str]:
    try:
        return {str(one[4][0]) for one in socket.getaddrinfo(socket.gethostname(), None)}
    except OSError:
        return set()


class Server(uvicorn.Server):
    """A studio that serves; `run` ends with Ctrl-C or SIGTERM, or once `should_exit` is set.

    Parameters
    ----------
    listener : socket
        From `listen`.
    host : str
        Its address.
    studio : Studio
        It is closed in the end.
    ready : callable
        Called with the address to open, in a thread, once the server answers.

    Attributes
    ----------
    address : str
        To be opened; with the token.
    """

    def __init__(
        self, listener: socket.socket, host: str, studio: Studio, ready: Callable[[str], None]
    ) -> None:
        self.listener, self.ready = listener, ready
        port = listener.getsockname()[1]
        shown = "127.0.0.1" if host in ("0.0.0.0", "::", "localhost") else host
        shown = f"[{shown}]" if ":" in shown else shown
        self.address = f"http://{shown}:{port}/#token={studio.token}"
        config = uvicorn.Config(
            make_app(studio, hosts_of(host, port)),
            loop="asyncio",
            http="h11",
            ws="none",
            lifespan="on",
            log_level="error",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            limit_concurrency=studio.limits.requests,
            timeout_graceful_shutdown=_GRACE,
        )
        super().__init__(config)

    async def startup(self, sockets: Any = None) -> None:
        """Begin to answer, and say so."""
        await super().startup([self.listener])
        threading.Thread(target=self.ready, args=(self.address,), daemon=True).start()
