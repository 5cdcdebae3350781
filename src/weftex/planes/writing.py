"""Write a plane to a file block by block: larger than memory, and again from where it stopped."""

from __future__ import annotations

import numbers
import os
from dataclasses import dataclass
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import InvalidInputError, shown
from weftex.loading import load_exemplar
from weftex.planes.definition import BLOCK, Definition, period_of, settled
from weftex.planes.files import check_target
from weftex.planes.job import Job, at_work, check_room, done_before
from weftex.planes.record import Record
from weftex.progress import Progress
from weftex.random import seed_number
from weftex.tasks.method_names import AUTO, make_method
from weftex.threads import in_turn, thread_count

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from weftex.loading import Sample
    from weftex.method import Method
    from weftex.planes.layout import Place
    from weftex.progress import ProgressCallback
    from weftex.random import Seed

    #: Makes blocks of one level for the run of a record, which are done when it gives them.
    Runner = Callable[[Record, Iterable[Place], Progress], Iterator[Place]]

_AT_ONCE = 4  # blocks, which bounds the memory


@dataclass(frozen=True)
class Written:
    """What a run did.

    Attributes
    ----------
    blocks, made : int
        How many there are to do in all, and how many this run did.
    pixels : int
        Of level 0, that this run made.
    """

    blocks: int
    made: int
    pixels: int


def stream(
    sample: Sample,
    path: str | os.PathLike[str],
    size: int | tuple[int, int],
    *,
    method: str | Method = AUTO,
    seed: Seed = None,
    tileable: bool | str = False,
    block: int = BLOCK,
    restart: bool = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    **parameters: Any,
) -> Written:
    """Write a picture of any size to a file, a block at a time.

    What was stopped goes on when it is called again with the same arguments; the bytes are those
    of one run.

    Parameters
    ----------
    sample : path, array, PIL image or Exemplar
        The material; see `weftex.load_exemplar`.
    path : path
        ``.tif`` for a tiled BigTIFF, ``.zarr`` (extra ``zarr``) or ``.dzi``, all with smaller
        versions. Maps of a set have groups of a Zarr, or files beside it, ``plane_normal.tif``.
    size : int or (int, int)
        Height and width, up to 2**40 each.
    method, seed, tileable
        As for `weftex.synthesize`. Without a seed that of the run that is there is taken.
    block : int
        Side of the blocks in pixels, a power of two from 64 to 4096; it changes no pixel.
    restart : bool
        Remove what is there and begin again.
    threads : int, optional
        At most so many.
    progress : callable, optional
        See `weftex.progress.ProgressCallback`; steps are blocks.
    **parameters
        Of the method.

    Raises
    ------
    InvalidInputError
        If an argument is out of range, or the file was begun by another run.
    UnsupportedError
        If the method does not make windows of a plane.
    FileError
        If the file cannot be written, or the disk has not enough room.

    Examples
    --------
    >>> import tempfile, weftex
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     weftex.stream("sample:bricks", f"{folder}/wall.tif", (300, 500), seed=1,
    ...                   method="near-regular", block=256)
    Written(blocks=4, made=4, pixels=150000)
    """
    target = os.fspath(path)
    check_target(target)
    chosen, exemplar = make_method(method, parameters), load_exemplar(sample)
    recipe = recipe_of(exemplar, chosen, size, target, seed=seed, tileable=tileable, block=block)
    return write_plane(Job(recipe, target), restart=restart, threads=threads, progress=progress)


def recipe_of(
    exemplar: Any,
    method: Method,
    size: int | tuple[int, int],
    target: str = "",
    *,
    seed: Seed = None,
    tileable: bool | str = False,
    block: int = BLOCK,
    stems: Mapping[str, str] | None = None,
) -> Definition:
    """Return what a plane is made of; a seed that is not given is that of a run that is there."""
    axes = {False: (False, False), True: (True, True), "x": (False, True), "y": (True, False)}
    if tileable not in axes:
        raise InvalidInputError(f"tileable is {tileable!r}; it must be True, False, 'x' or 'y'")
    height, width = _sides(size)
    record = Record(target)
    if seed is None and target and record.exists():
        seed = Definition.load(record.recipe).seed
    number = seed_number(seed)
    period = period_of((height, width), axes[tileable])
    model = method.fit(exemplar)
    chosen = settled(model, number, period)
    about: dict[str, Any] = {"height": height, "width": width, "wrap": axes[tileable]}
    about |= {"seed": number, "block": block, "stems": dict(stems or {})}
    recipe = Definition(exemplar, **chosen, **about)
    if recipe.method is model.asked:
        vars(recipe)["model"] = model  # not fitted again
    return recipe


def _sides(size: Any) -> tuple[int, int]:
    """Height and width."""
    pair = size if isinstance(size, (tuple, list)) and len(size) == 2 else (size, size)
    if not all(isinstance(side, numbers.Integral) and int(side) >= 1 for side in pair):
        raise InvalidInputError(f"size is {shown(size)}; it must be (height, width), 1 or more")
    return int(pair[0]), int(pair[1])


def write_plane(
    job: Job,
    *,
    restart: bool = False,
    repair: bool = False,
    threads: int | None = None,
    progress: ProgressCallback | None = None,
    runner: Runner | None = None,
    check_disk: bool = True,
) -> Written:
    """Make all blocks that are not done.

    Parameters
    ----------
    job : Job
    restart, threads, progress
        As for `stream`.
    repair : bool
        Continue a plane that is there, and make blocks and files that are damaged or missing, too.
    runner : callable, optional
        Makes the blocks of a level, here by default, in threads.
    check_disk : bool
        Refuse what may not fit on the disk.
    """
    found = done_before(job, restart=restart, repair=repair)
    if check_disk:
        check_room(job, job.left(found))
    with at_work(job, restart=restart, repair=repair) as record:
        done = job.sound(record.done()) if repair else record.done()
        left = job.left(done)
        steps = Progress(progress, left, "blocks", lambda: None)
        run = runner or partial(_here, job, threads)
        pixels = 0
        for level in range(job.levels):  # each is made of the one below
            todo = (place for place in job.blocks(level) if place not in done)
            for place in run(record, todo, steps):
                if level == 0:
                    pixels += int(np.prod(job.recipe.base.window(place)[2:]))
                steps.advance(1)
        return Written(job.count, left, pixels)


def _here(
    job: Job, threads: int | None, record: Record, level: Iterable[Place], steps: Progress
) -> Iterator[Place]:
    """Make blocks in threads of this process."""
    count = thread_count(threads)
    at_once = min(count, _AT_ONCE)
    how = {"threads": max(1, count // at_once), "progress": steps.within()}
    fitting = Lock()

    def make(place: Place) -> Place:
        if place[0] == 0:
            with fitting:
                job.recipe.model  # noqa: B018  (fitted once, not in every thread)
        job.make(record, place, **how)
        return place

    yield from in_turn(make, level, at_once)
