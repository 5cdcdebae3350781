"""What a batch made: one JSON object a line, in a file beside the outputs."""

from __future__ import annotations

import json
import os
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from weftex.errors import FileError
from weftex.io.pictures import atomic

MANIFEST = "manifest.jsonl"


class Manifest:
    """The records of a folder's outputs, of which each is on disk before its output appears.

    So an output without a record was not made by a batch, and a record without its output is of
    work that was cut off; those are left out when the file is opened.

    Parameters
    ----------
    folder : str
        Where the outputs are.

    Raises
    ------
    FileError
        If the file cannot be read or written.
    """

    def __init__(self, folder: str) -> None:
        self._folder, self._path = folder, os.path.join(folder, MANIFEST)
        self._lock = threading.Lock()
        self._records = {record["output"]: record for record in self._read()}
        kept = [one for one in self._records.values() if os.path.exists(self.path_of(one))]
        self._records = {record["output"]: record for record in kept}
        if os.path.exists(self._path):
            self._rewrite()

    def __contains__(self, output: str) -> bool:
        return output in self._records

    def path_of(self, record: dict[str, Any]) -> str:
        """Return where the output of a record is."""
        return os.path.join(self._folder, record["output"])

    def add(self, record: dict[str, Any]) -> None:
        """Write a record, durably, before its output appears under its name."""
        with self._lock:
            self._records[record["output"]] = record
            try:
                with open(self._path, "a", encoding="utf-8") as file:
                    file.write(_line(record))
                    file.flush()
                    os.fsync(file.fileno())
            except OSError as error:
                raise FileError(f"{self._path}: cannot write: {error.strerror}") from None

    def _read(self) -> list[dict[str, Any]]:
        """All whole lines: the last may have been cut off."""
        found = []
        try:
            with open(self._path, encoding="utf-8") as file:
                for line in file:
                    try:
                        record = json.loads(line)
                    except ValueError:
                        continue
                    if isinstance(record, dict) and isinstance(record.get("output"), str):
                        found.append(record)
        except FileNotFoundError:
            pass
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(f"{self._path}: cannot read: {error}") from None
        return found

    def _rewrite(self) -> None:
        with atomic(self._path) as temporary, open(temporary, "w", encoding="utf-8") as file:
            file.writelines(map(_line, self._records.values()))


def _line(record: dict[str, Any]) -> str:
    return json.dumps(record, ensure_ascii=False, default=str) + "\n"


@contextmanager
def appearing(target: str, before: Callable[[], None]) -> Iterator[str]:
    """Give a path in a folder of its own beside `target`, which replaces it when the block ends.

    That may be a file or a folder. `before` is called when it is whole; on any exception `target`
    is as it was.
    """
    folder, name = os.path.split(target)
    temporary = os.path.join(folder, f".weftex-{os.getpid()}-{os.urandom(4).hex()}")
    try:
        os.mkdir(temporary)
        inner = os.path.join(temporary, name)
        yield inner
        before()
        remove(target)
        os.replace(inner, target)
    except OSError as error:
        raise FileError(f"{target}: cannot write: {error.strerror}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def remove(path: str) -> None:
    """Remove a file or a folder, if it is there."""
    if os.path.isdir(path):
        shutil.rmtree(path)
    elif os.path.exists(path):
        os.remove(path)
