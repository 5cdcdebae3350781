"""Repetition penalties: what it costs to show the same part of a sample again.

A `Repetition` is the policy; a penalty applies it to one output. For each patch, it says by which
factor, 1 or more, the cost of each candidate offset is multiplied (`PatchPenalty.of`,
`salience.SaliencePenalty.of`). Clearly better matches are never given up.

Graph cuts leave no boxes, so `repeat_kernels` count pixels. The square patches of quilting and the
blocks of near-regular synthesis are compared with those around by their offsets, in their kernels.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas
from weftex.exemplar import Exemplar
from weftex.raster.boxes import box_sums
from weftex.repeats import repeat_kernels as kernels

_LEAST_STEP = 4  # at least every fourth pixel is looked at
_ENOUGH = 2**14  # pixels of the canvas tell how evenly the sample is used
_ALIGNED = 16  # copies are in line if they are less than 1/16 of a patch off


class Output(Protocol):
    """An output in the making."""

    @property
    def canvas(self) -> Canvas:
        """The canvas."""

    @property
    def source(self) -> NDArray[np.int32]:
        """(H, W): flat indices into the sample, -1 where there is none."""

    @property
    def done(self) -> NDArray[np.uint8]:
        """(H, W): 0 where a pixel is missing."""


class Offsets(NamedTuple):
    """Candidate offsets of a patch: the pixels of the sample that may come to lie on one pixel."""

    pixel: tuple[int, int]  # of the canvas
    allowed: NDArray[np.bool_]  # of every 2**level-th pixel of the sample, both ways
    level: int  # of the sample's pyramid
    first: tuple[int, int] = (0, 0)  # the pixel of the sample that `allowed` begins with


class Repetition(NamedTuple):
    """How much repeats cost, as shares of what a match costs: factor = 1 + strength * sum."""

    strength: float
    nearby: float  # for all of a patch, shown once nearby
    use: float  # for pixels that the canvas shows as often as the mean
    in_line: float = 0.0  # for all of a patch, shown once in the same rows or columns
    most: float = 4.0  # repeats that count


class Usage:
    """The sources of every `step`-th pixel of an output, both ways.

    They are copied close together, so that they stay in the cache; a patch of `size` pixels changes
    what lies within its size of the pixel that it was announced for.
    """

    def __init__(
        self, output: Output, sample_shape: tuple[int, int], size: tuple[int, int], step: int
    ) -> None:
        self.output, self.sample_shape, self.size = output, sample_shape, size
        self.step = max(_LEAST_STEP, step)
        self._sparse = self.step
        while output.source.size > _ENOUGH * self._sparse**2:
            self._sparse *= 2
        self.source = output.source[:: self.step, :: self.step].copy()
        self._changing: list[NDArray[np.int64]] = []

    def next_patch(self, pixel: tuple[int, int]) -> None:
        """Prepare for a patch at a pixel of the canvas; all patches before it are pasted."""
        if self._changing:
            here = np.ix_(*self._changing)
            self.source[here] = self.output.source[:: self.step, :: self.step][here]
        self._changing = []
        canvas = self.output.canvas
        for first, size, n, wraps in zip(pixel, self.size, canvas.shape, canvas.wrap, strict=True):
            count = -(-n // self.step)
            line = np.arange((first - size) // self.step, (first + size) // self.step + 1)
            if len(line) > count or (wraps and n % self.step):
                line = np.arange(count)
            inside = (line >= 0) & (line < count)
            self._changing.append(line % count if wraps else line[inside])

    def counts(self, level: int) -> NDArray[np.int64]:
        """How often the output shows each square of 2**level pixels a side of the sample."""
        apart = self._sparse // self.step
        source = np.ascontiguousarray(self.source[::apart, ::apart])
        counts = np.zeros([(n - 1 >> level) + 1 for n in self.sample_shape], np.int64)
        kernels.count_squares(source, self.sample_shape[1], level, counts)
        return counts


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
        """Factor for the cost of each offset, 1 or more; the pixel is the patch's corner."""
        here = tuple(
            slice(first >> offsets.level, (first >> offsets.level) + n)
            for first, n in zip(offsets.first, offsets.allowed.shape, strict=True)
        )
        nearby, in_line = self._repeats(*offsets.pixel, offsets.level)
        use = self._use(offsets.level)
        policy = self.policy
        factors = np.ones(offsets.allowed.shape)
        for weight, each in ((policy.nearby, nearby), (policy.in_line, in_line), (policy.use, use)):
            factors += policy.strength * (weight * np.minimum(each[here], policy.most))
        return factors

    def _repeats(self, top: int, left: int, level: int) -> NDArray[np.float64]:
        """How much of the patch from each offset is shown already, 1 for all of it once.

        (2, H, W): nearby, and in line.
        """
        shape = [(n - 1 >> level) + 2 for n in self.exemplar.shape]
        marks = np.zeros([2, *shape], np.int32)
        near, rest, over = zip(self._lines(0, top), self._lines(1, left), strict=True)
        for rows, columns in ((near[0], near[1]), (rest[0], over[1]), (over[0], rest[1])):
            kernels.mark_repeats(
                self.usage.source, rows, columns, self._sample, self._reach, level, marks
            )
        once = self.size[0] * self.size[1] / self.usage.step**2
        for axis in (1, 2):
            marks.cumsum(axis=axis, out=marks)
        result: NDArray[np.float64] = marks[:, :-1, :-1] / once
        return result

    def _use(self, level: int) -> NDArray[np.float64]:
        """How often the canvas shows the pixels of each offset, 1 as often as the mean."""
        counts, sides = self.usage.counts(level), [max(1, n >> level) for n in self.size]
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
