"""The levels of a Gaussian stack as one picture, so that windows are contiguous in memory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.raster.boxes import whole_windows
from weftex.raster.pyramids import phase_starts

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Layout:
    """Arranges the phases of level `number` one below the other; level 0 is the finest.

    Each phase has a margin of `reach` pixels that makes all windows whole: its other side if the
    sample tiles, else its mirror image.
    """

    shape: tuple[int, int]
    number: int
    reach: int
    tileable: bool

    @property
    def margin(self) -> int:
        """One more than a window reaches: a step off a border that tiles is a place too."""
        return self.reach + 1

    def arranged(self, phases: list[NDArray[Any]]) -> NDArray[Any]:
        """Put phases below each other, each with its margin."""
        return self._below(phases, "wrap" if self.tileable else "symmetric")

    @cached_property
    def places(self) -> NDArray[np.int32]:
        """Flat index of the pixel of the sample that each shows; -1 for none and for a mirrored."""
        every = np.arange(1, self.shape[0] * self.shape[1] + 1, dtype=np.int32)
        result: NDArray[np.int32] = self._margins(every, self.tileable) - 1
        return result

    @cached_property
    def index(self) -> NDArray[np.int32]:
        """The flat index of each pixel of the sample in the arrangement, never in a margin."""
        every = np.arange(1, self.shape[0] * self.shape[1] + 1, dtype=np.int32)
        inside = self._margins(every, False).ravel()
        flat = np.flatnonzero(inside).astype(np.int32)
        result = np.empty(len(flat), np.int32)
        result[inside[flat] - 1] = flat
        return result

    def usable(self, masks: list[NDArray[np.bool_]]) -> NDArray[np.uint8]:
        """1 where a window may be centered, given the phases of the mask."""
        m = self.margin
        mode: Any = "wrap" if self.tileable else "symmetric"
        whole = [whole_windows(np.pad(k, m, mode=mode), (self.reach,) * 4) for k in masks]
        if not self.tileable:
            whole = [np.pad(k[m:-m, m:-m], m) for k in whole]
        width = whole[0].shape[1]
        return np.concatenate([np.pad(k, ((0, 0), (0, width - k.shape[1]))) for k in whole])

    def _margins(self, every: NDArray[np.int32], beyond: bool) -> NDArray[np.int32]:
        """Arrange the pixels of the sample; margins are zeros, or the sample's continuation."""
        step, sample = 1 << self.number, every.reshape(self.shape)
        phases = [sample[y::step, x::step] for y, x in phase_starts(self.number)]
        return self._below(phases, "wrap" if beyond else "constant")

    def _below(self, phases: list[NDArray[Any]], mode: Any) -> NDArray[Any]:
        m, columns = self.margin, phases[0].shape[1]
        parts = []
        for phase in phases:
            more = ((0, 0),) * (phase.ndim - 2)
            part = np.pad(phase, ((m, m), (m, m), *more), mode=mode)
            parts.append(np.pad(part, ((0, 0), (0, columns - phase.shape[1]), *more)))
        return np.ascontiguousarray(np.concatenate(parts))
