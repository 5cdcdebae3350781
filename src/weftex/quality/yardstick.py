"""The real-crop yardstick: what the figures are for real pictures of the same surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.exemplar import Exemplar
from weftex.quality.assess import Assessment, assess
from weftex.quality.figures import FIGURES

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DIGITS = 3


def real_crops(sample: Exemplar) -> dict[str, float | None]:
    """Measure each half of a sample as if it were a result made from the other half.

    Parameters
    ----------
    sample : Exemplar
        Halves that its mask does not leave whole are not taken.

    Returns
    -------
    dict of str to float or None
        The mean of upper and lower, and left and right half, each from the other, for every
        figure that needs no source; None where it cannot be measured.

    Examples
    --------
    >>> import weftex
    >>> found = real_crops(weftex.load_exemplar("sample:pebbles"))
    >>> 0.8 < found["sharpness"] < 1.25
    True
    """
    y, x = (side // 2 for side in sample.shape)
    boxes = (np.s_[:y], np.s_[-y:] if y else np.s_[:0]), (np.s_[:, :x], np.s_[:, -x:])
    found: list[Assessment] = []
    for pair in boxes:
        first, second = (_part(sample, box) for box in pair)
        if first is not None and second is not None:
            found += [assess(first, second.pixels), assess(second, first.pixels)]
    return {name: _mean([getattr(one, name) for one in found]) for name in FIGURES}


def _part(sample: Exemplar, box: tuple[slice, ...] | slice) -> Exemplar | None:
    pixels: NDArray[np.generic] = sample.pixels[box]
    if pixels.size == 0 or (sample.mask is not None and not sample.mask[box].all()):
        return None
    return Exemplar(pixels, alpha=sample.alpha, name=sample.name)


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return round(float(np.mean(known)), _DIGITS) if known else None
