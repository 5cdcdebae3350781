"""Print a script that completes weftex commands and options in a shell.

examples:
  weftex completion bash > ~/.local/share/bash-completion/completions/weftex
  weftex completion zsh > ~/.zfunc/_weftex        with ~/.zfunc in fpath, before compinit
  weftex completion fish > ~/.config/fish/completions/weftex.fish
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Any

from weftex.cli.parser import Parser, ParserBuilt
from weftex.errors import missing_packages
from weftex.registry import METHODS

#: Options and arguments that are files or folders, by their names in the help.
_FILES = {"SAMPLE", "PHOTO", "RESULT", "MAP", "OUT", "OUT.html", "F.npz", "FILE"}
_METHODS = ("--method", "method")


Run = Callable[[str, list[str]], None]


def run(argv: list[str], commands: Mapping[str, str], run_command: Run) -> None:
    """Run the command; `argv` is what follows its name, `commands` are all, and what they do."""

    def built(command: str, argv: list[str]) -> Parser:
        Parser.build_only = True
        try:
            run_command(command, argv)
        except ParserBuilt as whole:
            return whole.parser
        finally:
            Parser.build_only = False
        raise AssertionError(f"{command} parses nothing")

    parser = Parser("completion", __doc__)
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), help="shell to complete in")
    shell = parser.parse(argv).shell
    try:
        import shtab
    except ImportError:
        raise missing_packages("completion needs shtab", "completion") from None
    print(shtab.complete(_whole(commands, built, shtab.FILE), shell))


def _whole(
    commands: Mapping[str, str], built: Callable[[str, list[str]], Parser], file: Any
) -> argparse.ArgumentParser:
    """All commands as one parser, each with the parameters of all methods that it takes."""
    whole = argparse.ArgumentParser("weftex", description="Texture synthesis from samples.")
    whole.add_argument("--version", "-V", action="store_true", help="print the version")
    parts = whole.add_subparsers()
    for name, text in commands.items():
        part = parts.add_parser(name, help=text, parents=[built(name, [])], add_help=False)
        if "--method" in part._option_string_actions:
            for method in METHODS:
                for action in built(name, ["--method", method])._actions:
                    if not {*action.option_strings} & {*part._option_string_actions}:
                        part._add_action(action)
        for action in part._actions:
            if action.metavar in _FILES:
                action.complete = file  # type: ignore[attr-defined]
            if _METHODS[bool(not action.option_strings)] in (action.dest, *action.option_strings):
                action.choices = ["auto", *METHODS]
    return whole
