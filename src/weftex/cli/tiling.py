"""weftex tile with --check, --pad or --crop, and of several photos."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence

from weftex.cli.files import plan, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, run, run_and_report
from weftex.errors import InvalidInputError
from weftex.exemplar.material import has_several, with_border
from weftex.io.formats import written_as
from weftex.io.pictures import check_output, is_folder, locate, write_image
from weftex.recipe import TASKS, Recipe
from weftex.recipe.command_line import value_of
from weftex.recipe.declared import CROP, PAD
from weftex.recipe.options import Option

#: Options of `weftex tile` that do something else than making a photo tileable.
TOOLS = ("--check", "--pad", "--crop")
_DIRECTIONS = "top to bottom", "left to right"
_AXES = TASKS["tile"].options["axes"]


def add_tools(parser: Parser) -> None:
    """Add the options of `TOOLS`, and --picture."""
    parser.under[PAD.heading] = group = parser.add_argument_group(PAD.heading)
    add = group.add_argument
    text = "check whether images are tileable; exit code 0 if all are, 1 if not"
    add("--check", action="store_true", help=text)
    text = "with --check: write the image with the worst border in its middle, marked red"
    add("--picture", metavar="FILE", help=text)
    parser.take(PAD, CROP)


def materials_of(
    paths: Sequence[str], output: str = "", *, folders: bool = False
) -> list[tuple[str, str]]:
    """Return the materials in paths, and where the output of each goes.

    A folder of separate pictures stands for all of them, and `output`, if any, is then a folder;
    all outputs are folders if `folders`.
    """
    from weftex.cli.commands.batch import Entry, entries_of, refuse_twins

    if len(paths) == 1 and not has_several(paths[0]):
        return [(paths[0], output)]
    entries: list[Entry] = []
    for path in paths:
        if has_several(path):
            entries += entries_of(path, output)
        else:
            name, suffix = os.path.basename(os.path.abspath(path.removeprefix("sample:"))), ""
            if not is_folder(path):
                suffix, name = written_as(locate(path)[0]), os.path.splitext(name)[0]
            entries.append(Entry(path, name, suffix))
    if output:
        refuse_twins(entries)
    return [(e.path, os.path.join(output, e.name + ("" if folders else e.suffix))) for e in entries]


def each_output(
    paths: Sequence[str], args: argparse.Namespace, outputs: Outputs, *, folders: bool = False
) -> Iterator[tuple[str, argparse.Namespace]]:
    """Give each material, and the arguments with the output of it, whose folder is made."""
    found = materials_of(paths, args.output, folders=folders)
    if len(found) > 1 or found[0][1] != args.output:
        outputs.make_folder(args.output)
    for path, output in found:
        if folders or is_folder(path):
            outputs.make_folder(output)
        yield path, argparse.Namespace(**vars(args) | {"output": output})


def each_job(
    recipe: Recipe, args: argparse.Namespace, outputs: Outputs
) -> Iterator[tuple[Recipe, argparse.Namespace]]:
    """Give the recipe of each material, and its arguments; see `each_output`."""
    spec = dict(recipe.materials[0])
    for path, own in each_output(args.materials, args, outputs):
        if own.output == args.output:
            yield recipe, own
            continue
        for flag, given in (("--save-source", args.save_source), ("--maps", args.maps)):
            if given is not None:
                raise InvalidInputError(f"{flag} works for one photo, not for several")
        spec = {k: v for k, v in spec.items() if k != "sample"} | {"path": path}
        yield recipe.changed(materials=[spec]), own


def run_tool(argv: list[str]) -> None:
    """Run `weftex tile` with one of `TOOLS`."""
    named = [tool for tool in TOOLS if tool in {word.split("=")[0] for word in argv}]
    if len(named) > 1:
        raise InvalidInputError(f"give only one of {' and '.join(named)}")
    parser = Parser(f"tile {named[0]}")
    parser.add_argument("materials", nargs="+")
    parser.take(_AXES)
    parser.share("--quiet", "--allow-huge", *(["--output"] if named != ["--check"] else []))
    parser.set_defaults(preset=None)
    add_tools(parser)
    args = parser.parse(argv)
    if args.picture is not None and not args.check:
        raise InvalidInputError("--picture has no effect without --check")
    axes = {None: (0, 1), True: (0, 1), "y": (0,), "x": (1,)}[value_of(_AXES, vars(args))]
    if args.check:
        _check(args, axes)
    else:
        _resize(args, axes, PAD if named[0] == PAD.flag else CROP)


def _check(args: argparse.Namespace, axes: tuple[int, ...]) -> None:
    """Print a line for each image; exit code 1 if one is not tileable."""
    from weftex.quality import borders_of_each, draw_borders

    if args.picture is not None:
        check_output(args.picture)

    def work(bar: Bar, outputs: Outputs) -> tuple[list[str], float]:
        lines, worst, picture = list[str](), -1.0, None
        for path, _ in materials_of(args.materials):
            material = read_input(path, args)
            for name, borders in borders_of_each(material.maps).items():
                bad = [axis for axis in axes if borders[axis].badness > 1]
                badness = max(borders[axis].badness for axis in axes)
                if badness > worst and args.picture is not None:
                    picture = draw_borders(material.maps[name], borders)
                worst = max(worst, badness)
                said = "; ".join(f"{_DIRECTIONS[axis]}, {borders[axis]}" for axis in bad)
                line = f"not tileable: {said}" if bad else "tileable"
                lines.append(f"{material.pictures[name].path}: {line}")
        if picture is not None:
            write_image(outputs.staged_path(args.picture), picture)
        return lines, worst

    (lines, worst), _ = run(work, args.quiet)
    if not args.quiet:
        print("\n".join(lines))
    if worst > 1:
        raise SystemExit(1)


def _resize(args: argparse.Namespace, axes: tuple[int, ...], option: Option) -> None:
    """Write images with wrapped pixels around them, or without."""
    by = {option.name: value_of(option, vars(args))}

    def work(bar: Bar, outputs: Outputs) -> str:
        count = 0
        for path, own in each_output(args.materials, args, outputs):
            changed = with_border(read_input(path, args), **by, axes=axes, flag="--")
            files, _ = plan([changed], changed.exemplar(), own)
            files.write(outputs.staged_path)
            count += len(changed.pictures)
        did = "padded" if option is PAD else "cropped"
        return f"{did} {count} image{'s'[: count > 1]} in {args.output}, in {bar.took:.2f} s"

    run_and_report(work, args.quiet)
