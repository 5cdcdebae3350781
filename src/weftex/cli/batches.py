"""Many outputs from many samples: what there is to make, and making one of them."""

from __future__ import annotations

import argparse
import heapq
import os
import string
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any

from weftex.canvas import as_canvas
from weftex.cli.files import open_materials, pixels_of
from weftex.cli.sets import plan
from weftex.cli.terminal import Outputs
from weftex.errors import CancelledError, FileError, InvalidInputError, WeftexError, shown
from weftex.io.formats import READABLE, suffix_of, written_as
from weftex.io.manifest import MANIFEST, unfinished
from weftex.io.map_files import map_files
from weftex.quality.score import MapsScorer

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from weftex.io.manifest import Manifest
    from weftex.method import Model
    from weftex.recipe import Recipe
    from weftex.recipe.making import Opened
    from weftex.results.synthesis import Synthesis

_FIELDS = {"name", "seed"}
_LONGEST = 255  # bytes of a file's name


@dataclass(frozen=True)
class Entry:
    """A sample of a batch: a picture, or a folder of maps."""

    path: str
    name: str  # which outputs are called after
    suffix: str  # of its outputs; empty for a folder of maps


@dataclass(frozen=True)
class Job:
    """Outputs of one sample."""

    entry: Entry
    outputs: dict[int, str]  # names of files, or folders, by seed
    keep: int | None = None  # the number of outputs with the best scores to write; all if None


@dataclass(frozen=True)
class Done:
    """The records of what a job made, where each output is until it is published, and why not."""

    made: list[tuple[dict[str, Any], str]]
    failure: str | None = None


def entries_of(folder: str, output: str) -> list[Entry]:
    """Return the pictures of a folder, and the folders in it that have pictures, but `output`."""
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise FileError(f"{folder}: cannot read the folder: {error.strerror}") from None
    found: dict[str, Entry] = {}
    for file in names:
        path, stem = os.path.join(folder, file), os.path.splitext(file)[0]
        if file.startswith(".") or _same(path, output):
            continue
        if os.path.isdir(path):
            try:
                map_files(path)
            except FileError:
                continue
            entry = Entry(path, file, "")
        elif suffix_of(file) in READABLE:
            entry = Entry(path, stem, written_as(path))
        else:
            continue
        if entry.name in found:
            raise InvalidInputError(
                f"{found[entry.name].path} and {path} would both make {entry.name}; rename one"
            )
        found[entry.name] = entry
    if not found:
        raise FileError(f"{folder}: has no pictures, and no folders of maps")
    return list(found.values())


def jobs_of(
    entries: Sequence[Entry], template: str, seeds: Sequence[int], keep: int | None
) -> list[Job]:
    """Return what there is to make: a job a seed, or a job a sample where the best are kept."""
    try:
        fields = {name for _, name, _, _ in string.Formatter().parse(template) if name is not None}
        if not fields <= _FIELDS:
            raise ValueError
        template.format(name="", seed=0)
    except (ValueError, LookupError, AttributeError):
        raise InvalidInputError(
            f"the template is {shown(template)}; it may have {{name}} and {{seed}}, such as "
            "{name}_{seed}"
        ) from None
    taken: set[str] = set()
    jobs = []
    for entry in entries:
        outputs = {seed: template.format(name=entry.name, seed=seed) for seed in seeds}
        for seed, stem in outputs.items():
            _check_name(stem, entry.suffix)
            if stem.casefold() in taken:
                raise InvalidInputError(
                    f"two outputs would be named '{stem}'; use {{name}} and {{seed}} in --template"
                )
            taken.add(stem.casefold())
            outputs[seed] = stem + entry.suffix
        if keep is None:
            jobs += [Job(entry, {seed: output}) for seed, output in outputs.items()]
        else:
            jobs.append(Job(entry, outputs, keep))
    return jobs


def _check_name(stem: str, suffix: str) -> None:
    """Refuse names that files cannot have, hidden ones, and that of the manifest."""
    plain = os.path.basename(stem) == stem and stem.isprintable()
    if not plain or stem.startswith(".") or stem.casefold() in ("", MANIFEST):
        raise InvalidInputError(f"the template makes {shown(stem)}, which is no name of an output")
    if len(os.fsencode(stem + suffix)) > _LONGEST:
        raise InvalidInputError(
            f"the template makes a name of {len(stem + suffix)} letters; systems have room for "
            f"{_LONGEST} bytes"
        )


