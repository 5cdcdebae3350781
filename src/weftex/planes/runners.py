"""Make the blocks of a plane: in threads, or in processes of this machine."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Iterable, Iterator
from threading import Lock

from weftex.errors import FileError
from weftex.planes.layout import Place
from weftex.planes.plane_file import PlaneFile
from weftex.planes.record import Record
from weftex.planes.tiff import KEPT
from weftex.processes import LostError, Workers
from weftex.progress import Progress
from weftex.threads import in_turn, thread_count

#: Makes blocks of one level for the run of a record, which are done when it gives them.
Runner = Callable[[Record, Iterable[Place], Progress], Iterator[Place]]

_AT_ONCE = 4  # blocks, which bounds the memory


def in_threads(
    plane: PlaneFile, threads: int | None, record: Record, level: Iterable[Place], steps: Progress
) -> Iterator[Place]:
    """Make blocks in threads of this process."""
    count = thread_count(threads)
    at_once = min(count, _AT_ONCE)
    fitting = Lock()

    def make(place: Place) -> Place:
        with fitting:
            plane.definition.model  # noqa: B018  (fitted once, not in every thread)
        plane.make(record, place, threads=max(1, count // at_once), progress=steps.within())
        return place

    return in_turn(make, level, at_once)


def in_processes(
    workers: Workers, count: int, record: Record, level: Iterable[Place], _: Progress
) -> Iterator[Place]:
    """Make blocks in `count` processes that began with `block_maker`."""

    def make(place: Place) -> Place:
        try:
            workers.do((record.run, place))
        except LostError:
            raise FileError(
                f"the block {place} was not made: a worker process was killed, perhaps for lack of "
                f"memory; {KEPT}"
            ) from None
        return place

    return in_turn(make, level, count)


def block_maker(plane: PlaneFile) -> Callable[[tuple[str, Place]], None]:
    """Return the function that makes a block of a run in another process, with its own journal."""
    records: dict[str, Record] = {}

    def make(work: tuple[str, Place]) -> None:
        run, place = work
        if run not in records:  # one that is kept reads the journals once a level
            records.clear()
            records[run] = Record(plane.path, f"worker-{socket.gethostname()}-{os.getpid()}", run)
        plane.make(records[run], place, threads=1)

    return make
