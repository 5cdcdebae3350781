"""Quantiles of many rows of whole numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weftex.quality import order_kernels as kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

_TIMES = 4  # as many numbers as there are values may be counted apart
_LEAST = 2**11  # the same at least, as the kernel needs


def at_quantiles(values: NDArray[np.int32], number: int) -> NDArray[np.int32]:
    """Return the values in the middle of so many equal parts of each row, if it were sorted.

    Parameters
    ----------
    values : int32 array (n, m)
    number : int

    Returns
    -------
    int32 array (n, number)

    Examples
    --------
    >>> at_quantiles(np.array([[5, 9, 1, 7, 3, 2]], np.int32), 3).tolist()
    [[2, 5, 9]]
    """
    size = values.shape[1]
    ranks = ((np.arange(number) + 0.5) / number * size).astype(np.int64)
    counts = np.empty(max(_LEAST, _TIMES * size), np.int32)
    found = np.empty((len(values), number), np.int32)
    kernels.at_ranks(values, ranks, counts, np.empty((2, size), np.uint32), found)
    return found