def left_of(
    jobs: Sequence[Job], folder: str, manifest: Manifest, *, skip: bool, force: bool
) -> list[Job]:
    """Return the jobs that are to be done; raises where outputs must not be replaced."""
    left = []
    for job in jobs:
        paths = {one: os.path.join(folder, one) for one in job.outputs.values()}
        there = [one for one, path in paths.items() if os.path.lexists(path)]
        most = len(job.outputs) if job.keep is None else job.keep
        if skip and len(there) >= most:
            continue
        foreign = [one for one in there if one not in manifest]
        for one in foreign:
            above = os.path.join(os.path.realpath(paths[one]), "")
            if os.path.join(os.path.realpath(job.entry.path), "").startswith(above):
                raise FileError(f"{paths[one]} is a sample; name another folder for outputs")
            if force and os.path.isdir(paths[one]):
                raise FileError(f"{paths[one]} is a folder that no batch made; move it away")
        if there and not force and (not skip or foreign):
            raise FileError(
                f"{paths[there[0]]} is there; give --skip-existing to go on, or --force to make it "
                "anew"
            )
        left.append(job)
    return left


def _same(one: str, other: str) -> bool:
    return os.path.exists(other) and os.path.samefile(one, other) if os.path.exists(one) else False


class Maker:
    """Does jobs with a recipe for any sample, and a number of threads for each output.

    A sample is read and fitted once for jobs that follow each other.
    """

    def __init__(self, recipe: Recipe, threads: int, args: argparse.Namespace) -> None:
        self.recipe, self.threads, self.args = recipe, threads, args
        self._path, self._cancelled = "", False
        self._opened: Opened
        self._model: Model
        self._scorer: MapsScorer | None = None

    def __call__(self, job: Job) -> Done:
        """Make the outputs of a job, or say what went wrong."""
        made: list[tuple[dict[str, Any], str]] = []
        try:
            self._read(job.entry.path)
            for result, record in self._results(job):
                made.append((record, self._write(result, record)))
        except CancelledError:
            raise
        except WeftexError as error:
            path, said = job.entry.path, str(error)
            return Done(made, said if said.startswith(path) else f"{path}: {said}")
        except MemoryError:
            return Done(made, f"{job.entry.path}: not enough memory; make it smaller")
        return Done(made)

    def cancel(self) -> None:
        """End at the next step."""
        self._cancelled = True

    def _read(self, path: str) -> None:
        if self._path == path:
            return
        self._path, self._scorer = "", None
        spec = {**self.recipe.materials[0], "path": path}
        self._opened = open_materials(self.recipe.changed(materials=[spec]), self.args)
        self._model = self.recipe.method.fit(self._opened.sample)
        self._path = path

    def _results(self, job: Job) -> Iterator[tuple[Synthesis, dict[str, Any]]]:
        """All results and their records, or the best ones in the order of their seeds."""
        canvas = as_canvas(self._opened.shape, self.recipe.options["tileable"])
        best: list[tuple[float, int, Synthesis, dict[str, Any]]] = []
        for order, (seed, output) in enumerate(job.outputs.items()):
            start = perf_counter()
            result = self._model.sample(
                canvas, seed=seed, threads=self.threads, progress=lambda *_: not self._cancelled
            )
            record = self._record(job, output, seed, result)
            if job.keep is not None or self.args.score:
                self._scorer = self._scorer or MapsScorer(self._model.exemplar)
                record["score"] = self._scorer.score(result)
            record["seconds"] = round(perf_counter() - start, 3)
            if job.keep is None:
                yield result, record
                continue
            score = record["score"]
            # The heap's first is the worst that is kept; of equal ones the later.
            item = (-(float("inf") if score is None else score), -order, result, record)
            (heapq.heappush if len(best) < job.keep else heapq.heappushpop)(best, item)
        for _, _, result, record in sorted(best, key=lambda one: -one[1]):
            yield result, record

    def _record(self, job: Job, output: str, seed: int, result: Synthesis) -> dict[str, Any]:
        used = dict(result.provenance)
        about = {name: used.pop(name) for name in ("reason", "warnings") if name in used}
        used.pop("seed", None)
        return {
            "output": output,
            "sample": job.entry.path,
            "seed": seed,
            "size": [result.shape[1], result.shape[0]],
            "method": used.pop("method"),
            "parameters": used,
        } | about

    def _write(self, result: Synthesis, record: dict[str, Any]) -> str:
        """Write an output under another name, and return that."""
        target, job = os.path.join(self.args.output, record["output"]), self._opened
        with unfinished(target) as path, Outputs() as outputs:
            options = argparse.Namespace(**vars(self.args) | {"output": path})
            if job.materials[0].folder:
                outputs.make_folder(path)
            made = plan(job.materials, job.like, options)
            made.write(pixels_of(result, made.main), outputs, self.args.threads)
        return path
