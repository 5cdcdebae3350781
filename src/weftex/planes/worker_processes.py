"""Make the blocks of a plane in several processes of this machine.

The processes are connected to this one by pipes; nobody else can send them work.
"""

from __future__ import annotations

import os
import socket
from typing import TYPE_CHECKING

from weftex.errors import FileError
from weftex.planes.record import Record
from weftex.processes import LostError, Workers
from weftex.threads import in_turn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from weftex.planes.job import Job
    from weftex.planes.layout import Place
    from weftex.progress import Progress


class WorkerProcesses:
    """Makes blocks in `count` processes; call it with the blocks of one level."""

    def __init__(self, job: Job, count: int) -> None:
        self._count, self._workers = count, Workers(block_maker, job)

    def __enter__(self) -> WorkerProcesses:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    def end(self) -> None:
        """Kill the processes."""
        self._workers.end()

    def __call__(self, record: Record, level: Iterable[Place], steps: Progress) -> Iterator[Place]:
        """Yield the blocks in their order, each when it is on the disk."""

        def make(place: Place) -> Place:
            try:
                self._workers.do((record.run, place))
            except LostError:
                raise FileError(
                    f"the block {place} was given up: a worker process was killed, perhaps "
                    "for lack of memory; blocks that are done are kept, and the same command "
                    "continues"
                ) from None
            return place

        yield from in_turn(make, level, self._count)


def block_maker(job: Job) -> Callable[[tuple[str, Place]], None]:
    """Return the function that makes a block of a run in a worker process."""
    records: dict[str, Record] = {}

    def make(work: tuple[str, Place]) -> None:
        run, place = work
        if run not in records:  # one that is kept reads the journals once a level
            records.clear()
            records[run] = Record(job.target, writer=writer_name(), run=run)
        job.make(records[run], place, threads=1)

    return make


def writer_name() -> str:
    """Return the name of the journal of this process."""
    return f"worker-{socket.gethostname()}-{os.getpid()}"
