"""The server itself, by uvicorn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import uvicorn

from weftex.studio.app import make_app
from weftex.studio.connections import connection_class
from weftex.studio.listening import hosts_of

if TYPE_CHECKING:
    import socket

    from weftex.studio.studio import Studio

_GRACE = 1  # seconds that requests have to end


class Server(uvicorn.Server):
    """A studio that serves at a socket of `listening.listen`, whose address is `host`.

    `run` ends with Ctrl-C or SIGTERM, or once `should_exit` is set; it closes the studio.
    """

    def __init__(self, listener: socket.socket, host: str, studio: Studio) -> None:
        self.listener = listener
        config = uvicorn.Config(
            make_app(studio, hosts_of(host, listener.getsockname()[1])),
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
