"""The record of a plane beside its file: its definition, and the blocks that are done.

A folder, ``plane.tif.run``, has

* ``run.json``: the files of the plane, and whether they are begun,
* ``recipe.npz``: sample, method, seed and size,
* ``done.txt``, the journal: a line is written, and on the disk, after its block is,
* ``lock``, which the process that makes the plane holds; it ends with its process.

A process may be killed at any moment.
"""

from __future__ import annotations

import json
import os
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from typing import Any

from weftex.errors import FileError
from weftex.io.formats import suffix_of
from weftex.io.npz import open_regular
from weftex.io.pictures import write_text
from weftex.io.temporary import is_temporary
from weftex.planes.layout import Place
from weftex.planes.tiff import synced

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_DEFINITION, _RUN, _JOURNAL, _LOCK = "recipe.npz", "run.json", "done.txt", "lock"
_MOST_OF_RUN, _MOST_OF_LINE = 2**24, 2**16  # bytes: far more than any


@dataclass(frozen=True)
class Run:
    """What the files of a plane are made of: `about` is `Definition.about`.

    `files`, in the plane's folder, were created by weftex, or are about to be; they count once the
    run has `begun`.
    """

    begun: bool
    files: list[str]
    about: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise ValueError, LookupError or TypeError if this is no run."""
        for name in self.files:
            if name in ("", ".", "..") or "/" in name or "\\" in name:
                raise ValueError("a file lies elsewhere")
        if [type(self.begun), type(self.files), type(self.about)] != [bool, list, dict]:
            raise TypeError("it is no run")


class Record:
    """The folder beside a plane; one process at a time writes it, while the plane is `held`."""

    def __init__(self, target: str) -> None:
        self.target, self.folder = target, f"{target}.run"
        self._lock = -1  # the open lock file

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

    def begun(self) -> bool:
        """Return whether a run has made its files."""
        run = self.current()
        return run is not None and run.begun

    def check_folder(self) -> None:
        """Raise `FileError` if the folder is not one of ours."""
        names = os.listdir(self.folder) if os.path.isdir(self.folder) else []
        foreign = [one for one in names if one not in (_LOCK, _RUN) and not is_temporary(one)]
        if foreign and not os.path.exists(self._path(_RUN)):
            raise FileError(
                f"{self.folder} contains other files, such as {foreign[0]}; move them, or name "
                "another file"
            )

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold the plane while the block runs; `FileError` if another process does."""
        with self._our_errors():
            os.makedirs(self.folder, exist_ok=True)
            while not self._is_held():  # unless somebody removed the file meanwhile
                self._release()
                self._lock = os.open(self._path(_LOCK), os.O_RDWR | os.O_CREAT, 0o666)
                if not _locked(self._lock):
                    self._release()
                    raise FileError(
                        f"{self.target}: another process makes it; wait until that ends"
                    )
        try:
            yield
        finally:
            self._release()

    def check_held(self) -> None:
        """Raise `FileError` if somebody removed the folder, and may have begun anew."""
        if not self._is_held():
            raise FileError(f"{self.target}: its folder {self.folder} was removed; this run stops")

    def begin(self, run: Run) -> None:
        """Write what the plane is made of, and whether its files are there."""
        with self._our_errors():
            write_text(self._path(_RUN), json.dumps(asdict(run)))
            synced(self._path(_RUN))
            synced(self.folder)

    def done(self) -> dict[Place, tuple[int, ...]]:
        """Return the blocks that are done, with the check sums of their pictures.

        Lines that were cut off do not count.
        """
        path = self._path(_JOURNAL)
        found: dict[Place, tuple[int, ...]] = {}
        if not os.path.lexists(path):
            return found
        with self._our_errors("read"), open_regular(path) as file:
            while line := file.readline(_MOST_OF_LINE):
                if len(line) == _MOST_OF_LINE:
                    raise FileError(f"{path} is damaged: a line has no end")
                text, _, check = line.strip().rpartition(b" ")
                if check == _check(text):
                    with suppress(ValueError):  # numbers, unless somebody else wrote them
                        level, row, column, *sums = map(int, text.split())
                        found[level, row, column] = tuple(sums)
        return found

    def add(self, place: Place, sums: tuple[int, ...]) -> None:
        """Write that a block is on the disk."""
        self.check_held()
        text = " ".join(map(str, (*place, *sums))).encode()
        path = self._path(_JOURNAL)
        with self._our_errors():
            new = not os.path.exists(path)
            with open(path, "ab") as file:
                file.write(b"\n" + text + b" " + _check(text))  # the last line may be cut off
                file.flush()
                os.fsync(file.fileno())
            if new:
                synced(path)

    def clear(self) -> None:
        """Forget what was done; who owns which files stays, and so does the lock."""
        self._unlink(_DEFINITION, _JOURNAL)

    def remove(self) -> None:
        """Remove the folder, unless others have files in it; call it while the plane is held."""
        self._unlink(_DEFINITION, _JOURNAL, _RUN)
        with suppress(OSError):  # Windows keeps what is open
            os.unlink(self._path(_LOCK))
            os.rmdir(self.folder)

    def _unlink(self, *names: str) -> None:
        with self._our_errors():
            for name in names:
                with suppress(FileNotFoundError):
                    os.unlink(self._path(name))

    def _path(self, name: str) -> str:
        return os.path.join(self.folder, name)

    def _is_held(self) -> bool:
        """Whether the lock file is open, and still the one of its name."""
        if self._lock < 0:
            return False
        try:
            return os.path.samestat(os.stat(self._path(_LOCK)), os.fstat(self._lock))
        except OSError:
            return False

    def _release(self) -> None:
        if self._lock >= 0:
            os.close(self._lock)  # which ends the lock
        self._lock = -1

    @contextmanager
    def _our_errors(self, doing: str = "write") -> Iterator[None]:
        try:
            yield
        except FileError:
            raise
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.folder}: cannot {doing}: {why}") from None


def _locked(number: int) -> bool:
    """Lock an open file if nobody else has it."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _check(text: bytes) -> bytes:
    """What ends a line of a journal."""
    return b"%08x" % zlib.crc32(text)
