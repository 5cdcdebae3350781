"""A plane and the file, or files, that it goes to."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from weftex.errors import FileError
from weftex.planes.definition import Definition
from weftex.planes.layout import Place
from weftex.planes.record import Record
from weftex.planes.tiff import TiffStore, check_sum

Sums = Mapping[Place, tuple[int, ...]]


@dataclass(frozen=True)
class PlaneFile:
    """A plane on disk; `open_plane` returns it.

    Attributes
    ----------
    definition : Definition
        Sample, method, size, seed and blocks.
    path : str
        The file.
    part : (int, int), optional
        Number of the part, from 1, and number of parts, if this process makes only one part, as
        with `--part` of the command line. `stream` always makes all.
    """

    definition: Definition
    path: str
    part: tuple[int, int] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without its stores, which each process opens."""
        return {name: getattr(self, name) for name in ("definition", "path", "part")}

    @cached_property
    def stores(self) -> dict[str, TiffStore]:
        """The file of each map."""
        return self.definition.stores(self.path)

    @property
    def levels(self) -> int:
        """Number of levels that are made."""
        return 1 if self.part else max(store.levels for store in self.stores.values())

    @property
    def count(self) -> int:
        """Number of blocks."""
        base = self.definition.base
        return sum(len(base.numbers(level, self.part)) for level in range(self.levels))

    def done(self) -> Sums:
        """Return the blocks that were written, with the check sums of their pixels."""
        return Record(self.path).done()

    def missing(self, done: Collection[Place] | None = None) -> int:
        """Return the number of blocks that are not done, smaller versions included."""
        return self.count - sum(map(self.has, self.done() if done is None else done))

    def has(self, place: Place) -> bool:
        """Return whether a block belongs to this plane, or this part of it."""
        level, row, column = place
        if not 0 <= level < self.levels:
            return False
        base = self.definition.base
        columns = base.grid(level)[1]
        return 0 <= column < columns and row * columns + column in base.numbers(level, self.part)

    def make(self, record: Record, place: Place, **how: Any) -> None:
        """Make and write a block of every map, and record it as done."""
        level, base = place[0], self.definition.base
        stores = self._stores(level)
        if level == 0:
            pixels = self.definition.render(base.window(place), **how)
        else:
            below = {one: record.sums(one) for one in base.below(place)}
            pixels = {}
            for k, name in enumerate(self._stores(level - 1)):
                if name in stores:
                    own = {one: sums[k] if k < len(sums) else -1 for one, sums in below.items()}
                    pixels[name] = stores[name].reduced(place, own)
        sums = tuple(check_sum(pixels[name]) for name in stores)
        with record.writing():
            for name, store in stores.items():
                store.write(place, pixels[name])
            record.add(place, sums)

    def damaged(self, done: Sums) -> Iterator[Place]:
        """Yield the blocks whose pixels differ from what was written; reads all blocks."""
        for place in filter(self.has, done):
            stores = self._stores(place[0]).values()
            if done[place] != tuple(store.sum_of(place) for store in stores):
                yield place

    def sound(self, done: Sums) -> Sums:
        """Return the undamaged blocks that are made of undamaged blocks; reads all blocks."""
        damaged = {*self.damaged(done)}
        found: dict[Place, tuple[int, ...]] = {}
        for place in sorted(filter(self.has, done)):  # level by level
            below = self.definition.base.below(place) if place[0] else ()
            if place not in damaged and all(one in found for one in below):
                found[place] = done[place]
        return found

    def flaws(self) -> list[str]:
        """Return the files that are missing, or damaged beside their pixels."""
        return [store.path for store in self.stores.values() if not store.is_sound()]

    def _stores(self, level: int) -> dict[str, TiffStore]:
        """The stores that have a level."""
        return {name: store for name, store in self.stores.items() if level < store.levels}


def open_plane(path: str | os.PathLike[str]) -> PlaneFile:
    """Open a plane that `weftex.planes.stream` wrote.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    FileError
        If there is no plane, or this version of weftex cannot read it.
    """
    target = os.fspath(path)
    record = Record(target)
    if (run := record.begun()) is None:
        raise FileError(f"{target}: there is no plane in {record.folder} beside it")
    return PlaneFile(Definition.load(record.definition, run.name), target)
