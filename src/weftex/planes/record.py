"""What is known of a plane beside its file: what it is made of, and which blocks are done.

A folder, ``plane.tif.run``, has

* ``run.json``: the run that the plane belongs to, a random name; its files; whether they are begun,
* ``recipe.npz``: sample, method, seed and size,
* a journal for each writer: a line is written, and on the disk, after its block is,
* locks: ``lock`` is held by who makes the plane or a part of it, ``begin`` by who begins;
  ``writing`` is shared by all who write a block, and held alone by who begins.

A process may be killed at any moment. One whose run has ended, such as a task of a cluster, finds
another run in ``run.json`` and writes nothing more.
"""

from __future__ import annotations

import json
import os
import re
import zlib
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError, InvalidInputError
from weftex.io.formats import show, suffix_of
from weftex.io.pictures import write_text
from weftex.io.regular import open_regular
from weftex.planes.locks import all_from, locked, shared
from weftex.planes.owned import is_stale, sweep
from weftex.planes.store import synced

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from weftex.planes.layout import Place

SUFFIX = ".run"
RECIPE, _RUN = "recipe.npz", "run.json"
_LOCKS = ("lock", "begin", "writing")
_JOURNAL = re.compile(r"(done|worker-.+|part-\d+-of-(\d{1,5}))\.txt")
_MOST_OF_RUN, _MOST_OF_LINE = 2**24, 2**16  # bytes: far more than any
#: Of parts, which take numbers of a lock that a run alone takes all of.
MOST_PARTS = 2**16


