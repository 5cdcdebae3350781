"""A plane that was written: whether it is whole, and its pixels in windows."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import FileError
from weftex.exemplar import Exemplar
from weftex.io.formats import path_text, show
from weftex.planes.definition import Definition
from weftex.planes.job import Job
from weftex.planes.layout import part_range
from weftex.planes.record import Record
from weftex.random import draw

if TYPE_CHECKING:
    import os

    from weftex.planes.job import Sums
    from weftex.planes.layout import Window

_SEEN, _SIDE = 5, 512  # windows of a plane that are looked at, and their sides


@dataclass(frozen=True)
class PlaneFile:
    """A plane on disk.

    Attributes
    ----------
    job : Job
        What it is made of, and where it is.
    done : mapping of (int, int, int) to tuple of int
        The blocks that were written, with the check sums of their pixels.
    """

    job: Job
    done: Sums

    @property
    def path(self) -> str:
        """The file, or folder."""
        return self.job.target

    @property
    def recipe(self) -> Definition:
        """What it is made of."""
        return self.job.recipe

    def missing(self) -> int:
        """Return the number of blocks that are not done, smaller versions included."""
        return self.job.left(self.done)

    def parts(self) -> dict[str, int]:
        """Return how many blocks are missing of each part, if parts were made."""
        base = self.recipe.base
        columns = base.grid(0)[1]
        done = [row * columns + column for level, row, column in self.done if level == 0]
        found: dict[str, int] = {}
        for count in Record(self.path).parts():
            numbers = [part_range(base, k, count) for k in range(1, count + 1)]
            starts = [one.start for one in numbers]
            made = Counter(bisect_right(starts, number) for number in done)
            left = {k: len(one) - made[k] for k, one in enumerate(numbers, 1)}
            found |= {f"{k}/{count}": number for k, number in left.items() if number > 0}
        return found

    def read(self, window: Window) -> Exemplar:
        """Return a window of level 0 with its maps, in pixels of the sample's size.

        Raises
        ------
        FileError
            If the plane is not whole.
        """
        if left := self.missing():
            raise FileError(
                f"{show(self.path)} is not whole: {left} blocks are missing; the command that made "
                "it goes on"
            )
        found = {}
        for name, picture in self.recipe.pictures.items():
            store = self.job.stores[name]
            ratio = store.layout.block / self.recipe.block
            top, left, height, width = (int(side * ratio) for side in window)
            found[name] = picture.changed(
                pixels=store.read(0, (top, left, height, width)), maps={}, mask=None, guide=None
            )
        main, *others = found
        return found[main].changed(maps={name: found[name] for name in others}, name=self.path)

    def some(self) -> list[Window]:
        """Return windows here and there, the same ones every time."""
        sides = (self.recipe.height, self.recipe.width)
        height, width = (min(side, _SIDE) for side in sides)
        where = draw(
            self.recipe.seed, "windows of a report", np.arange(_SEEN)[:, None], np.arange(2)
        )
        room = np.array([sides[0] - height, sides[1] - width], np.uint64) + np.uint64(1)
        corners = np.unique(where % room // np.uint64(16) * np.uint64(16), axis=0)
        return [(int(top), int(left), height, width) for top, left in corners]


def open_plane(path: str | os.PathLike[str]) -> PlaneFile:
    """Open a plane that `weftex.stream` wrote.

    Raises
    ------
    FileError
        If it is none, or was made by another version whose recipe cannot be read.
    """
    target = path_text(path)
    record = Record(target)
    run = record.current()
    if run is None or not run.begun:
        raise FileError(f"{show(target)}: there is no plane in {show(record.folder)} beside it")
    job = Job(Definition.load(record.recipe, run.name), target)
    return PlaneFile(job, record.done())
