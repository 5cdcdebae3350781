"""The median, without the modules for masked arrays that NumPy's own one loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def median(values: NDArray[Any]) -> float:
    """The median of all values of a non-empty array without NaN, without loading numpy.ma."""
    last = values.size // 2
    first = last - 1 + values.size % 2
    ordered = np.partition(values, (first, last), axis=None)
    return (float(ordered[first]) + float(ordered[last])) / 2
