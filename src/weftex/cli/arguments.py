"""From the words of a task's command to its recipe, and the limits of all commands."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from weftex.canvas import MAX_PIXELS
from weftex.cli.files import read_input
from weftex.cli.parser import BLOCKS, HUGE, Parser
from weftex.cli.terminal import say
from weftex.errors import InvalidInputError
from weftex.io.formats import TIFF, suffix_of
from weftex.method import Method
from weftex.parameters import bounds, kind_of
from weftex.recipe import TASKS, Recipe
from weftex.recipe.command_line import json_of, value_of
from weftex.recipe.declared import MATERIAL
from weftex.recipe.opening import measured
from weftex.recipe.options import SIZE, Option, read_length
from weftex.registry import AUTO, METHODS, method_class, owners


def given_blocks(args: argparse.Namespace) -> list[str]:
    """Return the names of the options that ask for blocks; a 0 is given, and refused later."""
    values = {flag[2:]: getattr(args, flag[2:]) for flag in BLOCKS}
    return [name for name, value in values.items() if value is not None and value is not False]


def is_plane(recipe: Recipe, args: argparse.Namespace) -> bool:
    """Whether an image is written block by block; raises if options ask for that in vain."""
    suffix, size = suffix_of(args.output), recipe.options["size"]
    if recipe.options["window"] is None and suffix in TIFF:
        pixels = size[0] * size[1] if size else 0
        large = pixels > (MAX_PIXELS if args.allow_huge else HUGE)
        return large or bool(given_blocks(args))
    for name in given_blocks(args):
        raise InvalidInputError(f"--{name} has no effect: only {', '.join(TIFF)} has blocks")
    return False


def parse_task(
    task: str,
    parser: Parser,
    argv: list[str],
    options: Iterable[Option],
    *,
    default: str = "chosen for the sample",
) -> tuple[argparse.Namespace, Recipe]:
    """Parse the words of a command: return its arguments, and the recipe that they make.

    This adds `options`, the method, its parameters and limits to the parser, which has "materials".
    `default` says in words which method is used where none is named.
    """
    parser.take(*options)
    text = f"synthesis method; 'weftex methods' lists them; default: {default}"
    parser.add_argument("--method", metavar="NAME", help=text)
    parser.share("--threads", "--quiet", "--allow-huge")
    name = _method_in(parser.filled(argv))
    fields = _add_parameters(parser, argv, TASKS[task].parameter_method, name)
    args = parser.parse(argv)
    check_numbers(args)
    given = vars(args)
    parameters = {field: given["parameter_" + field] for field in fields}
    paths = args.materials if isinstance(args.materials, list) else [args.materials]
    paths = paths[:1] if task == "tile" else paths  # each photo is a recipe of its own
    if given.get("sample") is not None:
        paths = [*paths, args.sample]
    if isinstance(given.get("size"), str):
        args.size = _in_pixels(args.size, paths[0], args, parser.command)
    chosen = None if args.method in (None, "auto") else args.method
    recipe = Recipe.from_json(json_of(task, paths, given, chosen, parameters), local=True)
    size = recipe.options.get("size")
    if size is not None:
        refuse_huge(size, args)
    return args, recipe


def _in_pixels(text: str, path: str, args: argparse.Namespace, command: str) -> str:
    """Return a size; one in meters, such as 2m or 2mx1.5m, in pixels by the sample's density."""
    try:
        sides = [read_length(side) for side in text.split("x")]
    except ValueError:
        return text  # of pixels, or wrong
    if command == "batch":
        raise InvalidInputError(f"--size is '{text}'; batch needs pixels, as samples may differ")
    given = vars(args)
    spec = {name: value_of(MATERIAL[name], given) for name in ("sample_width", "density")}
    material = read_input(path, args, value_of(MATERIAL["maps"], given))
    stated = material.pictures[material.main].density
    picture = measured(material, spec).pictures[material.main]
    if picture.density is None:
        fix = "weftex prepare sets it" if command == "fuse" else "give the width of what it shows"
        raise InvalidInputError(
            f"--size is '{text}', and {path} states no density; {fix}: --sample-width 0.6m"
        )
    if spec["sample_width"] is None and stated is not None and not args.quiet:
        width = picture.pixels.shape[1] / stated
        say(f"note: {path} states {stated:.5g} pixels per meter, so it is {width:.3g} m "
            "wide; --sample-width corrects it")  # fmt: skip
    return "x".join(str(max(1, round(side * picture.density))) for side in sides)


