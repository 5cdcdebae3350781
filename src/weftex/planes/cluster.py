"""Blocks of a plane on other processes and machines, by `distributed`.

A task is a block: it makes the window, writes it to the store, which all machines see, and then a
line to the worker's own journal. Tasks send nothing to each other, and return nothing that could be
lost with a worker. Only some of them are with the scheduler at a time, so
that a million blocks need no more memory there than a thousand.
"""

from __future__ import annotations

import logging
import os
import pickle
import sys
import warnings
from contextlib import contextmanager
from functools import cache, lru_cache
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError, InvalidInputError, WeftexError
from weftex.planes.job import Job
from weftex.planes.record import Record
from weftex.planes.worker_processes import writer_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from weftex.planes.layout import Place
    from weftex.progress import Progress

_AHEAD = 4  # tasks a thread of the workers that the scheduler knows
_LEAST_AHEAD = 16
_TRIES = 10  # workers that may die while they make one block
_PATIENCE = "10s"  # for the scheduler's answer
_POLL, _LOOK = 0.02, 2.0  # seconds
_GONE = "the scheduler is gone; blocks that are done are kept, and the same command continues"


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """Give a client of the scheduler at an address such as ``tcp://host:8786``."""
    try:
        import distributed
    except ImportError:
        raise InvalidInputError(
            "--cluster needs the extra dask: pip install 'weftex[dask]'"
        ) from None
    for name in ("distributed", "distributed.client", "distributed.core", "distributed.comm"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # a worker that dies is no news
    try:
        client = distributed.Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise FileError(f"--cluster {address}: no scheduler answers ({why})") from None
    with client:
        yield client


class Workers:
    """Makes blocks on the workers of a scheduler; call it with the blocks of one level.

    Parameters
    ----------
    client : distributed.Client
    job : Job

    Raises
    ------
    InvalidInputError
        If a worker has another version, or none, of weftex.
    """

    def __init__(self, client: Any, job: Job) -> None:
        self._client = client
        target = os.path.abspath(job.target)
        job = Job(job.recipe, target, job.part)
        self._versions, self._threads, self._look_again = versions(), 0, 0.0
        self._check_workers()
        # Sent once; workers get it from each other. Scattered data would be lost with the workers
        # that have it, the result of a task is made again.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a sample is large
            self._job = client.submit(_held, pickle.dumps(job), pure=False)

    def __call__(self, record: Record, level: Iterable[Place], steps: Progress) -> Iterator[Place]:
        """Yield the blocks as they are done; `steps` is asked to go on while none is."""
        from distributed import as_completed as futures_as_completed
        from distributed.scheduler import KilledWorker

        waiting = iter(level)
        tries: dict[Place, int] = {}
        running: dict[Any, Place] = {}
        as_completed: Any = futures_as_completed
        ended = as_completed(loop=self._client.loop)

        def submit(place: Place) -> None:
            tries[place] = tries.get(place, 0) + 1
            work = (self._job, record.run, place, self._versions)
            future = self._client.submit(make_block, *work, pure=False)
            running[future] = place
            ended.add(future)

        def refill() -> None:
            while len(running) < self._ahead():
                place = next(waiting, None)
                if place is None:
                    return
                submit(place)

        try:
            refill()
            while running:
                future = self._next(ended, steps)
                place = running.pop(future)
                # Whether it ended is known to the scheduler, its result only to a worker.
                error = None if future.status == "finished" else future.exception()
                if isinstance(error, KilledWorker) and tries[place] < _TRIES:
                    submit(place)
                    continue
                if isinstance(error, KilledWorker):
                    raise FileError(
                        f"the block {place} was given up: workers that make it die; do they have "
                        "enough memory?"
                    )
                if isinstance(error, WeftexError):
                    raise error
                if error is not None or future.status != "finished":
                    raise FileError(f"the block {place} failed: {error or _GONE}")
                tries.pop(place)
                refill()
                yield place
        finally:
            self._client.cancel(list(running))

    def _next(self, ended: Any, steps: Progress) -> Any:
        """The next future that ends; whoever waits may cancel meanwhile."""
        while not ended.has_ready():
            if self._client.status not in ("running", "connecting"):
                raise FileError(_GONE)
            steps.advance(0)
            sleep(_POLL)
        return next(ended)

    def _ahead(self) -> int:
        """How many tasks the scheduler is to know, by the workers of a moment ago."""
        if monotonic() > self._look_again:
            info = self._client.scheduler_info(n_workers=-1)["workers"]
            self._threads = sum(worker["nthreads"] for worker in info.values())
            self._look_again = monotonic() + _LOOK
        return max(_LEAST_AHEAD, _AHEAD * self._threads)

    def _check_workers(self) -> None:
        try:
            found = self._client.run(versions, on_error="return")
        except Exception as error:
            raise FileError(f"the workers do not answer: {error}") from None
        for worker, told in found.items():
            if isinstance(told, BaseException):
                raise InvalidInputError(f"worker {worker} cannot load weftex: {told}")
            refuse_versions(worker, told, self._versions)


@cache
def versions() -> dict[str, str]:
    """Return the versions that bytes may depend on."""
    return {"weftex": sys.modules["weftex"].__version__}


def refuse_versions(worker: str, found: dict[str, str], wanted: dict[str, str]) -> None:
    """Raise `InvalidInputError` if a worker has other versions."""
    for name, here in wanted.items():
        if found.get(name) != here:
            raise InvalidInputError(
                f"worker {worker} has {name} {found.get(name)}, this process {here}; they must be "
                "equal, or the bytes may not be"
            )


def _held(packed: bytes) -> bytes:
    """What all tasks need."""
    return packed


@lru_cache(maxsize=2)
def _opened(packed: bytes) -> Job:
    """The job, whose model is fitted once for all blocks of a worker."""
    job: Job = pickle.loads(packed)
    return job


def make_block(packed: bytes, run: str, place: Place, wanted: dict[str, str]) -> None:
    """Make a block of a run on a worker.

    Raises
    ------
    FileError
        If the worker does not see the store.
    InvalidInputError
        If it has another version of weftex.
    """
    from distributed import get_worker

    refuse_versions(get_worker().address, versions(), wanted)
    job = _opened(packed)
    for store in job.stores.values():
        if not os.path.exists(store.path):
            raise FileError(
                f"worker {get_worker().address} does not see {store.path}; all machines need the "
                "same folder under the same path"
            )
    job.make(_record(job.target, run), place, threads=1)


@lru_cache(maxsize=2)
def _record(target: str, run: str) -> Record:
    """The record of a run, which reads the journals once a level."""
    return Record(target, writer=writer_name(), run=run)
