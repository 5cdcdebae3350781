"""The argument parser of all commands: shared options, headings of the help, errors of one line."""

from __future__ import annotations

import argparse
import os
import re
from inspect import cleandoc
from typing import Any, ClassVar, NoReturn

from weftex.cli import terminal
from weftex.errors import InvalidInputError, did_you_mean
from weftex.recipe.declared import tasks_with
from weftex.recipe.options import Option
from weftex.registry import AUTO, owners

HUGE = 2**28  # pixels

_OUTPUT, _SETS, _LARGE = "output", "map sets", "large outputs"
#: Headings in the help, and arguments of `argparse.ArgumentParser.add_argument`.
SHARED: dict[str, tuple[str, dict[str, Any]]] = {
    "--output": ("", {"metavar": "OUT", "required": True,
                      "help": "file to write; a folder for a map set"}),
    "--threads": ("", {"type": int, "metavar": "N",
                       "help": "maximum number of threads; default: one per processor"}),
    "--quiet": ("", {"action": "store_true", "help": "print errors only"}),
    "--verbose": ("", {"action": "store_true", "help": "print the inputs, all parameters and "
                       "the time of each stage"}),
    "--allow-huge": (_OUTPUT, {"action": "store_true", "help": "accept images larger than "
                               f"{HUGE // 10**6} megapixels"}),
    "--save-source": (_OUTPUT, {"metavar": "F.npz", "help": "save the source of every pixel, for "
                                "'weftex replay' and 'weftex report'"}),
    "--preset": (_SETS, {"metavar": "NAME", "help": "write the files of an engine or program, "
                         "such as godot, unity-urp, unreal, gltf or ambientcg, or of your own "
                         ".toml; 'weftex pack --help' lists all"}),
    "--block": (_LARGE, {"type": int, "metavar": "PX", "help": "side of the blocks, a power of "
                         "two; every value gives the same image; default: 2048"}),
    "--restart": (_LARGE, {"action": "store_true",
                           "help": "delete this image and start again"}),
    "--part": (_LARGE, {"metavar": "K/N", "help": "write part K of N, on any machine that shares "
                        "the folder; needs --seed"}),
    "--workers": (_LARGE, {"type": int, "metavar": "N",
                           "help": "number of worker processes on this machine"}),
}  # fmt: skip
#: Those of images that are written block by block.
BLOCKS = ("--part", "--workers", "--restart", "--block")
SHORT = {"--output": "-o", "--verbose": "-v"}
#: The arguments that name what is written.
_WRITTEN = ("output", "save_source", "debug", "picture", "overlay", "correlation")
#: Below headings of the help.
ABOUT = {
    _LARGE: "OUT.tif of more than 268 megapixels, or with --block, is written block by block.\n"
    "The same command resumes an interrupted run."
}
#: Headings of the help, in their order, after the options that most people need.
HEADINGS = ("output", "tiling", "quality", "map sets", "large outputs", "preparation of the sample")
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


