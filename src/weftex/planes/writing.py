"""Write a plane to a file block by block, resume it, check it and repair it."""

from __future__ import annotations

import os
import shutil
import socket
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from math import prod
from threading import Lock
from typing import Any

import numpy as np

from weftex import Method
from weftex.errors import FileError
from weftex.io.formats import TIFF
from weftex.io.pictures import check_output
from weftex.planes.beginning import at_work, done_before
from weftex.planes.definition import BLOCK, Definition, define
from weftex.planes.layout import Place
from weftex.planes.plane_file import PlaneFile, Sums, open_plane
from weftex.planes.record import Record
from weftex.planes.tiff import KEPT
from weftex.processes import LostError, Workers
from weftex.progress import Progress, ProgressCallback, listening
from weftex.registry import AUTO
from weftex.threads import in_turn, thread_count

#: Makes blocks of one level for the run of a record, which are done when it gives them.
Runner = Callable[[Record, Iterable[Place], Progress], Iterator[Place]]

_AT_ONCE = 4  # blocks, which bounds the memory


@dataclass(frozen=True)
class Written:
    """The work of one run of `stream` or `repair`.

    Attributes
    ----------
    blocks : int
        Number of blocks of the file.
    made : int
        Number of blocks that this run made.
    pixels : int
        Number of full-resolution pixels that this run made.
    """

    blocks: int
    made: int
    pixels: int


def stream(
    sample: Any,
    path: str | os.PathLike[str],
    size: int | tuple[int, int],
    *,
    method: str | Method = AUTO,
    seed: int | np.random.Generator | None = None,
    tileable: bool | str = False,
    block: int = BLOCK,
    restart: bool = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Written:
    """Write an image of any size to a file, block by block.

    To resume an interrupted run, call it again with the same arguments. The result is the same as
    without the interruption. Only `threads` and `progress` may differ.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    path : path
        ``.tif``: a tiled BigTIFF with smaller versions. Maps become files beside each other, such
        as ``plane_normal.tif``.
    size : int or (int, int)
        Height and width of the image, up to 2**20 each.
    method, tileable
        As for `weftex.synthesize`.
    seed : int, numpy Generator or None
        The same seed gives the same bytes. None takes the seed of an interrupted run, or draws one.
    block : int
        Side of the blocks in pixels, a power of two from 64 to 4096; it changes no pixel. To resume
        a run, give the same.
    restart : bool
        Delete what an earlier run wrote, and start again.
    threads : int, optional
        Maximum number of threads.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`; steps are blocks.
    **parameters
        Parameters of the method.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, or a run with other arguments began the file.
    FileError
        If the file cannot be written, or the disk is too small.
    CancelledError
        If `progress` returned False. Finished blocks are kept.

    Examples
    --------
    >>> import tempfile, weftex
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     weftex.planes.stream("sample:bricks", f"{folder}/wall.tif", (300, 500), seed=1,
    ...                   method="near-regular", block=256)
    Written(blocks=4, made=4, pixels=150000)
    """
    target = os.fspath(path)
    check_output(target, suffixes=TIFF)
    seed = seed_of_run(target) if seed is None else seed
    with listening(progress):
        made = define(sample, size, method, parameters, seed=seed, tileable=tileable, block=block)
        plane = PlaneFile(made, target)
        return write_plane(plane, restart=restart, threads=threads, progress=progress)


def seed_of_run(target: str) -> int | None:
    """Return the seed of the plane that is there, if there is one."""
    record = Record(target)
    return Definition.load(record.definition).seed if record.begun() else None


def write_plane(
    plane: PlaneFile,
    *,
    restart: bool = False,
    repair: bool = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    runner: Runner | None = None,
    check_disk: bool = True,
) -> Written:
    """Make all blocks that are not done, by a runner: in threads by default.

    With `repair` blocks and files that are damaged are made again, of a plane that is there.
    `check_disk` refuses what may not fit on the disk.
    """
    found = done_before(plane, restart=restart, repair=repair)
    if check_disk:
        need = most_bytes(plane, plane.missing(found))
        free = shutil.disk_usage(os.path.dirname(os.path.abspath(plane.path))).free
        if need > free:
            raise FileError(
                f"{plane.path}: may take {in_words(need)} more, but {in_words(free)} are free on "
                "the disk; free some space, or try with --allow-huge"
            )
    with at_work(plane, restart=restart, repair=repair) as record:
        done = plane.sound(record.done()) if repair else record.done()
        left = plane.missing(done)
        steps = Progress(progress, left, "blocks", lambda: None)
        run = runner or partial(in_threads, plane, threads)
        base, pixels = plane.definition.base, 0
        for level in range(plane.levels):  # each is made of the one below
            places = base.places(level, plane.part)
            for place in run(record, (one for one in places if one not in done), steps):
                pixels += prod(base.window(place)[2:]) if level == 0 else 0
                steps.advance(1)
        return Written(plane.count, left, pixels)


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


def most_bytes(plane: PlaneFile, left: int) -> int:
    """Return what a number of blocks may take on the disk."""
    stores = plane.stores.values()
    blocks = plane.definition.base.count(max(store.levels for store in stores))
    return min(left, blocks) * sum(store.size for store in stores) // blocks


def in_words(count: float) -> str:
    """Return bytes with a unit, such as 40 GB."""
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} TB"


