"""The argument parser of all commands: headings of the help, and errors of one line."""

from __future__ import annotations

import argparse
import re
from typing import ClassVar, NoReturn

from weftex.errors import InvalidInputError, did_you_mean

#: Headings of the help, in their order, after the options that most people need.
HEADINGS = (
    "output",
    "tiling",
    "quality",
    "map sets",
    "large outputs",
    "preparation of the sample",
)
#: Names that other programs use, and the options that mean the same here.
SYNONYMS = {
    "--algorithm": "--method",
    "--dimensions": "--size",
    "--height": "--size",
    "--jobs": "--threads",
    "--loop": "--tileable",
    "--out": "--output",
    "--periodic": "--tileable",
    "--random-seed": "--seed",
    "--resolution": "--size",
    "--seamless": "--tileable",
    "--silent": "--quiet",
    "--tile": "--tileable",
    "--width": "--size",
    "--wrap": "--tileable",
}
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
        #: Groups of options by heading; a group without options is not printed.
        self.under = {heading: self.add_argument_group(heading) for heading in HEADINGS}

    def format_help(self) -> str:
        """Return the help, as wide as the terminal; the usage line has only what is required."""
        import shutil

        self._columns = shutil.get_terminal_size().columns
        words = [
            self._get_formatter()._format_args(a, a.dest) for a in self._get_positional_actions()
        ]
        required = [action for action in self._actions if action.required and action.option_strings]
        words += [f"{action.option_strings[0]} {action.metavar}" for action in required]
        self.usage = " ".join([self.prog, *words, "[options]"])
        self._optionals._group_actions.sort(key=lambda action: not action.required)
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
        """Parse all arguments; an error about an unknown option suggests a known one."""
        if Parser.only_built:
            raise Built(self)
        found, left = self.parse_known_args(self.filled(argv))
        for word in left:
            if word.startswith("-"):
                known = [o for o in self._option_string_actions if o.startswith("--")]
                name = word.split("=")[0]
                near = did_you_mean(SYNONYMS.get(name, name), known)
                raise InvalidInputError(f"unknown option '{word}'{near}")
        if left:
            option = ["", *argv][argv.index(left[0])]
            bare = option in ("--tileable", "--tileable=xy")
            hint = "; --tileable takes x, y or xy" if bare else ""
            raise InvalidInputError(f"unexpected argument '{left[0]}'{hint}")
        return found
