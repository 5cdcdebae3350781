"""The commands that do a task: synth, fill, tile and fuse."""

from __future__ import annotations

import argparse
from functools import partial

from weftex.cli.arguments import is_plane, parse_task
from weftex.cli.files import open_job, pixels_of, report, write_debug
from weftex.cli.parser import BLOCKS, Parser
from weftex.cli.terminal import Bar, Outputs, run_and_report
from weftex.cli.tiling import TOOLS, add_tools, each_job, run_tool
from weftex.errors import InvalidInputError, size_words
from weftex.recipe import Recipe
from weftex.recipe.declared import options_of
from weftex.recipe.opening import OpenedRecipe
from weftex.results.synthesis import Synthesis


def run_synth(argv: list[str]) -> None:
    """Make an image of any size from a sample of a material.

    examples:
      weftex synth brick.png -o wall.png --size 1024x768 --save-source wall.npz
      weftex synth brick.png -o tile.png --size 512 --tileable --seed 7
      weftex synth near.jpg far.jpg -o wall.png           several photos of one material
      weftex synth stone_wall/ -o big/ --size 2k          a folder of aligned maps
      weftex synth brick.png -o wall.png --method quilting --patch-size 48
      weftex synth brick.png -o wall.png --best-of 8      the best of eight seeds
      weftex synth photo.jpg -o wall.png --straighten --even-light
      weftex synth brick.png -o part.png --window 10000,-500,512,512 --seed 7    endless texture
      weftex synth brick.png -o wall.tif --size 100000x100000 --workers 4
      weftex synth moss.png -o face.png --method ashikhmin --guide face.png
      weftex synth a.png -o new.png --sample-guide painted.png --guide b.png
    """
    parser = Parser("synth", run_synth.__doc__)
    text = "image, folder of maps, or sample:NAME; several must show the same material"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    text = "folder for images that show how the result was composed: sources, patches, seams"
    parser.under["output"].add_argument("--debug", metavar="DIR", help=text)
    parser.share(*BLOCKS)
    args, recipe = _parsed(parser, argv, "chosen for the sample")
    if is_plane(recipe, args):
        from weftex.cli.commands.planes import synthesize

        synthesize(recipe, args)
    else:
        _do(recipe, args)


def run_fill(argv: list[str]) -> None:
    """Fill the holes in a photo.

    All other pixels stay unchanged unless --overlap is given. Without --method, weftex uses
    graphcut; with --sample or a method parameter, patch-sampling.

    examples:
      weftex fill photo.png --mask hole.png -o whole.png
      weftex fill erased.png -o whole.png                 fill the transparent pixels
      weftex fill photo.png --mask hole.png -o whole.png --sample grass.png
      weftex fill stone_wall/ --mask hole.png -o whole/   a folder of aligned maps
    """
    parser = Parser("fill", run_fill.__doc__)
    text = "image, folder of maps, or sample:NAME"
    parser.add_argument("materials", metavar="PHOTO", help=text)
    text = "image to fill the holes from, in place of the photo"
    parser.add_argument("--sample", metavar="FILE", help=text)
    args, recipe = _parsed(parser, argv, "chosen for the photo")
    _do(recipe, args)


def run_tile(argv: list[str]) -> None:
    """Make photos tileable at their own size.

    Only a border changes; all other pixels stay unchanged. --check checks images instead; --pad and
    --crop add and remove pixels around tileable images.

    examples:
      weftex tile photo.jpg -o tile.png
      weftex tile photo.jpg -o strip.png --tileable x --border 40
      weftex tile stone_wall/ -o tile/                    a folder of aligned maps
      weftex tile photos/ -o tiles/                       a folder of photos and map sets
      weftex tile --check tiles/ --picture border.png     exit code 1 if one is not tileable
      weftex tile --pad 32 tile.png -o padded.png         before an upscaler
    """
    if {word.split("=")[0] for word in argv} & {*TOOLS}:
        run_tool(argv)
        return
    parser = Parser("tile", run_tile.__doc__)
    text = "images, folders of maps or of separate images, or sample:NAME"
    parser.add_argument("materials", metavar="PHOTO", nargs="+", help=text)
    add_tools(parser)
    args, recipe = _parsed(parser, argv, "chosen for the photo")
    if args.picture is not None:
        raise InvalidInputError("--picture has no effect without --check")

    def work(bar: Bar, outputs: Outputs) -> str:
        jobs = each_job(recipe, args, outputs)
        return "\n".join(_make(one, own, bar, outputs) for one, own in jobs)

    run_and_report(work, args.quiet, verbose=args.verbose)


def run_fuse(argv: list[str]) -> None:
    """Make one image of several materials.

    A label map has one color for each sample, and says where each goes. --colors lists the colors.
    Without it, the color at the top left belongs to the first sample, and the next new color, row
    by row, to the second. --map gradient needs no image.

    examples:
      weftex fuse clover.png grape.png plum.png --map map.png -o field.png
      weftex fuse clover.png grape.png --map map.png --colors '#ff0000,#0000ff' -o field.png
      weftex fuse purple.png yellow.png --map gradient --size 400x400 -o beans.png
      weftex fuse stone_wall/ bark/ --map map.png --missing metallic=0 -o both/      folders of maps
      weftex fuse sand.png grass.png rock.png --map gradient --direction 0 --size 400 -o shore.png
    """
    parser = Parser("fuse", run_fuse.__doc__)
    text = "two or more images, folders of maps, or sample:NAME"
    parser.add_argument("materials", metavar="SAMPLE", nargs="+", help=text)
    args, recipe = _parsed(parser, argv, "chosen for each sample")
    _do(recipe, args)


def _parsed(parser: Parser, argv: list[str], default: str) -> tuple[argparse.Namespace, Recipe]:
    """Add what all tasks take, and parse; see `parse_task`."""
    parser.share("--output", "--preset", "--verbose", "--save-source")
    task = parser.command
    return parse_task(task, parser, argv, options_of(task), default=default)


def _do(recipe: Recipe, args: argparse.Namespace) -> None:
    """Do a task; its output appears when it has ended well."""
    run_and_report(partial(_make, recipe, args), args.quiet, verbose=args.verbose)


def _make(recipe: Recipe, args: argparse.Namespace, bar: Bar, outputs: Outputs) -> str:
    """Do a task, write its output, and return what to print."""
    debug, start = getattr(args, "debug", None), bar.took
    job, files, told = open_job(recipe, args, outputs)
    if debug is not None:
        outputs.make_folder(debug)
    result = job.make(progress=bar, threads=args.threads)
    files.write(outputs.staged_path, pixels_of(result, files.main), args.threads)
    if args.save_source is not None:
        result.save(outputs.staged_path(args.save_source))
    if debug is not None:
        write_debug(result, debug, outputs)
    if recipe.task == "fill" and not job.hole.any():
        return f"the mask is empty; {args.output} is the unchanged photo"
    return report(args, result, _done(job, result), bar.took - start, told)


def _done(job: OpenedRecipe, result: Synthesis) -> str:
    """What was done, in words that the name of the output follows."""
    if job.recipe.task == "fill":
        return f"filled {int(job.hole.sum())} pixels ({100 * job.hole.mean():.1f} %) of"
    if job.recipe.task == "fuse":
        return f"fused {len(job.prepared)} samples in"
    made = f"made {size_words(result.shape)}"
    if job.shape != job.asked:
        made += f", the nearest size to {size_words(job.asked)} that fits:"
    return {"synth": made, "tile": "made tileable:"}[job.recipe.task]
