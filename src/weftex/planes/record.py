"""The record of a plane beside its file: its definition, and the blocks that are done.

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
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, field
from typing import Any

from weftex.errors import FileError
from weftex.io.formats import file_error, suffix_of
from weftex.io.npz import open_regular
from weftex.io.pictures import write_text
from weftex.io.temporary import is_temporary
from weftex.planes.layout import Place, named
from weftex.planes.locks import COUNT, locked, shared
from weftex.planes.tiff import synced

_DEFINITION, _RUN = "recipe.npz", "run.json"
_LOCKS = ("lock", "begin", "writing")
_JOURNAL = re.compile(r"(done|worker-.+|part-\d+-of-(\d{1,5}))\.txt")
_MOST_OF_RUN, _MOST_OF_LINE = 2**24, 2**16  # bytes: far more than any
#: Of parts, which take numbers of a lock that a run alone takes all of.
MOST_PARTS = 2**16


@dataclass(frozen=True)
class Run:
    """The run that a plane belongs to; each start that creates files has a new random `name`.

    `files`, in the plane's folder, were created by weftex, or are about to be. `about` is
    `Definition.about`.
    """

    name: str
    begun: bool
    files: list[str]
    about: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise ValueError, LookupError or TypeError if this is no run."""
        for name in self.files:
            if name in ("", ".", "..") or "/" in name or "\\" in name:
                raise ValueError("a file lies elsewhere")
        types = [type(self.name), type(self.begun), type(self.files), type(self.about)]
        if types != [str, bool, list, dict]:
            raise TypeError("it is not a run of weftex")


class Record:
    """The folder beside a plane, for a process that writes a journal of its own for a run."""

    def __init__(self, target: str, journal: str = "done", run: str = "") -> None:
        self.target, self.folder, self.run = target, f"{target}.run", run
        self._journal = self._path(f"{journal}.txt")
        self._level: dict[Place, tuple[int, ...]] = {}  # the blocks of a level that are done

    @property
    def definition(self) -> str:
        """The path of the file that says what the plane is made of."""
        return self._path(_DEFINITION)

    def current(self) -> Run | None:
        """Return the run that the plane belongs to; `FileError` if that cannot be read."""
        path = self._path(_RUN)
        try:
            with open_regular(path, _MOST_OF_RUN) as file:
                run = Run(**json.loads(file.read().decode()))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
            raise FileError(
                f"{path} is damaged; remove {self.folder} and the plane, and make it again"
            ) from None
        for name in run.files:
            if suffix_of(name) != suffix_of(self.target):
                raise FileError(
                    f"{path} lists {name}, which no plane {self.target} has; remove the folder and "
                    "the plane, and make it again"
                )
        return run

    def begun(self) -> Run | None:
        """Return the run if it has made its files."""
        run = self.current()
        return run if run is not None and run.begun else None

    def check_folder(self) -> None:
        """Raise `FileError` if the folder is not one of ours."""
        known = {*_LOCKS, _RUN}
        foreign = [one for one in self._names() if one not in known and not is_temporary(one)]
        if foreign and not os.path.exists(self._path(_RUN)):
            raise FileError(
                f"{self.folder} contains other files, such as {foreign[0]}; move them, or name "
                "another file"
            )

    @contextmanager
    def held(self, part: tuple[int, int] | None = None) -> Iterator[None]:
        """Hold the plane, or a part, while the block runs; `FileError` if another process does."""
        first, count = (part[0], 1) if part else (1, COUNT - 1)
        with ExitStack() as stack:
            with self._our_errors():
                os.makedirs(self.folder, exist_ok=True)
                got = stack.enter_context(locked(self._path("lock"), first, count))
            if not got:
                what = f"part {first} of it" if part else "it"
                raise file_error(self.target, f"another process makes {what}; wait until that ends")
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
        """Let nobody begin anew while the block runs; `FileError` if another run has begun."""
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
        for path in map(self._path, self._journals()):
            with self._our_errors("read"), open_regular(path) as file:
                while line := file.readline(_MOST_OF_LINE):
                    if len(line) == _MOST_OF_LINE:
                        raise FileError(f"{path} is damaged: a line has no end")
                    text, _, check = line.strip().rpartition(b" ")
                    owner, *rest = text.split() or [b""]
                    if owner == run.encode() and check == _check(text):
                        with suppress(ValueError):  # numbers, unless somebody else wrote them
                            level, row, column, *sums = map(int, rest)
                            found[level, row, column] = tuple(sums)
        return found

    def sums(self, place: Place) -> tuple[int, ...]:
        """Return the check sums of a block that is done; journals are read once for each level."""
        if place not in self._level:
            self._level = {one: sums for one, sums in self.done().items() if one[0] == place[0]}
        if place not in self._level:
            raise file_error(self.target, f"{named(place)} is not done; the same command continues")
        return self._level[place]

    def parts(self) -> list[int]:
        """Return into how many parts the plane was divided, by whoever made some."""
        matches = map(_JOURNAL.fullmatch, self._journals())
        return sorted({int(m[2]) for m in matches if m and m[2] and 0 < int(m[2]) <= MOST_PARTS})

    def add(self, place: Place, sums: tuple[int, ...]) -> None:
        """Write that a block is on the disk; `FileError` if another run has begun."""
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
        self.sweep(done=True)

    def sweep(self, *, done: bool = False) -> None:
        """Remove temporary files that nobody writes any more, and what says what is `done`."""
        with self._our_errors():
            old = [_DEFINITION, *self._journals()] if done else []
            for name in (*old, *filter(is_temporary, self._names())):
                with suppress(FileNotFoundError):
                    os.unlink(self._path(name))

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

    def _names(self) -> list[str]:
        return os.listdir(self.folder) if os.path.isdir(self.folder) else []

    def _journals(self) -> list[str]:
        """Names of journals; "done", which repairs write, comes last."""
        return sorted(filter(_JOURNAL.fullmatch, self._names()), reverse=True)

    def _check_run(self) -> None:
        current = self.current()
        if current is None or current.name != self.run:
            raise file_error(self.target, "another command restarted or removed it; this run stops")

    @contextmanager
    def _our_errors(self, doing: str = "write") -> Iterator[None]:
        try:
            yield
        except FileError:
            raise
        except OSError as error:
            raise file_error(self.folder, f"cannot {doing}", error) from None


def _check(text: bytes) -> bytes:
    """What ends a line of a journal."""
    return b"%08x" % zlib.crc32(text)
