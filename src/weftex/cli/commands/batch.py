"""Make images from every image and every folder of maps in a folder.

In the output folder, contact.html shows all outputs, and manifest.jsonl records how each was made.
--skip-existing resumes an interrupted run.

examples:
  weftex batch samples/ -o out/ --size 1024 --tileable --seed 1
  weftex batch samples/ -o out/ --count 20 --keep-best 3 --seed 1
  weftex batch samples/ -o out/ --count 1000 --seed 1 --skip-existing     resume
"""

from __future__ import annotations

import argparse
import json
import os
import string
from collections.abc import Iterator, Sequence
from contextlib import suppress
from html import escape
from time import perf_counter
from typing import Any, NamedTuple
from urllib.parse import quote

from weftex.cli.arguments import parse_task
from weftex.cli.files import open_materials, pixels_of, plan
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report, say
from weftex.errors import CancelledError, FileError, InvalidInputError, WeftexError, shown
from weftex.exemplar.material import has_several
from weftex.io.formats import READABLE, suffix_of, written_as
from weftex.io.manifest import MANIFEST, Manifest, unfinished
from weftex.io.map_files import map_files
from weftex.io.pictures import write_text
from weftex.method import Model
from weftex.pages.html import document, small
from weftex.processes import LostError, Workers
from weftex.quality.score import MapsScorer, Rating
from weftex.recipe import MATERIAL, SEED, Recipe
from weftex.recipe.declared import FIT, OUTPUT_SIZE, TILEABLE
from weftex.recipe.opening import OpenedRecipe
from weftex.results.synthesis import Synthesis
from weftex.roles import COLOR, role_of
from weftex.threads import in_turn, thread_count

_MOST = 10**6
_FIELDS = {"name", "seed"}
_SHEET = "contact.html"
_LONGEST = 255  # bytes of a file's name


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("batch", __doc__)
    add = parser.add_argument
    add("materials", metavar="IN", help="folder of images and of folders of maps")
    add("-o", "--output", metavar="OUT", required=True, help="folder to write to")
    text = "number of outputs per sample, with successive seeds from --seed on; default: 1"
    add("--count", type=int, default=1, metavar="N", help=text)
    text = "names of the outputs; default: {name}_{seed}, or {name} for one output per sample"
    add("--template", metavar="TEXT", help=text)
    add("--keep-best", type=int, metavar="K", help="keep only the K best outputs of each sample")
    add("--score", action="store_true", help="write the score of each output to the manifest")
    add("--skip-existing", action="store_true", help="make only the outputs that are missing")
    add("--force", action="store_true", help="overwrite existing outputs")
    parser.share("--preset")
    args, recipe = parse_task(
        "synth", parser, argv, [OUTPUT_SIZE, TILEABLE, FIT, SEED, MATERIAL["turn"]]
    )
    if not 1 <= args.count <= _MOST:
        raise InvalidInputError(f"--count is {args.count}; it must be from 1 to {_MOST}")
    if args.keep_best is not None and not 1 <= args.keep_best <= args.count:
        raise InvalidInputError(
            f"--keep-best is {args.keep_best}; it must be from 1 to --count, {args.count}"
        )
    if args.skip_existing and args.force:
        raise InvalidInputError("give --skip-existing or --force, not both")

    def work(bar: Bar, outputs: Outputs) -> str:
        first = 0 if args.seed is None else recipe.seed
        entries = entries_of(args.materials, args.output)
        refuse_twins(entries)
        seeds = [(first + k) % 2**64 for k in range(args.count)]
        template = args.template or ("{name}" if args.count == 1 else "{name}_{seed}")
        jobs = jobs_of(entries, template, seeds, together=args.keep_best is not None)
        kept = Outputs()  # its folder stays whatever fails
        kept.make_folder(args.output)
        manifest = Manifest(args.output)
        try:
            left = left_of(jobs, args, manifest, recipe)
            failures = _do(left, manifest, recipe, args, bar)
            _write_contact_sheet(args.output, manifest)
        finally:
            manifest.sweep()
        stray = _stray(args.materials, entries, args.output)
        if failures:
            raise InvalidInputError(
                f"{len(failures)} of {len(left)} jobs failed, the first: {failures[0]}{stray}"
            )
        skipped = f", {len(jobs) - len(left)} existed" if len(left) < len(jobs) else ""
        done = f"did {len(left)} jobs of {len(entries)} samples{skipped}, in {bar.took:.2f} s"
        return f"{done}; {os.path.join(args.output, _SHEET)} shows all outputs{stray}"

    run_and_report(work, args.quiet)


def _stray(folder: str, entries: Sequence[Entry], output: str) -> str:
    """Return what of a folder is no sample, in words."""
    used = {os.path.basename(entry.path) for entry in entries} | {os.path.basename(output)}
    left = sorted(one for one in os.listdir(folder) if one not in used and one[0] != ".")
    more = f" and {len(left) - 3} more" if len(left) > 4 else ""
    names = ", ".join(left[: 3 if more else 4])
    return f"; ignored, neither an image nor a map set: {names}{more}" if left else ""


