"""What the command line understands; the options of a method are those of its dataclass."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

from weftex.errors import InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from weftex.method import Method

_HUGE = 2**28  # pixels
#: Options that may stand alone: the value that they have then, and which words are values of them.
_BARE = {
    "--tileable": ("xy", "x|y|xy"),
    "--straighten": ("", r"[-+.,\deE]*,[-+.,\deE]*"),
    "--even-light": ("2", r"[-+]?\d+"),
}
#: Options whose value may begin with a minus.
_SIGNED = {"--window"}


class Built(Exception):
    """A parser is whole; only raised where parsers are wanted and nothing is to be run."""

    def __init__(self, parser: Parser) -> None:
        super().__init__(parser)
        self.parser = parser


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose errors are one line."""

    #: Whether to raise `Built` in place of parsing.
    only_built: ClassVar[bool] = False

    def __init__(self, command: str, description: str, examples: str) -> None:
        # By itself argparse looks for the terminal's width with every option that is added.
        self._columns = 80
        super().__init__(
            f"weftex {command}",
            description=description,
            epilog=examples,
            allow_abbrev=False,
            formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(
                prog, width=self._columns - 2
            ),
        )

    def format_help(self) -> str:
        """Return the help, as wide as the terminal."""
        import shutil

        self._columns = shutil.get_terminal_size().columns
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        """Raise, so that usage errors look like all others."""
        raise InvalidInputError(message)

    def filled(self, argv: list[str]) -> list[str]:
        """Give bare options their values, so that none takes the file name that follows it."""
        for k in [k for k, word in enumerate(argv[:-1]) if word in _SIGNED][::-1]:
            if re.match(r"-\d", argv[k + 1]):
                argv = [*argv[:k], f"{argv[k]}={argv[k + 1]}", *argv[k + 2 :]]
        pairs = zip(argv, [*argv[1:], ""], strict=False)
        return [
            f"{a}={_BARE[a][0]}" if a in _BARE and not re.fullmatch(_BARE[a][1], b) else a
            for a, b in pairs
        ]

    def parse(self, argv: list[str]) -> argparse.Namespace:
        """Parse all arguments; an unknown option is answered with the nearest known one."""
        if Parser.only_built:
            raise Built(self)
        found, left = self.parse_known_args(self.filled(argv))
        for word in left:
            if word.startswith("-"):
                known = [o for o in self._option_string_actions if o.startswith("--")]
                near = did_you_mean(word.split("=")[0], known)
                raise InvalidInputError(f"unknown option '{word}'{near}")
        if left:
            raise InvalidInputError(f"unexpected argument '{left[0]}'")
        return found


def add_huge(parser: Parser) -> None:
    """Add the option of every command that reads pictures."""
    text = f"take pictures of more than {_HUGE} pixels"
    parser.add_argument("--allow-huge", action="store_true", help=text)


def add_tileable_sample(parser: Parser) -> None:
    """Add the option of every command that can use the sample's borders."""
    text = "the sample itself repeats without a seam, so that patches may run over its borders"
    parser.add_argument("--tileable-sample", action="store_true", help=f"{text}; see 'analyze'")


def add_sample_mask(parser: Parser) -> None:
    """Add the option of every command that can use a part of its sample."""
    text = "picture, white where the sample may be used; or alpha: where it is not clear at all"
    parser.add_argument("--sample-mask", metavar="M", help=text)


def add_turn(parser: Parser) -> None:
    """Add the option of every command that can make more of a sample by mirroring and turning."""
    text = (
        "use copies of the sample too: mirrored (flip), upside down (half), turned by quarters "
        "(4), or all of these (8)"
    )
    parser.add_argument("--turn", metavar="flip|half|4|8", help=text)


