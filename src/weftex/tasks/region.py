"""The part of a photo that is used to fill its holes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from weftex.raster.boxes import cell_sums
from weftex.raster.masks import grown

#: Usable pixels around the holes that patches are taken from. More make it slower, and what is
#: further away looks less like the place.
NEIGHBORHOOD = 2**20
_CELL = 16  # pixels a side; the neighborhood grows by whole cells


class Region:
    """The part of a photo that is used to fill its holes."""

    def __init__(
        self,
        hole: NDArray[np.bool_],
        wrap: tuple[bool, bool],
        usable: NDArray[np.bool_] | None,
        reach: int,
    ) -> None:
        cells = cell_sums(hole, _CELL) > 0
        supply = np.zeros(cells.shape, np.int64) if usable is None else cell_sums(usable, _CELL)
        steps = -(-reach // _CELL)
        near = grown(cells, steps, wrap)
        if usable is not None:
            while not near.all():
                wider = grown(near, max(1, steps // 8), wrap)
                if supply[wider].sum() > NEIGHBORHOOD:
                    break
                near = wider
        near = near.repeat(_CELL, 0).repeat(_CELL, 1)[: hole.shape[0], : hole.shape[1]]
        spans = [_span(np.any(near, axis=1 - axis), wrap[axis]) for axis in (0, 1)]
        self._rows, self._columns = (
            np.arange(start, start + length) % full
            for (start, length), full in zip(spans, hole.shape, strict=True)
        )
        full = [length == side for (_, length), side in zip(spans, hole.shape, strict=True)]
        self.whole = all(full)
        self.wrap = (wrap[0] and full[0], wrap[1] and full[1])
        self.corner = (int(self._rows[0]), int(self._columns[0]))
        self.near = self.crop(near)

    def put(self, part: NDArray[np.bool_], shape: tuple[int, int]) -> NDArray[np.bool_]:
        """Return the mask of the whole photo: `part` in the region, False elsewhere."""
        whole = np.zeros(shape, bool)
        whole[self._rows[:, None], self._columns] = part
        return whole

    def crop(self, pixels: NDArray[Any], blank: NDArray[np.bool_] | None = None) -> NDArray[Any]:
        """Return the region of an array; `blank` pixels get the value of another pixel."""
        part: NDArray[Any] = pixels[self._rows[:, None], self._columns]
        if blank is not None:
            # What marks a hole, such as white, must not stretch the range of values.
            empty = self.crop(blank)
            if not empty.all():
                part[empty] = part[np.unravel_index(int(empty.argmin()), empty.shape)]
        return part


def _span(taken: NDArray[np.bool_], wraps: bool) -> tuple[int, int]:
    """Return start and length of the shortest interval that holds all True values."""
    at = np.flatnonzero(taken)
    if not wraps:
        return int(at[0]), int(at[-1] - at[0] + 1)
    gaps = np.diff(at, append=at[0] + len(taken))
    widest = int(gaps.argmax())
    if gaps[widest] == 1:
        return 0, len(taken)
    return int(at[(widest + 1) % len(at)]), int(len(taken) - gaps[widest] + 1)
