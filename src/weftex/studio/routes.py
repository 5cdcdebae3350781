"""The routes under /api: sessions, uploads, materials, planes, jobs and results."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from anyio import to_thread
from starlette.responses import FileResponse, JSONResponse, Response

import weftex
from weftex import Exemplar
from weftex.errors import InvalidInputError, shown, wrong_value
from weftex.io.pictures import sample_names
from weftex.recipe import Recipe
from weftex.recipe.opening import PreparedMaterial
from weftex.studio import materials, results, works
from weftex.studio.about import about
from weftex.studio.jobs import ENDED, Job, Work
from weftex.studio.materials import id_of, map_of
from weftex.studio.pictures import Bytes, shown_smaller, smaller, times_smaller, whole_number
from weftex.studio.refusals import Refusal, answer_of
from weftex.studio.requests import Call, route
from weftex.studio.results import Result
from weftex.studio.sessions import path_of
from weftex.studio.synthesis import begin_plane, make_each, open_job, plane_window
from weftex.studio.uploads import IncomingUpload, label_of


@route("POST", "/session")
async def session(call: Call) -> Any:
    """Begin, or go on with the session that the page names."""
    given = await call.object("session")
    studio, limits = call.studio, call.studio.limits
    found, resumed = await call.work(studio.open_session, given.get("session"))
    return {
        "session": found.id,
        "resumed": resumed,
        "opened": studio.opened and await call.work(studio.opened.give, found),
        "steps": found.steps,
        "limits": {"upload_bytes": limits.upload_bytes},
    }


@route("POST", "/leave")
async def leave(call: Call) -> Any:
    """End the jobs that end with their page."""
    session = call.session
    call.studio.jobs.end(session, kept=False)
    session.left = not any(job.state not in ENDED for job in call.studio.jobs.of(session))
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
        line = f"{name} is larger than {most / 2**20:g} MiB, the limit for one file"
        # Not raised, which closes: browsers show no answer from a line that closes while they send.
        return JSONResponse(answer_of(Refusal(413, line))[1], 413)
    body = call.request.stream()
    try:
        with IncomingUpload(name, call.session) as coming:
            async for chunk in body:
                coming.write(chunk)
            # Uploads wait here, and leave the threads of other work free.
            found = await to_thread.run_sync(coming.finish, limiter=call.studio.decoding)
    except Refusal:
        # Read on for a while: browsers show no answer that comes before they have sent all.
        left = 2 * most
        async for chunk in body:
            left -= len(chunk)
            if left < 0:
                break
        raise
    return {key: found[key] for key in ("id", "name", "bytes")}


@route("GET", "/uploads/{id}")
async def one_upload(call: Call) -> Any:
    """Send the bytes of an upload."""
    about = call.session.upload(call.id)
    path = path_of(call.session.folder, about)
    return FileResponse(path, media_type="application/octet-stream", filename=about["name"])


@route("POST", "/sets")
async def sets(call: Call) -> Any:
    """Sort what was dropped together."""
    given = (await call.object("uploads")).get("uploads")
    if not isinstance(given, list) or not given:
        raise wrong_value("uploads", given, "a list")
    specs, notes = materials.sets_of([call.session.upload(one) for one in given])
    return {"materials": specs, "notes": notes}


@route("POST", "/materials")
async def material(call: Call) -> Any:
    """Read a material, and say what it is."""
    spec, session = await call.json(), call.session
    loaded = await call.work(materials.load_material, spec, session)
    session.remember(loaded.spec, 2**10, "spec", id_of(loaded.spec))
    return materials.described(loaded)


async def loaded_of(call: Call) -> PreparedMaterial:
    """The material of an address."""
    gone = Refusal(404, "this material is no longer in memory; open it again")
    spec = call.session.recall("spec", call.id, gone=gone)
    return await call.work(materials.load_material, spec, call.session)


@route("GET", "/materials/{id}/picture")
async def material_picture(call: Call) -> Any:
    """Show a map of a material."""
    loaded = await loaded_of(call)
    return await _shown(call, map_of(loaded.exemplar, loaded.material.main, call.query.get("map")))


async def _shown(call: Call, sample: Exemplar) -> Response:
    times = times_smaller(call.query, sample.shape)
    return await call.picture(lambda: shown_smaller(sample, times), sample.shape)


@route("POST", "/materials/{id}/look")
async def look(call: Call) -> Any:
    """Queue a job that says what a material is like; it ends an analysis that is under way."""
    return await found(call, "look", materials.analysis_of, await loaded_of(call), call.session)


@route("GET", "/materials/{id}/lattice")
async def lattice(call: Call) -> Any:
    """Say how good a lattice is that somebody drew."""
    vectors = call.query.get("vectors", "")[:200]
    return await call.work(materials.rate_lattice, await loaded_of(call), vectors, call.session)


@route("POST", "/planes")
async def add_plane(call: Call) -> Any:
    """Fit a method for an endless plane."""
    return await call.work(begin_plane, await call.json(), call.session)


@route("GET", "/planes/{id}/window")
async def show_window(call: Call) -> Any:
    """Show a window of an endless plane."""
    return await reduced(call, await call.work(plane_window, call.id, call.query, call.session))


_TICK = 0.02  # seconds between two looks at a job that somebody waits for
_LONGEST_WAIT = 20
_MOST = 16  # recipes of a job


@route("POST", "/jobs")
async def add_job(call: Call) -> Any:
    """Queue a job that makes something."""
    given = await call.object("recipe", "each", "compare", "lane", "keep")
    recipe, each = Recipe.from_json(given.get("recipe")), given.get("each") or [{}]
    are_changes = isinstance(each, list) and all(isinstance(one, dict) for one in each)
    if not are_changes or len(each) > _MOST:
        raise InvalidInputError(f"each is {shown(each)}; it must list at most {_MOST} changes")
    recipes = [Recipe.from_json({**recipe.as_json(), **changes}) for changes in each]
    await call.work(open_job, recipe, call.session)  # what is too large never waits
    work, keep = make_each(recipes, bool(given.get("compare"))), bool(given.get("keep"))
    return await queued(call, work, given.get("lane"), recipe=recipe, keep=keep)


async def queued(call: Call, work: Work, lane: Any, **how: Any) -> Any:
    """Queue a `Job`, wait for its end up to `within` milliseconds, and return its state."""
    within = whole_number(call.query, "within", 0, 0, 1000)
    job = Job(call.session, work, lane, **how)
    call.studio.jobs.add(job)
    return await _told(call, job, within / 1000, lambda: job.state in ENDED)


async def found(call: Call, lane: str | None, function: Callable[..., Any], *given: Any) -> Any:
    """Queue a job whose only result is what a function returns."""
    return await queued(call, lambda job: job.add(function(*given)), lane)


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


def result_of(call: Call) -> Result:
    """Return the result of an address."""
    gone = Refusal(410, "this result is no longer in memory; make it again by its recipe")
    made: Result = call.session.recall("result", call.id, gone=gone)
    return made


@route("GET", "/results/{id}/picture")
async def result_picture(call: Call) -> Any:
    """Show a map of a result, or a drawing of where its pixels come from."""
    wanted = call.query.get("map") or None, call.query.get("draw") or None
    picture = await call.work(results.picture_of, result_of(call), *wanted, call.session)
    return await reduced(call, picture)


@route("POST", "/results/{id}/figures")
async def figures(call: Call) -> Any:
    """Queue a job that says how good a result is; it ends one that is under way."""
    return await found(call, "figures", results.figures_of, result_of(call), call.session)


@route("GET", "/results/{id}/broken")
async def broken(call: Call) -> Any:
    """Show where a result has broken features."""
    return await reduced(call, await call.work(results.broken_of, result_of(call), call.session))


async def reduced(call: Call, picture: Bytes) -> Response:
    """Answer with a picture of at most the size that the page asks for."""
    times = times_smaller(call.query, picture.shape)
    return await call.picture(lambda: smaller(picture, times), picture.shape)


@route("GET", "/results/{id}/source")
async def source(call: Call) -> Any:
    """Tell where a pixel comes from."""
    made = result_of(call).result
    x, y = (whole_number(call.query, k, 0, 0, made.shape["yx".index(k)] - 1) for k in "xy")
    row, column = made.layers((y, x, 1, 1))[0][0, 0, 0].tolist()
    return {"x": column, "y": row} if row >= 0 else {"x": None, "y": None}


@route("GET", "/downloads/{id}")
async def download(call: Call) -> Any:
    """Send a file that is ready."""
    found = call.studio.downloads.get(call.id)
    return FileResponse(found.path, media_type="application/octet-stream", filename=found.name)


@route("POST", "/steps")
async def add_step(call: Call) -> Any:
    """Write a step of the page's history to the disk."""
    given = await call.object(*works.FIELDS)
    made = call.session.recall("result", given.get("result"))
    result = None if made is None else results.described(made, call.session)
    step = works.step_of(given, result)
    await call.work(call.session.add_steps, [step])
    return step


