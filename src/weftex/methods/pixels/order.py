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


def layers(unknown: NDArray[np.bool_], wrap: tuple[bool, bool]) -> list[NDArray[np.int32]]:
    """Flat indices of unknown pixels in layers from what is known inwards.

    Parameters
    ----------
    unknown : bool array (H, W)
        What is to be made. If nothing is known it is all one layer.
    wrap : (bool, bool)
        Axes along which the canvas goes around.

    Returns
    -------
    list of int32 arrays
        Each pixel of a layer has one of the layer before, or a known one, beside, above or below
        it. Within a layer in scan order.

    Examples
    --------
    >>> import numpy as np
    >>> unknown = np.array([[False, True, True, True, False]])
    >>> [layer.tolist() for layer in layers(unknown, (False, False))]
    [[1, 3], [2]]
    """
    found, left = [], unknown.copy()
    while left.any():
        known = np.pad(~left, 1)
        for axis in (0, 1):
            if wrap[axis]:
                ends = known.swapaxes(0, axis)
                ends[0], ends[-1] = ends[-2].copy(), ends[1].copy()
        beside = known[:-2, 1:-1] | known[2:, 1:-1] | known[1:-1, :-2] | known[1:-1, 2:]
        layer = left & beside if (left & beside).any() else left
        found.append(np.flatnonzero(layer).astype(np.int32))
        left = left & ~layer
    return found
