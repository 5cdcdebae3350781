"""What the commands of tasks share: parsing a recipe, and making it."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

from weftex.cli.options import given_blocks, parse_task
from weftex.cli.terminal import finish
from weftex.recipe.declared import options_of

if TYPE_CHECKING:
    import argparse

    from weftex.cli.parser import Parser
    from weftex.cli.terminal import Bar, Outputs
    from weftex.recipe import Recipe
    from weftex.recipe.making import Opened
    from weftex.results.synthesis import Synthesis


def run_task(task: str, parser: Parser, argv: list[str], usual: str) -> None:
    """Add the options of a task to a parser that has its materials, and do what it parses.

    `usual` is the method in words where none is named.
    """
    start = perf_counter()
    parser.share("--output", "--names", "--mtlx", "--verbose", "--save-source", "--preview")
    args, recipe = parse_task(task, parser, argv, options_of(task), usual=usual)
    if task == "synth" and _is_plane(recipe, args):
        from weftex.cli.planes import synthesize

        synthesize(recipe, args, start)
        return
    debug = getattr(args, "debug", None)

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.cli.files import open_job, report, write, write_debug

        job, plan = open_job(recipe, args, outputs)
        if debug is not None:
            outputs.make_folder(debug)
        result = job.make(progress=bar, threads=args.threads)
        write(result, plan, args, outputs)
        if debug is not None:
            write_debug(result, debug, outputs)
        if task == "fill" and not job.hole.any():
            return f"the mask covers nothing; {args.output} is the photo unchanged"
        return report(args, result, _done(job, result), start, plan.told)

    finish(work, args.quiet, preview=args.preview, verbose=args.verbose)


def _done(job: Opened, result: Synthesis) -> str:
    """What was done, in words that the name of the output follows."""
    if job.recipe.task == "fill":
        return f"filled {int(job.hole.sum())} pixels of"
    if job.recipe.task == "fuse":
        return f"fused {len(job.loaded)} samples in"
    made = f"made {result.shape[1]}x{result.shape[0]}"
    return {"synth": made, "tile": "made tileable:"}[job.recipe.task]


def _is_plane(recipe: Recipe, args: argparse.Namespace) -> bool:
    """Whether an image is written block by block."""
    from weftex.io.formats import FORMATS, suffix_of

    suffix = suffix_of(args.output)
    if not given_blocks(args) and suffix in FORMATS and suffix not in (".tif", ".tiff"):
        return False
    from weftex.cli.planes import refuse_options, wants_plane

    if recipe.options["window"] is not None:
        refuse_options(args)
        return False
    return wants_plane(args, recipe.options["size"])
