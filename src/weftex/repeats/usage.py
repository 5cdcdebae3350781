"""The pixels of a sample that an output shows so far."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.repeats import repeat_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weftex.repeats import Output

_LEAST_STEP = 4  # at least every fourth pixel is looked at
_ENOUGH = 2**14  # pixels of the canvas tell how evenly the sample is used


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
        kernels.count_squares(source, self.sample_shape[1], halvings, counts)
        return counts
