"""Write a plane to a file block by block: larger than memory, and again from where it stopped."""

from __future__ import annotations

import numbers
import os
import shutil
import zlib
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.errors import FileError, InvalidInputError, shown
from weftex.io.formats import show
from weftex.loading import load_exemplar
from weftex.progress import Progress
from weftex.random import seed_number
from weftex.stores.files import check_target
from weftex.stores.layout import part_of, places
from weftex.stores.record import Record, refuse_other
from weftex.tasks.method_names import AUTO, make_method
from weftex.tasks.recipe import BLOCK, Recipe, period_of, settled
from weftex.threads import in_turn, thread_count

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from weftex.loading import Sample
    from weftex.method import Method
    from weftex.progress import ProgressCallback
    from weftex.random import Seed
    from weftex.stores.layout import Place
    from weftex.stores.store import Store

    #: Makes blocks of one level, and gives each when it is on the disk, and the journal says so.
    Runner = Callable[[Iterable[Place], Progress], Iterator[Place]]

_AT_ONCE = 4  # blocks, which bounds the memory


@dataclass(frozen=True)
class Job:
    """A plane and the file, or files, that it goes to.

    Attributes
    ----------
    recipe : Recipe
    target : str
    part : (int, int), optional
        Make this part of so many, of level 0 only.
    """

    recipe: Recipe
    target: str
    part: tuple[int, int] | None = None

    def stores(self) -> dict[str, Store]:
        """Where each picture goes."""
        return self.recipe.stores(self.target)

    def make(self, stores: Mapping[str, Store], record: Record, place: Place, **how: Any) -> None:
        """Make a block of every picture, write it, and then that it is done."""
        base: dict[str, Any] = {}
        if place[0] == 0:
            base = self.recipe.render(self.recipe.base.window(place), **how)
        sums = []
        for name, store in stores.items():
            if place[0] >= store.levels:
                continue
            pixels = base[name] if place[0] == 0 else store.reduced(place)
            store.write(place, pixels)
            sums.append(check_sum(pixels))
        record.add(place, tuple(sums))


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


