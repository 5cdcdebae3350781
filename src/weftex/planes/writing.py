"""Write a plane to a file block by block, resume it, and check it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from weftex import Method
from weftex.errors import FileError, InvalidInputError, shown
from weftex.io.pictures import check_output
from weftex.planes.definition import BLOCK, Definition, define
from weftex.planes.layout import Place
from weftex.planes.plane_file import PlaneFile, Sums, open_plane
from weftex.planes.record import Record, Run
from weftex.planes.tiff import AGAIN, SUFFIXES, synced
from weftex.progress import Progress, ProgressCallback
from weftex.tasks.method_names import AUTO
from weftex.threads import in_turn, thread_count

_AT_ONCE = 4  # blocks, which bounds the memory
_WORDS = {"digest": "sample", "wrap": "tiling (y, x)", "version": "version of weftex"}


@dataclass(frozen=True)
class Written:
    """The work of one run of `stream`.

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

    To resume an interrupted run, call it again with the same arguments. The bytes are those of an
    uninterrupted run. Only `threads` and `progress` may differ.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    path : path
        ``.tif``: a tiled BigTIFF with smaller versions. Maps become files beside each other, such
        as ``plane_normal.tif``.
    size : int or (int, int)
        Height and width, up to 2**20 each.
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

    Examples
    --------
    >>> import tempfile, weftex
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     weftex.planes.stream("sample:bricks", f"{folder}/wall.tif", (300, 500), seed=1,
    ...                   method="near-regular", block=256)
    Written(blocks=4, made=4, pixels=150000)
    """
    target = os.fspath(path)
    check_output(target, suffixes=SUFFIXES)
    seed = seed_of_run(target) if seed is None else seed
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
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    check_disk: bool = True,
) -> Written:
    """Make all blocks that are not done; `check_disk` refuses what may not fit on the disk."""
    left = plane.missing(done_before(plane, restart=restart))
    if check_disk:
        _check_free_space(plane, left)
    base, pixels = plane.definition.base, 0
    with at_work(plane, restart=restart) as record:
        done = plane.done()
        left = plane.missing(done)
        steps = Progress(progress, left, "blocks", lambda: None)
        for level in range(plane.levels):  # each is made of the one below
            places = (one for one in base.places(level) if one not in done)
            for place in _made(plane, record, places, threads, steps):
                pixels += prod(base.window(place)[2:]) if level == 0 else 0
                steps.advance(1)
    return Written(plane.count, left, pixels)


def _made(
    plane: PlaneFile,
    record: Record,
    places: Iterable[Place],
    threads: int | None,
    steps: Progress,
) -> Iterator[Place]:
    """Make blocks in threads, and yield each when it is done."""
    count = thread_count(threads)
    at_once = min(count, _AT_ONCE)
    fitting = Lock()

    def make(place: Place) -> Place:
        with fitting:
            plane.definition.model  # noqa: B018  (fitted once, not in every thread)
        plane.make(record, place, threads=max(1, count // at_once), progress=steps.within())
        return place

    return in_turn(make, places, at_once)


def done_before(plane: PlaneFile, *, restart: bool = False) -> Sums:
    """Return the blocks that a run finds done, with their check sums.

    `FileError` if another file is in the way, `InvalidInputError` if another run began the plane.
    """
    return plane.done() if _continues(plane, Record(plane.path), restart) else {}


@contextmanager
def at_work(plane: PlaneFile, *, restart: bool = False) -> Iterator[Record]:
    """Hold the plane, which `done_before` has looked at, while the block runs; its files are there.

    Raises as `done_before`, and `FileError` if another process works on the plane.
    """
    record = Record(plane.path)
    with record.held():
        if not _continues(plane, record, restart):
            _begin(plane, record)
        try:
            yield record
        except Exception:
            with suppress(FileError):
                record.check_held()
                if not plane.done():  # nothing that a run could continue
                    _remove_files(plane, record, _names(plane))
                    record.remove()
            raise


def _continues(plane: PlaneFile, record: Record, restart: bool) -> bool:
    """Whether the run that is there is continued; else one begins."""
    there = [path for path in dict.fromkeys((plane.path, *_roots(plane))) if os.path.lexists(path)]
    for path in there:
        if os.path.islink(path) or not os.path.isfile(path):
            what = "a link" if os.path.islink(path) else "no file"
            raise FileError(f"{path} is {what}; remove it, or name another file")
    record.check_folder()
    run = record.current()
    if run is not None and run.begun and not restart:
        _refuse_other(plane, run)
        if there:
            if flaws := plane.flaws():
                raise FileError(f"{flaws[0]} is missing or damaged; {AGAIN}")
            return True
    own = [os.path.abspath(_path(plane, name)) for name in run.files] if run else []
    for path in there:
        if os.path.abspath(path) not in own:
            raise FileError(
                f"{path} exists already, and {record.folder} does not list it as part of this "
                "image; remove it, or name another file"
            )
    return False


def _refuse_other(plane: PlaneFile, run: Run) -> None:
    """Raise `InvalidInputError` unless a run makes the same plane, saying where they differ."""
    for name, wanted in plane.definition.about.items():
        found = run.about.get(name)
        if found != wanted:
            values = f"{shown(found)}, here {shown(wanted)}"
            raise InvalidInputError(
                f"{plane.path} was started by another run: its {_WORDS.get(name, name)} is "
                f"{'different' if name == 'digest' else values}; --restart starts again, or name "
                "another file"
            )


def _begin(plane: PlaneFile, record: Record) -> None:
    """Make the files anew. A run killed in between starts again."""
    old, names = record.current(), _names(plane)
    # The list of files may be a stranger's: only what this run writes, or its target, is removed.
    past = {os.path.basename(plane.path)}.intersection(old.files if old else ())
    _remove_files(plane, record, sorted({*names, *past}))
    record.clear()
    record.begin(Run(False, names))  # what was there before is gone
    for store in plane.stores.values():
        store.create()
    plane.definition.save(record.definition)
    synced(record.definition)
    record.begin(Run(True, names, plane.definition.about))


def _remove_files(plane: PlaneFile, record: Record, names: list[str]) -> None:
    """Remove files, which the record lists before."""
    record.begin(Run(False, names))
    for name in names:
        path = Path(_path(plane, name))
        if not path.is_symlink():
            path.unlink(missing_ok=True)


def _roots(plane: PlaneFile) -> list[str]:
    """The files of a plane, all in one folder."""
    return [store.path for store in plane.stores.values()]


def _names(plane: PlaneFile) -> list[str]:
    return [os.path.basename(path) for path in _roots(plane)]


def _path(plane: PlaneFile, name: str) -> str:
    return os.path.join(os.path.dirname(plane.path), name)


def _check_free_space(plane: PlaneFile, left: int) -> None:
    """Raise `FileError` unless a number of blocks fit on the disk."""
    need = most_bytes(plane, left)
    free = shutil.disk_usage(os.path.dirname(os.path.abspath(plane.path))).free
    if need > free:
        raise FileError(
            f"{plane.path}: may take {in_words(need)} more, and {in_words(free)} are free on the "
            "disk; make room, or --allow-huge tries anyway"
        )


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
        raise FileError(f"{plane.path} is not whole: {flaws[0]}{more}: missing or damaged; {AGAIN}")
    if missing := plane.missing(done):
        raise FileError(
            f"{plane.path} is not whole: {missing} blocks are missing; the same command continues"
        )
    if wrong := [*plane.damaged(done)] if read else []:
        raise FileError(
            f"{plane.path}: {len(wrong)} blocks differ from their checksums, the first at "
            f"level, row, column {min(wrong)}; {AGAIN}"
        )
    return plane
