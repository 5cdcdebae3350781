"""The repetition penalty of square patches: by all pixels that a patch would show again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.raster.boxes import box_sums
from weftex.repeats import Usage
from weftex.repeats import repeat_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.exemplar import Exemplar
    from weftex.repeats import Offsets, Output, Repetition

_ALIGNED = 16  # copies are in line if they are less than 1/16 of a patch off


class PatchPenalty:
    """Repeats within a patch's size, in the same rows and columns at any distance, and anywhere.

    `size` is that of the patches in pixels; every `step`-th pixel of the output is looked at.
    """

    def __init__(
        self,
        policy: Repetition,
        exemplar: Exemplar,
        output: Output,
        size: tuple[int, int],
        step: int,
    ) -> None:
        self.policy, self.exemplar, self.output, self.size = policy, exemplar, output, size
        self.usage = Usage(output, exemplar.shape, size, step)
        self.next_patch = self.usage.next_patch
        self._aligned = [n // _ALIGNED for n in size]
        self._sample = np.array([*exemplar.shape, exemplar.tileable], np.int32)
        self._reach = np.array([size, size, self._aligned], np.int32)

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """See `Penalty.of`; the pixel is the patch's upper left corner."""
        here = tuple(
            slice(first >> offsets.halvings, (first >> offsets.halvings) + n)
            for first, n in zip(offsets.first, offsets.allowed.shape, strict=True)
        )
        nearby, in_line = self._repeats(*offsets.pixel, offsets.halvings)
        use = self._use(offsets.halvings)
        policy = self.policy
        factors = np.ones(offsets.allowed.shape)
        for weight, each in (
            (policy.nearby, nearby),
            (policy.in_line, in_line),
            (policy.use, use),
        ):
            factors += policy.strength * (weight * np.minimum(each[here], policy.most))
        return factors

    def _repeats(self, top: int, left: int, halvings: int) -> NDArray[np.float64]:
        """How much of the patch from each offset is shown already, 1 for all of it once.

        (2, H, W): nearby, and in line.
        """
        shape = [(n - 1 >> halvings) + 2 for n in self.exemplar.shape]
        marks = np.zeros([2, *shape], np.int32)
        near, rest, over = zip(self._lines(0, top), self._lines(1, left), strict=True)
        for rows, columns in ((near[0], near[1]), (rest[0], over[1]), (over[0], rest[1])):
            kernels.mark_repeats(
                self.usage.source, rows, columns, self._sample, self._reach, halvings, marks
            )
        once = self.size[0] * self.size[1] / self.usage.step**2
        for axis in (1, 2):
            marks.cumsum(axis=axis, out=marks)
        result: NDArray[np.float64] = marks[:, :-1, :-1] / once
        return result

    def _use(self, halvings: int) -> NDArray[np.float64]:
        """How often the canvas shows the pixels of each offset, 1 as often as the mean."""
        counts, sides = self.usage.counts(halvings), [max(1, n >> halvings) for n in self.size]
        mean = float(counts.mean()) * sides[0] * sides[1]
        mode = {"mode": "wrap"} if self.exemplar.tileable else {"mode": "constant"}
        beyond = np.pad(counts, [(0, n - 1) for n in sides], **mode)  # type: ignore[call-overload]
        result: NDArray[np.float64] = box_sums(beyond, *sides) / (mean or 1)
        return result

    def _lines(self, axis: int, first: int) -> list[NDArray[np.int32]]:
        """Rows or columns of the grid near a patch, the others, and the ones that it nearly covers.

        Of each its number, and its distance from the patch's first line in pixels.
        """
        canvas, size = self.output.canvas, self.size[axis]
        n, wraps = canvas.shape[axis], canvas.wrap[axis]
        number = np.arange(-(-n // self.usage.step))
        away = number * self.usage.step - first
        if wraps:
            before = n // 2 - size // 2
            away = (away + before) % n - before
        lines = np.array([number, away], np.int32)
        nearby, over = (
            (away >= -reach) & (away < size + reach) for reach in (size, self._aligned[axis])
        )
        return [np.ascontiguousarray(lines[:, part]) for part in (nearby, ~nearby, over)]
