"""Routes of jobs, results, exports and endless planes."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any

from starlette.responses import FileResponse, JSONResponse, Response

from weftex.errors import InvalidInputError, shown
from weftex.studio import exports, planes, results
from weftex.studio.jobs import ENDED, Job
from weftex.studio.pictures import Part, whole_number
from weftex.studio.recipes import Recipe
from weftex.studio.refusals import Refusal
from weftex.studio.requests import as_plain
from weftex.studio.routes_start import picture_answer, pixels_answer
from weftex.studio.work import Batch, compared, plain, several

if TYPE_CHECKING:
    from collections.abc import Callable

    from weftex.studio.making import Made
    from weftex.studio.requests import Call

_TICK = 0.02  # seconds between two looks at a job that somebody waits for
_LONGEST_WAIT = 20
_LONGEST_TEXT = 200


async def add_job(call: Call) -> Any:
    """POST /api/jobs: its end, if that comes within so many milliseconds."""
    given = await call.object("recipe", "count", "methods", "lane", "leave")
    within = whole_number(call.query, "within", 0, 0, 1000)
    bench = call.bench
    recipe = Recipe.of(given.get("recipe"))
    recipes = several(recipe, given.get("count"), given.get("methods"))
    for upload in recipe.uploads:
        bench.session.upload(upload)
    first = recipes[0] if given.get("methods") is None else recipe
    await call.work(bench.sized, first)  # what is too large never waits
    work = plain(recipes, bench) if given.get("methods") is None else compared(recipes, bench)
    job = _queued(call, work, given)
    return JSONResponse(await _told(call, job, within / 1000, lambda: job.state in ENDED), 201)


async def add_batch(call: Call) -> Any:
    """POST /api/batches."""
    fields = ("recipe", "materials", "seeds", "keep", "format", "names", "name", "mtlx", "leave")
    given = await call.object(*fields)
    batch = Batch.of(Recipe.of(given.get("recipe")), given)
    for recipes in batch.recipes:
        for upload in recipes[0].uploads:
            call.session.upload(upload)
    job = _queued(call, batch.work(call.bench, call.studio.downloads), given)
    return JSONResponse(as_plain(job.as_json(call.studio.jobs.ahead(job))), 201)


def _queued(call: Call, work: Callable[[Job], None], given: dict[str, Any]) -> Job:
    lane, leave = given.get("lane"), given.get("leave") or "cancel"
    if lane is not None and not (isinstance(lane, str) and 0 < len(lane) <= _LONGEST_TEXT):
        raise InvalidInputError(f"lane is {shown(lane)}; it must be a short text")
    if leave not in ("cancel", "keep"):
        raise InvalidInputError(f"leave is {shown(leave)}; it must be 'cancel' or 'keep'")
    job = Job(call.session, work, lane, leave)
    call.studio.jobs.add(job)
    return job


async def all_jobs(call: Call) -> Any:
    """GET /api/jobs."""
    jobs = call.studio.jobs
    return [job.as_json(jobs.ahead(job)) for job in jobs.of(call.session)]


async def one_job(call: Call) -> Any:
    """GET /api/jobs/ID: at once, or as soon as there is news."""
    job = call.studio.jobs.get(call.part("id"), call.session)
    seen = whole_number(call.query, "seen", 0, 0, 2**31)
    wait = whole_number(call.query, "wait", 0, 0, _LONGEST_WAIT)
    return await _told(call, job, wait, lambda: job.version != seen)


async def _told(call: Call, job: Job, seconds: float, is_news: Callable[[], bool]) -> Any:
    """What the page is told of a job as soon as there is news, or after so many seconds."""
    start = now = time.monotonic()
    while True:
        job.asked, job.wanted = now, True
        if is_news() or now >= start + seconds:
            return as_plain(job.as_json(call.studio.jobs.ahead(job)))
        if await call.request.is_disconnected():
            job.wanted = False
            return {}
        await asyncio.sleep(min(_TICK, (now - start) / 8 + 0.001))  # what is quick is told quickly
        now = time.monotonic()


async def job_preview(call: Call) -> Any:
    """GET /api/jobs/ID/preview."""
    number, shown_last = call.studio.jobs.get(call.part("id"), call.session).picture
    if number == 0:
        raise Refusal(404, "there is no preview yet")
    picture, shape = shown_last
    headers = {"x-weftex-width": str(shape[1]), "x-weftex-height": str(shape[0])}
    return await pixels_answer(call, lambda: picture, headers)


async def end_job(call: Call) -> Any:
    """DELETE /api/jobs/ID."""
    job = call.studio.jobs.get(call.part("id"), call.session)
    call.studio.jobs.remove(job)
    return job.as_json(0)


def _made(call: Call) -> Made:
    return results.result_of(call.part("id"), call.bench)


async def one_result(call: Call) -> Any:
    """GET /api/results/ID."""
    return results.described(_made(call), call.bench)


async def forget_result(call: Call) -> Any:
    """DELETE /api/results/ID."""
    made, own = _made(call), call.session.key
    call.studio.memory.forget(
        lambda key: isinstance(key, tuple) and key[0] == own and made.recipe.id in key
    )
    return {}


async def result_picture(call: Call) -> Any:
    """GET /api/results/ID/picture."""
    made, bench, query = _made(call), call.bench, call.query
    drawing = query.get("draw") or None
    picture = await call.work(results.picture_of, made, query.get("map") or None, drawing, bench)
    return await picture_answer(call, picture.shape[:2], lambda part: part.cut(picture))


async def figures(call: Call) -> Any:
    """GET /api/results/ID/figures."""
    return await call.work(results.figures_of, _made(call), call.bench)


async def fault(call: Call) -> Any:
    """GET /api/results/ID/fault."""
    found = await call.work(results.faults_of, _made(call), call.bench)
    what = call.query.get("what", "seams")
    if what not in found:
        raise Refusal(404, f"there is no such map; known: {', '.join(found)}", "what")
    return await picture_answer(call, found[what].shape[:2], lambda part: part.cut(found[what]))


async def source(call: Call) -> Any:
    """GET /api/results/ID/source: where a pixel comes from."""
    made = _made(call)
    height, width = made.result.shape
    x = whole_number(call.query, "x", 0, 0, width - 1)
    y = whole_number(call.query, "y", 0, 0, height - 1)
    row, column = made.result.layers((y, x, 1, 1))[0][0, 0, 0].tolist()
    return {"x": column, "y": row} if row >= 0 else {"x": None, "y": None}


async def coordinates(call: Call) -> Any:
    """GET /api/results/ID/coordinates."""
    made = _made(call)
    part = Part.of(call.query, made.result.shape)
    window = (part.top, part.left, part.height, part.width)
    packed = await call.work(results.coordinates_of, made, window)
    return Response(packed, media_type="application/octet-stream")


async def export(call: Call) -> Any:
    """POST /api/results/ID/exports."""
    given = await call.object(*exports.FIELDS)
    made = _made(call)
    usual = made.materials[0].name.removeprefix("sample:")
    wanted = exports.Wanted.of(given, usual)
    owner = call.session.key
    return await call.work(exports.export, made, wanted, call.studio.downloads, owner)


async def download(call: Call) -> Any:
    """GET /api/downloads/TICKET."""
    found = call.studio.downloads.get(call.part("ticket"))
    return FileResponse(found.path, media_type="application/octet-stream", filename=found.name)


async def keep(call: Call) -> Any:
    """POST /api/results/ID/keep: its recipe goes to the disk."""
    given = await call.object("title")
    made, shelf = _made(call), call.session.shelf
    title = str(given.get("title") or made.materials[0].name)[:_LONGEST_TEXT]
    entry = {
        "result": made.recipe.id,
        "title": title,
        "recipe": made.recipe.as_json(),
        "time": round(time.time()),
    }
    await call.work(shelf.keep, entry)
    return entry


async def all_kept(call: Call) -> Any:
    """GET /api/kept."""
    return call.session.shelf.kept


async def forget_kept(call: Call) -> Any:
    """DELETE /api/kept/ID."""
    await call.work(call.session.shelf.forget, call.part("id"))
    return {}


async def begin_plane(call: Call) -> Any:
    """POST /api/planes."""
    return await call.work(planes.begin, await call.json(), call.bench)


async def plane_window(call: Call) -> Any:
    """GET /api/planes/ID/window."""
    bench = call.bench
    return await pixels_answer(call, lambda: planes.window(call.part("id"), call.query, bench), {})


ROUTES = [
    ("POST", "/jobs", add_job),
    ("POST", "/batches", add_batch),
    ("GET", "/jobs", all_jobs),
    ("GET", "/jobs/{id}", one_job),
    ("DELETE", "/jobs/{id}", end_job),
    ("GET", "/jobs/{id}/preview", job_preview),
    ("GET", "/results/{id}", one_result),
    ("DELETE", "/results/{id}", forget_result),
    ("GET", "/results/{id}/picture", result_picture),
    ("GET", "/results/{id}/figures", figures),
    ("GET", "/results/{id}/fault", fault),
    ("GET", "/results/{id}/source", source),
    ("GET", "/results/{id}/coordinates", coordinates),
    ("POST", "/results/{id}/exports", export),
    ("POST", "/results/{id}/keep", keep),
    ("GET", "/kept", all_kept),
    ("DELETE", "/kept/{id}", forget_kept),
    ("GET", "/downloads/{ticket}", download),
    ("POST", "/planes", begin_plane),
    ("GET", "/planes/{id}/window", plane_window),
]
