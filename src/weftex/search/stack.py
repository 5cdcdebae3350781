"""A sample at coarser resolutions, with a pixel for each of its own: a Gaussian stack.

A pyramid keeps every second pixel, so that places on a coarse level are a few pixels apart, and
what was put together there has to be shifted to fit on the finest. A stack keeps them all, so that
a place of any level is a pixel of the sample (Lefebvre and Hoppe, 2005). Pixels that are side by
side on a coarse level are two or more apart on the finest. Those that belong together are a phase:
a picture of its own. Phases are laid out below each other, so that windows lie in memory as those
of any picture do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weftex.raster.pyramids import halve, halve_mask
from weftex.search.windows import whole_windows

if TYPE_CHECKING:
    from numpy.typing import NDArray

_STARTS = ((0, 0), (0, 1), (1, 0), (1, 1))


def gaussian_stack(
    levels: NDArray[np.uint8], count: int, wrap: tuple[bool, bool] = (False, False)
) -> list[list[NDArray[np.uint8]]]:
    """Return the phases of `levels`, which is one, and of its coarser versions.

    Parameters
    ----------
    levels : uint8 array (H, W, K)
        The finest level.
    count : int
        How many levels; each has four times the phases of the one before.
    wrap : (bool, bool)
        Whether the vertical and the horizontal axis go around, as in `gaussian_pyramid`.

    Returns
    -------
    list of lists of uint8 arrays
        In the order of `Layout.starts`. The first phase of a level is that of a pyramid.

    Examples
    --------
    >>> import numpy as np
    >>> [p.shape for p in gaussian_stack(np.zeros((9, 6, 3), np.uint8), 2)[1]]
    [(5, 3, 3), (5, 3, 3), (4, 3, 3), (4, 3, 3)]
    """
    result = [[levels]]
    for _ in range(count - 1):
        result.append([halve(phase, wrap, at) for at in _STARTS for phase in result[-1]])
    return result


def mask_stack(
    mask: NDArray[np.bool_], count: int, wrap: tuple[bool, bool] = (False, False)
) -> list[list[NDArray[np.bool_]]]:
    """Return for each phase of `gaussian_stack` which pixels are means of the mask's alone."""
    result = [[mask]]
    for _ in range(count - 1):
        result.append([halve_mask(phase, wrap, at) for at in _STARTS for phase in result[-1]])
    return result


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the phases of a level are laid out.

    Around each is a margin: of a sample that tiles its other side, of others their mirror image,
    so that windows at all of its pixels are whole.

    Parameters
    ----------
    shape : (int, int)
        Of the sample.
    number : int
        Of the level; 0 is the finest.
    reach : int
        From the middle of a window to its side.
    tileable : bool
        Whether the sample tiles.
    """

    shape: tuple[int, int]
    number: int
    reach: int
    tileable: bool

    @property
    def margin(self) -> int:
        """One more than a window reaches: a step off a border that tiles is a place too."""
        return self.reach + 1

    @property
    def starts(self) -> list[tuple[int, int]]:
        """The first pixel of each phase."""
        starts = [(0, 0)]
        for k in range(self.number):
            starts = [(y + (v << k), x + (u << k)) for v, u in _STARTS for y, x in starts]
        return starts

    def lay(self, phases: list[NDArray[Any]]) -> NDArray[Any]:
        """Put phases below each other, each with its margin."""
        return self._stack(phases, "wrap" if self.tileable else "symmetric")

    @cached_property
    def places(self) -> NDArray[np.int32]:
        """Flat index of the pixel of the sample that each shows; -1 for none, or mirrored."""
        every = np.arange(1, self.shape[0] * self.shape[1] + 1, dtype=np.int32)
        result: NDArray[np.int32] = self._margins(every, self.tileable) - 1
        return result

    @cached_property
    def index(self) -> NDArray[np.int32]:
        """Where each pixel of the sample is laid, as a flat index, not in a margin."""
        every = np.arange(1, self.shape[0] * self.shape[1] + 1, dtype=np.int32)
        inside = self._margins(every, False).ravel()
        flat = np.flatnonzero(inside).astype(np.int32)
        result = np.empty(len(flat), np.int32)
        result[inside[flat] - 1] = flat
        return result

    def usable(self, masks: list[NDArray[np.bool_]]) -> NDArray[np.uint8]:
        """1 where a window may be centred, given the phases of the mask."""
        m = self.margin
        mode: Any = "wrap" if self.tileable else "symmetric"
        whole = [whole_windows(np.pad(k, m, mode=mode), (self.reach,) * 4) for k in masks]
        if not self.tileable:
            whole = [np.pad(k[m:-m, m:-m], m) for k in whole]
        width = whole[0].shape[1]
        return np.concatenate([np.pad(k, ((0, 0), (0, width - k.shape[1]))) for k in whole])

    def _margins(self, every: NDArray[np.int32], beyond: bool) -> NDArray[np.int32]:
        """Lay out the pixels of the sample, with zeros in the margins or what goes on there."""
        step, sample = 1 << self.number, every.reshape(self.shape)
        phases = [sample[y::step, x::step] for y, x in self.starts]
        return self._stack(phases, "wrap" if beyond else "constant")

    def _stack(self, phases: list[NDArray[Any]], mode: Any) -> NDArray[Any]:
        m, columns = self.margin, phases[0].shape[1]
        parts = []
        for phase in phases:
            more = ((0, 0),) * (phase.ndim - 2)
            part = np.pad(phase, ((m, m), (m, m), *more), mode=mode)
            parts.append(np.pad(part, ((0, 0), (0, columns - phase.shape[1]), *more)))
        return np.ascontiguousarray(np.concatenate(parts))
