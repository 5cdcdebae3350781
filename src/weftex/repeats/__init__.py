"""Repetition penalties: what it costs to show the same part of a sample again.

A `Repetition` is the policy; a penalty applies it to one output. For each patch, the method says
where the next one comes to lie (`Penalty.next_patch`), and multiplies the cost of each candidate
offset by a factor of 1 or more (`Penalty.of`). Clearly better matches are never given up.

Kernels that compare one box with its neighbors count with `overlap_kernels.repeated_pixels`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from weftex.repeats.repeat_kernels import count_squares

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.canvas import Canvas

_LEAST_STEP = 4  # at least every fourth pixel is looked at
_ENOUGH = 2**14  # pixels of the canvas tell how evenly the sample is used


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
    allowed: NDArray[np.bool_]  # of every 2**halvings-th pixel of the sample, both ways
    halvings: int
    first: tuple[int, int] = (0, 0)  # the pixel of the sample that `allowed` begins with
    copy: int = 0  # which oriented copy of the sample


class Penalty(Protocol):
    """A repetition penalty for one output."""

    def next_patch(self, pixel: tuple[int, int]) -> None:
        """Prepare for a patch at a pixel of the canvas; all patches before it are pasted."""

    def of(self, offsets: Offsets) -> NDArray[np.float64]:
        """Factor for the cost of each candidate offset, 1 or more; undefined where not allowed."""


@dataclass(frozen=True)
class Repetition:
    """How much repeats cost, as shares of what a match costs: factor = 1 + strength * sum."""

    strength: float
    nearby: float  # for all of a patch, shown once nearby
    use: float  # for pixels that the canvas shows as often as the mean
    in_line: float = 0.0  # for all of a patch, shown once in the same rows or columns
    most: float = 4.0  # repeats that count

    def factors(self, nearby: NDArray[np.float64], use: NDArray[np.float64]) -> NDArray[np.float64]:
        """Factors for repeats nearby, by their weights, and for use."""
        use = np.minimum(use, self.most)
        result: NDArray[np.float64] = 1 + self.strength * (self.nearby * nearby + self.use * use)
        return result


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
        """See `Penalty.next_patch`."""
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

    def counts(self, halvings: int) -> NDArray[np.int64]:
        """How often the output shows each square of 2**halvings pixels a side of the sample."""
        apart = self._sparse // self.step
        source = np.ascontiguousarray(self.source[::apart, ::apart])
        counts = np.zeros([(n - 1 >> halvings) + 1 for n in self.sample_shape], np.int64)
        count_squares(source, self.sample_shape[1], halvings, counts)
        return counts
