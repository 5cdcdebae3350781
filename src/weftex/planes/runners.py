"""Make the blocks of a plane: in threads, in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import logging
import os
import pickle
import socket
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from threading import Lock
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

import weftex
from weftex.errors import FileError, InvalidInputError, WeftexError, missing_packages
from weftex.planes.record import Record
from weftex.planes.store import KEPT
from weftex.processes import LostError, Workers
from weftex.threads import in_turn, thread_count

if TYPE_CHECKING:
    from weftex.planes.layout import Place
    from weftex.planes.plane_file import PlaneFile
    from weftex.progress import Progress

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
                f"the block {place} was given up: a worker process was killed, perhaps for lack of "
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


_AHEAD = 4  # tasks a thread of the workers that the scheduler knows
_LEAST_AHEAD = 16
_TRIES = 10  # workers that may die while they make one block
_PATIENCE = "10s"  # for the scheduler's answer
_POLL, _LOOK = 0.02, 2.0  # seconds
_GONE = f"the scheduler is gone; {KEPT}"


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """Give a client of the scheduler at an address such as ``tcp://host:8786``."""
    try:
        import distributed
    except ImportError:
        raise missing_packages("--cluster needs Dask", "dask") from None
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # a worker that dies is no news
    try:
        client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise FileError(f"--cluster {address}: no scheduler answers ({why})") from None
    with client:
        yield client


def in_cluster(client: Any, plane: PlaneFile) -> Runner:
    """Return what makes blocks on the workers of a scheduler."""
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    shared = pickle.dumps(replace(plane, path=os.path.abspath(plane.path)))
    # Sent once; workers get it from each other. Scattered data would be lost with the workers that
    # have it, the result of a task is made again.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a sample is large
        packed = client.submit(_held, shared, pure=False)
    ahead = _tasks_ahead(client)

    def run(record: Record, level: Iterable[Place], steps: Progress) -> Iterator[Place]:
        waiting = iter(level)
        tries: dict[Place, int] = {}
        running: dict[Any, Place] = {}
        done: Any = as_completed(loop=client.loop)

        def submit(place: Place) -> None:
            tries[place] = tries.get(place, 0) + 1
            work = (packed, record.run, place, weftex.__version__)
            future = client.submit(make_block, *work, pure=False)
            running[future] = place
            done.add(future)

        try:
            while True:
                while len(running) < ahead() and (place := next(waiting, None)):
                    submit(place)
                if not running:
                    return
                while not done.has_ready():  # whoever waits may cancel meanwhile
                    if client.status not in ("running", "connecting"):
                        raise FileError(_GONE)
                    steps.advance(0)
                    sleep(_POLL)
                future = next(done)
                place = running.pop(future)
                # Whether it ended is known to the scheduler, its result only to a worker.
                error = None if future.status == "finished" else future.exception()
                if isinstance(error, KilledWorker):
                    if tries[place] == _TRIES:
                        raise FileError(
                            f"the block {place} was given up: workers that make it die; do they "
                            "have enough memory?"
                        )
                    submit(place)
                    continue
                if isinstance(error, WeftexError):
                    raise error
                if future.status != "finished":
                    raise FileError(f"the block {place} failed: {error or _GONE}")
                del tries[place]
                yield place
        finally:
            client.cancel(list(running))

    return run


def _tasks_ahead(client: Any) -> Callable[[], int]:
    """How many tasks the scheduler is to know, by the workers of a moment ago."""

    @lru_cache(maxsize=1)
    def threads(_moment: int) -> int:
        info = client.scheduler_info(n_workers=-1)["workers"]
        return sum(worker["nthreads"] for worker in info.values())

    return lambda: max(_LEAST_AHEAD, _AHEAD * threads(int(monotonic() / _LOOK)))


def _held(packed: bytes) -> bytes:
    """What all tasks need."""
    return packed


@lru_cache(maxsize=2)
def _opened(packed: bytes) -> tuple[PlaneFile, Callable[[tuple[str, Place]], None]]:
    """The plane, whose model is fitted once for all blocks of a worker, and what makes blocks."""
    plane: PlaneFile = pickle.loads(packed)
    return plane, block_maker(plane)


def make_block(packed: bytes, run: str, place: Place, version: str) -> None:
    """Make a block of a run on a worker; raises if that does not see the files, or is another."""
    from distributed import get_worker

    worker = f"worker {get_worker().address}"
    if version != weftex.__version__:
        raise InvalidInputError(
            f"{worker} has weftex {weftex.__version__}, this process {version}; they must be "
            "equal, or the bytes may not be"
        )
    plane, make = _opened(packed)
    for store in plane.stores.values():
        if not os.path.exists(store.path):
            raise FileError(
                f"{worker} does not see {store.path}; all machines need the same folder under the "
                "same path"
            )
    make((run, place))
