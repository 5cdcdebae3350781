"""weftex tile with --check, --pad or --crop, and of several photos."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.cli.files import plan, read_input
from weftex.cli.parser import Parser
from weftex.cli.terminal import Bar, Outputs, finish, run
from weftex.errors import InvalidInputError
from weftex.exemplar.material import Material, has_several
from weftex.recipe import TASKS
from weftex.recipe.command_line import value_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from weftex.io.pictures import Picture
    from weftex.recipe import Recipe

#: Options of `weftex tile` that do something else than making a photo tileable.
TOOLS = ("--check", "--pad", "--crop")
_DIRECTIONS = "top to bottom", "left to right"
_AXES = TASKS["tile"].options["axes"]


def add_tools(parser: Parser) -> None:
    """Add the options of `TOOLS`, and --picture."""
    add = parser.add_argument_group("check, pad and crop").add_argument
    text = "check whether images are tileable; exit code 0 if all are, 1 if not"
    add("--check", action="store_true", help=text)
    text = "with --check: write the image with the worst border in its middle, marked red"
    add("--picture", metavar="FILE", help=text)
    text = "surround a tileable image with N pixels of the opposite sides, for upscalers and "
    add("--pad", type=int, metavar="N", help=text + "filters; --crop removes them")
    text = "remove N pixels at each side; after an upscaler by 2, N is twice that of --pad"
    add("--crop", type=int, metavar="N", help=text)


def materials_of(
    paths: Sequence[str], output: str = "", *, folders: bool = False
) -> list[tuple[str, str]]:
    """Return the materials in paths, and where the output of each goes.

    A folder of separate pictures stands for all of them, and `output` is then a folder; all
    outputs are folders if `folders`.
    """
    from weftex.cli.commands.batch import Entry, entries_of
    from weftex.io.formats import written_as
    from weftex.io.pictures import is_folder, locate

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
    taken: dict[str, str] = {}
    for path, name, _ in entries:
        if taken.setdefault(name, path) != path:
            raise InvalidInputError(f"{taken[name]} and {path} would both make {name}; rename one")
    return [(e.path, os.path.join(output, e.name + ("" if folders else e.suffix))) for e in entries]


def each_output(
    paths: Sequence[str], args: argparse.Namespace, outputs: Outputs, *, folders: bool = False
) -> Iterator[tuple[str, argparse.Namespace]]:
    """Give each material, and the arguments with the output of it, whose folder is made."""
    from weftex.io.pictures import check_output, is_folder

    found = materials_of(paths, args.output, folders=folders)
    if len(found) > 1 or found[0][1] != args.output:
        outputs.make_folder(args.output)
    for path, output in found:
        if folders or is_folder(path):
            outputs.make_folder(output)
        else:
            check_output(output)
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
        for flag in ("--save-source", "--maps"):
            if vars(args).get(flag, vars(args).get(flag[2:].replace("-", "_"))) is not None:
                raise InvalidInputError(f"{flag} takes one photo, and {args.output} is for several")
        spec = {k: v for k, v in spec.items() if k != "sample"} | {"path": path}
        yield recipe.changed(materials=[spec]), own


def run_tool(argv: list[str]) -> None:
    """Run `weftex tile` with one of `TOOLS`."""
    named = [tool for tool in TOOLS if tool in {word.split("=")[0] for word in argv}]
    if len(named) > 1:
        raise InvalidInputError(f"give only one of {' and '.join(named)}")
    parser = Parser(f"tile {named[0]}", "")
    parser.add_argument("materials", nargs="+")
    parser.take(_AXES)
    parser.share("--quiet", "--allow-huge", *(["--output"] if named != ["--check"] else []))
    add_tools(parser)
    args = parser.parse(argv)
    if args.picture is not None and not args.check:
        raise InvalidInputError("--picture has no effect without --check")
    wanted = value_of(_AXES, vars(args))
    axes = {None: (0, 1), True: (0, 1), "y": (0,), "x": (1,)}[wanted]
    if args.check:
        _check(args, axes)
    else:
        _resize(args, axes, named[0])


def _check(args: argparse.Namespace, axes: tuple[int, ...]) -> None:
    """Print a line for each image; exit code 1 if one is not tileable."""
    from weftex.io.pictures import check_output, write_image
    from weftex.quality import borders_of, draw_borders

    if args.picture is not None:
        check_output(args.picture)

    def work(bar: Bar, outputs: Outputs) -> tuple[list[str], float]:
        lines, worst, picture = list[str](), -1.0, None
        for path, _ in materials_of(args.materials):
            material = read_input(path, args)
            for name, image in material.maps.items():
                borders = borders_of(image)
                bad = [axis for axis in axes if borders[axis].badness > 1]
                badness = max(borders[axis].badness for axis in axes)
                if badness > worst and args.picture is not None:
                    picture = draw_borders(image, borders)
                worst = max(worst, badness)
                said = "; ".join(f"{_DIRECTIONS[axis]}, {borders[axis]}" for axis in bad)
                line = f"not tileable: {said}" if bad else "tileable"
                lines.append(f"{material.pictures[name].path}: {line}")
        if picture is not None:
            write_image(outputs.add(args.picture), picture)
        return lines, worst

    (lines, worst), _ = run(work, args.quiet)
    if not args.quiet:
        print("\n".join(lines))
    if worst > 1:
        raise SystemExit(1)


def _resize(args: argparse.Namespace, axes: tuple[int, ...], tool: str) -> None:
    """Write images with wrapped pixels around them, or without."""
    by = args.pad if tool == "--pad" else args.crop
    if by < 1:
        raise InvalidInputError(f"{tool} is {by}; it must be 1 or more")

    def work(bar: Bar, outputs: Outputs) -> str:
        count = 0
        for path, own in each_output(args.materials, args, outputs):
            material = read_input(path, args)
            pictures = {
                name: replace(one, pixels=_resized(one, _scaled(by, material, name), axes, tool))
                for name, one in material.pictures.items()
            }
            changed = replace(material, pictures=pictures)
            made = plan(
                [changed], changed.exemplar(), argparse.Namespace(**{"preset": None} | vars(own))
            )
            made.write(lambda name, made=made: made.pictures[name].pixels, outputs)  # type: ignore[misc]
            count += len(pictures)
        did = "padded" if tool == "--pad" else "cropped"
        return f"{did} {count} image{'s'[: count > 1]} in {args.output}, in {bar.took:.2f} s"

    finish(work, args.quiet)


def _scaled(by: int, material: Material, name: str) -> int:
    """Return a number of pixels of the main picture in those of a map."""
    from fractions import Fraction

    sizes = [material.pictures[one].pixels.shape[1] for one in (name, material.main)]
    found = by * Fraction(*sizes)
    if found.denominator > 1:
        raise InvalidInputError(
            f"{by} pixels of {material.main} are {float(found):g} of {name}, which is "
            f"{sizes[0]} pixels wide; give a multiple of {Fraction(*sizes).denominator}"
        )
    return int(found)


def _resized(picture: Picture, by: int, axes: tuple[int, ...], tool: str) -> NDArray[Any]:
    pixels = picture.pixels
    if tool == "--pad":
        return np.pad(pixels, [(by * (axis in axes),) * 2 for axis in range(pixels.ndim)], "wrap")
    if any(2 * by >= pixels.shape[axis] for axis in axes):
        most = (min(pixels.shape[axis] for axis in axes) - 1) // 2
        raise InvalidInputError(
            f"{tool} is {by}; {picture.path} is {pixels.shape[1]}x{pixels.shape[0]}, so it can be "
            f"at most {most}"
        )
    return pixels[tuple(slice(by, -by) if axis in axes else slice(None) for axis in (0, 1))]
