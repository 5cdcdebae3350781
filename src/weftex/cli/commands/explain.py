"""weftex explain: show step by step how a method chooses one pixel."""

from __future__ import annotations

from typing import Any

from weftex.cli.options import parse_task
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish
from weftex.errors import InvalidInputError
from weftex.recipe.command_line import value_of
from weftex.recipe.declared import OUTPUT_SIZE, SEED, TILEABLE
from weftex.recipe.options import PIXEL, Option

_ABOUT = """\
Show step by step how a method chooses one pixel: neighborhoods, errors, candidates, cuts, pyramid
levels. OUT is a folder of images, or one image that shows all steps side by side.\
"""

_EXAMPLES = """\
examples:
  weftex explain sample:pebbles work/ --method quilting --size 160 --seed 7
  weftex explain sample:bricks work.png --method near-regular --size 256 --seed 7
  weftex explain moss.png work/ --method wei-levoy --size 64 --at 40,30
"""

_AT = Option(
    "at", PIXEL, "row and column of the pixel", default_text="one past the middle", metavar="Y,X"
)


def run(argv: list[str]) -> None:
    """Run the command; `argv` is what follows its name."""
    parser = Parser("explain", _ABOUT, _EXAMPLES)
    parser.add_argument(
        "materials", metavar="SAMPLE", help="image, or sample:NAME; a small one is enough"
    )
    parser.add_argument("output", metavar="OUT", help="folder, or image, to write")
    options = [_AT, OUTPUT_SIZE._replace(default_text="128"), TILEABLE, SEED]
    usual = "patch-sampling"
    args, recipe = parse_task("synth", parser, argv, options, method=usual, usual=usual)
    if args.threads is not None:
        raise InvalidInputError("--threads has no effect: one thread works, so that it can be seen")
    at = value_of(_AT, vars(args))

    def work(bar: Bar, outputs: Outputs) -> str:
        from weftex.cli.files import open_materials
        from weftex.explanation import explain
        from weftex.io.formats import READABLE, suffix_of
        from weftex.io.pictures import write_image

        sample = open_materials(recipe, args).sample
        size, tileable = recipe.options["size"] or 128, recipe.options["tileable"]
        how: dict[str, Any] = {"method": recipe.method, "seed": recipe.seed}
        found = explain(sample, size, at=at, tileable=tileable, **how)
        if suffix_of(args.output) in READABLE:
            write_image(outputs.add(args.output), found.strip())
        else:
            outputs.make_folder(args.output)
            for path in found.save(args.output):
                outputs.add(str(path))
        y, x = found.pixel
        return (
            f"{len(found)} steps of {recipe.method.slug} at row {y}, column {x}, in {args.output}, "
            f"in {bar.took:.2f} s"
        )

    finish(work, args.quiet)
