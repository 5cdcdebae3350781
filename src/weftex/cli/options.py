"""Options that commands share, and how their values are read."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from weftex.cli.parser import Parser
    from weftex.method import Method

_HUGE = 2**28  # pixels


def add_huge(to: Parser | argparse._ArgumentGroup) -> None:
    """Add the option of every command that reads images."""
    text = f"accept images larger than {_HUGE // 10**6} megapixels"
    to.add_argument("--allow-huge", action="store_true", help=text)


def add_tileable_sample(parser: Parser) -> None:
    """Add the option of every command that can use the sample's borders."""
    text = "the sample is tileable, so patches can cross its borders; see 'weftex analyze'"
    parser.under["tiling"].add_argument("--tileable-sample", action="store_true", help=text)


def add_sample_mask(parser: Parser) -> None:
    """Add the option of every command that can use a part of its sample."""
    text = "image that is white where the sample may be used; 'alpha': where the sample is opaque"
    add = parser.under["preparation of the sample"].add_argument
    add("--sample-mask", metavar="FILE", help=text)


def add_turn(parser: Parser) -> None:
    """Add the option of every command that can make more of a sample by mirroring and turning."""
    text = (
        "also use copies of the sample that are mirrored (flip), rotated by 180 degrees (half), "
        "rotated by quarter turns (4), or both mirrored and rotated (8)"
    )
    parser.under["quality"].add_argument("--turn", metavar="flip|half|4|8", help=text)


def add_mending(parser: Parser) -> None:
    """Add the options that mend a photo before anything is made from it."""
    add = parser.under["preparation of the sample"].add_argument
    text = (
        "straighten the photo by its own lattice or rows (no value), by lattice vectors "
        "x1,y1,x2,y2, or by the corners of a rectangle in it, clockwise from the top left, as "
        "x1,y1,...,x4,y4"
    )
    add("--straighten", nargs="?", const="", metavar="X,Y,...", help=text)
    text = (
        "remove uneven lighting from the photo; maps stay unchanged; DEGREE is that of the "
        "polynomial that models the light, 1 to 8; higher removes finer changes; default: 2"
    )
    add("--even-light", nargs="?", const=2, type=int, metavar="DEGREE", help=text)


def add_output(parser: Parser) -> None:
    """Add the option of every command that writes an image or a map set."""
    text = "file to write; a folder for a map set"
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=text)


def add_threads(parser: Parser) -> None:
    """Add the option of every command that works on several threads."""
    text = "maximum number of threads; default: one per processor"
    parser.add_argument("--threads", type=int, metavar="N", help=text)


def add_limits(parser: Parser) -> None:
    """Add the options of every command that makes images."""
    add_quiet(parser)
    add_huge(parser)


def add_quiet(parser: Parser) -> None:
    """Add the option of every command that prints a line about its result."""
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def parse_task(
    parser: Parser,
    argv: list[str],
    default: str = "auto",
    *,
    positional: str = "",
    usual: str = "",
    tileable: str = "make the output tileable along both axes, or only along x or y",
) -> tuple[argparse.Namespace, type[Method], dict[str, Any]]:
    """Parse what all tasks take, and the parameters of the chosen method.

    A task with another default than "auto" uses it for "auto" too. `positional` is the help of an
    output without `-o`, for tasks that save no sources; `usual` is the default method in words,
    `tileable` the help of `--tileable`.
    """
    add = parser.add_argument
    if positional:
        add("output", metavar="OUT", help=positional)
    else:
        add_output(parser)
    add("--tileable", nargs="?", choices=("xy", "x", "y"), metavar="x|y", help=tileable)
    add("--seed", type=int, metavar="N", help="random seed; the same seed gives the same output")
    usual = usual or ("chosen for the sample" if default == "auto" else default)
    text = f"synthesis method; 'weftex methods' lists them; default: {usual}"
    add("--method", default=default, metavar="NAME", help=text)
    if not positional:
        text = "print what was read, all parameters and the time that each stage took"
        add("-v", "--verbose", action="store_true", help=text)
        add = parser.under["output"].add_argument
        text = "save the source of every pixel, for 'weftex replay' and 'weftex report'"
        add("--save-source", metavar="F.npz", help=text)
        text = "image to update during the run: a small preview at first, the result at the end"
        add("--preview", metavar="FILE", help=text)
    add_threads(parser)
    add_quiet(parser)
    add_huge(parser.under["output"])
    argv = parser.filled(argv)
    chooser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    chooser.add_argument("--method", default=default, nargs="?")
    name = chooser.parse_known_args(argv)[0].method or ""
    from weftex.naming import kind_of
    from weftex.tasks.method_names import AUTO, method_class

    by_default = name in (AUTO, default) and not any(word.startswith("--method") for word in argv)
    by_default |= name == AUTO
    name = default if name == AUTO else name
    method = method_class(name)
    if name == AUTO:
        _refuse_parameters(parser, argv)
    group = parser.add_argument_group(f"method parameters ({name})")
    for field, values in parameters_of(method):
        kind = kind_of(field)
        text = f"{field.metadata['help']} [{values}]"
        group.add_argument(
            "--" + field.name.replace("_", "-"),
            dest="parameter_" + field.name,
            type=kind,
            metavar=field.metadata["unit"].upper() or ("TEXT" if kind is str else "N"),
            help=text.replace("%", "%%"),
        )
    if name == AUTO:
        group.description = "--method NAME --help shows the parameters of another method"
    args = parser.parse(argv)
    args.method, args.by_default = name, by_default
    check_numbers(args)
    given = {
        name.removeprefix("parameter_"): value
        for name, value in vars(args).items()
        if name.startswith("parameter_") and value is not None
    }
    return args, method, given


