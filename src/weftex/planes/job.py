"""A plane and the files that it goes to: begun once, and held while blocks are made."""

from __future__ import annotations

import os
import secrets
import shutil
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from weftex.errors import FileError
from weftex.io.formats import show, suffix_of
from weftex.planes.layout import blocks_below, blocks_in, part_of, part_range, places_of
from weftex.planes.owned import remove, sweep
from weftex.planes.record import Record, Run, refuse_other
from weftex.planes.store import REPAIR, check_sum, synced

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from weftex.planes.definition import Definition
    from weftex.planes.layout import Place
    from weftex.planes.store import Store

    Sums = Mapping[Place, tuple[int, ...]]


@dataclass(frozen=True)
class Job:
    """A plane and the file, or files, that it goes to.

    Attributes
    ----------
    recipe : Definition
    target : str
    part : (int, int), optional
        Make this part of so many, of level 0 only.
    """

    recipe: Definition
    target: str
    part: tuple[int, int] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without its stores, which each process opens."""
        return {"recipe": self.recipe, "target": self.target, "part": self.part}

    @cached_property
    def stores(self) -> dict[str, Store]:
        """Where each picture goes."""
        return self.recipe.stores(self.target)

    @property
    def levels(self) -> int:
        """Number of levels that are made."""
        return 1 if self.part else max(store.levels for store in self.stores.values())

    @property
    def count(self) -> int:
        """Number of blocks."""
        if self.part:
            return len(part_range(self.recipe.base, *self.part))
        return blocks_in(self.recipe.base, self.levels)

    def blocks(self, level: int) -> Iterator[Place]:
        """Give the blocks of a level, of which there may be more than memory holds."""
        base = self.recipe.base
        return part_of(base, *self.part) if self.part else places_of(base, level)

    def left(self, done: Collection[Place]) -> int:
        """Return the number of blocks that are not done."""
        return self.count - sum(map(self._has, done))

    def left_below(self, done: Collection[Place]) -> int:
        """Return the number of blocks of level 0 that are not done."""
        made = sum(place[0] == 0 for place in filter(self._has, done))
        return blocks_in(self.recipe.base, 1) - made

    def _has(self, place: Place) -> bool:
        level, row, column = place
        if not 0 <= level < self.levels:
            return False
        rows, columns = self.recipe.base.grid(level)
        inside = 0 <= row < rows and 0 <= column < columns
        numbers = part_range(self.recipe.base, *self.part) if self.part else None
        return inside and (numbers is None or row * columns + column in numbers)

    def make(self, record: Record, place: Place, **how: Any) -> None:
        """Make a block of every picture, write it, and then that it is done."""
        level = place[0]
        stores = self._stores(level)
        if level == 0:
            pixels = self.recipe.render(self.recipe.base.window(place), **how)
        else:
            names = [*self._stores(level - 1)]
            below = {
                one: dict(zip(names, record.sums(one), strict=False))
                for one in blocks_below(self.recipe.base, place)
            }
            pixels = {
                name: store.reduced(place, {one: sums.get(name, -1) for one, sums in below.items()})
                for name, store in stores.items()
            }
        sums = tuple(check_sum(pixels[name]) for name in stores)
        with record.writing():
            for name, store in stores.items():
                store.write(place, pixels[name])
            record.add(place, sums)

    def damaged(self, done: Sums) -> Iterator[Place]:
        """Give the blocks whose pixels are not those that were written; reads all of them."""
        for place, sums in done.items():
            if self._has(place):
                stores = self._stores(place[0]).values()
                if sums != tuple(_sum_of(store, place) for store in stores):
                    yield place

    def sound(self, done: Sums) -> Sums:
        """Return the blocks that are as they were written, and made of such; reads all of them."""
        damaged = {*self.damaged(done)}
        found: dict[Place, tuple[int, ...]] = {}
        for place in sorted(filter(self._has, done)):  # level by level
            below = blocks_below(self.recipe.base, place) if place[0] and not self.part else ()
            if place not in damaged and all(one in found for one in below):
                found[place] = done[place]
        return found

    def _stores(self, level: int) -> dict[str, Store]:
        """The stores that have a level."""
        return {name: store for name, store in self.stores.items() if level < store.levels}

    def lost(self, done: Collection[Place]) -> Iterator[Place]:
        """Give the blocks that were written, and of which a file is missing."""
        for place in filter(self._has, done):
            if any(store.lacks(place) for store in self._stores(place[0]).values()):
                yield place

    def flaws(self) -> list[str]:
        """Return the files that are missing, or damaged beside their pixels."""
        return [path for store in self.stores.values() for path in store.flaws()]


def _sum_of(store: Store, place: Place) -> int:
    try:
        return check_sum(store.read(place[0], store.layout.window(place)))
    except FileError:
        return -1


def done_before(job: Job, *, restart: bool = False, repair: bool = False) -> Sums:
    """Return the blocks that a run finds done, with their check sums.

    Raises
    ------
    FileError
        If another file is in the way.
    InvalidInputError
        If the plane was begun by another run.
    """
    record = Record(job.target)
    return record.done() if _continued(job, record, restart, repair) else {}


@contextmanager
def at_work(job: Job, *, restart: bool = False, repair: bool = False) -> Iterator[Record]:
    """Hold the plane while the block runs; its files are there then.

    Raises
    ------
    FileError
        If another process works on it, or as `done_before`.
    """
    record = Record(job.target, job.part)
    _continued(job, record, restart, repair)  # leaves nothing behind where it is refused
    with record.held():
        with record.beginning():
            _begin(job, record, restart, repair)
        try:
            yield record
        except Exception:
            if job.part is None and not record.done():  # nothing that a run could go on with
                with suppress(FileError):
                    _forget(job, record)
            raise


def _continued(job: Job, record: Record, restart: bool, repair: bool) -> Run | None:
    """The run that is continued; None if one begins."""
    # Looked for before the run is read: a file that a run has made since is known to be its own.
    there = [path for path in dict.fromkeys((job.target, *_roots(job))) if os.path.lexists(path)]
    for path in filter(os.path.islink, there):
        raise FileError(f"{show(path)} is a link; remove it, or name another file")
    record.check_folder()
    run = record.current()
    if run is not None and run.begun and not restart:
        refuse_other(job.target, run.about, job.recipe.about)
        if repair or there:
            if not repair and (flaws := job.flaws()):
                raise FileError(f"{show(flaws[0])} is missing or damaged; {REPAIR}")
            return run
    if repair:
        raise FileError(f"{show(job.target)} was not begun")
    own = [os.path.abspath(_path(job, name)) for name in run.files] if run else []
    for path in there:
        if os.path.abspath(path) not in own:
            raise FileError(
                f"{show(path)} is there already, and {show(record.folder)} does not say that it is "
                "of this plane; remove it, or name another file"
            )
    return None


def _begin(job: Job, record: Record, restart: bool, repair: bool) -> None:
    """Make the files, unless a run is continued. Whoever is killed in between begins anew."""
    if run := _continued(job, record, restart, repair):
        record.run = run.name
        if job.part is None:
            with record.alone():
                for path in (record.folder, *(_path(job, name) for name in run.files)):
                    sweep(path)
                if repair and job.flaws():
                    _create(job)
        return
    old = record.current()
    name, roots = secrets.token_hex(16), [_name(job, path) for path in _roots(job)]
    # The list of files may be a stranger's: only what this run writes, or its folder, is removed.
    past = record.of_target(old.files) if old else []
    owned = sorted({*roots, *past}, reverse=True)  # groups, then their Zarr
    run, grids = Run(name, False, owned, grids=old.grids if old else {}), _grids(job)
    record.begin(run)
    with record.alone():
        for root in owned:
            remove(_path(job, root), run.grids.get(root))
        record.clear()
        record.begin(Run(name, False, roots, grids=grids))  # what was there before is gone
        _create(job)
        job.recipe.save(record.recipe, name)
        synced(record.recipe)
        record.begin(Run(name, True, roots, job.recipe.about, grids))


def _create(job: Job) -> None:
    for store in job.stores.values():
        store.create()
    for root in _roots(job):
        if os.path.exists(root):
            synced(root)


def _forget(job: Job, record: Record) -> None:
    """Remove what a run made that has not finished a block."""
    with record.beginning():
        if (run := record.current()) is None or run.name != record.run:
            return  # somebody removed the plane, and another run may have begun it since
        roots, grids = [_name(job, path) for path in _roots(job)], _grids(job)
        record.begin(Run(secrets.token_hex(16), False, roots, grids=grids))
        with record.alone():
            for root in sorted(roots, reverse=True):
                remove(_path(job, root), grids.get(root))
        record.remove()


def _roots(job: Job) -> list[str]:
    """Files and folders of a plane; maps of a Zarr are groups in one."""
    roots = [root for store in job.stores.values() for root in store.roots]
    return (
        [*roots, job.target] if suffix_of(job.target) == ".zarr" and len(job.stores) > 1 else roots
    )


def _grids(job: Job) -> dict[str, list[int]]:
    """Return the grid of each store's files, by the names of its roots."""
    stores = job.stores.values()
    return {_name(job, root): [*store.grid] for store in stores for root in store.roots}


def _name(job: Job, path: str) -> str:
    return os.path.relpath(path, os.path.dirname(job.target) or ".").replace(os.sep, "/")


def _path(job: Job, name: str) -> str:
    return os.path.join(os.path.dirname(job.target), *name.split("/"))


def check_room(job: Job, left: int) -> None:
    """Raise `FileError` unless the disk has room for a number of blocks."""
    need = most_bytes(job, left)
    free = shutil.disk_usage(os.path.dirname(os.path.abspath(job.target))).free
    if need > free:
        raise FileError(
            f"{show(job.target)}: may take {in_words(need)} more, and {in_words(free)} are free on "
            "the disk; make room, or --allow-huge tries anyway"
        )


def most_bytes(job: Job, left: int) -> int:
    """Return what a number of blocks may take on the disk."""
    stores = job.stores.values()
    blocks = blocks_in(job.recipe.base, max(store.levels for store in stores))
    return min(left, blocks) * sum(store.most_bytes for store in stores) // blocks


def in_words(count: float) -> str:
    """Return bytes with a unit.

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