def add_mending(parser: Parser) -> None:
    """Add the options that mend a photo before anything is made from it."""
    text = "straighten the photo, by the lattice or rows seen in it, by vectors x1,y1,x2,y2, or by "
    text += (
        "the corners of a rectangle in it, x,y of top left, top right, bottom right, bottom left"
    )
    parser.add_argument("--straighten", nargs="?", const="", metavar="X,Y,...", help=text)
    text = (
        "take slow lighting off the photo; its maps stay as they are. DEGREE, 1 to 8, is that of "
    )
    text += "the surface which the light is taken for; default: 2"
    add = parser.add_argument
    add("--even-light", nargs="?", const=2, type=int, metavar="DEGREE", help=text)


def add_limits(parser: Parser) -> None:
    """Add the options of every command that makes pictures."""
    add_huge(parser)
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def parse_task(
    parser: Parser, argv: list[str], default: str = "auto", *, positional: bool = False
) -> tuple[argparse.Namespace, type[Method], dict[str, Any]]:
    """Parse what all tasks take, and the parameters of the chosen method.

    A task with another default than "auto" takes that for "auto" too. One whose output is a
    `positional` argument writes a folder of many, and no sources.
    """
    add = parser.add_argument
    if positional:
        add("output", metavar="OUT", help="folder to write to")
    else:
        add("-o", "--output", metavar="OUT", required=True, help="file, or folder, to write")
        text = "where each pixel comes from, for 'weftex replay'"
        add("--save-source", metavar="F.npz", help=text)
        text = "write the picture so far there while work goes on, small, and in the end the result"
        add("--preview", metavar="FILE", help=text)
        text = "say what was read and used, and what each stage took"
        add("-v", "--verbose", action="store_true", help=text)
    text = "chosen by the sample" if default == "auto" else default
    add("--method", default=default, metavar="NAME", help=f"see 'weftex methods'; default: {text}")
    add("--seed", type=int, metavar="N", help="the same seed gives the same bytes")
    text = "repeats without a seam, along both axes or one"
    add("--tileable", nargs="?", choices=("xy", "x", "y"), metavar="x|y", help=text)
    add("--threads", type=int, metavar="N", help="use at most so many")
    add_limits(parser)
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
    group = parser.add_argument_group(f"parameters of {name}")
    for field, values in parameters_of(method):
        kind = kind_of(field)
        text = f"{field.metadata['help']}; {values}"
        group.add_argument(
            "--" + field.name.replace("_", "-"),
            dest="parameter_" + field.name,
            type=kind,
            metavar=field.metadata["unit"].upper() or ("TEXT" if kind is str else "N"),
            help=text.replace("%", "%%"),
        )
    if name == AUTO:
        group.description = "with --method NAME --help stand those of another method"
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
        default = field.metadata["default_text"]
        if field.default is not None:
            number = isinstance(field.default, float)
            default = f"{field.default:g}{unit}" if number else f"{field.default}{unit}"
        yield field, f"{bounds(field)}{unit}; default: {default}"


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
            f"{option} is '{text}', more than {_HUGE} pixels; --allow-huge makes it anyway, and "
            "OUT.tif, OUT.zarr and OUT.dzi take any size"
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
    text = "files of the folder that are its maps, where their names do not say so"
    parser.add_argument("--maps", metavar="NAME=FILE,...", type=parse_maps, help=text)


def add_map_weights(parser: Parser) -> None:
    """Add the option of every command that matches on maps."""
    text = "how much maps count in matching, 1 each by default, together as much as the color; 0: "
    text += "not at all. With height=3,normal=2 seams rather run where heights and normals fit"
    add = parser.add_argument
    add("--map-weights", metavar="NAME=N,...", type=parse_weights, help=text)


def add_sets(parser: Parser) -> None:
    """Add the options of every command that writes sets of maps."""
    add_maps(parser)
    add_names(parser)


def add_names(parser: Parser) -> None:
    """Add the options about the files of a set that is written."""
    names = ("ambientcg", "polyhaven", "substance", "gltf")
    text = f"call the maps of a set as {', '.join(names)} does; default: as they came"
    parser.add_argument("--names", choices=names, metavar="NAME", help=text)
    text = "write a MaterialX file beside the maps of a set, which renderers open"
    parser.add_argument("--mtlx", action="store_true", help=text)


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
