"""Repetition penalties: what it costs to show the same part of a sample again.

A `Repetition` is the policy; `salience.SaliencePenalty` applies it to one output. For each
patch, it says by which factor, 1 or more, the cost of each candidate offset is multiplied. For each
cut, it says what each pixel of the patch costs by what it repeats nearby, less what the pixel that
it replaces does. Both are shares of other costs, so a clearly better match or seam is never given
up.

Graph cuts leave no boxes, so `repeat_kernels` count pixels. The square patches of quilting and the
blocks of near-regular synthesis are compared with those around by their offsets, in their kernels.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from weftex.canvas import Canvas


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


class Repetition(NamedTuple):
    """How much repeats cost, as shares of what a match costs: factor = 1 + strength * sum."""

    strength: float
    nearby: float  # for all of a patch, shown once nearby
    use: float  # for pixels that the canvas shows as often as the mean
    most: float = 4.0  # repeats that count
