"""The median, without the modules for masked arrays that NumPy's own one loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def median(values: NDArray[Any]) -> float:
    """Return the middle of all values, or the mean of the two in the middle.

    Parameters
    ----------
    values : array
        Not empty, without NaN.

    Examples
    --------
    >>> median(np.array([4.0, 1.0, 3.0])), median(np.array([4, 1, 3, 8]))
    (3.0, 3.5)
    """
    last = values.size // 2
    first = last - 1 + values.size % 2
    ordered = np.partition(values, (first, last), axis=None)
    return (float(ordered[first]) + float(ordered[last])) / 2