def check_numbers(args: argparse.Namespace) -> None:
    """Raise `InvalidInputError` unless what all tasks take is in its range."""
    if args.quiet and getattr(args, "verbose", False):
        raise InvalidInputError("--quiet and --verbose exclude each other")
    if args.threads is not None and args.threads < 1:
        raise InvalidInputError(f"--threads is {args.threads}; it must be 1 or more")
    if args.seed is not None and not 0 <= args.seed < 2**64:
        raise InvalidInputError(f"--seed is {args.seed}; it must be from 0 to 2**64 - 1")


def _refuse_parameters(parser: Parser, argv: list[str]) -> None:
    """Name the methods that have a parameter which "auto" chooses by itself."""
    from weftex.methods import owners

    for word in argv:
        option = word.split("=")[0]
        if option.startswith("--") and option not in parser._option_string_actions:
            able = owners(option[2:].replace("-", "_"))
            if able:
                raise InvalidInputError(
                    f"{option} belongs to a method, so name one: --method {' or '.join(able)}"
                )


def parameters_of(method: type[Method]) -> Iterator[tuple[Any, str]]:
    """Give each field of a method, and its range and default in words."""
    from dataclasses import fields

    from weftex.parameters import bounds

    for field in fields(method):
        unit = f" {field.metadata['unit']}" if field.metadata["unit"] else ""
        between = " in" if field.metadata["count"] else ""
        default = field.metadata["default_text"]
        if field.default is not None:
            number = isinstance(field.default, float)
            default = f"{field.default:g}{unit}" if number else f"{field.default}{unit}"
        values = f"{'one of ' * bool(field.metadata['choices'])}{bounds(field)}{between}{unit}"
        yield field, f"{values}; default: {default}"


def parse_size(text: str, huge: bool, option: str = "--size") -> tuple[int, int]:
    """Height and width from 'WxH' or 'N'; 2k is 2048."""
    try:
        sides = [
            int(side.removesuffix("k")) * (1024 if side.endswith("k") else 1)
            for side in text.lower().split("x")
        ]
        width, height = sides * 2 if len(sides) == 1 else sides
    except ValueError:
        raise InvalidInputError(
            f"{option} is '{text}'; it must be WxH or N, such as 640x480 or 2k"
        ) from None
    if min(height, width) < 1:
        raise InvalidInputError(f"{option} is '{text}'; both sides must be 1 or more")
    if height * width > _HUGE and not huge:
        raise InvalidInputError(
            f"{option} is '{text}', more than {_HUGE // 10**6} megapixels; --allow-huge makes it "
            "anyway, and OUT.tif, OUT.zarr and OUT.dzi take any size"
        )
    return height, width


