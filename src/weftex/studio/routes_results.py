"""Routes of jobs, results and exports."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any

from starlette.responses import FileResponse

from weftex.errors import InvalidInputError, shown
from weftex.recipe import Recipe
from weftex.studio import exports, results
from weftex.studio.jobs import ENDED, Job
from weftex.studio.making import open_job
from weftex.studio.pictures import smaller, source_of, times_smaller, whole_number
from weftex.studio.refusals import Refusal
from weftex.studio.requests import route
from weftex.studio.work import Batch, compared, plain, several

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray
    from starlette.responses import Response

    from weftex.studio.making import Made
    from weftex.studio.requests import Call

_TICK = 0.02  # seconds between two looks at a job that somebody waits for
_LONGEST_WAIT = 20
_LONGEST_TEXT = 200


@route("POST", "/jobs")
async def add_job(call: Call) -> Any:
    """Queue a job; its end, if that comes within so many milliseconds."""
    given = await call.object("recipe", "count", "methods", "lane", "leave")
    within = whole_number(call.query, "within", 0, 0, 1000)
    recipe = Recipe.from_json(given.get("recipe"))
    recipes = several(recipe, given.get("count"), given.get("methods"))
    await call.work(open_job, recipe, call.session)  # what is too large never waits
    work = plain(recipes) if given.get("methods") is None else compared(recipes)
    job = _queued(call, work, given, recipe)
    return await _told(call, job, within / 1000, lambda: job.state in ENDED)


@route("POST", "/batches")
async def add_batch(call: Call) -> Any:
    """Queue a batch."""
    fields = ("recipe", "materials", "seeds", "keep", "format", "names", "mtlx", "leave")
    given = await call.object(*fields)
    batch = Batch.of(Recipe.from_json(given.get("recipe")), given)
    for recipes in batch.recipes:
        for upload in recipes[0].pictures:
            call.session.upload(upload)
    job = _queued(call, batch.work(call.studio.downloads), given, None)
    return job.as_json(call.studio.jobs.ahead(job))


def _queued(
    call: Call, work: Callable[[Job], None], given: dict[str, Any], recipe: Recipe | None
) -> Job:
    lane, leave = given.get("lane"), given.get("leave") or "cancel"
    if lane is not None and not (isinstance(lane, str) and 0 < len(lane) <= _LONGEST_TEXT):
        raise InvalidInputError(f"lane is {shown(lane)}; it must be a short text")
    if leave not in ("cancel", "keep"):
        raise InvalidInputError(f"leave is {shown(leave)}; it must be 'cancel' or 'keep'")
    job = Job(call.session, work, lane, leave)
    if recipe is not None:
        job.more["recipe"] = recipe.as_json()
    call.studio.jobs.add(job)
    return job


@route("GET", "/jobs")
async def all_jobs(call: Call) -> Any:
    """Tell of all jobs of the session."""
    jobs = call.studio.jobs
    return [job.as_json(jobs.ahead(job)) for job in jobs.of(call.session)]


@route("GET", "/jobs/{id}")
async def one_job(call: Call) -> Any:
    """Tell of a job: at once, or as soon as there is news."""
    job = call.studio.jobs.get(call.id, call.session)
    seen = whole_number(call.query, "seen", 0, 0, 2**31)
    wait = whole_number(call.query, "wait", 0, 0, _LONGEST_WAIT)
    return await _told(call, job, wait, lambda: job.version != seen)


async def _told(call: Call, job: Job, seconds: float, is_news: Callable[[], bool]) -> Any:
    """What the page is told of a job as soon as there is news, or after so many seconds."""
    start = now = time.monotonic()
    while True:
        job.asked, job.wanted = now, True
        if is_news() or now >= start + seconds:
            return job.as_json(call.studio.jobs.ahead(job))
        if await call.request.is_disconnected():
            job.wanted = False
            return {}
        await asyncio.sleep(min(_TICK, (now - start) / 8 + 0.001))  # what is quick is told quickly
        now = time.monotonic()


@route("GET", "/jobs/{id}/preview")
async def job_preview(call: Call) -> Any:
    """Show what a job has made so far."""
    number, shown_last = call.studio.jobs.get(call.id, call.session).picture
    if number == 0:
        raise Refusal(404, "there is no preview yet")
    picture, shape = shown_last
    return await call.picture(lambda: picture, shape)


@route("DELETE", "/jobs/{id}")
async def end_job(call: Call) -> Any:
    """Cancel a job."""
    job = call.studio.jobs.get(call.id, call.session)
    job.cancel()
    return job.as_json(0)


def _made(call: Call) -> Made:
    return results.result_of(call.id, call.session)


@route("GET", "/results/{id}/picture")
async def result_picture(call: Call) -> Any:
    """Show a map of a result, or a drawing of where its pixels come from."""
    wanted = call.query.get("map") or None, call.query.get("draw") or None
    return await _shown(
        call, await call.work(results.picture_of, _made(call), *wanted, call.session)
    )


@route("GET", "/results/{id}/figures")
async def figures(call: Call) -> Any:
    """Tell how good a result is."""
    return await call.work(results.figures_of, _made(call), call.session)


@route("GET", "/results/{id}/seams")
async def seams(call: Call) -> Any:
    """Show where a result has seams."""
    return await _shown(call, await call.work(results.seams_of, _made(call), call.session))


async def _shown(call: Call, picture: NDArray[np.uint8]) -> Response:
    times = times_smaller(call.query, picture.shape)
    return await call.picture(lambda: smaller(picture, times), picture.shape)


@route("GET", "/results/{id}/source")
async def source(call: Call) -> Any:
    """Tell where a pixel comes from."""
    row, column = source_of(_made(call).result, call.query)
    return {"x": column, "y": row} if row >= 0 else {"x": None, "y": None}


@route("POST", "/results/{id}/exports")
async def export(call: Call) -> Any:
    """Write files of a result, ready to be downloaded."""
    given = await call.object(*exports.FIELDS)
    made = _made(call)
    wanted = exports.Wanted.of(given, made.name)
    return await call.work(exports.export, made, wanted, call.studio.downloads, call.session.key)


@route("GET", "/downloads/{id}")
async def download(call: Call) -> Any:
    """Send a file that is ready."""
    found = call.studio.downloads.get(call.id)
    return FileResponse(found.path, media_type="application/octet-stream", filename=found.name)


@route("POST", "/results/{id}/keep")
async def keep(call: Call) -> Any:
    """Write the recipe of a result to the disk."""
    given = await call.object("title")
    made = _made(call)
    title = str(given.get("title") or made.name)[:_LONGEST_TEXT]
    entry = {
        "result": made.id,
        "title": title,
        "recipe": made.recipe.as_json(),
        "time": round(time.time()),
    }
    await call.work(call.session.keep, entry)
    return entry
