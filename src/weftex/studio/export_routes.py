"""The routes under /api of what is checked and saved: borders, exports, atlases, downloads."""

from __future__ import annotations

from typing import Any

from starlette.responses import FileResponse

from weftex.recipe import ATLAS
from weftex.studio import exports, results
from weftex.studio.jobs import Job
from weftex.studio.requests import Call, route
from weftex.studio.routes import loaded_of, queued, reduced, result_of


async def _source(call: Call) -> exports.Source:
    """The result, or the material as it is, of an address."""
    is_material = call.request.url.path.startswith("/api/materials/")
    return await call.work(
        exports.Source.of, await loaded_of(call) if is_material else result_of(call)
    )


@route("POST", "/materials/{id}/exports")
@route("POST", "/results/{id}/exports")
async def export(call: Call) -> Any:
    """Write files of a result or a material, ready to be downloaded."""
    given = await call.object(*exports.FIELDS)
    found = await _source(call)
    wanted = exports.ExportOptions.of(given, found.stem)
    return await call.work(exports.export, found, wanted, call.studio.downloads, call.session)


@route("GET", "/materials/{id}/borders")
@route("GET", "/results/{id}/borders")
async def borders(call: Call) -> Any:
    """Tell whether a result or a material is tileable, and how it wraps around."""
    found = await _source(call)
    return await call.work(results.borders_of_maps, found.material, found.id, call.session)


@route("GET", "/materials/{id}/borders/picture")
@route("GET", "/results/{id}/borders/picture")
async def borders_picture(call: Call) -> Any:
    """Show the borders of a map, in the middle of the picture."""
    found = await _source(call)
    wanted = found.material, found.id, call.query.get("map", found.material.main), call.session
    return await reduced(call, await call.work(results.drawn_borders, *wanted))


@route("POST", "/materials/{id}/atlases")
@route("POST", "/results/{id}/atlases")
async def add_atlas(call: Call) -> Any:
    """Queue a job that makes an atlas of the sample; it ends the one before it."""
    given, found = await call.object(*ATLAS), await _source(call)
    return await queued(
        call, Job(call.session, None, exports.tiles_of(found, given), "atlas", "cancel")
    )


@route("GET", "/atlases/{id}/picture")
async def atlas_picture(call: Call) -> Any:
    """Show an atlas, or with `plane` a plane of its tiles."""
    tiles = exports.tiles_for(call.id, call.session)
    plane = "plane" in call.query
    return await reduced(call, await call.work(exports.tiles_picture, tiles, plane))


@route("POST", "/atlases/{id}/exports")
async def export_atlas(call: Call) -> Any:
    """Write the files of an atlas, ready to be downloaded."""
    given, tiles = await call.object("name"), exports.tiles_for(call.id, call.session)
    return await call.work(exports.save_tiles, tiles, given, call.studio.downloads, call.session)


@route("POST", "/results/{id}/sample")
async def use_as_sample(call: Call) -> Any:
    """Make a result a material."""
    return await call.work(exports.as_sample, result_of(call), call.studio.downloads, call.session)


@route("GET", "/downloads/{id}")
async def download(call: Call) -> Any:
    """Send a file that is ready."""
    found = call.studio.downloads.get(call.id)
    return FileResponse(found.path, media_type="application/octet-stream", filename=found.name)