def _write_contact_sheet(folder: str, manifest: Manifest) -> None:
    """Write a page that shows the outputs in a folder, which it links to."""
    parts = ['<div class="pictures">']
    for record in sorted(manifest.records, key=lambda one: str(one["output"])):
        file = record["output"]
        if os.path.isdir(os.path.join(folder, file)):
            stems = map_files(os.path.join(folder, file))[0]
            first = next((s for s in stems if role_of(s) in (None, COLOR)), next(iter(stems)))
            file = f"{file}/{os.path.basename(stems[first])}"
        score = "" if record.get("score") is None else f", score {record['score']:.2f}"
        said = f"{record['output']}: {record['method']}, seed {record['seed']}{score}"
        image = f'<img src="{quote(file)}" alt="{escape(said)}" width="240" loading="lazy">'
        parts.append(f'<figure><a href="{quote(file)}">{image}</a>{small(said)}</figure>')
    parts.append("</div>")
    write_text(os.path.join(folder, _SHEET), document("Outputs of weftex batch", parts))


def _do(
    jobs: list[Job], manifest: Manifest, recipe: Recipe, args: argparse.Namespace, bar: Bar
) -> list[str]:
    """Do the jobs, in as many processes as there are threads to use; what went wrong."""
    threads = thread_count(args.threads)
    count = max(1, min(threads, len(jobs)))
    maker = Maker(recipe, threads // count, args)
    failures: list[str] = []
    bar.left = f"--skip-existing continues in {args.output}"

    def one(number: int) -> str | None:
        job = jobs[number]
        try:
            found: Done = maker(job) if count < 2 else workers.do(job)
        except LostError as error:
            found = Done([], f"{job.path}: {error}")
        for record, path in found.made:
            manifest.publish(record, path)
        if args.keep_best is not None and found.failure is None:
            manifest.leave_out(job.outputs.values(), [k["output"] for k, _ in found.made])
        return found.failure

    def check(done: int) -> None:
        if bar(done, len(jobs), "jobs", lambda: None) is False:
            raise CancelledError(f"cancelled after {done} of {len(jobs)} jobs")

    with Workers(Maker, recipe, maker.threads, args) as workers:
        bar.at_stop(maker.cancel)
        bar.at_stop(workers.end)
        check(0)
        for done, failure in enumerate(in_turn(one, range(len(jobs)), count), start=1):
            if failure is not None:
                failures.append(failure)
                if not args.quiet and not bar.stopped:
                    say(failure)
            check(done)
    return failures


class Entry(NamedTuple):
    """A sample of a batch: a picture, or a folder of maps."""

    path: str
    name: str  # which outputs are called after
    suffix: str  # of its outputs; empty for a folder of maps


class Job(NamedTuple):
    """Outputs of one sample."""

    path: str  # of the sample
    outputs: dict[int, str]  # names of files, or folders, by seed


class Done(NamedTuple):
    """The records of what a job made, where each output is until it is published, and why not."""

    made: list[tuple[dict[str, Any], str]]
    failure: str | None = None


def entries_of(folder: str, output: str) -> list[Entry]:
    """Return the pictures of a folder, and the folders in it that have pictures, but `output`."""
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise FileError(f"{folder}: cannot read the folder: {error.strerror}") from None
    found = list[Entry]()
    there = os.path.exists(output)
    for file in names:
        path, stem = os.path.join(folder, file), os.path.splitext(file)[0]
        if file.startswith(".") or (
            there and os.path.exists(path) and os.path.samefile(path, output)
        ):
            continue
        if os.path.isdir(path):
            with suppress(FileError):
                map_files(path)
                found += [] if has_several(path) else [Entry(path, file, "")]
        elif suffix_of(file) in READABLE:
            found.append(Entry(path, stem, written_as(path)))
    if not found:
        raise FileError(f"{folder}: has no images, and no folders of maps")
    return found


def refuse_twins(entries: Sequence[Entry]) -> None:
    """Raise `InvalidInputError` if two samples would make one output."""
    paths: dict[str, str] = {}
    for path, name, _ in entries:
        if (first := paths.setdefault(name.casefold(), path)) != path:
            raise InvalidInputError(f"{first} and {path} would both make {name}; rename one")


def jobs_of(
    entries: Sequence[Entry], template: str, seeds: Sequence[int], *, together: bool
) -> list[Job]:
    """Return what there is to make: a job a seed, or, if `together`, a job a sample."""
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
        parts = [outputs] if together else [{seed: output} for seed, output in outputs.items()]
        jobs += [Job(entry.path, part) for part in parts]
    return jobs


def _check_name(stem: str, suffix: str) -> None:
    """Refuse names that files cannot have, hidden ones, and that of the manifest."""
    plain = os.path.basename(stem) == stem and stem.isprintable()
    if not plain or stem.startswith(".") or stem.casefold() in ("", MANIFEST):
        raise InvalidInputError(f"the template makes {shown(stem)}, which is not a file name")
    if len(os.fsencode(stem + suffix)) > _LONGEST:
        raise InvalidInputError(
            f"the template makes a name of {len(stem + suffix)} letters; it must be at most "
            f"{_LONGEST} bytes"
        )


def _told(recipe: Recipe) -> dict[str, Any]:
    """A recipe as records have it: JSON without a sample and a seed, which they have themselves."""
    options = {k: v for k, v in recipe.as_json().items() if k not in ("seed", "task")}
    spec = {k: v for k, v in recipe.materials[0].items() if k != "path"}
    return dict(json.loads(json.dumps({**options, "materials": spec})))


def left_of(
    jobs: Sequence[Job], args: argparse.Namespace, manifest: Manifest, recipe: Recipe
) -> list[Job]:
    """Return the jobs that are to be done; raises where outputs must not be replaced."""
    left, asked = [], _told(recipe)
    made = {record["output"]: record for record in manifest.records}
    for job in jobs:
        paths = {one: os.path.join(args.output, one) for one in job.outputs.values()}
        there = [one for one, path in paths.items() if os.path.lexists(path)]
        for one in there if args.skip_existing else ():
            if made.get(one, {}).get("recipe", asked) != asked:
                raise FileError(f"{paths[one]} was made with other options; --force replaces it")
        if args.skip_existing and len(there) >= (args.keep_best or len(job.outputs)):
            continue
        foreign = [one for one in there if one not in manifest]
        for one in foreign:
            above = os.path.join(os.path.realpath(paths[one]), "")
            if os.path.join(os.path.realpath(job.path), "").startswith(above):
                raise FileError(f"{paths[one]} is a sample; name another folder for outputs")
            if args.force and os.path.isdir(paths[one]):
                raise FileError(f"{paths[one]} is a folder that batch did not make; move it")
        if there and not args.force and (not args.skip_existing or foreign):
            raise FileError(
                f"{paths[there[0]]} exists; --skip-existing continues, --force replaces it"
            )
        left.append(job)
    return left


class Maker:
    """Does jobs with a recipe for any sample, and a number of threads for each output.

    A sample is read and fitted once for jobs that follow each other.
    """

    def __init__(self, recipe: Recipe, threads: int, args: argparse.Namespace) -> None:
        self.recipe, self.threads, self.args = recipe, threads, args
        self._path, self._cancelled = "", False
        self._opened: OpenedRecipe
        self._model: Model
        self._scorer: MapsScorer | None = None

    def __call__(self, job: Job) -> Done:
        """Make the outputs of a job, or say what went wrong."""
        made: list[tuple[dict[str, Any], str]] = []
        try:
            self._read(job.path)
            for result, record in self._results(job):
                made.append((record, self._write(result, record)))
        except CancelledError:
            raise
        except WeftexError as error:
            said = str(error)
            return Done(made, said if said.startswith(job.path) else f"{job.path}: {said}")
        except MemoryError:
            return Done(made, f"{job.path}: not enough memory; make the image smaller")
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
        keep = self.args.keep_best
        best: list[tuple[float, int, Synthesis, dict[str, Any]]] = []
        for order, (seed, output) in enumerate(job.outputs.items()):
            start = perf_counter()
            result = self._opened.make(
                seed=seed,
                get_model=lambda _: self._model,
                threads=self.threads,
                progress=lambda *_: not self._cancelled,
            )
            record = self._record(job, output, seed, result)
            rating = Rating()
            if keep is not None or self.args.score:
                self._scorer = self._scorer or MapsScorer(self._model.exemplar)
                rating = self._scorer.rate(result)
                record["score"] = rating.score
            record["seconds"] = round(perf_counter() - start, 3)
            best.append((rating.choice, order, result, record))
            best.sort(key=lambda one: one[:2])
            del best[keep or 1 :]  # a job of one seed keeps it
        for _, _, result, record in sorted(best, key=lambda one: one[1]):
            yield result, record

    def _record(self, job: Job, output: str, seed: int, result: Synthesis) -> dict[str, Any]:
        used = dict(result.provenance)
        about = {name: used.pop(name) for name in ("reason", "warnings") if name in used}
        used.pop("seed", None)
        return {
            "output": output,
            "sample": job.path,
            "seed": seed,
            "size": [result.shape[1], result.shape[0]],
            "method": used.pop("method"),
            "parameters": used,
            "recipe": _told(self.recipe),
        } | about

    def _write(self, result: Synthesis, record: dict[str, Any]) -> str:
        """Write an output under another name, and return that."""
        target, job = os.path.join(self.args.output, record["output"]), self._opened
        with unfinished(target) as path:
            options = argparse.Namespace(**vars(self.args) | {"output": path})
            if job.materials[0].folder:
                os.mkdir(path)
            files, _ = plan(job.materials, job.like, options)
            try:
                files.write(str, pixels_of(result, files.main), self.args.threads)
            except WeftexError as error:
                raise type(error)(str(error).replace(path, target)) from None
        return path
