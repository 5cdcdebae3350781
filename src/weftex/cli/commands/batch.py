"""weftex batch: synthesize from every sample in a folder."""

from __future__ import annotations

import os
from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.options import parse_task
from weftex.cli.parser import Parser
from weftex.cli.terminal import finish, say
from weftex.errors import CancelledError, FileError, InvalidInputError
from weftex.recipe import MATERIAL, SEED
from weftex.recipe.declared import OUTPUT_SIZE, TILEABLE

if TYPE_CHECKING:
    from argparse import Namespace

    from weftex.cli.batches import Job
    from weftex.cli.terminal import Bar, Outputs
    from weftex.io.manifest import Manifest
    from weftex.recipe import Recipe

_ABOUT = """\
Synthesize outputs from every image and every folder of maps in a folder. manifest.jsonl in the
output folder records how each output was made. --skip-existing resumes an interrupted run.\
"""

_EXAMPLES = """\
examples:
  weftex batch samples/ out/ --size 1024 --tileable --seed 1
  weftex batch samples/ out/ --count 20 --keep-best 3 --seed 1
  weftex batch samples/ out/ --count 1000 --seed 1 --skip-existing     resume
"""
_MOST = 10**6


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    start = perf_counter()
    parser = Parser("batch", _ABOUT, _EXAMPLES)
    add = parser.add_argument
    add("materials", metavar="IN", help="folder of images and of folders of maps")
    add("output", metavar="OUT", help="folder to write to")
    text = "number of outputs per sample, with successive seeds from --seed on; default: 1"
    add("--count", type=int, default=1, metavar="N", help=text)
    text = "names of the outputs; default: {name}_{seed}, or {name} for one output per sample"
    add("--template", metavar="TEXT", help=text)
    add("--keep-best", type=int, metavar="K", help="keep only the K best outputs of each sample")
    add("--score", action="store_true", help="write the score of each output to the manifest")
    add("--skip-existing", action="store_true", help="make only the outputs that are missing")
    add("--force", action="store_true", help="overwrite existing outputs")
    parser.share("--names", "--mtlx")
    args, recipe = parse_task(
        "synth", parser, argv, [OUTPUT_SIZE, TILEABLE, SEED, MATERIAL["turn"]]
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
        from weftex.cli.batches import entries_of, jobs_of, left_of
        from weftex.io.manifest import Manifest

        first = 0 if getattr(args, "--seed") is None else recipe.seed
        entries = entries_of(args.materials, args.output)
        seeds = [(first + k) % 2**64 for k in range(args.count)]
        template = args.template or ("{name}" if args.count == 1 else "{name}_{seed}")
        jobs = jobs_of(entries, template, seeds, args.keep_best)
        try:
            os.makedirs(args.output, exist_ok=True)
        except OSError as error:
            raise FileError(f"{args.output}: cannot make this folder: {error.strerror}") from None
        manifest = Manifest(args.output)
        try:
            how = {"skip": args.skip_existing, "force": args.force}
            left = left_of(jobs, args.output, manifest, **how)
            failures = _do(left, manifest, recipe, args, bar)
        finally:
            manifest.sweep()
        took = perf_counter() - start
        if failures:
            raise InvalidInputError(
                f"{len(failures)} of {len(left)} jobs failed, the first: {failures[0]}"
            )
        skipped = f", {len(jobs) - len(left)} were there" if len(left) < len(jobs) else ""
        return f"did {len(left)} jobs of {len(entries)} samples{skipped}, in {took:.2f} s"

    finish(work, args.quiet)


def _do(
    jobs: list[Job],
    manifest: Manifest,
    recipe: Recipe,
    args: Namespace,
    bar: Bar,
) -> list[str]:
    """Do the jobs, in as many processes as there are threads to use; what went wrong."""
    from weftex.cli.batches import Done, Maker
    from weftex.processes import LostError, Workers
    from weftex.threads import in_turn, thread_count

    threads = thread_count(args.threads)
    count = max(1, min(threads, len(jobs)))
    maker = Maker(recipe, threads // count, args)
    failures: list[str] = []
    bar.left = f"--skip-existing goes on in {args.output}"

    def one(number: int) -> str | None:
        job = jobs[number]
        try:
            found: Done = maker(job) if count < 2 else workers.do(job)
        except LostError as error:
            found = Done([], f"{job.entry.path}: {error}")
        for record, path in found.made:
            manifest.publish(record, path)
        if job.keep is not None and found.failure is None:
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
