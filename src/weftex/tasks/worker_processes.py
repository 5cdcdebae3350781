"""Make the blocks of a plane in several processes of this machine.

The processes are connected to this one by pipes; nobody else can send them work.
"""

from __future__ import annotations

import os
import socket
from functools import partial
from typing import TYPE_CHECKING

from weftex.errors import FileError
from weftex.processes import LostError, Workers
from weftex.stores.record import Record
from weftex.threads import in_turn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from weftex.progress import Progress
    from weftex.stores.layout import Place
    from weftex.tasks.stream import Job


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

    def __call__(self, level: Iterable[Place], steps: Progress) -> Iterator[Place]:
        """Yield the blocks in their order, each when it is on the disk."""
        blocks = list(level)

        def make(k: int) -> Place:
            try:
                self._workers.do(blocks[k])
            except LostError:
                raise FileError(
                    f"the block {blocks[k]} was given up: a worker process was killed, perhaps "
                    "for lack of memory; blocks that are done are kept, and the same command "
                    "continues"
                ) from None
            return blocks[k]

        yield from in_turn(make, range(len(blocks)), self._count)


def block_maker(job: Job) -> Callable[[Place], None]:
    """Return the function that makes a block in a worker process, with a journal of its own."""
    record = Record(job.target, writer=f"worker-{socket.gethostname()}-{os.getpid()}")
    return partial(job.make, job.stores(), record, threads=1)
