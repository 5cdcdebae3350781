"""Places of the sample that a patch would show again, which is no idea of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut import repeat_kernels as kernels
from weftex.raster.boxes import box_sums
from weftex.search.translation import correlations, fast_size

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth

DIRECT = 2**22  #: places times pixels up to which sums are quicker than transforms
_STEP = 4  # every fourth pixel of the canvas or fewer, both ways, are looked at
_ENOUGH = 2**14  # pixels of the canvas tell how evenly the sample is shown
_ALIGNED = 16  # copies are in line if they are less than 1/16 of a patch off


class Repeats:
    """What the canvas shows of the sample, and what a patch would show again.

    Parameters
    ----------
    exemplar : Exemplar
        The sample.
    growth : Growth
        The canvas.
    size : (int, int)
        Height and width of patches.
    near : (int, int)
        What is shown again within this distance counts, and at any distance what is in line.
    step : int
        Look at every `step`-th pixel of the canvas, both ways, or 4th where that is fewer.
    """

    def __init__(
        self,
        exemplar: Exemplar,
        growth: Growth,
        size: tuple[int, int],
        near: tuple[int, int],
        step: int,
    ) -> None:
        self.exemplar, self.growth, self.size, self.near = exemplar, growth, size, near
        self.aligned, self.step = [n // _ALIGNED for n in size], max(_STEP, step)
        self.sparse = self.step
        while growth.source.size > _ENOUGH * self.sparse**2:
            self.sparse *= 2
        # What is looked at, close together, so that it stays in the processor's cache.
        self._seen = growth.source[:: self.step, :: self.step].copy()
        self._changing: list[NDArray[np.int64]] = []
        three = (np.array(k, np.int32) for k in (size, near, self.aligned))
        self._showing = kernels.Showing(self._seen, exemplar.shape, exemplar.tileable, *three)

    def turn_to(self, top: int, left: int) -> None:
        """Say where the next patch comes to lie, to within its size; the one before is laid."""
        if self._changing:
            rows, columns = self._changing
            from_rows, from_columns = self._changing[0] * self.step, self._changing[1] * self.step
            self._seen[np.ix_(rows, columns)] = self.growth.source[np.ix_(from_rows, from_columns)]
        self._changing = []
        for first, size, n, wraps in zip(
            (top, left), self.size, self.growth.canvas.shape, self.growth.canvas.wrap, strict=True
        ):
            count = -(-n // self.step)
            line = np.arange((first - size) // self.step, (first + size) // self.step + 1)
            if len(line) > count or (wraps and n % self.step):
                line = np.arange(count)
            inside = (line >= 0) & (line < count)
            self._changing.append(line % count if wraps else line[inside])

    def shown(self, top: int, left: int, halvings: int) -> NDArray[np.float64]:
        """How much of the patch from each place is shown already, 1 for all of it once.

        Parameters
        ----------
        top, left : int
            The patch's corner on the canvas.
        halvings : int
            Every 2**halvings-th place both ways.

        Returns
        -------
        float64 array (2, H, W)
            What is shown nearby, and what in line.
        """
        marks = np.zeros([2, *((n - 1 >> halvings) + 2 for n in self.exemplar.shape)], np.int32)
        places = [kernels.Marks(each, halvings) for each in marks]
        near, rest, over = zip(self._lines(0, top), self._lines(1, left), strict=True)
        for rows, columns in ((near[0], near[1]), (rest[0], over[1]), (over[0], rest[1])):
            kernels.count_shown(self._showing, rows, columns, *places)
        once = self.size[0] * self.size[1] / self.step**2
        for axis in (1, 2):
            marks.cumsum(axis=axis, out=marks)
        result: NDArray[np.float64] = marks[:, :-1, :-1] / once
        return result

    def used(self, halvings: int) -> NDArray[np.float64]:
        """How often the canvas shows what a patch from each place has, 1 as often as the mean.

        Every 2**halvings-th place both ways.
        """
        counts, sides = self._counts(halvings), [max(1, n >> halvings) for n in self.size]
        mean = float(counts.mean()) * sides[0] * sides[1]
        if self.exemplar.tileable:
            beyond = np.pad(counts, [(0, n - 1) for n in sides], mode="wrap")
        else:
            beyond = np.zeros([n + m - 1 for n, m in zip(counts.shape, sides, strict=True)], int)
            beyond[: counts.shape[0], : counts.shape[1]] = counts
        result: NDArray[np.float64] = box_sums(beyond, *sides) / (mean or 1)
        return result

    def used_where(
        self,
        missing: NDArray[np.bool_],
        halvings: int,
        offset: Sequence[int],
        allowed: NDArray[np.bool_],
    ) -> NDArray[np.float64]:
        """How often the canvas shows what each place would newly show, 1 as often as the mean.

        Parameters
        ----------
        missing : bool array (H, W)
            Every 2**halvings-th pixel of a box of the canvas: whether it is missing.
        halvings : int
            Every 2**halvings-th place both ways.
        offset : (int, int)
            From the box's corner to the pixel that places are of.
        allowed : bool array
            The places; of others nothing is said.
        """
        counts = self._counts(halvings)
        if allowed.sum() * counts.size <= DIRECT:
            sums = np.zeros((*allowed.shape, 2), np.int64)
            kernels.sum_over(
                counts.astype(np.int32),
                missing.view(np.uint8),
                allowed.view(np.uint8),
                np.array(offset, np.int32),
                sums,
            )
            shown, area = sums[..., 0], sums[..., 1]
        else:
            rows, columns = (
                fast_size(n + m) for n, m in zip(counts.shape, missing.shape, strict=True)
            )
            both = correlations(np.stack([counts, np.ones_like(counts)]), missing, (rows, columns))
            both = np.roll(both, offset, (1, 2))
            shown, area = both[:, : allowed.shape[0], : allowed.shape[1]]
        mean = counts.mean()
        result: NDArray[np.float64] = shown / np.maximum(area * mean, mean or 1)
        return result

    def _counts(self, halvings: int) -> NDArray[np.int64]:
        """How often the canvas shows each square of 2**halvings a side of the sample."""
        apart = self.sparse // self.step
        seen = np.ascontiguousarray(self._seen[::apart, ::apart])
        counts = np.zeros([(n - 1 >> halvings) + 1 for n in self.exemplar.shape], np.int64)
        kernels.count_squares(seen, self.exemplar.shape[1], halvings, counts)
        return counts

    def _lines(self, axis: int, first: int) -> list[NDArray[np.int32]]:
        """The lines near a patch, the others, and those that it covers or nearly covers.

        Of each its number, of those looked at, and the distance from the patch's first line.
        """
        n, wraps = self.growth.canvas.shape[axis], self.growth.canvas.wrap[axis]
        size, near, aligned = self.size[axis], self.near[axis], self.aligned[axis]
        number = np.arange(-(-n // self.step))
        away = number * self.step - first
        if wraps:
            before = n // 2 - size // 2
            away = (away + before) % n - before
        lines = np.array([number, away], np.int32)
        nearby, over = ((away >= -reach) & (away < size + reach) for reach in (near, aligned))
        return [np.ascontiguousarray(lines[:, part]) for part in (nearby, ~nearby, over)]