def _method_in(argv: list[str]) -> str:
    """Return the method that arguments name, or nothing."""
    found = ""
    for word, after in zip(argv, [*argv[1:], ""], strict=False):
        if word == "--method" or word.startswith("--method="):
            found = word[9:] if "=" in word else after
    return found


def _add_parameters(parser: Parser, argv: list[str], default: str, named: str) -> list[str]:
    """Add the parameters of a method, if the arguments have an option that may be one."""
    unknown = parser.unknown(argv)
    if not (unknown or parser.build_only or {"-h", "--help"} & {*argv}):
        return []
    is_named = named not in ("", AUTO)
    name = named if is_named else default
    found = [*parameters_of(method_class(name), parser.command in ("fill", "tile"))]
    fields = [field.name for field, _ in found]
    if not is_named:
        # Methods that have a parameter which the default method lacks are named.
        kinds = _KINDS.get(parser.command, set())
        for option in unknown:
            field_name = option[2:].replace("-", "_")
            able = [one for one in owners(field_name) if kinds <= METHODS[one].supports]
            if able and field_name not in fields:
                raise InvalidInputError(
                    f"{option} belongs to a method, so name one: --method {' or '.join(able)}"
                )
    group = parser.add_argument_group(f"method parameters ({name})")
    for field, values in found:
        kind = kind_of(field)
        group.add_argument(
            "--" + field.name.replace("_", "-"),
            dest="parameter_" + field.name,
            type=kind,
            metavar=field.metadata["unit"].upper() or ("TEXT" if kind is str else "N"),
            help=f"{field.metadata['help']} [{values}]".replace("%", "%%"),
        )
    if name == AUTO:
        group.description = "--method NAME --help shows the parameters of another method"
    return fields


#: What methods must support for a command.
_KINDS = {"fill": {"known"}, "tile": {"known"}, "fuse": {"known", "many"}}


def check_numbers(args: argparse.Namespace) -> None:
    """Raise `InvalidInputError` unless what all tasks take is in its range."""
    if args.quiet and getattr(args, "verbose", False):
        raise InvalidInputError("give --quiet or --verbose, not both")
    if args.threads is not None and args.threads < 1:
        raise InvalidInputError(f"--threads is {args.threads}; it must be 1 or more")


def parameters_of(method: type[Method], hole: bool = False) -> Iterator[tuple[Any, str]]:
    """Give each field of a method, and its range and default, in a hole if asked, in words."""
    for field in dataclasses.fields(method):
        unit = f" {field.metadata['unit']}" if field.metadata["unit"] else ""
        between = " in" if field.metadata["count"] else ""
        default = field.metadata["default_text"]
        if field.default is not None:
            number = isinstance(field.default, float)
            default = f"{field.default:g}{unit}" if number else f"{field.default}{unit}"
        default = (hole and field.metadata["hole_text"]) or default
        values = f"{'one of ' * bool(field.metadata['choices'])}{bounds(field)}{between}{unit}"
        yield field, f"{values}; default: {default}"


def refuse_huge(size: tuple[int, int], args: argparse.Namespace) -> None:
    """Raise `InvalidInputError` for an output that is large by mistake."""
    height, width = size
    any_size = args.allow_huge or suffix_of(args.output or "") in TIFF
    if height * width > HUGE and not any_size:
        raise InvalidInputError(
            f"--size is '{SIZE.text(size)}', more than {HUGE // 10**6} megapixels; --allow-huge "
            "allows it; OUT.tif may have 1,048,576 pixels a side"
        )
