"""Refuse requests that do not come from the page of this start of the studio.

A page of another site can send requests to 127.0.0.1, and by DNS rebinding even under a name of its
own. So the Host must be one of ours, an Origin must be ours (a frame without one says ``null``),
what changes anything must have one, and the API wants a token that only the opened address had.
"""

from __future__ import annotations

import hmac
from collections.abc import Collection
from typing import Any

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: What browsers are told about every answer.
HEADERS = {
    "content-security-policy": (
        "default-src 'self'; img-src 'self' blob:; object-src 'none'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
TOKEN = "x-weftex-token"
#: In the scope of a request that has the token.
OWNER = "studio.owner"
_SAFE = ("GET", "HEAD")
_METHODS = (*_SAFE, "POST", "DELETE")
#: What needs no token: it is a random name that is given once, see `weftex.studio.downloads`.
_TICKETS = "/api/downloads/"


class Guard:
    """Let requests through that come from the page, and put safety headers on every answer.

    `hosts` are the values that the Host header may have, ports included. The scopes of requests
    with the token get the key `OWNER`.
    """

    def __init__(self, app: ASGIApp, *, token: str, hosts: Collection[str]) -> None:
        self.app, self.token = app, token
        self.hosts = {host.lower() for host in hosts}
        self.origins = {f"http://{host}" for host in self.hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or pass on."""
        if scope["type"] != "http":  # the server's own start and end
            await self.app(scope, receive, send)
            return

        async def answer(message: Message) -> None:
            if message["type"] == "http.response.start":
                own = [(name.encode(), value.encode()) for name, value in HEADERS.items()]
                given = {name.lower() for name, _ in message["headers"]}
                message["headers"] += [pair for pair in own if pair[0] not in given]
            await send(message)

        app, refused = self.app, self.refuse(scope)
        if refused is not None:
            app = JSONResponse({"error": refused[1], "parameter": None}, refused[0])
        await app(scope, receive, answer)

    def refuse(self, scope: Scope) -> tuple[int, str] | None:
        """Return the status and the reason, or None for a request that is let through."""
        method, path = scope["method"], scope["path"]
        host, origin, site = (_only(scope, name) for name in ("host", "origin", "sec-fetch-site"))
        if host is None or host.lower() not in self.hosts:
            return 403, "this Host is not the studio's"
        if method not in _METHODS:
            return 405, f"{method} is not known here"
        if origin is not None and origin.lower() not in self.origins:
            return 403, "this Origin is not the studio's"
        if origin is None and method not in _SAFE:
            return 403, "an Origin is needed for what changes anything"
        if not path.startswith("/api/"):
            return None
        if site not in (None, "same-origin", "none"):
            return 403, "another site may not ask for this"
        if path.startswith(_TICKETS) and method in _SAFE:
            return None
        token = _only(scope, TOKEN) or ""
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return 401, "the token is missing or of another start of the studio; open its address"
        scope[OWNER] = True
        return None


def _only(scope: Scope, name: str) -> str | None:
    """A header; of several something that nothing is equal to."""
    found: list[Any] = [value for key, value in scope["headers"] if key.lower() == name.encode()]
    if not found:
        return None
    return found[0].decode("latin-1") if len(found) == 1 else "several"
