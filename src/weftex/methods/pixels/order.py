"""In which order single pixels are made."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def scan_lines(height: int, width: int) -> list[NDArray[np.int32]]:
    """Flat indices of each row of a canvas.

    Examples
    --------
    >>> [line.tolist() for line in scan_lines(2, 3)]
    [[0, 1, 2], [3, 4, 5]]
    """
    return list(np.arange(height * width, dtype=np.int32).reshape(height, width))
