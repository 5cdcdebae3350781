"""Cutting patches out and pasting them: patch fitting (Kwatra et al., 2003, section 3)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weftex.methods.graphcut import cut_kernels as kernels
from weftex.seams.maxflow import minimum_cut

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.methods.graphcut.placement import Place
    from weftex.methods.graphcut.settings import Settings
    from weftex.methods.pixels.growth import Growth


class Cut(NamedTuple):
    """A patch cut out."""

    cost: int  # of all seams in its box, once it is pasted
    place: Place
    patch: kernels.Patch
    graph: kernels.Graph
    side: NDArray[np.uint8]  # 1 inside the cut


class Picture:
    """The canvas so far, with old seams: all patches that were pasted show in its labels."""

    def __init__(self, settings: Settings, growth: Growth) -> None:
        self.shape, self.sample_shape = growth.canvas.shape, settings.exemplar.shape
        self.done = growth.done.ravel()
        channels = growth.pixels.shape[2]
        self._sample = kernels.Sample(
            settings.windows.pixels.reshape(-1, channels),
            settings.windows.usable.ravel(),
            self.sample_shape,
            settings.exemplar.tileable,
            settings.by_gradients,
        )
        self._picture = kernels.Picture(
            growth.pixels.reshape(-1, channels),
            growth.source.ravel(),
            self.done,
            self.done.copy(),
            self.shape,
            growth.canvas.wrap,
        )

    def missing(self) -> Iterator[tuple[int, int]]:
        """Yield the first pixel that is missing, until none is."""
        first = 0
        while True:
            first += int(self.done[first:].argmin())
            if self.done[first]:
                return
            yield divmod(first, self.shape[1])

    def cut(self, place: Place) -> Cut:
        """Cut a patch out along the seam of least cost, new and old seams counted (section 3.1)."""
        shape = place.height, place.width
        patch = kernels.Patch(
            _box(place.top, place.left, *shape, self.shape),
            _box(place.source_top, place.source_left, *shape, self.sample_shape),
        )
        arcs = np.empty((*shape, 4), np.int32)
        old, new = np.empty((2, *shape), np.int32)
        graph = kernels.Graph(arcs, old, new, np.empty(shape, np.uint8))
        fixed: int = kernels.graph_of_patch(self._picture, self._sample, patch, graph)
        side, cost = minimum_cut(arcs, old, new)
        return Cut(cost + fixed, place, patch, graph, side.view(np.uint8))

    def paste(self, cut: Cut) -> int:
        """Copy the pixels inside the cut; return how many were missing before."""
        covered: int = kernels.paste_patch(
            self._picture, self._sample, cut.patch, cut.graph, cut.side
        )
        return covered

    def price_seams(self, places: NDArray[np.int32], costs: NDArray[np.int32]) -> None:
        """Fill in the cost of the seams to the right of and below pixels.

        Parameters
        ----------
        places : int32 array (H, W)
            The pixels, flat.
        costs : int32 array (N,)
            Of all pixels of the canvas.
        """
        kernels.costs_of_seams(self._picture, self._sample, places, costs)


def _box(top: int, left: int, height: int, width: int, shape: tuple[int, int]) -> NDArray[np.int32]:
    """The pixels of a box in a picture that goes around, as flat places (height, width)."""
    y, x = np.arange(top, top + height)[:, None], np.arange(left, left + width)
    return (y % shape[0] * shape[1] + x % shape[1]).astype(np.int32)
