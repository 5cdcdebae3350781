"""Routes of sessions, uploads, materials and endless planes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from starlette.responses import FileResponse, JSONResponse

import weftex
from weftex.errors import InvalidInputError, shown
from weftex.io.pictures import sample_names
from weftex.studio import looks, materials, planes
from weftex.studio.about import about
from weftex.studio.materials import id_of, map_of
from weftex.studio.pictures import shown_smaller, smaller, times_smaller
from weftex.studio.refusals import Refusal, answer_of
from weftex.studio.requests import route
from weftex.studio.uploads import Coming, label_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.responses import Response

    from weftex import Exemplar
    from weftex.recipe.making import Loaded
    from weftex.studio.requests import Call


@route("POST", "/session")
async def session(call: Call) -> Any:
    """Begin, or go on with the session that the page names."""
    given = await call.object("session")
    studio, limits = call.studio, call.studio.limits
    found, resumed = await call.work(studio.sessions.open, given.get("session"))
    opened = None
    if studio.opened is not None:
        opened = await call.work(studio.opened.give, found)
    return {
        "session": found.id,
        "resumed": resumed,
        "opened": opened,
        "kept": found.kept,
        "limits": {"upload_bytes": limits.upload_bytes},
    }


@route("POST", "/leave")
async def leave(call: Call) -> Any:
    """End the jobs that end with their page."""
    call.studio.jobs.end(call.session, kept=False)
    return {}


@route("GET", "/about")
async def tell(call: Call) -> Any:
    """Tell the page what there is."""
    return await call.work(about)


@route("GET", "/samples/{id}/picture")
async def sample_picture(call: Call) -> Any:
    """Show a bundled sample."""
    if call.id not in sample_names():
        raise Refusal(404, "there is no such sample", "sample")
    return await _shown(call, await call.work(weftex.load_exemplar, f"sample:{call.id}"))


@route("POST", "/uploads")
async def upload(call: Call) -> Any:
    """Take a picture in, as it is."""
    name = label_of(call.request.headers.get("x-weftex-name"))
    length = call.request.headers.get("content-length", "0")
    most = call.studio.limits.upload_bytes
    if not length.isdigit() or int(length) > most:
        line = f"{name} has more than {most / 2**20:g} MiB, the most for one file"
        # Not raised, which closes: browsers show no answer from a line that closes while they send.
        return JSONResponse(answer_of(Refusal(413, line))[1], 413)
    body = call.request.stream()
    try:
        with Coming(name, call.session) as coming:
            async for chunk in body:
                coming.write(chunk)
            found = await call.decode(coming.finish)
    except Refusal:
        await _drain(body, 2 * most)
        raise
    return {key: found[key] for key in ("id", "name", "bytes")}


async def _drain(body: AsyncIterator[bytes], most: int) -> None:
    """Read on for a while: browsers show no answer that comes before they have sent all."""
    count = 0
    async for chunk in body:
        count += len(chunk)
        if count > most:
            break


@route("GET", "/uploads/{id}")
async def one_upload(call: Call) -> Any:
    """Send the bytes of an upload."""
    about = call.session.upload(call.id)
    path = call.session.path(about)
    return FileResponse(path, media_type="application/octet-stream", filename=about["name"])


@route("POST", "/sets")
async def sets(call: Call) -> Any:
    """Sort what was dropped together."""
    given = (await call.object("uploads")).get("uploads")
    if not isinstance(given, list) or not given:
        raise InvalidInputError(f"uploads is {shown(given)}; it must be a list")
    specs, notes = materials.sets_of([call.session.upload(one) for one in given])
    return {"materials": specs, "notes": notes}


@route("POST", "/materials")
async def material(call: Call) -> Any:
    """Read a material, and say what it is."""
    spec, session = await call.json(), call.session
    loaded = await call.work(materials.load, spec, session)
    session.remember(loaded.spec, 2**10, "spec", id_of(loaded.spec))
    return materials.described(loaded)


async def _loaded(call: Call) -> Loaded:
    """The material of an address."""
    spec = call.session.recall("spec", call.id)
    if spec is None:
        raise Refusal(404, "this material is not here; describe it again")
    return await call.work(materials.load, spec, call.session)


@route("GET", "/materials/{id}/picture")
async def material_picture(call: Call) -> Any:
    """Show a map of a material."""
    loaded = await _loaded(call)
    return await _shown(call, map_of(loaded.exemplar, loaded.material.main, call.query.get("map")))


async def _shown(call: Call, sample: Exemplar) -> Response:
    times = times_smaller(call.query, sample.shape)
    return await call.picture(lambda: shown_smaller(sample, times), sample.shape)


@route("GET", "/materials/{id}/look")
async def look(call: Call) -> Any:
    """Say what a material is like."""
    return await call.work(looks.look, await _loaded(call), call.session)


@route("GET", "/materials/{id}/lattice")
async def lattice(call: Call) -> Any:
    """Say how good a lattice is that somebody drew."""
    vectors = call.query.get("vectors", "")[:200]
    return await call.work(looks.rate, await _loaded(call), vectors, call.session)


@route("POST", "/planes")
async def begin_plane(call: Call) -> Any:
    """Fit a method for an endless plane."""
    return await call.work(planes.begin, await call.json(), call.session)


@route("GET", "/planes/{id}/window")
async def plane_window(call: Call) -> Any:
    """Show a window of an endless plane."""
    made = await call.work(planes.window, call.id, call.query, call.session)
    times = times_smaller(call.query, made.shape)
    return await call.picture(lambda: smaller(made, times), made.shape)
