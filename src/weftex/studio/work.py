"""What jobs do: one recipe, several seeds or methods of it, or batches."""

from __future__ import annotations

import json
import os
import zipfile
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

import weftex
from weftex.errors import CancelledError, InvalidInputError, WeftexError, shown
from weftex.studio import results
from weftex.studio.exports import DATE, ExportOptions, pack, write
from weftex.studio.materials import id_of
from weftex.studio.refusals import answer_of
from weftex.studio.synthesis import Result, make, open_job
from weftex.studio.uploads import label_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from weftex.recipe import Recipe
    from weftex.studio.downloads import Downloads
    from weftex.studio.jobs import Job

MOST_SEEDS = 16
_MOST_IN_BATCH = 1000


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


def made_of(recipe: Recipe, job: Job) -> Result:
    """Make a recipe, or remember it; progress goes to the job."""
    session = job.session
    ready = open_job(recipe, session)
    job.to_show = results.preview_of(ready.prepared[0].exemplar)
    key = "result", id_of(ready.recipe.as_json())
    return session.find(lambda: make(ready, session, job), lambda made: 2 * made.bytes, *key)


def several(recipe: Recipe, count: Any, methods: Any) -> list[Recipe]:
    """Return the recipes of a job: seeds from the recipe's on, or each with another method."""
    if count is not None and (type(count) is not int or not 1 <= count <= MOST_SEEDS):
        raise InvalidInputError(f"count is {shown(count)}; it must be from 1 to {MOST_SEEDS}")
    if methods is None:
        seeds = ((recipe.seed + k) % 2**64 for k in range(count or 1))
        return [recipe.changed(seed=seed) for seed in seeds]
    if count is not None:
        raise InvalidInputError("count has no effect beside methods; leave one of them out")
    if not isinstance(methods, list) or not 0 < len(methods) <= MOST_SEEDS:
        raise InvalidInputError(f"methods is {shown(methods)}; it must be a list of names")
    return [recipe.changed(method=name, parameters={}) for name in map(str, methods)]


@dataclass(frozen=True)
class Batch:
    """Many outputs in one zip."""

    recipes: list[list[Recipe]]  # a list for each material, with its seeds
    keep: int | None  # so many of each, those with the best scores; all if None
    wanted: ExportOptions

    @classmethod
    def of(cls, recipe: Recipe, given: dict[str, Any]) -> Batch:
        """Read what the page sent."""
        seeds, keep, specs = (given.get(name) for name in ("seeds", "keep", "materials"))
        seeds = [recipe.seed] if seeds is None else seeds
        if not isinstance(seeds, list) or not seeds or len(set(map(str, seeds))) < len(seeds):
            raise InvalidInputError(f"seeds is {shown(seeds)}; it must be a list without repeats")
        if keep is not None and (type(keep) is not int or not 1 <= keep <= len(seeds)):
            raise InvalidInputError(f"keep is {shown(keep)}; it must be from 1 to {len(seeds)}")
        if specs is not None and not (isinstance(specs, list) and specs):
            raise InvalidInputError(f"materials is {shown(specs)}; it must be a list")
        wholes = [[spec] for spec in specs] if specs else [list(recipe.materials)]
        if len(wholes) * len(seeds) > _MOST_IN_BATCH:
            raise InvalidInputError(f"seeds and materials make more than {_MOST_IN_BATCH} outputs")
        recipes = [
            [recipe.changed(materials=whole, seed=seed) for seed in seeds] for whole in wholes
        ]
        files = {name: given.get(name) for name in ("format", "preset")}
        return cls(recipes, keep, ExportOptions.of(files, "batch"))

    def work(self, downloads: Downloads) -> Callable[[Job], None]:
        """Return what makes it; the page gets one file."""

        def run(job: Job) -> None:
            with downloads.new_folder() as folder:
                with zipfile.ZipFile(folder / "batch.zip", "w") as packed:
                    self._write(packed, folder, job)
                file = downloads.add(folder / "batch.zip", "batch.zip", job.session.key)
                job.more.update(file)

        return run

    def _write(self, packed: zipfile.ZipFile, folder: Path, job: Job) -> None:
        """Make all outputs, and put them into the zip."""
        total, lines, done = sum(map(len, self.recipes)), list[str](), 0

        def within(_: int, __: int, ___: str, preview: Callable[[], Any]) -> bool:
            return job(done, total, "outputs", preview)

        for number, recipes in enumerate(self.recipes, 1):
            best: list[tuple[float, Result]] = []
            for recipe in recipes:
                made = make(open_job(recipe, job.session), job.session, within)
                done += 1
                job(done, total, "outputs", lambda: None)
                job.check()
                if self.keep is None:
                    lines += self._pack(packed, made, number, folder)
                else:
                    best = sorted([*best, (_score(made), made)], key=lambda one: one[0])
                    best = best[: self.keep]
            for _, made in best:
                lines += self._pack(packed, made, number, folder)
        packed.writestr(zipfile.ZipInfo("manifest.jsonl", DATE), "".join(lines))

    def _pack(self, packed: zipfile.ZipFile, made: Result, number: int, folder: Path) -> list[str]:
        """Put the files of one output into the zip; its line of the manifest."""
        own = folder / "one"
        own.mkdir()
        stem = os.path.splitext(label_of(made.name))[0]
        inner = f"{number:03}_{stem}/" if len(self.recipes) > 1 else ""
        names = []
        files, notes = write(made, self.wanted.named(f"{stem}_{made.recipe.seed}"), own)
        for file in files:
            names.append(inner + file.name)
            pack(packed, file, names[-1])
            file.unlink()
        own.rmdir()
        return [
            json.dumps({"files": names, "notes": notes, "recipe": made.recipe.as_json()}) + "\n"
        ]


def _score(made: Result) -> float:
    score = weftex.assess(made.result.sample, made.result).score
    return float("inf") if score is None else score
