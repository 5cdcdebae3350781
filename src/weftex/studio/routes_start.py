"""Routes of sessions, uploads, materials."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from starlette.responses import FileResponse, JSONResponse, Response

from weftex.errors import InvalidInputError, shown
from weftex.io.pictures import sample_names
from weftex.material import read_material
from weftex.studio import looks, materials
from weftex.studio.about import about
from weftex.studio.answers import answer_of
from weftex.studio.pictures import Part, packed
from weftex.studio.refusals import Refusal
from weftex.studio.uploads import label_of, receive

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    import numpy as np
    from numpy.typing import NDArray

    from weftex.studio.materials import Loaded
    from weftex.studio.requests import Call

_TOLD = ("id", "name", "width", "height", "channels", "dtype", "alpha", "role", "bytes")


async def session(call: Call) -> Any:
    """POST /api/session: begin, or go on."""
    given = await call.object("session")
    studio, limits = call.studio, call.studio.limits
    found, resumed = await call.work(studio.sessions.open, given.get("session"))
    opened = None
    if studio.opened is not None:
        opened = await call.work(studio.opened.give, found, limits)
    known = ("upload_bytes", "upload_pixels", "output_pixels")
    bounds = {name: getattr(limits, name) for name in known} | {"jobs": limits.session_jobs}
    return {
        "session": found.id,
        "resumed": resumed,
        "version": version("weftex"),
        "opened": opened,
        "kept": found.shelf.kept,
        "limits": bounds,
    }


async def leave(call: Call) -> Any:
    """POST /api/leave: the page goes."""
    call.studio.jobs.leave(call.session)
    return {}


async def tell(call: Call) -> Any:
    """GET /api/about."""
    return await call.work(about)


async def sample_picture(call: Call) -> Any:
    """GET /api/samples/NAME/picture: of a bundled sample."""
    name = call.part("name")
    if name not in sample_names():
        raise Refusal(404, "there is no such sample", "sample")
    found = (await call.work(read_material, f"sample:{name}")).exemplar()
    return await picture_answer(call, found.shape, lambda part: part.shown(found))


async def upload(call: Call) -> Any:
    """POST /api/uploads: a picture, as it is."""
    name = label_of(call.request.headers.get("x-weftex-name"))
    length = call.request.headers.get("content-length", "0")
    most = call.studio.limits.upload_bytes
    if not length.isdigit() or int(length) > most:
        line = f"{name} has more than {most / 2**20:g} MiB, the most for one file"
        # Not raised, which closes: browsers show no answer from a line that closes while they send.
        return JSONResponse(answer_of(Refusal(413, line))[1], 413)
    body = call.body()
    try:
        found = await receive(body, name, call.session, call.studio.limits, call.decode)
        return _told(found)
    except Refusal:
        await _drain(body, 2 * most)
        raise


async def _drain(body: AsyncIterator[bytes], most: int) -> None:
    """Read on for a while: browsers show no answer that comes before they have sent all."""
    count = 0
    async for chunk in body:
        count += len(chunk)
        if count > most:
            break


async def all_uploads(call: Call) -> Any:
    """GET /api/uploads."""
    return [_told(one) for one in call.session.shelf.uploads.values()]


async def one_upload(call: Call) -> Any:
    """GET /api/uploads/ID: its bytes."""
    about = call.session.upload(call.part("id"))
    path = call.session.shelf.path(about)
    return FileResponse(path, media_type="application/octet-stream", filename=about["name"])


async def remove_upload(call: Call) -> Any:
    """DELETE /api/uploads/ID."""
    await call.work(call.session.shelf.remove, call.part("id"))
    return {}


async def sets(call: Call) -> Any:
    """POST /api/sets: what was dropped together, sorted."""
    given = (await call.object("uploads")).get("uploads")
    if not isinstance(given, list) or not given:
        raise InvalidInputError(f"uploads is {shown(given)}; it must be a list")
    found = []
    for one in given:
        named = one if isinstance(one, dict) else {"id": one}
        about = call.session.upload(named.get("id"))
        name = label_of(str(named["name"])) if named.get("name") else about["name"]
        found.append(about | {"name": name})
    specs, notes = materials.sets_of(found)
    return {"materials": specs, "notes": notes}


async def material(call: Call) -> Any:
    """POST /api/materials: read one, and say what it is."""
    spec = await call.json()
    bench = call.bench
    loaded = await call.work(bench.load, spec)
    bench.memory.put((bench.session.key, "spec", loaded.id), loaded.spec, 2**10)
    return materials.described(loaded)


async def _loaded(call: Call) -> Loaded:
    """The material of an address."""
    bench = call.bench
    spec = bench.memory.get((bench.session.key, "spec", call.part("id")))
    if spec is None:
        raise Refusal(404, "this material is not here; describe it again")
    return await call.work(bench.load, spec)


async def material_picture(call: Call) -> Any:
    """GET /api/materials/ID/picture."""
    loaded = await _loaded(call)
    main, exemplar = loaded.material.main, loaded.exemplar
    name = call.query.get("map") or main
    if name != main and name not in exemplar.maps:
        raise Refusal(404, "there is no such map", "map")
    one = exemplar if name == main else exemplar.map(name)
    return await picture_answer(call, one.shape, lambda part: part.shown(one))


async def picture_answer(
    call: Call, shape: tuple[int, int], make: Callable[[Part], NDArray[np.uint8]]
) -> Response:
    """Answer with the part of a picture that the query asks for."""
    part = Part.of(call.query, shape)
    headers = {"x-weftex-width": str(shape[1]), "x-weftex-height": str(shape[0])}
    return await pixels_answer(call, lambda: make(part), headers)


async def pixels_answer(
    call: Call, make: Callable[[], NDArray[np.uint8]], headers: dict[str, str]
) -> Response:
    """Answer with a picture for the screen."""
    pixels, kind = await call.work(lambda: packed(make(), call.query))
    return Response(pixels, headers=headers | kind)


async def look(call: Call) -> Any:
    """GET /api/materials/ID/look."""
    return await call.work(looks.look, await _loaded(call), call.bench)


async def lattice(call: Call) -> Any:
    """GET /api/materials/ID/lattice?vectors=."""
    vectors = call.query.get("vectors", "")[:200]
    return await call.work(looks.rate, await _loaded(call), vectors, call.bench)


async def choice(call: Call) -> Any:
    """GET /api/materials/ID/choice."""
    axes = {"": False, "xy": True, "true": True, "x": "x", "y": "y"}
    tileable = axes.get(call.query.get("tileable", ""))
    if tileable is None:
        raise Refusal(400, "tileable must be xy, x or y", "tileable")
    query = {"size": call.size(), "tileable": tileable}
    return await call.work(looks.choose, await _loaded(call), query, call.bench)


def _told(about: dict[str, Any]) -> dict[str, Any]:
    return {name: about[name] for name in _TOLD}


ROUTES = [
    ("POST", "/session", session),
    ("POST", "/leave", leave),
    ("GET", "/about", tell),
    ("GET", "/samples/{name}/picture", sample_picture),
    ("POST", "/uploads", upload),
    ("GET", "/uploads", all_uploads),
    ("GET", "/uploads/{id}", one_upload),
    ("DELETE", "/uploads/{id}", remove_upload),
    ("POST", "/sets", sets),
    ("POST", "/materials", material),
    ("GET", "/materials/{id}/picture", material_picture),
    ("GET", "/materials/{id}/look", look),
    ("GET", "/materials/{id}/lattice", lattice),
    ("GET", "/materials/{id}/choice", choice),
]
