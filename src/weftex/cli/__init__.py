"""The command line: finds the command and prints errors; `commands` has the commands."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from importlib import import_module
from typing import NoReturn

from weftex.cli.terminal import Stopped, say
from weftex.errors import InvalidInputError, WeftexError, did_you_mean

_COMMANDS = (
    "synth",
    "fill",
    "tile",
    "batch",
    "fuse",
    "replay",
    "check",
    "analyze",
    "prepare",
    "estimate",
    "report",
    "compare",
    "methods",
    "samples",
)

_ABOUT = """\
usage: weftex COMMAND ...      (weftex COMMAND --help says more)

  synth     make a picture of any size from a sample of a material
  fill      fill holes of a photo
  tile      make a photo repeat without a seam, its middle untouched
  batch     many outputs from all samples of a folder
  fuse      merge several materials where a map says
  replay    lay a saved result again with another map of the same sample
  check     say whether a picture that is written block by block is all there
  analyze   say what a sample is like: its scale, its lattice, whether it tiles
  prepare   straighten a photo and even its light, before it is a sample
  estimate  guess height and normals of a photo that has none
  compare   every method on one sample, side by side: pictures, figures, times
  report    say how good a result is, in figures and maps of where it fails
  methods   list the methods, or the parameters of one
  samples   list the samples that ship with weftex

  weftex synth sample:bricks -o wall.png --size 1024x768
  weftex synth brick.png -o tile.png --size 512 --tileable --seed 7
  weftex fill photo.png --mask hole.png -o whole.png
  weftex --version
"""


def main(argv: list[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : list of str, optional
        Arguments; those of the process by default.

    Returns
    -------
    int
        The exit code: 0, 2 after an error, 130 after Ctrl-C, 143 after SIGTERM.
    """
    if "numpy" not in sys.modules:
        # Matrix products are small here: threads for them take longer to start than they save.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        arguments = sys.argv[1:] if argv is None else argv
        if not arguments:
            raise InvalidInputError("a command is missing; weftex --help lists them")
        name = arguments[0]
        if name in ("-h", "--help", "help"):
            print(_ABOUT, end="")
        elif name in ("-V", "--version"):
            from importlib.metadata import version

            print(f"weftex {version('weftex')}")
        elif name in _COMMANDS:
            import_module(f"weftex.cli.commands.{name}").run(arguments[1:])
        else:
            what = "option" if name.startswith("-") else "command"
            raise InvalidInputError(f"unknown {what} '{name}'{did_you_mean(name, _COMMANDS)}")
        return 0
    except SystemExit as end:  # argparse after --help
        return int(end.code or 0)
    except (KeyboardInterrupt, Stopped) as end:
        end = end if isinstance(end, Stopped) else Stopped(130)
        say(f"stopped; {end.kept}")
        return end.code
    except MemoryError as error:
        say(f"error: not enough memory{f' ({error})' if str(error) else ''}; make it smaller")
    except WeftexError as error:
        hint = "; --allow-huge takes it anyway" if "max_pixels" in str(error) else ""
        say(f"error: {error}{hint}")
    except BrokenPipeError:  # such as 'weftex methods | head'
        return 141
    except OSError as error:
        say(f"error: {error}")
    return 2


def entry() -> NoReturn:
    """Run a command as a process of its own, which ends here."""
    code = main()
    with suppress(OSError):  # nobody reads on
        sys.stdout.flush()
    # Taking numpy and OpenImageIO down in order takes a tenth of a short run.
    os._exit(code)