def parse_best_of(text: str) -> int | list[str]:
    """A number of seeds, or names of methods."""
    try:
        return int(text)
    except ValueError:
        return parse_names(text)


def parse_names(text: str) -> list[str]:
    """Names of methods, with commas between them."""
    return [word.strip() for word in text.split(",")]


def add_maps(parser: Parser) -> None:
    """Add the option of every command whose sample may be a folder of maps."""
    text = "files of the maps in the folder, if their names do not say which map they are"
    add = parser.under["map sets"].add_argument
    add("--maps", metavar="NAME=FILE,...", type=parse_maps, help=text)


def add_map_weights(parser: Parser) -> None:
    """Add the option of every command that matches on maps."""
    text = (
        "weights of the maps in matching, such as height=3,normal=2; higher makes seams run where "
        "that map matches, 0 ignores it; default: 1 each"
    )
    add = parser.under["map sets"].add_argument
    add("--map-weights", metavar="NAME=N,...", type=parse_weights, help=text)


def add_sets(parser: Parser) -> None:
    """Add the options of every command that writes sets of maps."""
    add_maps(parser)
    add_names(parser)


def add_names(parser: Parser) -> None:
    """Add the options about the files of a set that is written."""
    names = ("ambientcg", "polyhaven", "substance", "gltf")
    text = f"how to name the written maps: {', '.join(names)}; default: as in the sample"
    add = parser.under["map sets"].add_argument
    add("--names", choices=names, metavar="STYLE", help=text)
    text = "also write a MaterialX file (.mtlx), which renderers can open"
    add("--mtlx", action="store_true", help=text)


def parse_weights(text: str) -> dict[str, float]:
    """Numbers by maps' names, from 'height=2,normal=0.5'."""
    values = {name: k for name, k in parse_values(text).items() if not isinstance(k, str)}
    if len(values) < text.count(",") + 1:
        raise argparse.ArgumentTypeError(f"'{text}' must be maps and numbers: height=2,normal=0.5")
    return values


def parse_values(text: str) -> dict[str, float | str]:
    """Values by maps' names, from 'height=0.5,normal=flat'."""
    values: dict[str, float | str] = {}
    for word in text.split(","):
        name, _, value = (part.strip() for part in word.partition("="))
        try:
            if not name or name in values:
                raise ValueError
            values[name] = value if value == "flat" else float(value)
        except ValueError:
            raise argparse.ArgumentTypeError(
                f"'{word.strip()}' must be a map and its value, each once: height=0.5,normal=flat"
            ) from None
    return values


def parse_maps(text: str) -> dict[str, str]:
    """Maps by what they are, from 'color=a.png,normal=b.png'."""
    maps: dict[str, str] = {}
    for word in text.split(","):
        name, _, file = (part.strip() for part in word.partition("="))
        if not name or not file or name in maps:
            raise argparse.ArgumentTypeError(
                f"'{word.strip()}' must be a name and a file, color=FILE, each once"
            )
        maps[name] = file
    return maps


def parse_colors(text: str) -> list[tuple[int, ...]]:
    """Colors from '#rrggbb,#rrggbb,...' or gray levels '0,255,...', for maps of 8 bits."""
    return [_color(word.strip()) for word in text.split(",")]


def parse_shares(option: str, text: str) -> tuple[float, ...]:
    """Numbers with commas between them."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise InvalidInputError(
            f"{option} is '{text}'; it must be numbers with commas between them"
        ) from None


def parse_mixed(text: str) -> dict[tuple[int, ...], tuple[int, int]]:
    """Colors of mixed regions from '#rrggbb=1+2,...'; samples count from 1."""
    mixed = {}
    for word in text.split(","):
        color, _, pair = word.partition("=")
        try:
            first, second = (int(number) - 1 for number in pair.split("+"))
        except ValueError:
            raise InvalidInputError(
                f"--mixed has '{word.strip()}'; it must be a color and two samples, #rrggbb=1+2"
            ) from None
        mixed[_color(color.strip())] = first, second
    return mixed


def _color(word: str) -> tuple[int, ...]:
    try:
        if word.startswith("#") and len(word) == 7:
            return tuple(bytes.fromhex(word[1:]))
        return (int(word),)
    except ValueError:
        raise InvalidInputError(f"'{word}' is no color; it must be #rrggbb or a level") from None