@route("GET", "/presets")
async def all_presets(call: Call) -> Any:
    """List the chains of steps that were saved."""
    return await call.work(call.studio.chains.all)


@route("POST", "/presets")
async def change_preset(call: Call) -> Any:
    """Save a chain of steps, rename it with `to`, or remove it."""
    given = await call.object("name", "to", "steps")
    change = partial(call.studio.chains.change, given.get("name"))
    return await call.work(partial(change, to=given.get("to"), steps=given.get("steps")))


@route("GET", "/works")
async def all_works(call: Call) -> Any:
    """List the work of other tabs, of earlier days too."""
    return await call.work(works.works_of, call.studio.store, call.session)


@route("POST", "/works/{id}/open")
async def continue_work(call: Call) -> Any:
    """Continue the work of another tab in this one."""
    session, studio = call.session, call.studio
    in_use = studio.in_use(call.id) or call.id == session.key
    steps = await call.work(works.continue_work, call.id, studio.store, session, in_use)
    if not in_use:
        studio.forget(call.id)
    return {"steps": steps}


@route("DELETE", "/works/{id}")
async def remove_work(call: Call) -> Any:
    """Remove the work of another tab."""
    await call.work(works.remove_work, call.id, call.studio.store, call.studio.in_use(call.id))
    call.studio.forget(call.id)
    return {}
