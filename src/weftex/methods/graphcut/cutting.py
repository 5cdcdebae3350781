"""Cutting patches out and pasting them: patch fitting (Kwatra et al., 2003, section 3)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.methods.graphcut import cut_kernels, graph_kernels, run_kernels, seam_kernels
from weftex.methods.graphcut.kept import kept
from weftex.notes import is_asked, note
from weftex.seams.maxflow import search_trees

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.places import Place
    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth

_AHEAD = 2**16  # pixels that are looked through at a time for one that is missing


class Picture:
    """The canvas so far, with old seams: all patches that were pasted show in its labels.

    Parameters
    ----------
    settings, growth
        The sample and the canvas.
    size : (int, int)
        Height and width of the largest patch, in pixels.
    block : int
        The seams of candidates are priced in blocks of so many pixels a side, a power of 2.
    """

    def __init__(
        self, settings: Settings, growth: Growth, size: tuple[int, int], block: int
    ) -> None:
        self.growth = growth
        self.shape, self.sample_shape = growth.canvas.shape, settings.exemplar.shape
        self.done, self.halvings = growth.done.ravel(), block.bit_length() - 1
        channels = growth.pixels.shape[2]
        self._sample = kept(
            settings.windows,
            (settings.by_gradients, settings.whole),
            lambda: _seam_cost(settings, channels),
        )
        self.runs = np.zeros(self.done.size, np.int8)
        self._labeling = seam_kernels.Labeling(
            growth.pixels.reshape(-1, channels),
            growth.source.ravel(),
            self.done,
            self._frozen(growth),
            self.runs,
            self.shape,
            growth.canvas.wrap,
        )
        self.follow()
        # All lines of both, and as many on as a patch has, around the border.
        self._lines = [
            [
                (np.arange(n + side) % n).astype(np.int32)
                for n, side in zip(shape, size, strict=True)
            ]
            for shape in (self.shape, self.sample_shape)
        ]
        self._graphs = [_graph(*size) for _ in range(settings.candidates)]
        self._least = math.inf

    @staticmethod
    def _frozen(growth: Growth) -> NDArray[np.uint8]:
        """The known pixels, which stay."""
        if growth.canvas.shown is None:
            return growth.done.ravel().copy()
        assert growth.canvas.hole is not None
        return (~growth.canvas.hole).ravel().astype(np.uint8)

    def follow(self) -> None:
        """Look through all of the canvas for what `runs` tells; patches keep it up to date."""
        run_kernels.find_runs(self._labeling, self._sample)

    def missing(self) -> Iterator[tuple[int, int]]:
        """Yield the first pixel that is missing, until none is."""
        first, size = 0, self.done.size
        while first < size:
            part = self.done[first : first + _AHEAD]
            at = int(part.argmin())
            if part[at]:
                first += len(part)
                continue
            first += at
            yield divmod(first, self.shape[1])

    def cheapest(self, places: list[Place], map_: Callable[..., Any] = map) -> Place:
        """The first of the places whose `price` is the least.

        Candidates may meet in one place, which is cut once, where repeats cost least.
        """
        different: dict[tuple[int, ...], Place] = {}
        for place in places:
            if place.price < different.setdefault(place[:-1], place).price:
                different[place[:-1]] = place
        self._least = math.inf
        found = map_(self.price, different.values(), range(len(different)))
        prices = dict(zip(different, found, strict=True))
        least = min(prices.values())
        return next(
            place
            for place in places
            if prices[place[:-1]] == least
            and (least == 0 or place.price == different[place[:-1]].price)
        )

    def price(self, place: Place, number: int) -> float:
        """By how much a patch makes seams dearer, for each missing pixel, times what repeats cost.

        Cut out along the seam of least cost, new and old seams counted (section 3.1), in blocks.
        `number` is that of the candidate. Where another one was found cheaper than this one can
        still be, something between both prices.
        """
        # A little more, as what is rounded must not keep the cheapest one from its price.
        least = max(self._least, 0.0) / place.price * (1 + 1e-9)
        more, covered = cut_kernels.cost_in_blocks(
            self._labeling,
            self._sample,
            self._graph_of(place, number),
            self.halvings,
            least,
        )
        each: float = more / max(covered, 1)
        price = each * place.price if each > 0 else each / place.price
        self._least = min(self._least, price)
        return price

    def paste(self, place: Place) -> int:
        """Cut a patch out in smaller and smaller blocks, and copy it.

        Returns how many pixels were missing before.
        """
        asked = is_asked((place.top, place.left, place.height, place.width), self.shape)
        if asked:
            note("patch", growth=self.growth, place=place)
        covered: int = cut_kernels.paste_patch(
            self._labeling,
            self._sample,
            self._graph_of(place, 0),
            max(0, self.halvings - 1),
        )
        if asked:
            note("pasted", growth=self.growth, place=place)
        return covered

    def price_seams(
        self,
        rows: NDArray[np.int32],
        columns: NDArray[np.int32],
        costs: NDArray[np.int32],
        cells: NDArray[np.int64],
        side: int,
    ) -> None:
        """Fill in the cost of the seams to the right of and below the pixels of a box.

        Parameters
        ----------
        rows, columns : int32 arrays
            Of the box.
        costs : int32 array (H, W)
            Of all pixels of the canvas.
        cells : int64 array
            Their sums over squares.
        side : int
            Of a square, in pixels.
        """
        seam_kernels.sum_seams(self._labeling, self._sample, rows, columns, costs, cells, side)

    def _graph_of(self, place: Place, number: int) -> graph_kernels.Graph:
        """One of the graphs, over the box of a patch."""
        (down, along), (from_rows, from_columns) = self._lines
        y, x = place.top % self.shape[0], place.left % self.shape[1]
        v, u = place.source_top % self.sample_shape[0], place.source_left % self.sample_shape[1]
        graph = self._graphs[number]
        graph.cover(
            down[y : y + place.height],
            along[x : x + place.width],
            from_rows[v : v + place.height],
            from_columns[u : u + place.width],
        )
        return graph


def _seam_cost(settings: Settings, channels: int) -> seam_kernels.SeamCost:
    """The sample, with room for its gradients."""
    windows = settings.windows
    return seam_kernels.SeamCost(
        windows.pixels.reshape(-1, channels),
        windows.usable.ravel(),
        _joins(windows.usable != 0, settings.exemplar.tileable).ravel(),
        settings.exemplar.shape,
        settings.whole,
        np.zeros((2, windows.usable.size), np.int32) if settings.by_gradients else None,
    )


def _graph(height: int, width: int) -> graph_kernels.Graph:
    """Make room for the graph of a patch."""
    old, new = np.empty((2, height, width), np.int32)
    arcs = np.empty((height, width, 4), np.int32)
    choice, side = np.empty((2, height, width), np.uint8)
    near, scratch = (
        np.empty((2, height, width), np.uint8),
        np.empty((2, max(height, width)), np.int32),
    )
    trees = search_trees(height, width)
    return graph_kernels.Graph(arcs, old, new, choice, side, near, scratch, trees)


def _joins(usable: NDArray[np.bool_], tiles: bool) -> NDArray[np.uint8]:
    """The directions in which each pixel of a sample has a neighbor, as bits; see the kernels."""
    joins = np.zeros(usable.shape, np.uint8)
    for d, (axis, step) in enumerate([(1, 1), (0, 1), (1, -1), (0, -1)]):
        beside = np.roll(usable, -step, axis)
        last = np.zeros_like(usable)  # the line that is beyond the border
        last[(slice(None),) * axis + (-1 if step > 0 else 0,)] = True
        joins |= ((beside & (tiles | ~last)) * np.uint8(1 << d)).astype(np.uint8)
        joins |= (last * np.uint8(16 << d)).astype(np.uint8)
    return joins
