"""What jobs do: one recipe, or several seeds or methods of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any

from weftex.errors import CancelledError, InvalidInputError, WeftexError, is_whole, shown
from weftex.recipe import Recipe
from weftex.studio import results
from weftex.studio.jobs import Job
from weftex.studio.materials import id_of
from weftex.studio.refusals import answer_of
from weftex.studio.synthesis import Result, bytes_of, make, open_job

MOST_SEEDS = 16


def plain(recipes: list[Recipe]) -> Callable[[Job], None]:
    """Make one recipe after the other; the first that fails ends it."""

    def work(job: Job) -> None:
        for recipe in recipes:
            job.check()
            job.add(results.described(made_of(recipe, job), job.session))

    return work


def compared(recipes: list[Recipe]) -> Callable[[Job], None]:
    """Make what several methods make, each with its figures; one that cannot says why."""

    def work(job: Job) -> None:
        for recipe in recipes:
            start = perf_counter()
            try:
                made = made_of(recipe, job)
                figures = results.figures_of(made, job.session)
                job.add(results.described(made, job.session) | {"figures": figures})
            except CancelledError:
                raise
            except WeftexError as error:
                _, answer = answer_of(error)
                took = round(perf_counter() - start, 3)
                job.add(answer | {"method": recipe.method.slug, "seconds": took})

    return work


def found(function: Callable[..., dict[str, Any]], *given: Any) -> Callable[[Job], None]:
    """Add what a function returns."""
    return lambda job: job.add(function(*given))


def made_of(recipe: Recipe, job: Job) -> Result:
    """Make a recipe, or remember it; progress goes to the job."""
    session = job.session
    job(0, 1, "reading", lambda: None)
    ready = open_job(recipe, session)
    recipe = ready.recipe
    job.to_show = results.preview_of(ready.prepared[0].exemplar)
    first, *others = recipe.materials

    def work() -> Result:
        if "sample_width" not in first or "density" in first:
            return make(ready, session, job)
        # A width alone changes no pixels: a result without it has them.
        bare = {name: value for name, value in first.items() if name != "sample_width"}
        like = made_of(recipe.changed(materials=[bare, *others]), job)
        return replace(like, recipe=recipe, pictures=ready.pictures)

    key = "result", id_of(recipe.as_json())
    return session.find(work, lambda made: 2 * bytes_of(made.result), *key)


def several(recipe: Recipe, count: Any, methods: Any) -> list[Recipe]:
    """Return the recipes of a job: seeds from the recipe's on, or each with another method."""
    if count is not None and not is_whole(count, 1, MOST_SEEDS):
        raise InvalidInputError(f"count is {shown(count)}; it must be from 1 to {MOST_SEEDS}")
    if methods is None:
        seeds = ((recipe.seed + k) % 2**64 for k in range(count or 1))
        return [recipe.changed(seed=seed) for seed in seeds]
    if count is not None:
        raise InvalidInputError("count has no effect beside methods; leave one of them out")
    if not isinstance(methods, list) or not 0 < len(methods) <= MOST_SEEDS:
        raise InvalidInputError(f"methods is {shown(methods)}; it must be a list of names")
    return [recipe.changed(method=name, parameters={}) for name in map(str, methods)]
