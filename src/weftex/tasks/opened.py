"""A plane that was written: whether it is whole, and its pixels in windows."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weftex.errors import FileError
from weftex.exemplar import Exemplar
from weftex.io.formats import path_text, show
from weftex.random import draw
from weftex.stores.layout import part_of
from weftex.stores.record import Record
from weftex.tasks.recipe import Recipe
from weftex.tasks.stream import Job, check_sum, wanted

if TYPE_CHECKING:
    from weftex.stores.layout import Place, Window
    from weftex.stores.store import Store

_SEEN, _SIDE = 5, 512  # windows of a plane that are looked at, and their sides


@dataclass(frozen=True)
class PlaneFile:
    """A plane on disk.

    Attributes
    ----------
    path : str
    recipe : Recipe
        What it is made of.
    stores : dict of str to Store
        Its pictures by the names of maps.
    """

    path: str
    recipe: Recipe
    stores: dict[str, Store]

    def missing(self) -> list[Place]:
        """Return the blocks that are not done, smaller versions included."""
        done = Record(self.path).done()
        return [place for place in wanted(self._job, self.stores) if place not in done]

    def unlike(self) -> list[Place]:
        """Return the blocks whose pixels are not those that were written; reads all of them."""
        found = []
        for place, sums in Record(self.path).done().items():
            level = place[0]
            stores = [store for store in self.stores.values() if level < store.levels]
            if sums != tuple(_sum_of(store, place) for store in stores):
                found.append(place)
        return found

    def parts(self) -> dict[str, int]:
        """Return how many blocks are missing of each part, if parts were made."""
        counts = {int(m[1]) for m in map(_PART.fullmatch, _files(self.path)) if m}
        done, base = Record(self.path).done(), self.recipe.base
        return {
            f"{k}/{count}": left
            for count in sorted(counts)
            for k in range(1, count + 1)
            if (left := sum(place not in done for place in part_of(base, k, count)))
        }

    def read(self, window: Window) -> Exemplar:
        """Return a window of level 0 with its maps, in pixels of the sample's size.

        Raises
        ------
        FileError
            If the plane is not whole.
        """
        if left := len(self.missing()):
            raise FileError(
                f"{show(self.path)} is not whole: {left} blocks are missing; the command that made "
                "it goes on"
            )
        found = {}
        for name, picture in self.recipe.pictures.items():
            store = self.stores[name]
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

    @property
    def _job(self) -> Job:
        return Job(self.recipe, self.path)


_PART = re.compile(r"part-\d+-of-(\d+)\.txt")


def _files(path: str) -> list[str]:
    return os.listdir(Record(path).folder)


def _sum_of(store: Store, place: Place) -> int:
    try:
        pixels = store.read(place[0], store.layout.window(place))
    except (OSError, ValueError, FileError):
        return -1
    return check_sum(pixels)


def open_plane(path: str | os.PathLike[str]) -> PlaneFile:
    """Open a plane that `weftex.stream` wrote.

    Raises
    ------
    FileError
        If it is none, or was made by another version whose recipe cannot be read.
    """
    target = path_text(path)
    if not Record(target).exists():
        raise FileError(f"{show(target)}: there is no {show(Record(target).folder)} beside it")
    recipe = Recipe.load(Record(target).recipe)
    return PlaneFile(target, recipe, recipe.stores(target))
