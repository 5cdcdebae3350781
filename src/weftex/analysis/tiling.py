"""Whether a sample tiles: the step across its border, over the steps inside."""

from __future__ import annotations

import numpy as np

from weftex.exemplar import Exemplar
from weftex.raster.medians import median

#: Up to this many times the steps inside, a border step is no seam.
SEAMLESS = 1.5
_STRIP = 256  # lines that are read at a time, for little memory


def border_steps(exemplar: Exemplar) -> tuple[float, float]:
    """Return the step across the border over the steps inside, downwards and to the right.

    A step is the mean squared difference of neighboring lines. The step at the border is divided
    by the median of the others, or by the first or last where larger, as on a joint.
    """
    levels = exemplar.matching()
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    found = []
    for axis in (0, 1):
        lines, whole = np.moveaxis(levels, axis, 0), np.moveaxis(usable, axis, 0)
        total = np.zeros(len(lines), np.int64)
        for start in range(0, lines.shape[1], _STRIP):
            strip = lines[:, start : start + _STRIP].astype(np.int32)
            changes = ((strip - np.roll(strip, 1, 0)) ** 2).sum(axis=2)
            part = whole[:, start : start + _STRIP]
            total += (changes * (part & np.roll(part, 1, 0))).sum(axis=1)
        steps = total / np.maximum((whole & np.roll(whole, 1, 0)).sum(axis=1), 1)
        inside = steps[1:] if len(steps) > 1 else steps  # one line borders on itself
        usual = max(median(inside), float(inside[0]), float(inside[-1]), 1.0)
        found.append(round(float(steps[0]) / usual, 2))
    return found[0], found[1]
