"""Make textures from samples; 'weftex COMMAND --help' shows the options of a command.

commands:
{commands}

  weftex synth sample:bricks -o wall.png --size 1024x768
  weftex synth brick.png -o tile.png --size 2k --tileable --seed 7
  weftex synth - -o - < brick.png > wall.png       standard input and output
  weftex fill photo.png --mask hole.png -o whole.png
  weftex --for-program synth ...                   messages and progress as JSON
  weftex --version

exit codes: 0 success; 1 'tile --check' found an image that is not tileable; 2 error, explained in
one line; 130 Ctrl-C; 143 SIGTERM; 129 SIGHUP, or closed standard input with --for-program; 141
closed pipe. A command that fails writes no output, except that 'batch' and images written block by
block keep their finished parts.
"""

from __future__ import annotations

import gc
import os
import shlex
import sys
from functools import partial
from importlib import import_module
from typing import NoReturn

from weftex.cli import terminal
from weftex.cli.terminal import (
    Stopped,
    hear_signals,
    open_closed_streams,
    remove_temporary_files,
    say,
)
from weftex.errors import InvalidInputError, WeftexError, did_you_mean

#: Commands, and what they do in a few words.
_COMMANDS = {
    "synth": "make an image of any size from a sample of a material",
    "fill": "fill the holes in a photo",
    "tile": "make photos tileable, check whether they are, pad and crop them",
    "atlas": "make corner tiles of a material, for an endless texture in an engine",
    "batch": "make images from every sample in a folder",
    "fuse": "make one image of several materials, according to a label map",
    "replay": "make another map of a saved result",
    "check": "check that an image written block by block is complete",
    "analyze": "measure a sample: scale, lattice, whether it is tileable",
    "prepare": "straighten a photo, and remove uneven light",
    "estimate": "estimate the maps that a photo lacks: height, normals, occlusion",
    "pack": "write a map set for an engine",
    "unpack": "separate the packed maps of an engine",
    "compare": "run every method on one sample: images, scores, times",
    "studio": "open the studio in the browser",
    "report": "measure how good a result is, with pictures of its flaws",
    "methods": "list the methods, or the parameters of one",
    "samples": "list the samples that ship with weftex",
    "completion": "print a script that completes commands and options in bash, zsh or fish",
}
#: Commands whose function is not `run` of the module that is called as they are.
_HOMES = {
    "synth": "tasks:run_synth",
    "fill": "tasks:run_fill",
    "tile": "tasks:run_tile",
    "fuse": "tasks:run_fuse",
    "check": "planes:run_check",
    "unpack": "pack:run_unpack",
    "samples": "methods:run_samples",
}


def main(argv: list[str] | None = None) -> int:
    """Run a command, by default that of the process, and return its exit code."""
    if "numpy" not in sys.modules:
        # Matrix products are small here: threads for them take longer to start than they save.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        arguments = sys.argv[1:] if argv is None else argv
        terminal.for_program = arguments[:1] == ["--for-program"]
        try:
            _run(arguments[terminal.for_program :])
        except SystemExit as end:  # argparse after --help
            return int(end.code or 0)
        finally:
            sys.stdout.flush()
        return 0
    except (KeyboardInterrupt, Stopped) as end:
        end = end if isinstance(end, Stopped) else Stopped(130)
        say(end.left, "stopped")
        return end.code
    except MemoryError as error:
        size = f" ({error})" if str(error) else ""
        say(f"not enough memory{size}; make the image smaller", "error")
    except WeftexError as error:
        hint = "; --allow-huge accepts it" if "max_pixels" in str(error) else ""
        say(f"{error}{hint}", "error")
    except BrokenPipeError:  # such as 'weftex methods | head'
        return 141
    except OSError as error:
        what = f"{error.filename}: " if error.filename else ""
        say(f"{what}{error.strerror or error}", "error")
    return 2


def _run(arguments: list[str]) -> None:
    """Run the command that the first argument names; `-` stands for pipes."""
    if not arguments:
        raise InvalidInputError("a command is missing; weftex --help lists them")
    name = arguments[0]
    if name in ("-h", "--help", "help"):
        lines = (f"  {name:10}  {text}" for name, text in _COMMANDS.items())
        print((__doc__ or "").format(commands="\n".join(lines)), end="")
    elif name in ("-V", "--version"):
        # Of the code that runs, whatever is installed beside it.
        print(f"weftex {sys.modules['weftex'].__version__}")
    elif name not in _COMMANDS:
        if name.startswith("sample:") or os.path.splitext(name)[1] or os.path.exists(name):
            command = f"weftex synth {shlex.quote(name)} -o out.png"
            raise InvalidInputError(f"a command is missing before '{name}'; try: {command}")
        what = "option" if name.startswith("-") else "command"
        raise InvalidInputError(f"unknown {what} '{name}'{did_you_mean(name, _COMMANDS)}")
    elif any(word.startswith("-") and word[1:2] in ("", ".") for word in arguments):
        if terminal.for_program:
            raise InvalidInputError("--for-program takes files; - stands for a pipe")
        from weftex.io.streams import as_files

        sending = partial(hear_signals, "standard output may have received a part")
        with as_files(arguments, sending) as words:
            _run_command(name, words[1:])
    else:
        _run_command(name, arguments[1:])


def _run_command(name: str, argv: list[str]) -> None:
    """Run a command; `argv` is what follows its name."""
    if name == "completion":
        from weftex.cli.commands.completion import run

        run(argv, _COMMANDS, _run_command)
    else:
        module, _, function = _HOMES.get(name, f"{name}:run").partition(":")
        gc.disable()  # modules are no garbage, and looking for it takes a twentieth of a short run
        command = getattr(import_module(f"weftex.cli.commands.{module}"), function)
        gc.freeze()
        gc.enable()
        command(argv)


def entry() -> NoReturn:
    """Run a command as a process of its own, which ends here."""
    open_closed_streams()
    hear_signals()
    code = main()
    remove_temporary_files()
    # Taking numpy and OpenImageIO down in order takes a tenth of a short run.
    os._exit(code)
