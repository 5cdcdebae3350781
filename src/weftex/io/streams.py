"""``-`` for a file: pictures through pipes, as in ``weftex synth - -o - < brick.png | ...``.

A command reads and writes files; what comes through a pipe lies in a folder of its own meanwhile.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout

from weftex.errors import FileError, InvalidInputError
from weftex.io import temporary
from weftex.io.formats import SIGNATURES, SUFFIXES, file_error
from weftex.io.pictures import MAX_PIXELS

#: Options whose value is written, and what `-` stands for there; `-.exr` names another format.
_WRITTEN = dict.fromkeys(("-o", "--output", "--overlay"), ".png")
_WRITTEN["--save-source"] = ".npz"
_PAGES = ("report", "compare")
_STARTS = {
    start: SUFFIXES.get(kind, f".{kind}") for kind, starts in SIGNATURES.items() for start in starts
} | {b"RIFF": ".webp", b"PK\3\4": ".npz"}

_folder = ""  # with its separator
_MOST_BYTES = 16 * MAX_PIXELS  # of standard input


def unhidden(text: str) -> str:
    """Return a text in which files of `as_files` are called as what they stand for."""
    if not _folder:
        return text
    return re.sub(rf"{re.escape(_folder)}(standard (?:in|out)put)\.\w+", r"\1", text)


@contextmanager
def as_files(argv: list[str], before_sending: Callable[[], None]) -> Iterator[list[str]]:
    """Yield the arguments with temporary files for `-`; output is sent to stdout at the end.

    Until then prints go to stderr. `before_sending` is called after the command, before sending.
    """
    global _folder
    folder = temporary.claim(os.path.realpath(tempfile.gettempdir()), as_folder=True)
    _folder = os.path.join(folder, "")
    try:
        words, read, written = list(argv), "", ""
        for place, word in enumerate(argv):
            option = argv[place - 1] if place else ""
            if option in _WRITTEN and (word == "-" or word.startswith("-.")):
                if written:
                    raise InvalidInputError("only one file can be written to standard output")
                _check_output()
                page = option in ("-o", "--output") and argv[0] in _PAGES
                suffix = word[1:] or (".html" if page else _WRITTEN[option])
                words[place] = written = f"{_folder}standard output{suffix}"
                open(written, "wb").close()
            elif word == "-":
                if read:
                    raise InvalidInputError("standard input can be read only once")
                words[place] = read = _received(None if "--allow-huge" in argv else _MOST_BYTES)
        if not written:
            yield words
            return
        with redirect_stdout(sys.stderr):
            yield words
        before_sending()
        try:
            with open(written, "rb") as file:
                shutil.copyfileobj(file, sys.stdout.buffer)
            sys.stdout.buffer.flush()
        except BrokenPipeError:
            raise
        except OSError as error:
            raise file_error("standard output", "cannot write", error) from None
    finally:
        temporary.release(folder)


def _check_output() -> None:
    """Refuse a standard output that cannot take a picture."""
    if sys.stdout.isatty():
        raise FileError("- is standard output, which is a terminal here; name a file")
    try:
        os.write(sys.stdout.fileno(), b"")
    except OSError as error:
        raise file_error("standard output", "cannot write", error) from None


def _received(most: int | None) -> str:
    """Copy standard input to a file, and return its path."""
    source = sys.stdin.buffer
    if source.isatty():
        raise FileError("- is standard input, which is a terminal here; send an image through it")
    try:
        head = source.read(16)
    except OSError as error:
        raise file_error("standard input", "cannot read", error) from None
    suffix = next((suffix for start, suffix in _STARTS.items() if head.startswith(start)), "")
    if not suffix:
        raise FileError(f"standard input {'has no image' if head else 'is empty'}")
    path, count = f"{_folder}standard input{suffix}", 0
    try:
        with open(path, "wb") as file:
            while head:
                count += len(head)
                if most is not None and count > most:
                    raise FileError(
                        f"standard input is over {most / 2**30:.3g} GiB; --allow-huge accepts it"
                    )
                file.write(head)
                head = source.read(2**20)
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise file_error("standard input", f"cannot copy it to {_folder[:-1]}", error) from None
    return path
