"""What is known of a plane beside its file: what it is made of, and which blocks are done.

A folder, ``plane.tif.run``, has the recipe, a journal for each writer, and locks. A line of a
journal is written, and on the disk, after its block is; so a process may be killed at any moment.
"""

from __future__ import annotations

import os
import shutil
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError, InvalidInputError
from weftex.io.formats import show
from weftex.stores.locks import all_from, locked
from weftex.stores.store import synced

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from weftex.stores.layout import Place

SUFFIX = ".run"
RECIPE = "recipe.npz"
#: Of parts, which take numbers of a lock that a run alone takes all of.
MOST_PARTS = 2**16


class Record:
    """The folder beside a plane.

    Parameters
    ----------
    target : str
        The plane's file.
    part : (int, int), optional
        Which part of how many this process makes; all of it otherwise.
    writer : str
        What its journal is called; as its part by default.
    """

    def __init__(self, target: str, part: tuple[int, int] | None = None, writer: str = "") -> None:
        self.target, self.folder, self.part = target, target + SUFFIX, part
        name = writer or ("done" if part is None else f"part-{part[0]}-of-{part[1]}")
        self._journal = os.path.join(self.folder, f"{name}.txt")
        self._file: Any = None
        self._lock = threading.Lock()

    @property
    def recipe(self) -> str:
        """The path of the recipe."""
        return os.path.join(self.folder, RECIPE)

    def exists(self) -> bool:
        """Whether a run has begun."""
        return os.path.isfile(self.recipe)

    @contextmanager
    def at_work(self, begin: Callable[[], None]) -> Iterator[None]:
        """Hold the plane while the block runs.

        Parameters
        ----------
        begin : callable
            Called before, by one process at a time.

        Raises
        ------
        FileError
            If another process works on it, or the folder cannot be made.
        """
        try:
            os.makedirs(self.folder, exist_ok=True)
        except OSError as error:
            raise FileError(f"{show(self.folder)}: cannot write: {error.strerror}") from None
        first = self.part[0] if self.part else 1
        count = 1 if self.part else all_from(1)
        with locked(os.path.join(self.folder, "lock"), first, count) as got:
            if not got:
                what = f"part {first} of it" if self.part else "it"
                raise FileError(
                    f"{show(self.target)}: another process makes {what}; wait until that ends"
                )
            with locked(os.path.join(self.folder, "begin"), 0, wait=True):
                begin()
            try:
                yield
            finally:
                if self._file is not None:
                    self._file.close()
                    self._file = None

    def done(self) -> dict[Place, tuple[int, ...]]:
        """Return the blocks that are done, by any writer, with the check sums of their pictures.

        Raises
        ------
        FileError
            If a journal cannot be read.
        """
        found: dict[Place, tuple[int, ...]] = {}
        for name in sorted(os.listdir(self.folder)) if os.path.isdir(self.folder) else ():
            if not name.endswith(".txt"):
                continue
            try:
                with open(os.path.join(self.folder, name), encoding="ascii") as file:
                    for line in file:
                        if line.endswith("\n"):  # else cut off
                            level, row, column, *sums = map(int, line.split())
                            found[level, row, column] = tuple(sums)
            except (OSError, ValueError) as error:
                raise FileError(f"{show(self.folder)}: {name} is damaged: {error}") from None
        return found

    def add(self, place: Place, sums: tuple[int, ...]) -> None:
        """Write that a block is on the disk."""
        try:
            with self._lock:
                if self._file is None:
                    self._file = self._opened()
                self._file.write((" ".join(map(str, (*place, *sums))) + "\n").encode())
                os.fsync(self._file.fileno())
        except OSError as error:
            raise FileError(f"{show(self._journal)}: cannot write: {error.strerror}") from None

    def _opened(self) -> Any:
        """The journal, less a line that was cut off."""
        file = open(self._journal, "a+b", buffering=0)  # noqa: SIM115
        file.seek(0)
        whole = file.read().rfind(b"\n") + 1
        file.truncate(whole)
        synced(self._journal)
        return file

    def remove(self) -> None:
        """Forget what was done, but not the locks, which somebody holds."""
        for name in os.listdir(self.folder):
            if name == RECIPE or name.endswith(".txt"):
                os.unlink(os.path.join(self.folder, name))

    def remove_folder(self) -> None:
        """Remove everything."""
        shutil.rmtree(self.folder, ignore_errors=True)


def is_plane(path: str) -> bool:
    """Whether a path is that of a plane that was begun here."""
    return Record(path).exists()


def refuse_other(target: str, found: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Raise unless a recipe that lies there is the one that is wanted, saying where they differ.

    Raises
    ------
    InvalidInputError
    """
    for name in wanted:
        if found.get(name) != wanted[name]:
            values = f"{_short(found.get(name))}, here {_short(wanted[name])}"
            if name == "digest":
                values = "another than this one"
            raise InvalidInputError(
                f"{show(target)} was begun by another run: its {_NAMES.get(name, name)} is "
                f"{values}; --restart begins again, or name another file"
            )


_NAMES = {"digest": "sample", "wrap": "tiling (y, x)", "version": "version of weftex"}


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def parse_part(text: str) -> tuple[int, int]:
    """Return number and count of 'K/N'.

    Raises
    ------
    InvalidInputError

    Examples
    --------
    >>> parse_part("2/8")
    (2, 8)
    """
    try:
        number, count = map(int, text.split("/"))
        if 1 <= number <= count <= MOST_PARTS:
            return number, count
    except ValueError:
        pass
    raise InvalidInputError(
        f"--part is '{text}'; it must be K/N with K from 1 to N, N up to {MOST_PARTS}"
    )