class ParserBuilt(Exception):
    """A parser is whole; only raised where parsers are wanted and nothing is to be run."""

    def __init__(self, parser: Parser) -> None:
        super().__init__(parser)
        self.parser = parser


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose errors are one line, and whose help begins with a docstring."""

    #: Whether to raise `ParserBuilt` in place of parsing.
    build_only: ClassVar[bool] = False

    def __init__(self, command: str, docstring: str | None = None) -> None:
        about, heading, examples = cleandoc(docstring or "").partition("examples:")
        # By itself argparse looks for the terminal's width with every option that is added.
        self._columns = 80
        super().__init__(
            f"weftex {command}",
            description=about.rstrip(),
            epilog=heading + examples,
            allow_abbrev=False,
            formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(
                prog, width=self._columns - 2
            ),
        )
        self.command = command
        #: Groups of options by heading; a group without options is not printed.
        self.under = {heading: self.add_argument_group(heading) for heading in HEADINGS}
        self._bare: dict[str, tuple[str, str]] = {}

    def share(self, *flags: str) -> None:
        """Add options that several commands have."""
        for flag in flags:
            heading, how = SHARED[flag]
            group = self.under[heading] if heading else self
            group.add_argument(*([SHORT[flag]] if flag in SHORT else []), flag, **how)
            if heading in ABOUT:
                self.under[heading].description = ABOUT[heading]

    def take(self, *options: Option, **changes: str | bool) -> None:
        """Add declared options; `changes` are arguments of argparse, such as another help."""
        for option in options:
            if option.heading not in (*self.under, "options"):
                self.under[option.heading] = self.add_argument_group(option.heading)
            group = self.under.get(option.heading, self)
            default = option.default_text or ("" if option.default in (None, False, True) else
                                              f"{option.default}")  # fmt: skip
            text = option.help + (f"; default: {default}" if default else "")
            how: dict[str, object] = {"dest": option.dest, "help": text.replace("%", "%%")}
            if option.kind.name == "bool":
                bare = option.default is False
                how["action"] = "store_true" if bare else argparse.BooleanOptionalAction
            else:
                how["metavar"] = option.metavar
            if option.kind.bare is not None:
                how |= {"nargs": "?", "const": option.kind.bare}
                self._bare[option.flag] = option.kind.bare, option.kind.values
            group.add_argument(option.flag, **how | changes)  # type: ignore[arg-type]

    def format_help(self) -> str:
        """Return the help, as wide as the terminal; the usage line has only what is required."""
        import shutil

        self._columns = shutil.get_terminal_size().columns
        formatter = self._get_formatter()
        words = [formatter._format_args(a, a.dest) for a in self._get_positional_actions()]
        required = [action for action in self._actions if action.required and action.option_strings]
        words += [f"{action.option_strings[0]} {action.metavar}" for action in required]
        self.usage = " ".join([self.prog, *words, "[options]"])
        self._optionals._group_actions.sort(key=lambda action: not action.required)
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        """Raise, so that usage errors look like all others."""
        raise InvalidInputError(message)

    def filled(self, argv: list[str]) -> list[str]:
        """Give bare options their values, and join values that begin with a minus."""
        found: list[str] = []
        for word, after in zip(argv, [*argv[1:], ""], strict=False):
            before = found[-1] if found else ""
            text, values = self._bare.get(word, ("", ""))
            if before.startswith("--") and "=" not in before and re.match(r"-[.\d]", word):
                found[-1] = f"{before}={word}"
            elif word in self._bare and not re.fullmatch(values, after):
                found.append(f"{word}={text}")
            else:
                found.append(word)
        return found

    def unknown(self, argv: list[str]) -> list[str]:
        """Return the options that the parser does not have."""
        words = (word.split("=")[0] for word in argv if re.match("--[a-z]", word))
        return [word for word in words if word not in self._option_string_actions]

    def parse(self, argv: list[str]) -> argparse.Namespace:
        """Parse all arguments; an error about an unknown option suggests a known one."""
        if Parser.build_only:
            raise ParserBuilt(self)
        found, left = self.parse_known_args(self.filled(argv))
        for word in left:
            if word.startswith("-"):
                known = [o for o in self._option_string_actions if o.startswith("--")]
                name = word.split("=")[0]
                able = tasks_with(name)
                if able and SYNONYMS.get(name) not in known:
                    raise InvalidInputError(
                        f"{name} has no effect on {self.command}; it is for {', '.join(able)}"
                    )
                of = owners(name[2:].replace("-", "_")) or [AUTO] * (name == "--effort")
                if of and "--method" in known:
                    raise InvalidInputError(f"{name} is for --method {' or '.join(of)}")
                near = did_you_mean(SYNONYMS.get(name, name), known)
                raise InvalidInputError(f"unknown option '{word}'{near}")
        if left:
            option = ["", *argv][argv.index(left[0])]
            bare = option in ("--tileable", "--tileable=xy")
            hint = "; --tileable takes x, y or xy" if bare else ""
            raise InvalidInputError(f"unexpected argument '{left[0]}'{hint}")
        _keep_inputs(vars(found))
        return found


def _keep_inputs(given: dict[str, Any]) -> None:
    """Note what the command reads, and refuse outputs that are among it."""
    values = [value for name, value in given.items() if name not in _WRITTEN]
    words = [word for one in values for word in (one if isinstance(one, list) else [one])]
    terminal.inputs[:] = [w for w in words if isinstance(w, str) and os.path.exists(w)]
    for name in _WRITTEN:
        if given.get(name):
            terminal.refuse_input(given[name])
