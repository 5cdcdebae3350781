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
    """

    definition: Definition
    path: str

    @cached_property
    def stores(self) -> dict[str, TiffStore]:
        """The file of each map."""
        return self.definition.stores(self.path)

    @property
    def levels(self) -> int:
        """Number of levels that are made."""
        return max(store.levels for store in self.stores.values())

    @property
    def count(self) -> int:
        """Number of blocks."""
        return self.definition.base.count(self.levels)

    def done(self) -> Sums:
        """Return the blocks that were written, with the check sums of their pixels."""
        found = Record(self.path).done()
        return {place: sums for place, sums in found.items() if self._has(place)}

    def missing(self, done: Collection[Place] | None = None) -> int:
        """Return the number of blocks that are not done, smaller versions included."""
        return self.count - len(self.done() if done is None else done)

    def _has(self, place: Place) -> bool:
        """Return whether a block belongs to this plane."""
        level, row, column = place
        if not 0 <= level < self.levels:
            return False
        rows, columns = self.definition.base.grid(level)
        return 0 <= row < rows and 0 <= column < columns

    def make(self, record: Record, place: Place, **how: Any) -> None:
        """Make and write a block of every map, and record it as done."""
        stores = self._stores(place[0])
        if place[0] == 0:
            pixels = self.definition.render(self.definition.base.window(place), **how)
        else:
            pixels = {name: store.reduced(place) for name, store in stores.items()}
        record.check_held()
        for name, store in stores.items():
            store.write(place, pixels[name])
        record.add(place, tuple(check_sum(pixels[name]) for name in stores))

    def damaged(self, done: Sums) -> Iterator[Place]:
        """Yield the blocks whose pixels differ from what was written; reads all blocks."""
        for place, sums in done.items():
            stores = self._stores(place[0]).values()
            if sums != tuple(store.sum_of(place) for store in stores):
                yield place

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
    if not record.begun():
        raise FileError(f"{target}: there is no plane in {record.folder} beside it")
    return PlaneFile(Definition.load(record.definition), target)
