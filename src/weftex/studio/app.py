"""The server's application: routes, errors as one line, and work beside requests."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Collection
from contextlib import asynccontextmanager, suppress
from functools import cache
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route, Router
from starlette.types import ASGIApp, Receive, Scope, Send

from weftex.errors import WeftexError
from weftex.studio.guard import Guard
from weftex.studio.refusals import answer_of
from weftex.studio.requests import ROUTES, Call, Handler, as_plain
from weftex.studio.studio import Studio

_SWEEP = 1.0  # seconds
_MARK = 60  # sweeps between two marks of the folders in use
_PAUSE = 0.004  # seconds between two imports, in which files of the page are sent
#: Imported one after the other while the page loads; a thread would delay the page's files more.
_MODULES = (
    *("weftex.exemplar", "weftex.recipe.opening", "weftex.quality", "weftex.analysis.overlay"),
    "weftex.studio.routes",
    "weftex.studio.exports",
)
_PAGE = "index.html"
#: Of the files of the page.
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}
_log = logging.getLogger(__name__)


def make_app(studio: Studio, hosts: Collection[str]) -> ASGIApp:
    """Return the application."""

    async def page(request: Request) -> Response:
        name = request.path_params.get("name", _PAGE)
        if name not in static_files():  # looked up, never a path
            raise HTTPException(404)
        place, kind = static_files()[name]
        return Response(place.read_bytes(), media_type=kind)

    async def nothing(request: Request, error: HTTPException) -> Response:
        line = {"error": "there is nothing at this address", "parameter": None}
        return JSONResponse(line, error.status_code)

    loading: list[asyncio.Task[Router]] = []  # what begins with the server

    async def api(scope: Scope, receive: Receive, send: Send) -> None:
        await (await asyncio.shield(loading[0]))(scope, receive, send)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        loading.append(asyncio.create_task(_routes(studio)))
        sweeping = asyncio.create_task(_sweep(studio))
        yield
        sweeping.cancel()
        with suppress(asyncio.CancelledError):
            await sweeping
        studio.close()

    routes = [Route("/", page), Route("/static/{name:path}", page), Mount("/api", api)]
    own: Any = {HTTPException: nothing}
    app = Starlette(routes=routes, lifespan=lifespan, exception_handlers=own)
    return Guard(app, token=studio.token, hosts=hosts)


async def _routes(studio: Studio) -> Router:
    """Return the routes under /api, which need most of weftex."""
    for module in _MODULES:
        await asyncio.sleep(_PAUSE)
        import_module(module)

    def endpoint(handler: Handler) -> Callable[[Request], Awaitable[Response]]:
        async def answer(request: Request) -> Response:
            try:
                found = await handler(Call(request, studio))
            except ClientDisconnect:
                return Response(status_code=400)
            except Exception as error:
                if not isinstance(error, (WeftexError, MemoryError)):
                    _log.exception("a request failed")
                status, line = answer_of(error)
                # What is too large need not come to its end; the line is not used again.
                close = {"connection": "close"} if status == 413 else None
                return JSONResponse(line, status, headers=close)
            return found if isinstance(found, Response) else JSONResponse(as_plain(found))

        return answer

    routes = [Route(path, endpoint(handler), methods=[method]) for method, path, handler in ROUTES]
    return Router(routes)


@cache
def static_files() -> dict[str, tuple[Path, str]]:
    """Return every file and its type by its name, with slashes."""
    folder = Path(__file__).with_name("static")
    known = (file for file in folder.rglob("*.*") if file.suffix in _TYPES)
    return {file.relative_to(folder).as_posix(): (file, _TYPES[file.suffix]) for file in known}


async def _sweep(studio: Studio) -> None:
    for second in count():
        if second % _MARK == 0:
            studio.mark_used()
        await asyncio.sleep(_SWEEP)
        studio.jobs.sweep()
