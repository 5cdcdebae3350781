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

if TYPE_CHECKING:
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
