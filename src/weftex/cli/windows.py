"""The options of windows of endless planes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weftex.cli.options import parse_size
from weftex.errors import InvalidInputError

if TYPE_CHECKING:
    import argparse

    from weftex.cli.parser import Parser

#: Options that say something else about what is made.
_OTHERS = ("size", "guide", "sample_guide", "tileable")


def add_window(parser: Parser) -> None:
    """Add --window and --period."""
    add = parser.under["tiling"].add_argument
    text = "compute only these pixels of an endless plane; windows agree where they overlap"
    add("--window", metavar="TOP,LEFT,HEIGHT,WIDTH", help=text)
    text = "with --window: number of pixels after which the plane wraps around"
    add("--period", metavar="WxH|N", help=text)


def parse_window(args: argparse.Namespace) -> tuple[int, int, int, int] | None:
    """The window that was asked for; None if none was.

    Raises
    ------
    InvalidInputError
        If it is none, or something stands beside it that has no effect.
    """
    if args.window is None:
        if args.period is not None:
            raise InvalidInputError("--period has no effect without --window; see also --tileable")
        return None
    for name in _OTHERS:
        if getattr(args, name) is not None:
            option = name.replace("_", "-")
            raise InvalidInputError(f"--{option} and --window exclude each other")
    if args.best_of != "1":
        raise InvalidInputError("--best-of and --window exclude each other")
    try:
        top, left, height, width = (int(word) for word in args.window.split(","))
    except ValueError:
        raise InvalidInputError(
            f"--window is '{args.window}'; it must be TOP,LEFT,HEIGHT,WIDTH, such as -100,0,256,256"
        ) from None
    return top, left, height, width


def parse_period(args: argparse.Namespace) -> tuple[int, int] | None:
    """The period of the plane, height and width."""
    return None if args.period is None else parse_size(args.period, huge=True, option="--period")
