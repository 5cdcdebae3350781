"""``-`` for a file: pictures through pipes, as in ``weftex synth - -o - < brick.png | ...``.

A command reads and writes files; what comes through a pipe lies in a folder of its own meanwhile.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from contextlib import contextmanager, redirect_stdout
from typing import TYPE_CHECKING

from weftex.errors import FileError, InvalidInputError
from weftex.io.formats import SIGNATURES

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Options whose value is written, and what `-` stands for there; `-.exr` names another format.
_WRITTEN = dict.fromkeys(("-o", "--output", "--overlay", "--correlation"), ".png")
_WRITTEN["--save-source"] = ".npz"
_PAGES = ("report", "compare")
_SUFFIXES = {"jpeg": ".jpg", "tiff": ".tif", "openexr": ".exr", "jpegxl": ".jxl"}
_STARTS = {
    start: _SUFFIXES.get(kind, f".{kind}")
    for kind, starts in SIGNATURES.items()
    for start in starts
} | {b"RIFF": ".webp", b"PK\3\4": ".npz"}

_folder = ""  # with its separator


def unhidden(text: str) -> str:
    """Return a text in which files of `as_files` are called as what they stand for."""
    return text.replace(_folder, "") if _folder else text


def clear() -> None:
    """Remove what lies there, where the process ends at once."""
    if _folder:
        shutil.rmtree(_folder, ignore_errors=True)


@contextmanager
def as_files(argv: list[str]) -> Iterator[list[str]]:
    """Give arguments with files in place of `-`; what is written there goes out at the end.

    Until then nothing reaches standard output: what a command prints goes to standard error.

    Parameters
    ----------
    argv : list of str
        The command and what follows it.

    Raises
    ------
    InvalidInputError
        If there is more than one of either.
    FileError
        If standard input is a terminal, or has nothing that weftex reads.
    """
    global _folder
    with tempfile.TemporaryDirectory(prefix="weftex-") as folder:
        _folder = os.path.join(os.path.realpath(folder), "")
        words, read, written = list(argv), "", ""
        for place, word in enumerate(argv):
            option = argv[place - 1] if place else ""
            if option in _WRITTEN and (word == "-" or word.startswith("-.")):
                if written:
                    raise InvalidInputError("only one file can be written to standard output")
                if sys.stdout.isatty():
                    raise FileError("- is standard output, which is a terminal here; name a file")
                page = option in ("-o", "--output") and argv[0] in _PAGES
                suffix = word[1:] or (".html" if page else _WRITTEN[option])
                words[place] = written = f"{_folder}standard output{suffix}"
                open(written, "wb").close()
            elif word == "-":
                if read:
                    raise InvalidInputError("standard input can be read once")
                words[place] = read = _received()
        if not written:
            yield words
            return
        with redirect_stdout(sys.stderr):
            yield words
        with open(written, "rb") as file:
            shutil.copyfileobj(file, sys.stdout.buffer)
        sys.stdout.buffer.flush()


def _received() -> str:
    """The path of a file with all of standard input."""
    source = sys.stdin.buffer
    if source.isatty():
        raise FileError("- is standard input, which is a terminal here; send a picture through it")
    head = source.read(16)
    suffix = next((suffix for start, suffix in _STARTS.items() if head.startswith(start)), "")
    if not suffix:
        raise FileError(f"standard input {'has no picture' if head else 'is empty'}")
    path = f"{_folder}standard input{suffix}"
    with open(path, "wb") as file:
        file.write(head)
        shutil.copyfileobj(source, file)
    return path