_REPAIR = "--repair makes it again"
_SHOWN = 8  # parts


def check(path: str | os.PathLike[str], *, read: bool = False) -> PlaneFile:
    """Check that a plane that `weftex.planes.stream` wrote is whole, and return it.

    Parameters
    ----------
    path : path
        The file.
    read : bool
        Also read all pixels and compare them with their check sums.

    Raises
    ------
    FileError
        If a block or a file is missing or damaged, or there is no plane.
    """
    plane = open_plane(path)
    done = plane.done()
    if flaws := plane.flaws():
        more = f", and {len(flaws) - 1} more files" if flaws[1:] else ""
        raise FileError(
            f"{plane.path} is not complete: {flaws[0]}{more}: missing or damaged; {_REPAIR}"
        )
    if plane.missing(done):
        raise FileError(f"{plane.path} is not complete: {_what_is_missing(plane, done)}")
    if wrong := [*plane.damaged(done)] if read else []:
        raise FileError(
            f"{plane.path}: {len(wrong)} blocks differ from their checksums, the first at "
            f"level, row, column {min(wrong)}; {_REPAIR}"
        )
    return plane


def repair(
    path: str | os.PathLike[str],
    *,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
) -> Written:
    """Read all pixels of a plane, and make missing or damaged blocks and files again.

    Parameters
    ----------
    path, threads, progress
        As for `weftex.planes.stream`.

    Raises
    ------
    FileError
        If there is no plane, or it cannot be written.
    CancelledError
        If `progress` returned False. Finished blocks are kept.
    """
    return write_plane(open_plane(path), repair=True, threads=threads, progress=progress)


def _what_is_missing(plane: PlaneFile, done: Sums) -> str:
    base = plane.definition.base
    columns = base.grid(0)[1]
    made = [row * columns + column for level, row, column in filter(plane.has, done) if level == 0]
    below = base.count(1) - len(made)
    if not below:
        return "only overviews are missing; run the command without --part"
    parts = []
    for count in Record(plane.path).parts():
        numbers = [base.numbers(0, (k, count)) for k in range(1, count + 1)]
        there = Counter(bisect_right([one.start for one in numbers], number) for number in made)
        left = {k: len(one) - there[k] for k, one in enumerate(numbers, 1)}
        parts += [f"{k}/{count} ({number} blocks)" for k, number in left.items() if number > 0]
    more = f" and {len(parts) - _SHOWN} more" if len(parts) > _SHOWN else ""
    of_parts = f"; parts that are not done: {', '.join(parts[:_SHOWN])}{more}" if parts else ""
    return f"{below} blocks are missing{of_parts}"
