"""Whether a sample tiles: what a step across its border is like beside the steps inside."""

from __future__ import annotations

import numpy as np

from weft.exemplar import Exemplar

#: Border steps up to this many times those inside pass for none.
SEAMLESS = 1.5


def border_steps(exemplar: Exemplar) -> tuple[float, float]:
    """Return how much more a sample changes across its border than inside.

    The step from one row to the next is the mean squared difference of their pixels. The step from
    the last row back to the first is divided by the median of all others, or, if it is larger, by
    the mean of the three nearest to each side of the border: the border may run along a joint.

    Parameters
    ----------
    exemplar : Exemplar
        The sample; pairs with a pixel that its mask leaves out do not count.

    Returns
    -------
    (float, float)
        From bottom to top and from right to left, rounded to hundredths. About 1 where the sample
        tiles (see `SEAMLESS`), 2 and more where it does not, 0 where both sides are equal.

    Examples
    --------
    >>> import numpy as np
    >>> waves = np.sin(np.arange(64) * 2 * np.pi / 16)
    >>> sample = np.tile(np.rint(127 + 100 * waves), (40, 1)).astype(np.uint8)
    >>> border_steps(Exemplar(sample))[1] <= SEAMLESS < border_steps(Exemplar(sample[:, :56]))[1]
    True
    """
    levels = exemplar.matching().astype(np.int32)
    usable = np.ones(exemplar.shape, bool) if exemplar.mask is None else exemplar.mask
    found = []
    for axis in (0, 1):
        changes = ((levels - np.roll(levels, 1, axis)) ** 2).sum(axis=2, dtype=np.int64)
        pairs = usable & np.roll(usable, 1, axis)
        total = (changes * pairs).sum(axis=1 - axis)
        steps = total / np.maximum(pairs.sum(axis=1 - axis), 1)
        inside = steps[1:] if len(steps) > 1 else steps  # one line borders on itself
        near = np.concatenate([inside[:3], inside[-3:]])
        usual = max(float(np.median(inside)), float(near.mean()), 1.0)
        found.append(round(float(steps[0]) / usual, 2))
    return found[0], found[1]
