"""What a batch made: one JSON object a line, in a file beside the outputs."""

from __future__ import annotations

import json
import os
import shutil
import threading
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from weftex.errors import FileError
from weftex.io.pictures import atomic
from weftex.io.temporary import lock

MANIFEST = "manifest.jsonl"
_UNFINISHED = ".weftex-batch-"  # whoever holds the folder may remove what is called so


class Manifest:
    """The records of a folder's outputs; each is on disk before its output appears.

    An output without a record is foreign; a record without output was interrupted and is dropped on
    opening. One process at a time has the folder; `sweep` releases it.
    """

    def __init__(self, folder: str) -> None:
        self._folder, self._path = folder, os.path.join(folder, MANIFEST)
        self._held, self._lock = lock(folder), threading.Lock()
        if self._held is None:
            raise FileError(f"{folder}: another batch is running in this folder")
        try:
            found = (one for one in self._read() if os.path.exists(self.path_of(one)))
            self._records = {record["output"]: record for record in found}
            if os.path.exists(self._path):
                with atomic(self._path) as temporary, open(temporary, "wb") as file:
                    file.writelines(map(_line, self._records.values()))
        except BaseException:
            self._let_go()
            raise

    def __contains__(self, output: str) -> bool:
        return output in self._records

    @property
    def records(self) -> list[dict[str, Any]]:
        """The records of all outputs."""
        return list(self._records.values())

    def path_of(self, record: dict[str, Any]) -> str:
        """Return where the output of a record is."""
        return os.path.join(self._folder, record["output"])

    def publish(self, record: dict[str, Any], made: str) -> None:
        """Write a record durably, then move its finished output from `made` to its name."""
        target = self.path_of(record)
        try:
            with self._lock, open(self._path, "ab", buffering=0) as file:
                end = file.tell()
                try:
                    file.write(_line(record))
                    os.fsync(file.fileno())
                except OSError:  # a full disk may have taken a part of it
                    file.truncate(end)
                    raise
                self._records[record["output"]] = record
            remove(target)
            os.replace(made, target)
        except OSError as error:
            raise FileError(f"{target}: cannot write: {error.strerror}") from None
        finally:
            shutil.rmtree(os.path.dirname(made), ignore_errors=True)

    def leave_out(self, outputs: Iterable[str], kept: Collection[str]) -> None:
        """Remove outputs that have a record, except the kept ones."""
        for output in outputs:
            if output in self and output not in kept:
                remove(os.path.join(self._folder, output))

    def sweep(self) -> None:
        """Remove what is unfinished, and let others into the folder."""
        for name in os.listdir(self._folder):
            if name.startswith(_UNFINISHED):
                remove(os.path.join(self._folder, name))
        self._let_go()

    def _let_go(self) -> None:
        if self._held is not None and self._held >= 0:
            os.close(self._held)
            self._held = None

    def _read(self) -> list[dict[str, Any]]:
        """All whole lines: the last may have been cut off."""
        found = []
        try:
            with open(self._path, encoding="utf-8") as file:
                for line in file:
                    with suppress(ValueError, RecursionError):
                        record = json.loads(line)
                        if isinstance(record, dict) and isinstance(record.get("output"), str):
                            found.append(record)
        except FileNotFoundError:
            pass
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(f"{self._path}: cannot read: {error}") from None
        return found


def _line(record: dict[str, Any]) -> bytes:
    line = json.dumps(record, ensure_ascii=False, default=str) + "\n"
    return line.encode("utf-8", "backslashreplace")  # half a letter: JSON spells it so too


@contextmanager
def unfinished(target: str) -> Iterator[str]:
    """Yield a path for a file or folder named like `target`, in a folder of its own beside it.

    It stays until `Manifest.publish`; any exception removes it.
    """
    folder, name = os.path.split(target)
    temporary = os.path.join(folder, f"{_UNFINISHED}{os.getpid()}-{os.urandom(4).hex()}")
    try:
        os.mkdir(temporary)
        yield os.path.join(temporary, name)
    except BaseException as error:
        shutil.rmtree(temporary, ignore_errors=True)
        if isinstance(error, OSError) and not isinstance(error, FileError):
            raise FileError(f"{target}: cannot write: {error.strerror}") from None
        raise


def remove(path: str) -> None:
    """Remove a file or a folder, if it is there; of a link only the link."""
    if os.path.isdir(path) and not os.path.islink(path):
        shutil.rmtree(path)
    elif os.path.lexists(path):
        os.remove(path)
