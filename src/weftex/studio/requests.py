"""A request as the routes see it: its session, its body, work that is done in threads."""

from __future__ import annotations

import json
import math
from collections.abc import Awaitable, Callable, Sequence
from typing import Any, TypeVar

from anyio import to_thread
from starlette.requests import Request
from starlette.responses import Response

from weftex.studio.pictures import Bytes, packed
from weftex.studio.refusals import Refusal
from weftex.studio.sessions import Session
from weftex.studio.studio import Studio

Result = TypeVar("Result")
Handler = Callable[["Call"], Awaitable[Any]]

SESSION = "x-weftex-session"
#: All routes under /api: method, path, and what answers.
ROUTES: list[tuple[str, str, Handler]] = []


def route(method: str, path: str) -> Callable[[Handler], Handler]:
    """Add a function of a `Call` to the routes; it returns a `Response` or what JSON can say."""

    def add(handler: Handler) -> Handler:
        ROUTES.append((method, path, handler))
        return handler

    return add


class Call:
    """One request."""

    def __init__(self, request: Request, studio: Studio) -> None:
        self.request, self.studio = request, studio
        self.query = request.query_params

    @property
    def session(self) -> Session:
        """The session that the page says it is; it alone knows its secret."""
        return self.studio.session(self.request.headers.get(SESSION))

    @property
    def id(self) -> str:
        """The part of the address that names something."""
        return str(self.request.path_params["id"])

    async def json(self) -> Any:
        """Return the body's JSON, of which no more is read than is allowed, or raise `Refusal`."""
        text, most = bytearray(), self.studio.limits.body_bytes
        async for chunk in self.request.stream():
            text += chunk
            if len(text) > most:
                raise Refusal(413, f"the request has more than {most} bytes")
        try:
            found = json.loads(bytes(text) or b"{}", parse_constant=_no_number)
            json.dumps(found, ensure_ascii=False).encode()  # no surrogate stands by itself
        except ValueError:
            raise Refusal(400, "the request is not JSON") from None
        return found

    async def object(self, *known: str) -> dict[str, Any]:
        """Return the body's JSON object, of which only these fields are known."""
        found = await self.json()
        if not isinstance(found, dict):
            raise Refusal(400, "the request must be an object")
        for name in found:
            if name not in known:
                raise Refusal(400, f"the request has an unknown field; known: {', '.join(known)}")
        return found

    async def work(self, function: Callable[..., Result], *values: Any) -> Result:
        """Call something that takes a while in a thread; only some run at a time."""
        return await to_thread.run_sync(function, *values, limiter=self.studio.limiter)

    async def picture(self, make: Callable[[], Bytes], shape: tuple[int, ...]) -> Response:
        """Answer with a picture for the screen, which may be smaller than what it stands for."""
        pixels, kind = await self.work(lambda: packed(make(), self.query))
        headers = {"x-weftex-width": str(shape[1]), "x-weftex-height": str(shape[0])}
        return Response(pixels, headers=headers | kind)


def as_plain(value: Any) -> Any:
    """Return a value as JSON has it: no tuples, no numbers of NumPy, null for what is no number."""
    if isinstance(value, dict):
        return {str(key): as_plain(one) for key, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_plain(one) for one in value]
    if hasattr(value, "tolist"):
        value = value.tolist()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _no_number(name: str) -> Any:
    raise ValueError(name)
