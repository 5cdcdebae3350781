"""From recipes to results, in jobs, or to windows of an endless plane."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

from weftex import Exemplar, Synthesis
from weftex.errors import CancelledError, WeftexError
from weftex.method import Model
from weftex.recipe import Recipe
from weftex.recipe.opening import OpenedRecipe, open_recipe
from weftex.studio import results
from weftex.studio.jobs import Job
from weftex.studio.materials import id_of, load_material, map_of, maps_of, size_of
from weftex.studio.pictures import Bytes, on_screen, preview_of, whole_number
from weftex.studio.refusals import Refusal, answer_of
from weftex.studio.results import Result
from weftex.studio.sessions import Session
from weftex.studio.uploads import picture_of


def make_each(recipes: list[Recipe], compared: bool) -> Callable[[Job], None]:
    """Make one recipe after the other; to be `compared`, each has its figures, or says why not."""

    def work(job: Job) -> None:
        for recipe in recipes:
            job.check()
            start = perf_counter()
            try:
                made = made_of(recipe, job)
                more = {"figures": results.figures_of(made, job.session)} if compared else {}
                job.add(results.described(made, job.session) | more)
            except WeftexError as error:
                if not compared or isinstance(error, CancelledError):
                    raise
                took = round(perf_counter() - start, 3)
                job.add(answer_of(error)[1] | {"method": recipe.method.slug, "seconds": took})

    return work


def made_of(recipe: Recipe, job: Job) -> Result:
    """Make a recipe, or remember it; progress goes to the job."""
    session = job.session
    job(0, 1, "reading", lambda: None)
    ready = open_job(recipe, session)
    recipe = ready.recipe
    job.to_show = preview_of(ready.prepared[0].exemplar)
    first, *others = recipe.materials

    def make() -> Result:
        if "sample_width" in first and "density" not in first:
            # A width alone changes no pixels: a result without it has them.
            bare = {name: value for name, value in first.items() if name != "sample_width"}
            like = made_of(recipe.changed(materials=[bare, *others]), job)
            return replace(like, recipe=recipe, pictures=ready.pictures)
        start = perf_counter()
        result = ready.make(get_model=partial(fitted, ready, session), progress=job)
        result.image  # rendering is part of the work  # noqa: B018
        seconds, folder = perf_counter() - start, any(one.folder for one in ready.materials)
        return Result(recipe, result, ready.materials[0].name, folder, ready.pictures, seconds)

    key = "result", id_of(recipe.as_json())
    return session.find(make, lambda made: 2 * bytes_of(made.result), *key)


def bytes_of(result: Synthesis) -> int:
    """Return what a result takes in memory."""
    return int(result.image.nbytes + sum(array.nbytes for array in result.arrays().values()))


def open_job(recipe: Recipe, session: Session) -> OpenedRecipe:
    """Read what a recipe needs, and fill its size in; raise `Refusal` if that is too large."""
    for upload in recipe.pictures:
        session.upload(upload)
    picture = partial(picture_of, session=session)
    job = open_recipe(recipe, partial(load_material, session=session), picture)
    height, width = job.shape
    if recipe.task == "synth":
        job = replace(job, recipe=recipe.changed(size=[height, width]))
    if math.prod(job.shape) > session.limits.output_pixels:
        most = session.limits.output_pixels / 2**20
        raise Refusal(
            413,
            f"size is {width}x{height}; the studio makes at most {most:g} megapixels at once, "
            "weftex on the command line more",
            "size",
        )
    return job


def fitted(job: OpenedRecipe, session: Session, sample: Exemplar) -> Model:
    """Return a recipe's method, fitted to its sample."""
    method, names = job.recipe.method, [id_of(spec) for spec in job.recipe.materials]
    key = "model", *names, method, job.recipe.options["sample_guide"]
    return session.find(lambda: method.fit(sample), lambda _: 8 * size_of(sample), *key)


_LARGEST = 1024  # pixels a side of a window
_FAR = 2**40  # pixels from the middle of a plane


@dataclass(frozen=True)
class Plane:
    """A fitted method that makes windows."""

    model: Model
    main: str  # the name of its picture among the maps
    seed: int
    method: str  # the slug of the one that makes the windows, also where `auto` chose it


def begin_plane(given: Any, session: Session) -> dict[str, Any]:
    """Fit the method of a recipe to its material; return the plane as JSON for the page."""
    recipe = Recipe.from_json(given)
    job = open_job(recipe.changed(size=None, tileable=False), session)
    name = id_of({"plane": job.recipe.as_json()})

    def fit() -> Plane:
        model = fitted(job, session, job.sample)
        used = model.window(0, 0, 1, 1, seed=recipe.seed).provenance
        return Plane(model, next(iter(job.pictures)), recipe.seed, used["method"])

    plane = session.find(fit, lambda _: 2**20, "plane", name)
    return {"id": name, "maps": maps_of(plane.model.exemplar, plane.main), "method": plane.method}


def plane_window(name: str, query: Mapping[str, str], session: Session) -> Bytes:
    """Return a window of a plane as a screen shows it, or raise `Refusal`."""
    gone = Refusal(410, "this endless texture is no longer in memory; open it again")
    plane: Plane = session.recall("plane", name, gone=gone)
    top, left = (whole_number(query, side, 0, -_FAR, _FAR) for side in ("top", "left"))
    height, width = (whole_number(query, side, 256, 1, _LARGEST) for side in ("height", "width"))
    like = map_of(plane.model.exemplar, plane.main, query.get("map"))
    box = top, left, height, width
    make = partial(plane.model.window, *box, seed=plane.seed, threads=1)
    made = session.find(make, bytes_of, "window", name, *box)
    return on_screen(like, made.image if like is plane.model.exemplar else made.render(like))
