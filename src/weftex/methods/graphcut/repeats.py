"""Places of the sample that a patch would show again, which is no idea of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.methods.graphcut import repeat_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.methods.pixels.growth import Growth

_STEP = 4  # every fourth pixel of the canvas or fewer, both ways, are looked at
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
        three = (np.array(k, np.int32) for k in (size, near, self.aligned))
        self._showing = kernels.Showing(
            growth.source, exemplar.shape, exemplar.tileable, *three
        )

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
        float64 array (H, W)
        """
        marks = np.zeros([(n - 1 >> halvings) + 2 for n in self.exemplar.shape], np.int32)
        places = kernels.Marks(marks, halvings)
        near, rest, over = zip(self._lines(0, top), self._lines(1, left), strict=True)
        for rows, columns in ((near[0], near[1]), (rest[0], over[1]), (over[0], rest[1])):
            kernels.count_shown(self._showing, rows, columns, places)
        once = self.size[0] * self.size[1] / self.step**2
        result: NDArray[np.float64] = marks.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] / once
        return result

    def _lines(self, axis: int, first: int) -> list[NDArray[np.int32]]:
        """The lines near a patch, the others, and those that it covers or nearly covers.

        Of each the place on the canvas and the distance from the patch's first line.
        """
        n, wraps = self.growth.canvas.shape[axis], self.growth.canvas.wrap[axis]
        size, near, aligned = self.size[axis], self.near[axis], self.aligned[axis]
        line = np.arange(0, n, self.step)
        away = line - first
        if wraps:
            before = n // 2 - size // 2
            away = (away + before) % n - before
        lines = np.array([line, away], np.int32)
        nearby, over = ((away >= -reach) & (away < size + reach) for reach in (near, aligned))
        return [np.ascontiguousarray(lines[:, part]) for part in (nearby, ~nearby, over)]
