"""Facts and arrays in one compressed file, which may be anybody's: looked at before it is read."""

from __future__ import annotations

import errno
import math
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from weftex.errors import FileError
from weftex.io.formats import path_text, show

__all__ = ["DamageError", "one_line_errors", "open_npz", "open_regular", "write_npz"]

_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
MOST_FACTS = 2**24  #: bytes: far more than any facts


class DamageError(ValueError):
    """A saved file contains something that was never written so."""


class Arrays:
    """An open `.npz` file: `facts` from its JSON, and `size`, the bytes its arrays will take."""

    def __init__(self, file: Any) -> None:
        self._file = file
        entries = file.zip.namelist()
        self._names = [entry.removesuffix(".npy") for entry in entries]
        # NumPy would read the one of two namesakes that was not looked at here.
        if len({*self._names}) < len(entries) or {f"{n}.npy" for n in self._names} != {*entries}:
            raise DamageError("its arrays have no names of their own")
        lengths = {name: self._lengths(name) for name in self._names}
        if max(lengths["about"]) > MOST_FACTS:
            raise DamageError("its description is too long")
        import json  # few runs save or load

        self.facts = json.loads(str(file["about"]))
        if not isinstance(self.facts, dict):
            raise ValueError("its description is not an object")
        self.size = sum(map(max, lengths.values()))
        self._whole = all(said == there for said, there in lengths.values())

    def read(self) -> dict[str, NDArray[Any]]:
        """Return all arrays but the facts."""
        if not self._whole:
            raise DamageError("an array is not as long as it says")
        names = (name for name in self._names if name != "about")
        return {name: np.ascontiguousarray(self._file[name]) for name in names}

    def _lengths(self, name: str) -> tuple[int, int]:
        """Bytes that an array takes by its header, and bytes that follow it."""
        entry = self._file.zip.getinfo(f"{name}.npy")
        with self._file.zip.open(entry) as member:
            form = np.lib.format
            first = form.read_magic(member) == (1, 0)
            read = form.read_array_header_1_0 if first else form.read_array_header_2_0
            shape, _, dtype = read(member)
            return math.prod(map(abs, shape)) * int(dtype.itemsize), entry.file_size - member.tell()


def write_npz(
    path: str | os.PathLike[str], facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> None:
    """Write facts and arrays, compressed; the file appears whole or not at all."""
    import json  # few runs save, and a run on arrays needs no files

    from weftex.io.pictures import atomic

    about = np.array(json.dumps(facts))
    with atomic(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, about=about, **arrays)  # type: ignore[arg-type]


@contextmanager
def one_line_errors(path: str | os.PathLike[str], what: str) -> Iterator[None]:
    """Turn whatever goes wrong while a file is read into a `FileError`; `what` should be in it."""
    name = path_text(path)
    try:
        yield
    except FileNotFoundError:
        raise FileError(f"{show(name)} does not exist") from None
    except MemoryError:
        raise FileError(f"{show(name)} does not fit in memory") from None
    except DamageError as error:
        raise FileError(f"{show(name)} is damaged: {error}") from None
    except Exception:  # numpy and zipfile raise many kinds, with advice that does not fit here
        raise FileError(f"{show(name)} is not {what}") from None


@contextmanager
def open_npz(path: str | os.PathLike[str]) -> Iterator[Arrays]:
    """Open a file; no pickles are read. A damaged file raises errors of many kinds."""
    with open_regular(path) as raw, np.load(raw, allow_pickle=False) as file:
        if isinstance(file, np.ndarray):
            raise DamageError("it is one array")
        yield Arrays(file)


def open_regular(path: str | os.PathLike[str], most_bytes: int | None = None) -> IO[bytes]:
    """Return an open file; OSError if it has more than `most_bytes`, or is a pipe or device."""
    number = os.open(path, _FLAGS)
    try:
        found = os.fstat(number)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file", os.fspath(path))
        if most_bytes is not None and found.st_size > most_bytes:
            raise OSError(errno.EFBIG, f"it has more than {most_bytes} bytes", os.fspath(path))
        return open(number, "rb")
    except BaseException:
        os.close(number)
        raise
