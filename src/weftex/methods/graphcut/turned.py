"""Entire patches of a sample that may be turned; no idea of the paper."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut import turned_kernels as kernels
from weftex.methods.graphcut.copies import Copy
from weftex.methods.graphcut.entire import EntirePatchMatching, holes_of
from weftex.methods.graphcut.places import Matches, Place, draw_matches
from weftex.methods.graphcut.shown import cells_of, priced
from weftex.methods.graphcut.sight import Sight
from weftex.raster.turning import TURNS, turned_pixels
from weftex.search.windows import Windows
from weftex.turns import copies_in

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth
    from weftex.raster.turning import Box

# It costs so much to show something within a third of a side of a turned copy of it, by its share
# of what is new, but no more than the most.
_BESIDE, _NEAR, _MOST = 10.0, 0.35, 4.0
# A thing beside its mirror image is seen at once, and costs nothing to cut between. So that is done
# only where nothing else can be, if more than a share of a patch lies within a seventh of a side.
_CLOSE, _SHARE, _NEVER = 0.15, 0.05, 1e6


class TurnedMatching:
    """Entire patch matching with turned copies of the sample: each patch is one of them.

    Parameters
    ----------
    settings : Settings
        The exemplar is a picture of copies, see `weftex.turned`.
    growth : Growth
        The canvas.
    """

    def __init__(self, settings: Settings, growth: Growth) -> None:
        self.settings, self.growth = settings, growth
        self.boxes = copies_in(settings.exemplar)
        parts = [_part(settings, box) for box in self.boxes]
        prices: list[TurnedAgain | None] = [None] * len(parts)
        if settings.variety > 0:
            seen = CopiesInSight(settings, growth, self.boxes)
            prices = [TurnedAgain(seen, number) for number in range(len(parts))]
        self.ways = [
            EntirePatchMatching(part, growth, random=False, prices=each)
            for part, each in zip(parts, prices, strict=True)
        ]
        # Quarter turns of a sample that is not square have other sides.
        height, width = (max(sides) for sides in zip(*(way.size for way in self.ways), strict=True))
        self.size, self.reduction = (height, width), self.ways[0].reduction

    def candidates(
        self, pixel: tuple[int, int], number: int, centered: bool, map_: Callable[..., Any] = map
    ) -> list[Place]:
        """See `Placement.candidates`."""
        found = [way.found(pixel, centered, map_) for way in self.ways]
        least = min(each.matches.halvings for each in found)
        found = [
            each if each.matches.halvings == least else way.found(pixel, centered, map_, least)
            for way, each in zip(self.ways, found, strict=True)
        ]
        all_, tops = _stacked([each.matches for each in found])
        copies, seed = self.ways[0].copies, self.growth.seed
        drawn = draw_matches(self.settings, seed, number, all_, copies, self.size)
        which = np.searchsorted(tops, [y for y, _ in drawn], side="right") - 1
        places: dict[tuple[int, int], Place] = {}
        for k, (way, each, (top, left, _, _)) in enumerate(
            zip(self.ways, found, self.boxes, strict=True)
        ):
            own = [at for at, of in zip(drawn, which, strict=True) if of == k]
            if not own:
                continue
            laid = way.placed(each, [(y - tops[k], x) for y, x in own], map_)
            for at, place in zip(own, laid, strict=True):
                moved = {"source_top": place.source_top + top}
                places[at] = place._replace(**moved, source_left=place.source_left + left)
        return [places[at] for at in drawn]


class CopiesInSight:
    """What the canvas shows, whichever copy shows it.

    Parameters
    ----------
    settings : Settings
        The exemplar is a picture of copies.
    growth : Growth
        The canvas.
    boxes : list of (top, left, height, width)
        The copies, the first of which is the sample as it is.
    """

    def __init__(self, settings: Settings, growth: Growth, boxes: list[Box]) -> None:
        self.growth, exemplar = growth, settings.exemplar
        self.variety = settings.variety
        first = _part(settings, boxes[0]).windows
        self.sight = Sight(growth, Copy(first.pixels, first.usable), holes_of(growth))
        height, width = self.sight.count
        side = self.cell = self.sight.cell
        rows, columns = (np.arange(n) // side for n in self.sight.shape)
        own = (rows[:, None] * width + columns).astype(np.int32)
        assert exemplar.turn is not None
        #: Of each pixel of the picture of copies, the cell of the sample, and the copy.
        self.cell_of = turned_pixels(own, exemplar.turn)
        self.copy_of = np.zeros(exemplar.shape, np.int32)
        self.cells = []
        for number, box in enumerate(boxes):
            top, left, high, wide = box
            self.copy_of[top : top + high, left : left + wide] = number
            middles = [
                np.minimum(np.arange(0, n, side) + side // 2, n - 1) + start
                for n, start in ((high, top), (wide, left))
            ]
            self.cells.append(np.ascontiguousarray(self.cell_of[np.ix_(*middles)]))
        salience = np.zeros((height, width), np.int32)
        known = self.sight.salience
        salience[: known.shape[0], : known.shape[1]] = known
        self.salience = salience.ravel()
        self.near, self.close = (int((far * min(height, width)) ** 2) for far in (_NEAR, _CLOSE))
        copies = [copy for row in TURNS[exemplar.turn] for copy in row]
        self.mirrored = np.array([mirrored for _, mirrored in copies], np.uint8)
        self.weights = self.sight.weights()

    def look(self, pixel: tuple[int, int]) -> None:
        """See what is around a pixel of the canvas."""
        source, cell_of = self.growth.source, self.cell_of.ravel()
        rows, columns = self.sight.lines_of(pixel)
        shown = source[np.ix_(rows[0], columns[0])]
        v, u = np.nonzero(shown >= 0)
        label = shown[v, u]
        cell = cell_of[label]
        order = np.argsort(cell, kind="stable")
        where = np.stack(
            [rows[1][v] // self.cell, columns[1][u] // self.cell, self.copy_of.ravel()[label]], 1
        ).astype(np.int32)
        first = np.searchsorted(cell[order], np.arange(len(self.salience) + 1))
        some = source[:: self.cell, :: self.cell]
        counts = np.bincount(cell_of[some[some >= 0]], minlength=len(self.salience))
        self.mean = max(float(counts.mean()), 1.0 / len(counts))
        self.seen = kernels.Seen(
            first.astype(np.int32),
            np.ascontiguousarray(where[order]),
            counts.astype(np.int32),
            self.salience,
            self.weights,
            self.mirrored,
            self.near,
            self.close,
        )
        self.missing = self.sight.missing(pixel, max(self.cells[0].shape), max(self.cells[0].shape))


class TurnedAgain:
    """See `weftex.methods.graphcut.shown.ShownAgain`; of one copy.

    Parameters
    ----------
    shown : CopiesInSight
        What is shown by any.
    number : int
        The copy's.
    """

    def __init__(self, shown: CopiesInSight, number: int) -> None:
        self.shown, self.number = shown, number

    def turn_to(self, pixel: tuple[int, int]) -> None:
        """See `ShownAgain.turn_to`; all copies see the same."""
        if self.number == 0:
            self.shown.look(pixel)

    def of(
        self,
        pixel: tuple[int, int],
        allowed: NDArray[np.bool_],
        k: int,
        offset: list[int],
        missing: Callable[[], NDArray[np.bool_]],
    ) -> NDArray[np.float64]:
        """See `ShownAgain.of`."""
        shown, own = self.shown, self.shown.cells[self.number]
        rows, columns, cells = cells_of(allowed, k, shown.cell, list(own.shape))
        sums = np.zeros((*own.shape, 6), np.int64)
        kernels.sum_seen(shown.seen, own, self.number, shown.missing, cells, sums)
        again, salience, used, beside, area, mirrored = np.moveaxis(sums, 2, 0)
        again = again / np.maximum(Sight.UNIT * salience, 1)
        used = used / np.maximum(area * shown.mean, 1)
        prices = priced(shown.variety, again, used)
        prices += shown.variety * np.minimum(_BESIDE * beside / np.maximum(area, 1), _MOST)
        prices[mirrored > _SHARE * own.size] += shown.variety * _NEVER
        result: NDArray[np.float64] = prices[np.ix_(rows, columns)]
        return result


def _part(settings: Settings, box: Box) -> Settings:
    """The same for one of the copies."""
    top, left, height, width = box
    here, windows = np.s_[top : top + height, left : left + width], settings.windows
    pixels, usable = (np.ascontiguousarray(a[here]) for a in (windows.pixels, windows.usable))
    part = Windows(pixels, usable, windows.period, (height, width))
    return replace(settings, windows=part, patch_shape=(height, width))


def _stacked(matches: list[Matches]) -> tuple[Matches, list[int]]:
    """Matches one under the other, and the row that each begins with."""
    tops, width = [0], max(each.allowed.shape[1] for each in matches)
    for each in matches:
        tops.append(tops[-1] + len(each.allowed))
    costs, prices = np.full((tops[-1], width), np.inf), np.ones((tops[-1], width))
    allowed = np.zeros((tops[-1], width), bool)
    for top, each in zip(tops[:-1], matches, strict=True):
        here = np.s_[top : top + each.allowed.shape[0], : each.allowed.shape[1]]
        costs[here], prices[here], allowed[here] = each.costs, each.prices, each.allowed
    return Matches(costs, prices, allowed, matches[0].halvings), tops[:-1]