def check_sum(pixels: NDArray[Any]) -> int:
    """Return the check sum of pixels that journals have."""
    return zlib.crc32(np.ascontiguousarray(pixels).data)


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
) -> Recipe:
    """Return what a plane is made of; a seed that is not given is that of a run that is there."""
    axes = {False: (False, False), True: (True, True), "x": (False, True), "y": (True, False)}
    if tileable not in axes:
        raise InvalidInputError(f"tileable is {tileable!r}; it must be True, False, 'x' or 'y'")
    height, width = _sides(size)
    record = Record(target)
    if seed is None and target and record.exists():
        seed = Recipe.load(record.recipe).seed
    number = seed_number(seed)
    period = period_of((height, width), axes[tileable])
    model = method.fit(exemplar)
    chosen = settled(model, number, period)
    about: dict[str, Any] = {"height": height, "width": width, "wrap": axes[tileable]}
    about |= {"seed": number, "block": block, "stems": dict(stems or {})}
    recipe = Recipe(exemplar, **chosen, **about)
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
    runner : callable, optional
        Makes the blocks of a level, here by default, in threads.
    check_disk : bool
        Refuse what may not fit on the disk.
    """
    stores, record = job.stores(), Record(job.target, job.part)
    check_begun(job, stores, record, restart)
    if check_disk:
        check_room(job.target, stores, left_of(job, stores, record, restart))
    with at_work(job, stores, record, restart):
        todo = left_of(job, stores, record)
        steps = Progress(progress, len(todo), "blocks", lambda: None)
        run = runner or partial(_here, job, stores, record, threads)
        pixels = 0
        for level in sorted({place[0] for place in todo}):  # each is made of the one below
            for place in run([place for place in todo if place[0] == level], steps):
                if level == 0:
                    pixels += int(np.prod(job.recipe.base.window(place)[2:]))
                steps.advance(1)
        return Written(len(wanted(job, stores)), len(todo), pixels)


def _here(
    job: Job,
    stores: Mapping[str, Store],
    record: Record,
    threads: int | None,
    level: Iterable[Place],
    steps: Progress,
) -> Iterator[Place]:
    """Make blocks in threads of this process."""
    count = thread_count(threads)
    at_once = min(count, _AT_ONCE)
    how = {"threads": max(1, count // at_once), "progress": steps.within()}
    blocks = list(level)
    if blocks and blocks[0][0] == 0:
        job.recipe.model  # noqa: B018  (fitted once, not in every thread)

    def make(k: int) -> Place:
        job.make(stores, record, blocks[k], **how)
        return blocks[k]

    yield from in_turn(make, range(len(blocks)), at_once)


def wanted(job: Job, stores: Mapping[str, Store]) -> list[Place]:
    """All blocks of a job, in their order."""
    base = job.recipe.base
    if job.part is not None:
        return list(part_of(base, *job.part))
    return list(places(base, max(store.levels for store in stores.values())))


def left_of(
    job: Job, stores: Mapping[str, Store], record: Record, restart: bool = False
) -> list[Place]:
    """Those that are not done."""
    done = {} if restart else record.done()
    return [place for place in wanted(job, stores) if place not in done]


@contextmanager
def at_work(
    job: Job, stores: Mapping[str, Store], record: Record, restart: bool = False
) -> Iterator[None]:
    """Hold the plane while the block runs; its files are there then.

    Raises
    ------
    FileError
        If another process works on it.
    """

    def begin() -> None:
        if record.exists() and not restart:
            refuse_other(job.target, Recipe.load(record.recipe).about, job.recipe.about)
            if all(store.exists() for store in stores.values()):
                return
        record.remove()
        for store in stores.values():
            if os.path.exists(store.path):
                store.remove()
        for store in stores.values():
            store.create({"seed": job.recipe.seed, "method": job.recipe.method.describe()})
        job.recipe.save(record.recipe)

    with record.at_work(begin):
        try:
            yield
        except Exception:
            if job.part is None and not record.done():  # nothing that a run could go on with
                for store in stores.values():
                    store.remove()
                record.remove_folder()
            raise


def check_begun(
    job: Job, stores: Mapping[str, Store], record: Record, restart: bool = False
) -> None:
    """Refuse to go on with another plane, and to replace another file unasked.

    Raises
    ------
    FileError
        If another file is in the way.
    InvalidInputError
        If it was begun by another run.
    """
    files = [store.path for store in stores.values()]
    in_the_way = [path for path in (job.target, *files) if os.path.exists(path)]
    if record.exists() and not restart:
        refuse_other(job.target, Recipe.load(record.recipe).about, job.recipe.about)
    elif in_the_way and not (restart and _ours(in_the_way)):
        raise FileError(
            f"{show(in_the_way[0])} is there already; --restart replaces a plane or a picture, or "
            "name another file"
        )


def _ours(paths: list[str]) -> bool:
    """Whether what is in the way looks like a picture or a store: no folder of anything else."""
    return all(
        os.path.isfile(path) or os.path.exists(os.path.join(path, "zarr.json")) for path in paths
    )


def check_room(target: str, stores: Mapping[str, Store], todo: list[Place]) -> None:
    """Raise `FileError` unless the disk has room for the blocks that are left."""
    need = most_bytes(stores, todo)
    free = shutil.disk_usage(os.path.dirname(os.path.abspath(target))).free
    if need > free:
        raise FileError(
            f"{show(target)}: may take {in_words(need)} more, and {in_words(free)} are free on the "
            "disk; make room, or --allow-huge tries anyway"
        )


def most_bytes(stores: Mapping[str, Store], todo: list[Place]) -> int:
    """What blocks may take on the disk."""
    some = next(iter(stores.values()))  # all have the same blocks
    blocks = sum(rows * columns for rows, columns in map(some.layout.grid, range(some.levels)))
    share = min(len(todo) / blocks, 1)
    return int(share * sum(store.most_bytes for store in stores.values()))


def in_words(count: float) -> str:
    """Bytes with a unit.

    Examples
    --------
    >>> in_words(40e9)
    '40 GB'
    """
    for unit in ("bytes", "kB", "MB", "GB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} TB"