@dataclass(frozen=True)
class Run:
    """Who a plane belongs to; the name of a run is new at every start that makes new files.

    `files` are the files and folders that weftex made, or is about to make, relative to the folder
    of the plane. `about` is what the recipe says of itself. `grids` are those of `Store.grid`.
    """

    name: str
    begun: bool
    files: list[str]
    about: dict[str, Any] = field(default_factory=dict)
    grids: dict[str, list[int]] = field(default_factory=dict)

    @classmethod
    def of(cls, text: str) -> Run:
        """Return what a file says; ValueError, LookupError or TypeError if that is no run."""
        run = cls(**json.loads(text))
        for path in run.files:
            names = path.split("/")
            plain = all(n not in ("", ".", "..") and "\\" not in n for n in names)
            if not plain or len(names) > 2:
                raise ValueError("a file lies elsewhere")
        if not isinstance(run.name, str) or run.begun not in (True, False):
            raise ValueError("it names no run")
        if not isinstance(run.about, dict) or not isinstance(run.files, list):
            raise ValueError("it says nothing of its recipe")
        for grid in run.grids.values():
            if [*map(type, grid)] != [int] * 4 or min(grid) < 1:
                raise ValueError("a grid is none")
        return run


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
    run : str
        The run that this process writes for, see `begin`.
    """

    def __init__(
        self, target: str, part: tuple[int, int] | None = None, writer: str = "", run: str = ""
    ) -> None:
        self.target, self.folder, self.part, self.run = target, target + SUFFIX, part, run
        name = writer or ("done" if part is None else f"part-{part[0]}-of-{part[1]}")
        self._journal = self._path(f"{name}.txt")
        self._level: dict[Place, tuple[int, ...]] = {}  # the blocks of a level that are done

    @property
    def recipe(self) -> str:
        """The path of the recipe."""
        return self._path(RECIPE)

    def current(self) -> Run | None:
        """Return the run that the plane belongs to.

        Raises
        ------
        FileError
            If that cannot be read.
        """
        try:
            with open_regular(self._path(_RUN), _MOST_OF_RUN) as file:
                run = Run.of(file.read().decode())
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
            raise FileError(
                f"{show(self._path(_RUN))} is damaged; remove {show(self.folder)} and the plane, "
                "and make it again"
            ) from None
        for name in run.files:
            if not self._can_have(name):
                raise FileError(
                    f"{show(self._path(_RUN))} lists {show(name)}, which no plane "
                    f"{show(self.target)} has; remove the folder and the plane, and make it again"
                )
        return run

    def _can_have(self, name: str) -> bool:
        """Whether a file may be of a store of this target, by its name."""
        suffix = suffix_of(self.target)
        first, *inner = name.split("/")
        if suffix == ".zarr" or inner:
            return suffix == ".zarr" and first == os.path.basename(self.target)
        return suffix_of(first) == suffix or (suffix == ".dzi" and first.endswith("_files"))

    def of_target(self, names: Iterable[str]) -> list[str]:
        """Return the names that are the target's own, or lie in its folder."""
        own = os.path.basename(self.target)
        return [name for name in names if name == own or name.startswith(f"{own}/")]

    def exists(self) -> bool:
        """Whether a run has begun."""
        run = self.current()
        return run is not None and run.begun

    def check_folder(self) -> None:
        """Raise `FileError` if the folder is not one of ours."""
        known = {*_LOCKS, _RUN}
        names = os.listdir(self.folder) if os.path.isdir(self.folder) else []
        foreign = [name for name in names if name not in known and not is_stale(name)]
        if foreign and not os.path.exists(self._path(_RUN)):
            raise FileError(
                f"{show(self.folder)} has files of others, such as {show(foreign[0])}; move them, "
                "or name another file"
            )

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the plane, or its part, while the block runs.

        Raises
        ------
        FileError
            If another process works on it, or the folder cannot be made.
        """
        first = self.part[0] if self.part else 1
        count = 1 if self.part else all_from(1)
        with ExitStack() as stack:
            with self._our_errors():
                os.makedirs(self.folder, exist_ok=True)
                got = stack.enter_context(locked(self._path("lock"), first, count))
            if not got:
                what = f"part {first} of it" if self.part else "it"
                raise FileError(
                    f"{show(self.target)}: another process makes {what}; wait until that ends"
                )
            yield

    @contextmanager
    def beginning(self) -> Iterator[None]:
        """Let one process at a time begin."""
        with self._our_errors(), locked(self._path("begin"), wait=True):
            yield

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Wait until no block is being written, and let none be written while the block runs."""
        with self._our_errors(), locked(self._path("writing"), wait=True):
            yield

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Let nobody begin anew while the block runs.

        Raises
        ------
        FileError
            If another run has begun.
        """
        with self._our_errors(), shared(self._path("writing")):
            self._check_run()
            yield

    def begin(self, run: Run) -> None:
        """Write which run the plane belongs to; others write nothing from now on."""
        with self._our_errors():
            write_text(self._path(_RUN), json.dumps(asdict(run)))
            synced(self._path(_RUN))
            synced(self.folder)
        self.run = run.name

    def done(self) -> dict[Place, tuple[int, ...]]:
        """Return the blocks that are done, by any writer, with the check sums of their pictures.

        Lines of other runs, and those that were cut off, do not count.
        """
        run = self.run
        if not run and (current := self.current()):
            run = current.name
        found: dict[Place, tuple[int, ...]] = {}
        for name in self._journals():
            with self._our_errors("read"), open_regular(self._path(name)) as file:
                while line := file.readline(_MOST_OF_LINE):
                    if len(line) == _MOST_OF_LINE:
                        raise FileError(f"{show(self._path(name))} is damaged: a line has no end")
                    text, _, check = line.strip().rpartition(b" ")
                    owner, *rest = text.split() or [b""]
                    if owner == run.encode() and check == _check(text):
                        with suppress(ValueError):  # numbers, unless somebody else wrote them
                            level, row, column, *sums = map(int, rest)
                            found[level, row, column] = tuple(sums)
        return found

    def sums(self, place: Place) -> tuple[int, ...]:
        """Return the check sums of a block; journals are read once for each level.

        Raises
        ------
        FileError
            If it is not done.
        """
        if place not in self._level:
            self._level = {one: sums for one, sums in self.done().items() if one[0] == place[0]}
        if place not in self._level:
            what = f"level {place[0]}, row {place[1]}, column {place[2]}"
            raise FileError(
                f"{show(self.target)}: the block {what} is not done; the same command continues"
            )
        return self._level[place]

    def parts(self) -> list[int]:
        """Return into how many parts the plane was divided, by whoever made some."""
        matches = map(_JOURNAL.fullmatch, self._journals())
        return sorted({int(m[2]) for m in matches if m and m[2] and 0 < int(m[2]) <= MOST_PARTS})

    def add(self, place: Place, sums: tuple[int, ...]) -> None:
        """Write that a block is on the disk.

        Raises
        ------
        FileError
            If another run has begun, or the journal cannot be written.
        """
        self._check_run()
        text = " ".join(map(str, (self.run, *place, *sums))).encode()
        with self._our_errors():
            new = not os.path.exists(self._journal)
            # The file may end in a line that was cut off. It is opened anew, since it may be gone.
            with open(self._journal, "ab") as file:
                file.write(b"\n" + text + b" " + _check(text))
                file.flush()
                os.fsync(file.fileno())
            if new:
                synced(self._journal)

    def clear(self) -> None:
        """Forget what was done; who owns which files stays, and so do the locks."""
        with self._our_errors():
            for name in (RECIPE, *self._journals()):
                with suppress(FileNotFoundError):
                    os.unlink(self._path(name))
            sweep(self.folder)

    def remove(self) -> None:
        """Remove the folder, unless others have files in it; call it while the plane is held."""
        self.clear()
        for name in (_RUN, *_LOCKS):
            with suppress(OSError):  # Windows keeps what is open
                os.unlink(self._path(name))
        with suppress(OSError):
            os.rmdir(self.folder)

    def _path(self, name: str) -> str:
        return os.path.join(self.folder, name)

    def _journals(self) -> list[str]:
        names = os.listdir(self.folder) if os.path.isdir(self.folder) else []
        return sorted(filter(_JOURNAL.fullmatch, names), reverse=True)  # "done", of repairs, last

    def _check_run(self) -> None:
        current = self.current()
        if current is None or current.name != self.run:
            raise FileError(
                f"{show(self.target)}: it was begun again, or removed; this run writes nothing more"
            )

    @contextmanager
    def _our_errors(self, doing: str = "write") -> Iterator[None]:
        try:
            yield
        except FileError:
            raise
        except OSError as error:
            raise FileError(
                f"{show(self.folder)}: cannot {doing}: {error.strerror or error}"
            ) from None


def _check(text: bytes) -> bytes:
    """What ends a line of a journal."""
    return b"%08x" % zlib.crc32(text)


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
